//! The camera, and the numbers that a kernel needs of it.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::scene::{Bounds, Grid};

/// A right-handed perspective camera in the coordinates of the file. In the picture, x goes right and
/// y down; a point belongs to the pixel `floor((ndc * 0.5 + 0.5) * size)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    pub eye: [f64; 3],
    pub target: [f64; 3],
    #[serde(default = "up")]
    pub up: [f64; 3],
    /// Vertical field of view, degrees.
    #[serde(default = "fov_y_deg")]
    pub fov_y_deg: f64,
}

fn up() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

fn fov_y_deg() -> f64 {
    60.0
}

/// Why a camera cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CameraError {
    #[error("camera: expected finite numbers, found {0}")]
    NotFinite(&'static str),
    #[error("camera: eye and target are the same point")]
    NoDirection,
    #[error("camera: fov_y_deg must be above 0 and below 180, found {0}")]
    FieldOfView(f64),
    #[error("camera: the eye is {0:.0e} grid steps from the scene's origin; at most 7e13 are supported")]
    TooFar(f64),
}

/// Fractions of a grid step that the eye is rounded to. A scan shifted by a whole number of steps,
/// seen by a camera shifted alike, then gives the same numbers to the last bit although its f64
/// coordinates round differently (at 5,000 km in millimetres an f64 resolves 10⁻⁶ steps).
const EYE_SUBSTEPS: f64 = 4096.0;

/// Room around a scene that is fitted into the picture.
const FIT_MARGIN: f64 = 1.03;

impl Camera {
    /// Looks at the whole box from the south and above, so that all of it is in the picture. The eye
    /// and the target lie on the grid.
    pub fn fit(bounds: &Bounds, grid: &Grid, aspect: f64) -> Camera {
        Camera::fit_from(bounds, grid, aspect, DVec3::new(0.35, -1.0, 0.75))
    }

    /// The camera turned by so many degrees about the vertical through its target.
    pub fn turned(&self, degrees: f64) -> Camera {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let [x, y] = [0, 1].map(|a| self.eye[a] - self.target[a]);
        let eye = [self.target[0] + cos * x - sin * y, self.target[1] + sin * x + cos * y, self.eye[2]];
        Camera { eye, ..*self }
    }

    /// As [`Camera::fit`], from the direction `from` (from the target towards the eye).
    pub fn fit_from(bounds: &Bounds, grid: &Grid, aspect: f64, from: DVec3) -> Camera {
        let fov_y_deg = fov_y_deg();
        let forward = -from.normalize();
        let up = up_for(forward, DVec3::Z);
        let right = forward.cross(up).normalize();
        let true_up = right.cross(forward);
        let center = DVec3::from_array(bounds.center());
        let corners = (0..8).map(|corner| {
            let side = |a: usize| if corner >> a & 1 == 0 { bounds.min[a] } else { bounds.max[a] };
            DVec3::new(side(0), side(1), side(2)) - center
        });
        // In the camera's axes, with the eye at (x, y, z): a corner at (u, v, w) is in the picture if
        // |u - x| <= (w - z) tan, and alike for v. So x - z tan >= low and x + z tan <= high, with the
        // extremes of all corners; the nearest eye is where the tighter axis has both equal, and the
        // other axis has its margins alike.
        let tan_y = (0.5 * fov_y_deg.to_radians()).tan() / FIT_MARGIN;
        let fit_axis = |axis: DVec3, tan: f64| {
            corners.clone().fold((f64::NEG_INFINITY, f64::INFINITY), |(low, high), corner| {
                let (u, w) = (axis.dot(corner), forward.dot(corner) * tan);
                (low.max(u - w), high.min(u + w))
            })
        };
        let (tan_x, (left, right_end), (bottom, top)) =
            (tan_y * aspect, fit_axis(right, tan_y * aspect), fit_axis(true_up, tan_y));
        let nearest = ((right_end - left) / (2.0 * tan_x)).min((top - bottom) / (2.0 * tan_y));
        // A scene of a single point still needs a direction to look along.
        let smallest_step = grid.scale.iter().map(|step| step.abs()).fold(f64::INFINITY, f64::min);
        let along = nearest.min(-100.0 * smallest_step);
        let aside = right * (0.5 * (left + right_end)) + true_up * (0.5 * (bottom + top));
        let on_grid = |p: DVec3| {
            let steps = grid.steps(p.to_array());
            std::array::from_fn(|a| grid.origin[a] + grid.scale[a] * steps[a].round())
        };
        let eye = on_grid(center + aside + along * forward);
        let target = on_grid(center + aside);
        Camera { eye, target, up: up.to_array().map(round_unit), fov_y_deg }
    }

    /// What the kernels need to project this scene's points to `size` pixels.
    pub fn view(&self, grid: &Grid, size: [u32; 2], point_size: u32) -> Result<View, CameraError> {
        for (name, v) in [("eye", self.eye), ("target", self.target), ("up", self.up)] {
            if !v.iter().all(|x| x.is_finite()) {
                return Err(CameraError::NotFinite(name));
            }
        }
        if !(self.fov_y_deg > 0.0 && self.fov_y_deg < 180.0) {
            return Err(CameraError::FieldOfView(self.fov_y_deg));
        }
        let snap = |p: [f64; 3]| grid.steps(p).map(|s| (s * EYE_SUBSTEPS).round() / EYE_SUBSTEPS);
        let (eye, target) = (snap(self.eye), snap(self.target));
        let farthest = eye.iter().fold(0.0_f64, |m, s| m.max(s.abs()));
        // Above 2^46 the upper part of a difference would not fit 32 bits.
        if farthest > 7e13 {
            return Err(CameraError::TooFar(farthest));
        }
        let scale = DVec3::from_array(grid.scale);
        let forward = (DVec3::from_array(target) - DVec3::from_array(eye)) * scale;
        if forward.length() == 0.0 {
            return Err(CameraError::NoDirection);
        }
        let forward = forward.normalize();
        let right = forward.cross(up_for(forward, DVec3::from_array(self.up))).normalize();
        let down = forward.cross(right);
        let focal = 1.0 / (0.5 * self.fov_y_deg.to_radians()).tan();
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let row_w = forward * scale;
        // No grid position is farther than this, so depth * depth_scale stays below one.
        let reach: f64 = (0..3).map(|a| row_w[a].abs() * (2f64.powi(31) + eye[a].abs())).sum();
        let row = |v: DVec3, last: f32| [v.x as f32, v.y as f32, v.z as f32, last];
        let whole = eye.map(f64::floor);
        Ok(View {
            row_x: row(right * scale * (focal / aspect), 0.0),
            row_y: row(down * scale * focal, 0.0),
            row_w: row(row_w, 2f64.powi(-(reach.log2().ceil() as i32 + 1)) as f32),
            eye_high: std::array::from_fn(|a| ((whole[a] as i64) >> 16) as i32),
            width: size[0],
            eye_low: std::array::from_fn(|a| (whole[a] as i64 & 0xffff) as i32),
            height: size[1],
            eye_fraction: std::array::from_fn(|a| (eye[a] - whole[a]) as f32),
            point_size,
        })
    }
}

/// `x.floor() as i32` for numbers of moderate size; without SSE4.1 that is a call of a library.
fn floor(x: f32) -> i32 {
    let toward_zero = x as i32;
    toward_zero - i32::from(toward_zero as f32 > x)
}

/// `up` unless it is (nearly) the viewing direction; then another axis.
fn up_for(forward: DVec3, up: DVec3) -> DVec3 {
    [up.normalize_or_zero(), DVec3::Y, DVec3::X]
        .into_iter()
        .find(|candidate| forward.cross(*candidate).length() > 1e-6)
        .expect("three axes cannot all be parallel to one direction")
}

fn round_unit(x: f64) -> f64 {
    if x.abs() < 1e-12 { 0.0 } else { x }
}

/// A camera in numbers for the kernels. Layout shared with `shaders/project.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct View {
    /// Clip-space x per grid step; the fourth number is unused.
    pub row_x: [f32; 4],
    /// Clip-space y (down) per grid step; the fourth number is unused.
    pub row_y: [f32; 4],
    /// Depth, in the file's unit, per grid step; the fourth number is a power of two that takes every
    /// depth below one (for the depth texture of the hardware rasterizer).
    pub row_w: [f32; 4],
    /// The eye's whole grid position is `eye_high * 65536 + eye_low`.
    pub eye_high: [i32; 3],
    pub width: u32,
    pub eye_low: [i32; 3],
    pub height: u32,
    /// Rest of the eye's position, in grid steps, from 0 to 1.
    pub eye_fraction: [f32; 3],
    /// Width of a point, pixels.
    pub point_size: u32,
}

/// Where a point falls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// Column and row of the upper left pixel of the point's square; may be outside of the picture
    /// by up to `point_size - 1`.
    pub corner: [i32; 2],
    /// Distance along the viewing direction, in the file's unit.
    pub depth: f32,
}

impl View {
    /// Whether both are of pictures of the same width and height.
    pub fn has_size_of(&self, other: &View) -> bool {
        (self.width, self.height) == (other.width, other.height)
    }

    /// Whether every position in this box is less than 2³¹ grid steps from the eye on each axis. Kernels made for
    /// that subtract the eye's position once instead of in halves; no bit of a picture changes.
    pub fn is_near(&self, low: [i32; 3], high: [i32; 3]) -> bool {
        let fits = |a: usize| {
            let eye = (i64::from(self.eye_high[a]) << 16) + i64::from(self.eye_low[a]);
            let differences = [i64::from(low[a]) - eye, i64::from(high[a]) - eye, eye];
            differences.iter().all(|&steps| i32::try_from(steps).is_ok())
        };
        (0..3).all(fits)
    }

    /// Twin of `project` in `shaders/project.wgsl`: `None` behind the eye or outside of the picture.
    pub fn project(&self, position: [i32; 3]) -> Option<Projected> {
        // The upper and lower 16 bits are subtracted as integers, so that no difference overflows,
        // however far the eye is, and the only rounding is that of the sum.
        let d: [f32; 3] = std::array::from_fn(|a| {
            let high = ((position[a] >> 16) - self.eye_high[a]) as f32;
            let low = ((position[a] & 0xffff) - self.eye_low[a]) as f32;
            (high * 65536.0 + low) - self.eye_fraction[a]
        });
        let dot = |row: &[f32; 4]| (row[0] * d[0] + row[1] * d[1]) + row[2] * d[2];
        let depth = dot(&self.row_w);
        // Not a number is no place either.
        if depth.is_nan() || depth <= 0.0 {
            return None;
        }
        let half = 0.5 * (self.point_size - 1) as f32;
        let x = (dot(&self.row_x) / depth * 0.5 + 0.5) * self.width as f32 - half;
        let y = (dot(&self.row_y) / depth * 0.5 + 0.5) * self.height as f32 - half;
        let edge = -(self.point_size as f32) + 1.0;
        if !(x >= edge && x < self.width as f32 && y >= edge && y < self.height as f32) {
            return None;
        }
        Some(Projected { corner: [floor(x), floor(y)], depth })
    }
}
