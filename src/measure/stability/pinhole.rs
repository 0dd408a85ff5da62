//! A camera in f64 that shares nothing with the program's, and the same camera as a viewer has it that holds
//! positions and matrix in f32.

use glam::{DVec3, Vec3};

use crate::render::Camera;

/// A point in the picture: its place in pixels, from the upper left corner, and its distance along the viewing
/// direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    pub x: f64,
    pub y: f64,
    pub depth: f64,
}

impl Place {
    /// The pixel that the place lies in; `None` outside of the picture.
    pub fn pixel(&self, size: [u32; 2]) -> Option<[i64; 2]> {
        let is_inside = |at: f64, end: u32| at >= 0.0 && at < f64::from(end);
        (self.depth > 0.0 && is_inside(self.x, size[0]) && is_inside(self.y, size[1]))
            .then(|| [self.x.floor() as i64, self.y.floor() as i64])
    }

    /// Distance to the nearest border between pixels.
    pub fn border_distance(&self) -> f64 {
        [self.x, self.y].map(|at| (at - at.round()).abs()).into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// A perspective camera.
pub struct Pinhole {
    eye: DVec3,
    right: DVec3,
    down: DVec3,
    forward: DVec3,
    /// Pixels per unit of (offset / depth).
    focal: f64,
    half: [f64; 2],
}

impl Pinhole {
    pub fn of(camera: &Camera, size: [u32; 2]) -> Pinhole {
        let eye = DVec3::from_array(camera.eye);
        let forward = (DVec3::from_array(camera.target) - eye).normalize();
        let right = forward.cross(DVec3::from_array(camera.up)).normalize();
        let half = size.map(|n| 0.5 * f64::from(n));
        let focal = half[1] / (0.5 * camera.fov_y_deg.to_radians()).tan();
        Pinhole { eye, right, down: forward.cross(right), forward, focal, half }
    }

    /// Where a point is.
    pub fn place(&self, world: [f64; 3]) -> Place {
        let d = DVec3::from_array(world) - self.eye;
        self.divided(d.dot(self.right), d.dot(self.down), d.dot(self.forward))
    }

    /// Where a viewer sees it that holds coordinates as f32, and the camera as a matrix of f32 whose last column is
    /// the eye's offset.
    pub fn place_f32(&self, world: [f32; 3]) -> Place {
        let row = |axis: DVec3| Vec3::from_array(world).dot(axis.as_vec3()) - axis.dot(self.eye) as f32;
        self.divided(row(self.right).into(), row(self.down).into(), row(self.forward).into())
    }

    fn divided(&self, right: f64, down: f64, depth: f64) -> Place {
        Place { x: right / depth * self.focal + self.half[0], y: down / depth * self.focal + self.half[1], depth }
    }
}

/// For each pixel the nearest of these points, as −1 or a record.
pub fn nearest(size: [u32; 2], places: impl Iterator<Item = (i64, Place)>) -> Vec<i64> {
    let mut shown = vec![(f64::INFINITY, -1); size[0] as usize * size[1] as usize];
    for (record, place) in places {
        let Some([x, y]) = place.pixel(size) else { continue };
        let pixel = &mut shown[y as usize * size[0] as usize + x as usize];
        if place.depth < pixel.0 {
            *pixel = (place.depth, record);
        }
    }
    shown.into_iter().map(|(_, record)| record).collect()
}
