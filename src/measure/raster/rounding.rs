//! Where a point is to the last bit that counts, and how far 32-bit arithmetic may end from there.
//!
//! `project` (`shaders/project.wgsl`, `View::project`) computes in 32 bits, and WGSL leaves devices free to fuse
//! multiplications with additions, to add in another order, and to be off by 2.5 units in the last place when they
//! divide. All of these results are right. With u = 2⁻²⁴, the largest relative error of one rounded operation, for
//! the view's rows r (taken as they are: all compute with the same 32-bit numbers) and d = position − eye:
//!
//! 1. Per axis, d is a conversion, a sum and a difference, of numbers up to |d| + 1: off by at most 3u (|d| + 1).
//! 2. A product of a row with d passes through a multiplication and two additions more, so that the sum is off by at
//!    most E(r) = 6u Σ |rₐ| (|dₐ| + 1), and terms of u², for which 6 is taken as 8. The depth is w = r_w · d, with
//!    the error E(r_w).
//! 3. The quotient q = x / w is off by (E(r_x) + |q| E(r_w)) / (w − E(r_w)) + 5u |q|.
//! 4. The pixel coordinate (q/2 + ½) · width halves that and adds the roundings of a sum and a product: in all
//!    width · (δq / 2 + 2u · |q/2 + ½|), for which 2 is taken as 3.

use crate::render::View;

const U: f64 = 1.0 / (1 << 24) as f64;

/// A point in a picture of one-pixel points, in 64 bits, with bounds of what 32 bits make of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exact {
    /// Pixel coordinates, right and down; the pixel is the whole number below each.
    pub at: [f64; 2],
    pub at_error: [f64; 2],
    pub depth: f64,
    pub depth_error: f64,
}

impl Exact {
    /// `None` for a point that is behind the eye for certain.
    pub fn of(view: &View, position: [i32; 3]) -> Option<Exact> {
        let d: [f64; 3] = std::array::from_fn(|a| {
            let eye = i64::from(view.eye_high[a]) * 65_536 + i64::from(view.eye_low[a]);
            (i64::from(position[a]) - eye) as f64 - f64::from(view.eye_fraction[a])
        });
        let dot = |row: &[f32; 4]| (0..3).map(|a| f64::from(row[a]) * d[a]).sum::<f64>();
        let error =
            |row: &[f32; 4]| 8.0 * U * (0..3).map(|a| f64::from(row[a]).abs() * (d[a].abs() + 1.0)).sum::<f64>();
        let (depth, depth_error) = (dot(&view.row_w), error(&view.row_w));
        if depth + depth_error <= 0.0 {
            return None;
        }
        // Next to the eye, nothing is certain.
        let surely = depth - depth_error;
        let axes = [(&view.row_x, view.width), (&view.row_y, view.height)].map(|(row, pixels)| {
            let q = dot(row) / depth;
            let q_error = if surely > 0.0 {
                (error(row) + q.abs() * depth_error) / surely + 5.0 * U * q.abs()
            } else {
                f64::INFINITY
            };
            let share = 0.5 * q + 0.5;
            let pixels = f64::from(pixels);
            (share * pixels, pixels * (0.5 * q_error + 3.0 * U * share.abs()))
        });
        Some(Exact { at: axes.map(|axis| axis.0), at_error: axes.map(|axis| axis.1), depth, depth_error })
    }

    /// Whether 32 bits may put it into the pixel.
    pub fn may_be_in(&self, pixel: [u32; 2]) -> bool {
        (0..2).all(|a| {
            let low = f64::from(pixel[a]);
            self.at[a] + self.at_error[a] >= low && self.at[a] - self.at_error[a] <= low + 1.0
        })
    }

    /// Whether 32 bits must put it into the pixel.
    pub fn must_be_in(&self, pixel: [u32; 2]) -> bool {
        self.depth > self.depth_error
            && (0..2).all(|a| {
                let low = f64::from(pixel[a]);
                self.at[a] - self.at_error[a] > low && self.at[a] + self.at_error[a] < low + 1.0
            })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::{render::Camera, scene::Grid};

    /// `View::project` as a device that fuses, adds the other way round and divides by multiplying would do it.
    pub fn project_fused(view: &View, position: [i32; 3]) -> Option<([f32; 2], f32)> {
        let d: [f32; 3] = std::array::from_fn(|a| {
            let high = ((position[a] >> 16) - view.eye_high[a]) as f32;
            let low = ((position[a] & 0xffff) - view.eye_low[a]) as f32;
            high.mul_add(65_536.0, low) - view.eye_fraction[a]
        });
        let dot = |row: &[f32; 4]| row[0].mul_add(d[0], row[1].mul_add(d[1], row[2] * d[2]));
        let depth = dot(&view.row_w);
        if depth.is_nan() || depth <= 0.0 {
            return None;
        }
        let inverse = 1.0 / depth;
        let at = |row, pixels: u32| (dot(row) * inverse).mul_add(0.5, 0.5) * pixels as f32;
        let at = [at(&view.row_x, view.width), at(&view.row_y, view.height)];
        let is_inside = at[0] >= 0.0 && at[0] < view.width as f32 && at[1] >= 0.0 && at[1] < view.height as f32;
        is_inside.then_some((at, depth))
    }

    /// Both ways to compute stay within the bounds, and the bounds are not far: some point uses a fifth of its.
    #[test]
    fn rounding_stays_within_its_bounds() {
        let grid = Grid { scale: [0.001, 0.001, 0.0005], origin: [0.0; 3] };
        let mut state = 1u64;
        let mut next = |side: i64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) as i64 % side - side / 2) as i32
        };
        let (mut used, mut seen) = (0.0_f64, 0);
        for eye in [[3.0015, -25.0, 11.0], [1e6, -1e6, 5e5], [0.0123, 0.5, 0.25], [-4e3, 9e3, 700.0]] {
            let camera = Camera { eye, target: [0.0; 3], up: [0.0, 0.0, 1.0], fov_y_deg: 60.0, ..Default::default() };
            let view = camera.view(&grid, [1920, 1080], 1).unwrap();
            for side in [2000, 100_000, 30_000_000] {
                for _ in 0..20_000 {
                    let position = [next(side), next(side), next(side)];
                    let exact = Exact::of(&view, position);
                    if let Some(projected) = view.project(position) {
                        let exact = exact.expect("it is before the eye");
                        assert!(exact.may_be_in(projected.corner.map(|c| c as u32)), "{position:?} {exact:?}");
                    }
                    let Some((at, depth)) = project_fused(&view, position) else { continue };
                    let exact = exact.expect("it is before the eye");
                    let off = (0..2).map(|a| (f64::from(at[a]) - exact.at[a]).abs() / exact.at_error[a]);
                    let off = off.fold((f64::from(depth) - exact.depth).abs() / exact.depth_error, f64::max);
                    assert!(off <= 1.0, "{position:?}: {off} of {exact:?}");
                    used = used.max(off);
                    seen += 1;
                }
            }
        }
        assert!(seen > 20_000 && used > 0.2, "{seen} points, {used} of the bounds used");
    }

    #[test]
    fn a_border_is_in_doubt_and_a_centre_is_not() {
        let exact = |x: f64| Exact { at: [x, 7.5], at_error: [0.001; 2], depth: 10.0, depth_error: 1e-5 };
        assert!(exact(3.5).must_be_in([3, 7]) && !exact(3.5).may_be_in([4, 7]));
        assert!(
            exact(3.9995).may_be_in([4, 7]) && exact(3.9995).may_be_in([3, 7]) && !exact(3.9995).must_be_in([3, 7])
        );
        assert!(!exact(3.998).may_be_in([4, 7]));
    }
}
