//! The camera in the user's hands: orbit, pan, zoom to the cursor, fly. In f64, in the coordinates of
//! the file; knows nothing of windows. Cursor positions are in pixels from the upper left corner.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};

use crate::{
    render::Camera,
    scene::{Bounds, Grid},
};

/// Distance from the scene, in units of its size, at which zooming out ends.
const FARTHEST: f64 = 1e4;
/// Farthest that the eye may be from the grid's origin, in steps; [`Camera::view`] takes ten times that.
const FARTHEST_STEPS: f64 = 1e12;

/// Where the user looks at a scene from. The pivot that it turns around is the camera's target.
#[derive(Debug, Clone)]
pub struct Navigation {
    camera: Camera,
    grid: Grid,
    bounds: Bounds,
    /// Of the picture, in pixels.
    size: DVec2,
}

impl Navigation {
    /// All of the box in the picture. The box may be as broken as a header can be.
    pub fn new(grid: Grid, bounds: &Bounds, size: [u32; 2]) -> Navigation {
        let bounds = representable(bounds, &grid);
        let size = pixels(size);
        let camera = Camera::fit(&bounds, &grid, size.x / size.y);
        let mut navigation = Navigation { camera, grid, bounds, size };
        navigation.pull_in();
        navigation
    }

    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The picture has another size now; the camera stays.
    pub fn resize(&mut self, size: [u32; 2]) {
        self.size = pixels(size);
    }

    /// Shows all of the box from the usual direction.
    pub fn home(&mut self) {
        self.camera = Camera::fit(&self.bounds, &self.grid, self.size.x / self.size.y);
        self.pull_in();
    }

    /// Shows all of the box from the direction `from` (from the scene towards the eye).
    pub fn look_from(&mut self, from: DVec3) {
        self.camera = Camera::fit_from(&self.bounds, &self.grid, self.size.x / self.size.y, from);
        self.pull_in();
    }

    /// Takes over a camera from elsewhere.
    pub fn set_camera(&mut self, camera: Camera) {
        self.camera = camera;
    }

    /// Turns around the pivot, as if the mouse held the scene's near side: the height of the picture
    /// is half a turn. Straight down and straight up are the ends, so nothing ever flips over.
    pub fn orbit(&mut self, moved: DVec2) {
        let axes = self.axes();
        let angle = moved * (PI / self.size.y);
        let heading = axes.right.y.atan2(axes.right.x) - angle.x;
        let pitch = (axes.forward.z.clamp(-1.0, 1.0).asin() - angle.y).clamp(-FRAC_PI_2, FRAC_PI_2);
        let ahead = DVec3::new(-heading.sin(), heading.cos(), 0.0);
        let forward = ahead * pitch.cos() + DVec3::Z * pitch.sin();
        let up = DVec3::Z * pitch.cos() - ahead * pitch.sin();
        let target = DVec3::from_array(self.camera.target);
        self.place(target - forward * self.distance(), target, up);
    }

    /// The point of the scene that a cursor holds: at `depth` along the viewing direction where that
    /// is known, else as far away as the pivot.
    pub fn grab(&self, cursor: DVec2, depth: Option<f64>) -> DVec3 {
        self.eye() + self.ray(cursor) * depth.unwrap_or_else(|| self.distance())
    }

    /// Moves sideways until `grabbed` is under the cursor.
    pub fn pan(&mut self, grabbed: DVec3, cursor: DVec2) {
        let axes = self.axes();
        let depth = (grabbed - self.eye()).dot(axes.forward);
        let eye = grabbed - self.ray(cursor) * depth;
        self.place(eye, eye + axes.forward * self.distance(), axes.up);
    }

    /// Brings what is under the cursor closer (`factor` below 1) or farther away. It stays under the
    /// cursor, and its depth becomes the pivot's.
    pub fn zoom(&mut self, cursor: DVec2, factor: f64, depth: Option<f64>) {
        let axes = self.axes();
        let depth = depth.unwrap_or_else(|| self.distance());
        let (nearest, farthest) = self.depth_range();
        let new_depth = (depth * factor).clamp(nearest, farthest);
        // Someone who is outside of the range already may come back, but not go on.
        if (new_depth - depth) * (factor - 1.0) <= 0.0 {
            return;
        }
        let ray = self.ray(cursor);
        let eye = self.eye() + ray * (depth - new_depth);
        self.place(eye, eye + axes.forward * new_depth, axes.up);
    }

    /// Flies right, forward and up (along the file's z) by so many pivot distances.
    pub fn fly(&mut self, right: f64, forward: f64, up: f64) {
        let axes = self.axes();
        let by = (axes.right * right + axes.forward * forward + DVec3::Z * up) * self.distance();
        self.place(self.eye() + by, DVec3::from_array(self.camera.target) + by, axes.up);
    }

    /// Where a point of the scene is: its pixel, and its depth along the viewing direction; `None` for
    /// what is behind the eye.
    pub fn locate(&self, point: DVec3) -> Option<(DVec2, f64)> {
        let axes = self.axes();
        let at = point - self.eye();
        let depth = at.dot(axes.forward);
        if depth.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        let tan_y = (0.5 * self.camera.fov_y_deg.to_radians()).tan();
        let ndc = DVec2::new(at.dot(axes.right) * self.size.y / self.size.x, -at.dot(axes.up)) / (depth * tan_y);
        Some(((ndc * 0.5 + DVec2::splat(0.5)) * self.size, depth))
    }

    /// Makes `point` the pivot: the camera moves sideways until it is in the middle of the picture.
    pub fn center_on(&mut self, point: DVec3) {
        let axes = self.axes();
        let depth = (point - self.eye()).dot(axes.forward).max(self.depth_range().0);
        self.place(point - axes.forward * depth, point, axes.up);
    }

    /// Distance from the eye to the pivot.
    pub fn distance(&self) -> f64 {
        DVec3::from_array(self.camera.target).distance(self.eye())
    }

    fn eye(&self) -> DVec3 {
        DVec3::from_array(self.camera.eye)
    }

    fn axes(&self) -> Axes {
        let forward = (DVec3::from_array(self.camera.target) - self.eye()).normalize();
        // Top views carry an `up` along y, all others one that is not the viewing direction.
        let right = forward.cross(DVec3::from_array(self.camera.up)).normalize();
        Axes { right, forward, up: right.cross(forward) }
    }

    /// From the eye through a pixel, one unit long along the viewing direction.
    fn ray(&self, cursor: DVec2) -> DVec3 {
        let axes = self.axes();
        let tan_y = (0.5 * self.camera.fov_y_deg.to_radians()).tan();
        let ndc = cursor / self.size * 2.0 - DVec2::ONE;
        axes.forward + axes.right * (ndc.x * tan_y * self.size.x / self.size.y) - axes.up * (ndc.y * tan_y)
    }

    /// Nearest and farthest that zooming goes.
    fn depth_range(&self) -> (f64, f64) {
        let step = smallest(self.grid.scale);
        let coordinate = self.camera.target.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        // Below the second bound f64 coordinates no longer tell eye and pivot apart well enough.
        let nearest = (4.0 * step).max(1e-11 * coordinate);
        (nearest, (FARTHEST * self.bounds.diagonal()).max(1e6 * step).max(nearest))
    }

    /// A box of absurd size cannot be seen from where all of it would be in the picture.
    fn pull_in(&mut self) {
        let target = DVec3::from_array(self.camera.target);
        let mut eye = self.eye();
        while !self.is_reachable(eye) && target.distance(eye) > self.depth_range().0 {
            eye = target + (eye - target) * 0.5;
            self.camera.eye = eye.into();
        }
    }

    fn is_reachable(&self, eye: DVec3) -> bool {
        self.grid.steps(eye.to_array()).iter().all(|s| s.abs() <= FARTHEST_STEPS)
    }

    /// Takes the camera there, unless it is where no picture can be drawn.
    fn place(&mut self, eye: DVec3, target: DVec3, up: DVec3) {
        if self.is_reachable(eye) && target.is_finite() && up.is_finite() && target != eye {
            self.camera = Camera { eye: eye.into(), target: target.into(), up: up.into(), ..self.camera };
        }
    }
}

/// Unit vectors of the picture.
#[derive(Debug)]
struct Axes {
    right: DVec3,
    forward: DVec3,
    up: DVec3,
}

fn pixels(size: [u32; 2]) -> DVec2 {
    DVec2::new(f64::from(size[0].max(1)), f64::from(size[1].max(1)))
}

fn smallest(scale: [f64; 3]) -> f64 {
    scale.into_iter().fold(f64::INFINITY, f64::min)
}

/// The part of the box that the grid can have points in; a header may say anything.
fn representable(bounds: &Bounds, grid: &Grid) -> Bounds {
    let low = grid.world([i32::MIN; 3]);
    let high = grid.world([i32::MAX; 3]);
    if !bounds.is_sane() {
        return Bounds { min: grid.world([-1000; 3]), max: grid.world([1000; 3]) };
    }
    Bounds {
        min: std::array::from_fn(|a| bounds.min[a].clamp(low[a], high[a])),
        max: std::array::from_fn(|a| bounds.max[a].clamp(low[a], high[a])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [1280, 800];

    fn utm_grid() -> Grid {
        Grid { scale: [0.001; 3], origin: [500_000.0, 5_000_000.0, 0.0] }
    }

    fn town() -> Navigation {
        let bounds = Bounds { min: [500_010.0, 5_000_020.0, 300.0], max: [500_510.0, 5_000_320.0, 380.0] };
        Navigation::new(utm_grid(), &bounds, SIZE)
    }

    /// The pixel that shows `point`.
    fn pixel(navigation: &Navigation, point: DVec3) -> DVec2 {
        navigation.locate(point).expect("before the eye").0
    }

    fn assert_near(a: DVec2, b: DVec2) {
        assert!(a.distance(b) < 1e-3, "{a} is not {b}");
    }

    fn assert_usable(navigation: &Navigation) {
        let view = navigation.camera.view(&navigation.grid, SIZE, 2).expect("camera");
        for row in [view.row_x, view.row_y, view.row_w] {
            assert!(row.iter().all(|x| x.is_finite()), "{navigation:?}");
        }
    }

    #[test]
    fn the_first_camera_is_that_of_the_headless_picture() {
        let n = town();
        assert_eq!(*n.camera(), Camera::fit(&n.bounds, &n.grid, 1.6));
    }

    #[test]
    fn pixels_agree_with_the_kernels() {
        let mut n = town();
        n.orbit(DVec2::new(77.0, -31.0));
        let view = n.camera.view(&n.grid, SIZE, 1).expect("camera");
        for cursor in [DVec2::new(3.5, 5.5), DVec2::new(640.5, 400.5), DVec2::new(1200.5, 700.5)] {
            let steps = n.grid.steps(n.grab(cursor, Some(300.0)).to_array()).map(|s| s.round() as i32);
            let projected = view.project(steps).expect("visible");
            assert_eq!(projected.corner, [cursor.x as i32, cursor.y as i32]);
            assert!((projected.depth - 300.0).abs() < 0.01, "{}", projected.depth);
        }
    }

    #[test]
    fn fit_shows_all_corners_from_everywhere_and_in_any_window() {
        for size in [[1280, 800], [300, 900], [2000, 100], [1, 1]] {
            for from in [DVec3::Z, -DVec3::Y, DVec3::X, DVec3::new(0.35, -1.0, 0.75)] {
                let mut n = town();
                n.resize(size);
                n.look_from(from);
                for corner in 0..8 {
                    let side = |a: usize| if corner >> a & 1 == 0 { n.bounds.min[a] } else { n.bounds.max[a] };
                    let at = pixel(&n, DVec3::new(side(0), side(1), side(2)));
                    assert!(at.x >= 0.0 && at.x < n.size.x && at.y >= 0.0 && at.y < n.size.y, "{size:?} {from}: {at}");
                }
            }
        }
    }

    #[test]
    fn orbit_keeps_pivot_and_distance() {
        let mut n = town();
        let (target, distance) = (n.camera.target, n.distance());
        for i in 0..2000 {
            n.orbit(DVec2::new(13.0, f64::from(i % 7) * 3.0 - 9.0));
        }
        assert_eq!(n.camera.target, target);
        assert!((n.distance() / distance - 1.0).abs() < 1e-6, "{} of {distance}", n.distance());
        assert_near(pixel(&n, DVec3::from_array(target)), n.size * 0.5);
    }

    #[test]
    fn orbit_follows_the_hand() {
        let mut n = town();
        let eye = n.eye();
        let near_side = n.eye() + (DVec3::from_array(n.camera.target) - eye) * 0.8;
        let before = pixel(&n, near_side);
        n.orbit(DVec2::new(20.0, 10.0));
        let moved = pixel(&n, near_side) - before;
        assert!(moved.x > 0.0 && moved.y > 0.0, "{moved}");
    }

    #[test]
    fn orbit_stops_at_the_poles_and_keeps_the_horizon_level() {
        let mut n = town();
        for (dy, pole) in [(10_000.0, -1.0), (-50_000.0, 1.0)] {
            for part in 0..10 {
                n.orbit(DVec2::new(f64::from(part) * 5.0, dy / 10.0));
                let axes = n.axes();
                assert!(axes.up.z > -1e-9, "upside down: {axes:?}");
                assert!(axes.right.z.abs() < 1e-9, "the horizon tilts: {}", axes.right);
            }
            assert!((n.axes().forward.z - pole).abs() < 1e-9);
            // At the pole, turning still turns, and the way back is as smooth.
            let right = n.axes().right;
            n.orbit(DVec2::new(400.0, 0.0));
            assert!(n.axes().right.dot(right).abs() < 1e-6, "half the height is a quarter turn");
            n.orbit(DVec2::new(-400.0, 0.0));
            assert!(n.axes().right.distance(right) < 1e-6);
            assert_usable(&n);
        }
    }

    #[test]
    fn orbit_goes_on_from_a_top_view() {
        let mut n = town();
        n.look_from(DVec3::Z);
        let right = n.axes().right;
        n.orbit(DVec2::new(0.0, -100.0));
        assert!(n.axes().right.distance(right) < 1e-9, "the picture must not spin");
        assert!(n.axes().forward.z > -0.99);
    }

    #[test]
    fn pan_keeps_the_grabbed_point_under_the_cursor() {
        for depth in [None, Some(123.4)] {
            let mut n = town();
            let distance = n.distance();
            let grabbed = n.grab(DVec2::new(100.0, 700.0), depth);
            for cursor in [DVec2::new(105.0, 690.0), DVec2::new(900.0, 20.0), DVec2::new(-50.0, 1000.0)] {
                n.pan(grabbed, cursor);
                assert_near(pixel(&n, grabbed), cursor);
            }
            assert!((n.distance() - distance).abs() < 1e-6);
        }
    }

    #[test]
    fn zoom_keeps_the_point_under_the_cursor() {
        for depth in [None, Some(200.0)] {
            let mut n = town();
            let cursor = DVec2::new(1000.0, 150.0);
            let point = n.grab(cursor, depth);
            let before = n.eye().distance(point);
            n.zoom(cursor, 0.5, depth);
            assert_near(pixel(&n, point), cursor);
            assert!((n.eye().distance(point) / before - 0.5).abs() < 1e-9);
            n.zoom(cursor, 3.0, Some((point - n.eye()).dot(n.axes().forward)));
            assert_near(pixel(&n, point), cursor);
        }
    }

    #[test]
    fn zoom_ends_before_numbers_do() {
        let mut n = town();
        for _ in 0..500 {
            n.zoom(DVec2::new(640.0, 400.0), 0.7, None);
            assert_usable(&n);
        }
        let (nearest, farthest) = n.depth_range();
        assert!(n.distance() < 1.01 * nearest, "{}", n.distance());
        for _ in 0..500 {
            n.zoom(DVec2::new(3.0, 4.0), 1.5, None);
            assert_usable(&n);
        }
        assert!(n.distance() > 0.99 * farthest);
        // A surface closer than the nearest pivot does not push the camera away.
        let (n, mut at_wall) = (town(), town());
        at_wall.zoom(DVec2::new(640.0, 400.0), 0.9, Some(0.001));
        assert_eq!(at_wall.camera, n.camera);
    }

    #[test]
    fn a_new_pivot_comes_to_the_middle_and_nothing_turns() {
        let mut n = town();
        let forward = n.axes().forward;
        let point = n.grab(DVec2::new(1000.0, 150.0), Some(250.0));
        n.center_on(point);
        assert_near(pixel(&n, point), n.size * 0.5);
        assert!((n.distance() - 250.0).abs() < 1e-6 && n.axes().forward.distance(forward) < 1e-9);
        assert!(n.locate(n.eye() - forward).is_none(), "behind the eye");
    }

    #[test]
    fn fly_moves_eye_and_pivot_alike() {
        let mut n = town();
        let (eye, distance, forward) = (n.eye(), n.distance(), n.axes().forward);
        n.fly(0.0, 0.5, 0.0);
        assert!((n.eye() - eye).distance(forward * 0.5 * distance) < 1e-6);
        n.fly(0.1, 0.0, 0.2);
        assert!((n.distance() - distance).abs() < 1e-6);
        for _ in 0..100_000 {
            n.fly(0.0, 1e9, 0.0);
        }
        assert_usable(&n);
    }

    #[test]
    fn broken_boxes_still_give_a_camera() {
        let nothing = Bounds { min: [0.0; 3], max: [0.0; 3] };
        let boxes = [
            nothing,
            Bounds { min: [f64::NAN; 3], max: [1.0; 3] },
            Bounds { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] },
            Bounds { min: [f64::MAX; 3], max: [f64::MIN; 3] },
            Bounds { min: [-1e300; 3], max: [1e300; 3] },
            Bounds { min: [1e30; 3], max: [1e30; 3] },
            Bounds { min: [0.0, 0.0, -1e9], max: [0.0, 0.0, 1e9] },
        ];
        for bounds in boxes {
            for grid in [utm_grid(), Grid { scale: [1e-7, 1e-7, 0.01], origin: [7.0, 51.0, 0.0] }] {
                let mut n = Navigation::new(grid, &bounds, [0, 0]);
                n.resize(SIZE);
                assert_usable(&n);
                n.orbit(DVec2::new(10.0, 10.0));
                n.zoom(DVec2::new(10.0, 10.0), 0.5, None);
                let grabbed = n.grab(DVec2::ZERO, None);
                n.pan(grabbed, DVec2::new(400.0, 400.0));
                n.fly(1.0, 1.0, 1.0);
                assert_usable(&n);
            }
        }
    }
}
