//! The camera.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::{
    point_size::{MAX_WORLD_PX, PointWidth},
    view::View,
};
use crate::scene::{Bounds, Grid};

/// How space becomes a picture.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Projection {
    /// What is twice as far looks half as large.
    #[default]
    Perspective,
    /// Parallel lines stay parallel, and everything looks as large as it would at the target in perspective: the
    /// picture is `2 * |target - eye| * tan(fov_y / 2)` high. What lies behind the eye is not drawn.
    Orthographic,
}

impl Projection {
    fn is_perspective(&self) -> bool {
        *self == Projection::Perspective
    }
}

/// A right-handed camera in the coordinates of the file. In the picture, x goes right and
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
    #[serde(default, skip_serializing_if = "Projection::is_perspective")]
    pub projection: Projection,
}

/// Looks north at the origin, from one unit away.
impl Default for Camera {
    fn default() -> Self {
        let projection = Projection::Perspective;
        Camera { eye: [0.0, -1.0, 0.0], target: [0.0; 3], up: up(), fov_y_deg: fov_y_deg(), projection }
    }
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

/// From a scene towards the eye of the first camera.
pub const SOUTH_AND_ABOVE: DVec3 = DVec3::new(0.35, -1.0, 0.75);

/// Room around a scene that is fitted into the picture.
const FIT_MARGIN: f64 = 1.03;

impl Camera {
    /// Looks at the whole box from the south and above, so that all of it is in the picture. The eye
    /// and the target lie on the grid.
    pub fn fit(bounds: &Bounds, grid: &Grid, aspect: f64) -> Camera {
        Camera::fit_from(bounds, grid, aspect, SOUTH_AND_ABOVE)
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
        Camera::fit_as(bounds, grid, aspect, from, Projection::Perspective)
    }

    /// As [`Camera::fit_from`], with any projection.
    pub fn fit_as(bounds: &Bounds, grid: &Grid, aspect: f64, from: DVec3, projection: Projection) -> Camera {
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
        // other axis has its margins alike. Without perspective the extremes are those of u and v themselves.
        let tan_y = (0.5 * fov_y_deg.to_radians()).tan() / FIT_MARGIN;
        let fit_axis = |axis: DVec3, tan: f64| {
            let tan = if projection.is_perspective() { tan } else { 0.0 };
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
        Camera { eye, target, up: up.to_array().map(round_unit), fov_y_deg, projection }.before(bounds)
    }

    /// An orthographic camera does not draw what lies behind its eye: the same picture from so far back that all of
    /// the box lies before it. A perspective camera stays where it is.
    pub fn before(self, bounds: &Bounds) -> Camera {
        let [eye, target] = [self.eye, self.target].map(DVec3::from_array);
        let (Some(forward), Projection::Orthographic) = ((target - eye).try_normalize(), self.projection) else {
            return self;
        };
        let nearest = |a: usize| forward[a] * (if forward[a] > 0.0 { bounds.min[a] } else { bounds.max[a] } - eye[a]);
        let behind = -(0..3).map(nearest).sum::<f64>();
        if behind.is_nan() || behind < 0.0 {
            return self;
        }
        let distance = eye.distance(target);
        // Not just before it: that is rounded.
        let back = behind + 0.01 * (distance + bounds.diagonal());
        let half = (0.5 * self.fov_y_deg.to_radians()).tan() * distance / (distance + back);
        let fov_y_deg = 2.0 * half.atan().to_degrees();
        Camera { eye: (eye - forward * back).to_array(), fov_y_deg, ..self }
    }

    /// Orthographic if this camera or `projection` is.
    pub fn or_as(self, projection: Projection) -> Camera {
        if self.projection.is_perspective() { Camera { projection, ..self } } else { self }
    }

    /// Height of the picture at the target, in the file's unit.
    pub fn height_at_target(&self) -> f64 {
        let distance = DVec3::from_array(self.eye).distance(DVec3::from_array(self.target));
        2.0 * distance * (0.5 * self.fov_y_deg.to_radians()).tan()
    }

    /// # Errors
    /// If a number is not finite, or the field of view none.
    pub(super) fn check(&self) -> Result<(), CameraError> {
        for (name, v) in [("eye", self.eye), ("target", self.target), ("up", self.up)] {
            if !v.iter().all(|x| x.is_finite()) {
                return Err(CameraError::NotFinite(name));
            }
        }
        if self.fov_y_deg > 0.0 && self.fov_y_deg < 180.0 {
            Ok(())
        } else {
            Err(CameraError::FieldOfView(self.fov_y_deg))
        }
    }

    /// What the kernels need to project this scene's points to `size` pixels.
    pub fn view(&self, grid: &Grid, size: [u32; 2], point_size: impl Into<PointWidth>) -> Result<View, CameraError> {
        self.check()?;
        let snap = |p: [f64; 3]| grid.steps(p).map(|s| (s * EYE_SUBSTEPS).round() / EYE_SUBSTEPS);
        let (eye, target) = (snap(self.eye), snap(self.target));
        let scale = DVec3::from_array(grid.scale);
        let forward = (DVec3::from_array(target) - DVec3::from_array(eye)) * scale;
        // Without perspective the eye may be far behind what is seen, and the difference of large numbers would
        // decide the pixel: positions are taken from the target.
        let anchor = if self.projection.is_perspective() { eye } else { target };
        let farthest = anchor.iter().fold(0.0_f64, |m, s| m.max(s.abs()));
        // Above 2^46 the upper part of a difference would not fit 32 bits.
        if farthest > 7e13 {
            return Err(CameraError::TooFar(farthest));
        }
        let distance = forward.length();
        if distance == 0.0 {
            return Err(CameraError::NoDirection);
        }
        let forward = forward.normalize();
        let right = forward.cross(up_for(forward, DVec3::from_array(self.up))).normalize();
        let down = forward.cross(right);
        let focal = 1.0 / (0.5 * self.fov_y_deg.to_radians()).tan();
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let row_w = forward * scale;
        // Pixels of one unit at a depth of one, or at any.
        let (zoom, anchor_depth) = match self.projection {
            Projection::Perspective => (focal, 0.0),
            Projection::Orthographic => (focal / distance, distance),
        };
        let pixels_per_unit = zoom * 0.5 * f64::from(size[1]);
        // No grid position is farther than this, so depth * depth_scale stays below one.
        let reach: f64 = (0..3).map(|a| row_w[a].abs() * (2f64.powi(31) + anchor[a].abs())).sum::<f64>() + anchor_depth;
        let row = |v: DVec3, last: f32| [v.x as f32, v.y as f32, v.z as f32, last];
        let whole = anchor.map(f64::floor);
        let (point_size, row_y_last) = match (point_size.into(), self.projection) {
            (PointWidth::Pixels(pixels), Projection::Perspective) => (pixels, 0.0),
            (PointWidth::World(size), Projection::Perspective) => (MAX_WORLD_PX, size * pixels_per_unit),
            (size, Projection::Orthographic) => {
                let pixels = match size {
                    PointWidth::Pixels(pixels) => pixels,
                    PointWidth::World(size) => (size * pixels_per_unit + 0.5).clamp(1.0, MAX_WORLD_PX.into()) as u32,
                };
                (pixels, (0.5 * fov_y_deg().to_radians()).tan().recip() / zoom)
            }
        };
        Ok(View {
            row_x: row(right * scale * (zoom / aspect), anchor_depth as f32),
            row_y: row(down * scale * zoom, row_y_last as f32),
            row_w: row(row_w, 2f64.powi(-(reach.log2().ceil() as i32 + 1)) as f32),
            eye_high: std::array::from_fn(|a| ((whole[a] as i64) >> 16) as i32),
            width: size[0],
            eye_low: std::array::from_fn(|a| (whole[a] as i64 & 0xffff) as i32),
            height: size[1],
            eye_fraction: std::array::from_fn(|a| (anchor[a] - whole[a]) as f32),
            point_size,
        })
    }
}

/// `up` unless it is (nearly) the viewing direction; then another axis.
pub(super) fn up_for(forward: DVec3, up: DVec3) -> DVec3 {
    [up.normalize_or_zero(), DVec3::Y, DVec3::X]
        .into_iter()
        .find(|candidate| forward.cross(*candidate).length() > 1e-6)
        .expect("three axes cannot all be parallel to one direction")
}

fn round_unit(x: f64) -> f64 {
    if x.abs() < 1e-12 { 0.0 } else { x }
}
