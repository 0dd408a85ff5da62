//! A short way from one camera to another, so that the eye can follow.

use glam::DVec3;

use super::{Axes, FOV_Y_DEG, reach};
use crate::render::{Camera, Projection};

/// Seconds that a way takes: long enough to see where it goes, too short to wait for.
const SECS: f64 = 0.25;

/// On its way from one camera to another. Times are in seconds of any one clock.
#[derive(Debug, Clone)]
pub struct Glide {
    from: Camera,
    to: Camera,
    began: f64,
}

impl Glide {
    pub fn new(from: Camera, to: Camera, now: f64) -> Glide {
        Glide { from, to, began: now }
    }

    /// Where it ends.
    pub fn to(&self) -> Camera {
        self.to
    }

    /// The camera at a time, and whether that is the end. The last is exactly [`Glide::to`]. The horizon stays level,
    /// and the distance changes by equal factors in equal times.
    pub fn at(&self, now: f64) -> (Camera, bool) {
        let part = (now - self.began) / SECS;
        if part.is_nan() || part >= 1.0 {
            return (self.to, true);
        }
        let part = part.max(0.0);
        let part = part * part * (3.0 - 2.0 * part);
        let between = between(&self.from, &self.to, part);
        match between {
            Some(camera) => (camera, false),
            None => (self.to, true),
        }
    }
}

/// `None` where numbers are too large for anything between them.
fn between(from: &Camera, to: &Camera, part: f64) -> Option<Camera> {
    let mix = |a: f64, b: f64| a + (b - a) * part;
    let angles = |camera: &Camera| {
        let axes = Axes::of(camera);
        (axes.right.y.atan2(axes.right.x), axes.forward.z.clamp(-1.0, 1.0).asin())
    };
    let ((heading, pitch), (end_heading, end_pitch)) = (angles(from), angles(to));
    // The short way round.
    let turn = (end_heading - heading).sin().atan2((end_heading - heading).cos());
    let axes = Axes::level(heading + turn * part, mix(pitch, end_pitch));
    let flat = to.projection == Projection::Orthographic || from.projection == Projection::Orthographic;
    // Without perspective the eye's distance says nothing, but the picture's height does.
    let distance = |camera: &Camera| match flat {
        true => reach(camera),
        false => DVec3::from_array(camera.target).distance(DVec3::from_array(camera.eye)),
    };
    let distance = mix(distance(from).ln(), distance(to).ln()).exp();
    let target = DVec3::from_array(from.target).lerp(DVec3::from_array(to.target), part);
    let eye = target - axes.forward * distance;
    let usable = eye.is_finite() && target.is_finite() && axes.up.is_finite() && eye != target;
    usable.then(|| Camera {
        eye: eye.into(),
        target: target.into(),
        up: axes.up.into(),
        fov_y_deg: if flat { FOV_Y_DEG } else { mix(from.fov_y_deg, to.fov_y_deg) },
        projection: to.projection,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(eye: [f64; 3], target: [f64; 3], up: [f64; 3]) -> Camera {
        Camera { eye, target, up, fov_y_deg: 60.0, projection: Default::default() }
    }

    #[test]
    fn begins_and_ends_exactly_and_stays_level_between() {
        let far = camera([500_100.0, 4_999_000.0, 900.0], [500_100.0, 5_000_000.0, 300.0], [0.0, 0.0, 1.0]);
        let top = camera([500_000.0, 5_000_100.0, 700.0], [500_000.0, 5_000_100.0, 300.0], [0.0, 1.0, 0.0]);
        let glide = Glide::new(far, top, 10.0);
        assert_eq!(glide.at(10.0 + SECS), (top, true));
        assert_eq!(glide.at(1e9), (top, true));
        assert_eq!(glide.at(f64::NAN), (top, true), "a broken clock ends it");
        let (first, over) = glide.at(10.0);
        assert!(!over && DVec3::from_array(first.eye).distance(DVec3::from_array(far.eye)) < 1e-6);
        let mut last = f64::INFINITY;
        for step in 0..20 {
            let (camera, over) = glide.at(10.0 + SECS * f64::from(step) / 20.0);
            let axes = Axes::of(&camera);
            assert!(!over && axes.right.z.abs() < 1e-9 && axes.up.z > -1e-9, "{axes:?}");
            let left = DVec3::from_array(camera.eye).distance(DVec3::from_array(top.eye));
            assert!(left < last + 1e-9, "it turns back at step {step}");
            last = left;
        }
    }

    #[test]
    fn turns_the_short_way_round() {
        let at = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            camera([10.0 * cos, 10.0 * sin, 0.0], [0.0; 3], [0.0, 0.0, 1.0])
        };
        let (camera, _) = Glide::new(at(170.0), at(-170.0), 0.0).at(0.5 * SECS);
        assert!(DVec3::from_array(camera.eye).distance(DVec3::new(-10.0, 0.0, 0.0)) < 1e-9, "{camera:?}");
    }

    #[test]
    fn numbers_without_a_middle_are_jumped_over() {
        let near = camera([0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let broken = camera([f64::MAX, 0.0, 0.0], [-f64::MAX, 0.0, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(Glide::new(near, broken, 0.0).at(0.5 * SECS), (broken, true));
    }
}
