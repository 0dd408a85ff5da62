//! The camera in 64 bits: where a place is in the picture, and what is under a pixel. For what is drawn over a
//! picture or grabbed in it; the points themselves are projected by [`View`](super::View).

use glam::{DVec2, DVec3};

use super::camera::{Camera, CameraError, Projection, up_for};

/// A camera and a size of picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Unit vectors of the picture, in the file's axes.
    pub right: DVec3,
    pub down: DVec3,
    pub forward: DVec3,
    eye: DVec3,
    /// Pixels of one unit at a depth of one; without perspective at any depth.
    zoom: f64,
    /// The middle of the picture, in pixels.
    middle: DVec2,
    projection: Projection,
}

impl Lens {
    /// # Errors
    /// If the camera's numbers make no picture.
    pub fn of(camera: &Camera, size: [u32; 2]) -> Result<Lens, CameraError> {
        camera.check()?;
        let eye = DVec3::from_array(camera.eye);
        let forward = (DVec3::from_array(camera.target) - eye).try_normalize().ok_or(CameraError::NoDirection)?;
        let right = forward.cross(up_for(forward, DVec3::from_array(camera.up))).normalize();
        let zoom = match camera.projection {
            Projection::Perspective => 0.5 * f64::from(size[1]) / (0.5 * camera.fov_y_deg.to_radians()).tan(),
            Projection::Orthographic => f64::from(size[1]) / camera.height_at_target(),
        };
        Ok(Lens {
            right,
            down: forward.cross(right),
            forward,
            eye,
            zoom,
            middle: DVec2::from_array(size.map(|n| 0.5 * f64::from(n))),
            projection: camera.projection,
        })
    }

    /// Pixels of one unit of the file at this depth.
    pub fn pixels_per_unit(&self, depth: f64) -> f64 {
        match self.projection {
            Projection::Perspective => self.zoom / depth,
            Projection::Orthographic => self.zoom,
        }
    }

    /// Depth of a place along the viewing direction; 0 or less at and behind the eye.
    pub fn depth(&self, world: DVec3) -> f64 {
        (world - self.eye).dot(self.forward)
    }

    /// Where a place is: pixels from the upper left corner, and its depth. `None` for what is not before the eye.
    pub fn place(&self, world: DVec3) -> Option<(DVec2, f64)> {
        let depth = self.depth(world);
        let at = world - self.eye;
        let aside = DVec2::new(at.dot(self.right), at.dot(self.down));
        (depth > 0.0).then(|| (aside * self.pixels_per_unit(depth) + self.middle, depth))
    }

    /// The place under a pixel at this depth.
    pub fn at(&self, pixel: DVec2, depth: f64) -> DVec3 {
        let aside = (pixel - self.middle) / self.pixels_per_unit(depth);
        self.eye + self.right * aside.x + self.down * aside.y + self.forward * depth
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Grid;

    #[test]
    fn places_are_where_the_kernels_draw_them_and_back() {
        let grid = Grid { scale: [0.001; 3], origin: [500_000.0, 5_000_000.0, 300.0] };
        let target = [500_010.0, 5_000_020.0, 305.0];
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let camera = Camera { eye: [500_003.0, 4_999_990.0, 330.0], target, projection, ..Default::default() };
            let lens = Lens::of(&camera, [640, 480]).expect("a camera");
            let view = camera.view(&grid, [640, 480], 1).expect("a camera");
            let mut seen = 0;
            for i in 0..1000 {
                let position = [i * 31 % 20_000, i * 7919 % 40_000, i * 131 % 9000];
                let world = DVec3::from_array(grid.world(position));
                let (Some((at, depth)), Some(drawn)) = (lens.place(world), view.project(position)) else { continue };
                seen += 1;
                let middle = DVec2::new(f64::from(drawn.corner[0]), f64::from(drawn.corner[1])) + 0.5;
                assert!((at - middle).abs().max_element() < 0.5 + 1e-3, "{projection:?}: {at} is not {middle}");
                assert!((f64::from(drawn.depth) / depth - 1.0).abs() < 1e-5, "{depth} is not {}", drawn.depth);
                assert!(lens.at(at, depth).distance(world) < 1e-6);
            }
            assert!(seen > 100, "{seen}");
        }
    }
}
