//! Planes stacked before the camera, a point for every pixel of each: the scene of Günther, Kanzok, Linsen and
//! Rosenthal 2013, "A GPGPU-based Pipeline for Accelerated Rendering of Point Clouds", Figure 3. More planes are
//! more fragments per pixel; so is a smaller base with as many points, until all of them lie in one pixel.

use super::orders::{Order, gather};
use crate::{
    methods::Cloud,
    render::{Camera, CameraError, View},
    scene::Grid,
};

/// Grid step and spacing of the planes, metres.
const STEP: f64 = 0.001;
/// Distance of the nearest plane, metres: a pixel of a 1080p picture is a metre wide there, a thousand steps.
const NEAREST: f64 = 1000.0;

/// Points over a base of whole pixels in the middle of the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stack {
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// Width and height of the base, pixels.
    pub base: [u32; 2],
    pub points: u32,
}

impl Stack {
    /// Points per pixel of the base.
    pub fn fragments_per_pixel(&self) -> f64 {
        f64::from(self.points) / (f64::from(self.base[0]) * f64::from(self.base[1]))
    }

    fn camera() -> Camera {
        Camera { eye: [0.0; 3], target: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0], fov_y_deg: 60.0, ..Default::default() }
    }

    /// The camera's numbers for [`Stack::cloud`].
    pub fn view(&self) -> Result<View, CameraError> {
        Stack::camera().view(&Grid { scale: [STEP; 3], origin: [0.0; 3] }, self.size, 1)
    }

    /// The points, in the random order that the viewer's store has.
    pub fn cloud(&self, seed: u64) -> Cloud {
        let [width, height] = self.size.map(f64::from);
        let first = [0, 1].map(|a| (self.size[a] - self.base[a]) / 2);
        let slope_y = (0.5 * Stack::camera().fov_y_deg.to_radians()).tan();
        let slope_x = slope_y * width / height;
        let place = |i: u32| {
            let (column, rest) = (i % self.base[0], i / self.base[0]);
            let (row, plane) = (rest % self.base[1], rest / self.base[1]);
            let distance = NEAREST + f64::from(plane) * STEP;
            let x = (2.0 * (f64::from(first[0] + column) + 0.5) / width - 1.0) * slope_x * distance;
            let y = (1.0 - 2.0 * (f64::from(first[1] + row) + 0.5) / height) * slope_y * distance;
            [x, y, -distance].map(|metres| (metres / STEP).round() as i32)
        };
        // Bands of hue, so that the wrong plane shows.
        let color = |i: u32| 0xff00_0000 | (i / (self.base[0] * self.base[1])).wrapping_mul(0x0035_719b) & 0x00ff_ffff;
        let in_order: Vec<[i32; 3]> = (0..self.points).map(place).collect();
        let shuffled = Order::Shuffled.points(&in_order, seed);
        let colors: Vec<u32> = (0..self.points).map(color).collect();
        Cloud { positions: gather(&in_order, &shuffled), colors: gather(&colors, &shuffled) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_of_the_base_has_its_points_and_no_other_has_any() {
        let size = [160, 90];
        for (base, points) in [(size, 160 * 90 * 3), ([40, 22], 160 * 90), ([3, 1], 6000), ([1, 1], 14_400)] {
            let stack = Stack { size, base, points };
            let view = stack.view().unwrap();
            let mut counts = vec![0u32; 160 * 90];
            for position in stack.cloud(5).positions {
                let [x, y] = view.project(position).expect("in the picture").corner;
                counts[y as usize * 160 + x as usize] += 1;
            }
            let used: Vec<u32> = counts.into_iter().filter(|&n| n > 0).collect();
            assert_eq!(used.len() as u32, base[0] * base[1]);
            let mean = stack.fragments_per_pixel();
            assert!(used.iter().all(|&n| (f64::from(n) - mean).abs() < 1.0), "{base:?}: {mean}");
        }
    }
}
