//! The camera in the user's hands: orbit, pan, zoom to the cursor, fly. In f64, in the coordinates of
//! the file; knows nothing of windows. Cursor positions are in pixels from the upper left corner.
//!
//! No move loses the scene: what is grabbed stays under the cursor, zooming in ends at the pivot's depth, zooming out
//! and flying end where the scene is small, panning ends one scene's size beside the picture; and the horizon
//! stays level.

mod bookmarks;
mod glide;
mod history;

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};

use crate::{
    render::{self, Camera, Clip, Projection, SOUTH_AND_ABOVE},
    scene::{Bounds, Grid},
};

pub use bookmarks::Bookmarks;
pub use glide::Glide;
pub use history::{Gesture, History};

/// Distance from the scene, in units of its size, at which zooming out and flying away end. In a window of 800 rows
/// the scene is then still a dozen pixels wide.
const FARTHEST: f64 = 50.0;
/// Farthest that the eye may be from the grid's origin, in steps; [`Camera::view`] takes ten times that.
const FARTHEST_STEPS: f64 = 1e12;
/// Room around a scene that is fitted into the picture, as [`Camera::fit`] leaves it.
const FIT_MARGIN: f64 = 1.03;
/// Share of the picture that may be left out below a scene that is fitted into it.
const COVERED_AT_MOST: f64 = 0.45;
/// Field of view of cameras that are made here; an orthographic one shows what this one would at its target.
const FOV_Y_DEG: f64 = 60.0;

/// The views that keys and buttons ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StandardView {
    /// From the usual direction: the south, and above.
    Home,
    Top,
    Bottom,
    /// From the south.
    Front,
    /// From the north.
    Back,
    /// From the west.
    Left,
    /// From the east.
    Right,
    /// From the south-east and above, all three axes foreshortened alike.
    Isometric,
    /// From where the eye is now, all of the scene.
    Fit,
}

/// Where the user looks at a scene from. The pivot that it turns around is the camera's target.
#[derive(Debug, Clone)]
pub struct Navigation {
    camera: Camera,
    grid: Grid,
    bounds: Bounds,
    /// What a clipping box and a slab leave of it: what standard views show.
    shown: Bounds,
    /// Of the picture, in pixels.
    size: DVec2,
    /// Pixels at its lower edge that something lies over: views of all of the scene leave them out.
    covered_below: f64,
}

impl Navigation {
    /// All of the box in the picture. The box may be as broken as a header can be.
    pub fn new(grid: Grid, bounds: &Bounds, size: [u32; 2]) -> Navigation {
        let bounds = representable(bounds, &grid);
        let size = pixels(size);
        let camera = Camera::fit(&bounds, &grid, size.x / size.y);
        let mut navigation = Navigation { camera, grid, bounds, shown: bounds, size, covered_below: 0.0 };
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

    /// So many pixels at the picture's lower edge are covered now; the camera stays.
    pub fn cover(&mut self, below: f64) {
        self.covered_below = below;
    }

    /// Of the picture, in pixels.
    pub fn size(&self) -> DVec2 {
        self.size
    }

    /// Standard views show what is left of the scene from now on.
    pub fn follow_clip(&mut self, clip: &Clip) {
        self.shown = render::clipped(&self.bounds, clip).unwrap_or(self.bounds);
    }

    /// Shows all of the box from the usual direction.
    pub fn home(&mut self) {
        self.look_from(SOUTH_AND_ABOVE);
    }

    /// Shows all of the box from the direction `from` (from the scene towards the eye).
    pub fn look_from(&mut self, from: DVec3) {
        if from.normalize_or_zero() == DVec3::ZERO {
            return;
        }
        let (aspect, projection) = (self.size.x / self.size.y, self.camera.projection);
        self.camera = Camera::fit_as(&self.shown, &self.grid, aspect, from, projection);
        if self.covered_below > 0.0 {
            self.camera = self.fitted_above(self.covered_below / self.size.y);
        }
        self.pull_in();
    }

    /// The camera that looks along the same direction and has all of the box above a share of the picture's height.
    ///
    /// As in [`Camera::fit_as`], with the eye at (x, y, z) in the camera's axes from the box's centre, a corner at
    /// (u, v, w) is in the picture if |u - x| <= (w - z) tan, and here, above and below,
    /// -(w - z) tan_below <= v - y <= (w - z) tan_above. The nearest eye has both of the tighter axis equal, and the
    /// other axis its margins alike.
    fn fitted_above(&self, covered: f64) -> Camera {
        let axes = self.axes();
        let tan = (0.5 * self.camera.fov_y_deg.to_radians()).tan();
        // Middle and half of the free rows, where all rows are from -1 to 1.
        let middle = covered.min(COVERED_AT_MOST);
        let half = (1.0 - middle) / FIT_MARGIN;
        let (above, below) = (tan * (half + middle), tan * (half - middle));
        let beside = tan * self.size.x / self.size.y / FIT_MARGIN;
        let center = DVec3::from_array(self.shown.center());
        let corners = box_corners(&self.shown).map(|corner| corner - center);
        // Without perspective it is the same at every depth.
        let slope = if self.is_flat() { 0.0 } else { 1.0 };
        let fit_axis = |axis: DVec3, plus: f64, minus: f64| {
            corners.iter().fold((f64::NEG_INFINITY, f64::INFINITY), |(low, high), corner| {
                let (u, w) = (axis.dot(*corner), axes.forward.dot(*corner) * slope);
                (low.max(u - w * plus), high.min(u + w * minus))
            })
        };
        let (left, right) = fit_axis(axes.right, beside, beside);
        let (bottom, top) = fit_axis(axes.up, above, below);
        let nearest = ((right - left) / (2.0 * beside)).min((top - bottom) / (above + below));
        // A scene of a single point still needs a direction to look along.
        let along = nearest.min(-100.0 * smallest(self.grid.scale).abs());
        let (x, y) = (0.5 * (left + right), 0.5 * (bottom + top + along * (above - below)));
        let target = center + axes.right * x + axes.up * y;
        let eye = target + axes.forward * along;
        Camera { eye: eye.into(), target: target.into(), ..self.camera }.before(&self.bounds)
    }

    /// Perspective or not: what is at the pivot's depth stays as large as it is.
    pub fn set_projection(&mut self, projection: Projection) {
        if self.camera.projection != projection {
            self.camera = settled(Camera { projection, ..self.camera }, &self.bounds);
        }
    }

    pub fn show(&mut self, view: StandardView) {
        match view {
            StandardView::Home => self.home(),
            StandardView::Top => self.look_from(DVec3::Z),
            StandardView::Bottom => self.look_from(-DVec3::Z),
            StandardView::Front => self.look_from(-DVec3::Y),
            StandardView::Back => self.look_from(DVec3::Y),
            StandardView::Left => self.look_from(-DVec3::X),
            StandardView::Right => self.look_from(DVec3::X),
            StandardView::Isometric => self.look_from(DVec3::new(1.0, -1.0, 1.0)),
            StandardView::Fit => self.look_from(-self.axes().forward),
        }
    }

    /// Takes over a camera from elsewhere (a bookmark, a command line), unless nothing could be seen with it.
    pub fn set_camera(&mut self, camera: Camera) {
        let [eye, target, up] = [camera.eye, camera.target, camera.up].map(DVec3::from_array);
        let sees = camera.fov_y_deg > 0.0 && camera.fov_y_deg < 180.0;
        // Neither an up of zero length nor one along the line of sight says where the right is.
        let sides = (target - eye).normalize_or_zero().cross(up.normalize_or_zero()).length() > 1e-6;
        if sees && sides && self.is_usable(eye, target, up) {
            self.camera = camera.before(&self.bounds);
        }
    }

    /// Turns around the pivot, as if the mouse held the scene's near side: the height of the picture
    /// is half a turn. Straight down and straight up are the ends, so nothing ever flips over.
    pub fn orbit(&mut self, moved: DVec2) {
        self.orbit_about(DVec3::from_array(self.camera.target), moved);
    }

    /// As [`Navigation::orbit`], around any point: it keeps its pixel and its depth.
    pub fn orbit_about(&mut self, point: DVec3, moved: DVec2) {
        self.turn(point, moved * (PI / self.size.y));
    }

    /// Looks around from where the eye is: the picture follows the mouse.
    pub fn look_around(&mut self, moved: DVec2) {
        // Without perspective there is no place that the picture is seen from.
        let from = if self.is_flat() { DVec3::from_array(self.camera.target) } else { self.eye() };
        let fov_y_deg = if self.is_flat() { FOV_Y_DEG } else { self.camera.fov_y_deg };
        self.turn(from, moved * (fov_y_deg.to_radians() / self.size.y));
    }

    /// Turns the camera around `point` to the right and down by these angles.
    fn turn(&mut self, point: DVec3, angle: DVec2) {
        let axes = self.axes();
        let heading = axes.right.y.atan2(axes.right.x) - angle.x;
        let pitch = (axes.forward.z.clamp(-1.0, 1.0).asin() - angle.y).clamp(-FRAC_PI_2, FRAC_PI_2);
        let turned = Axes::level(heading, pitch);
        let carried = |at: DVec3| {
            let from_point = at - point;
            let along = |axis: DVec3| from_point.dot(axis);
            point + turned.right * along(axes.right) + turned.forward * along(axes.forward) + turned.up * along(axes.up)
        };
        let (eye, target) = (carried(self.eye()), carried(DVec3::from_array(self.camera.target)));
        self.place(eye, target, turned.up);
    }

    /// The point of the scene that a cursor holds: at `depth` along the viewing direction where that
    /// is known, else as far away as the pivot.
    pub fn grab(&self, cursor: DVec2, depth: Option<f64>) -> DVec3 {
        let (from, along) = self.ray_through(cursor);
        from + along * depth.unwrap_or_else(|| self.distance())
    }

    /// Moves sideways until `grabbed` is under the cursor.
    pub fn pan(&mut self, grabbed: DVec3, cursor: DVec2) {
        let axes = self.axes();
        let depth = (grabbed - self.eye()).dot(axes.forward);
        let by = grabbed - self.grab(cursor, Some(depth));
        let eye = self.eye() + by;
        self.place_in_sight(eye, eye + axes.forward * self.distance(), axes.up);
    }

    /// Brings what is under the cursor closer (`factor` below 1) or farther away. It stays under the
    /// cursor, and its depth becomes the pivot's.
    pub fn zoom(&mut self, cursor: DVec2, factor: f64, depth: Option<f64>) {
        if self.is_flat() {
            return self.zoom_flat(cursor, factor);
        }
        let axes = self.axes();
        let depth = depth.unwrap_or_else(|| self.distance());
        let (nearest, farthest) = self.depth_range();
        let new_depth = (depth * factor).clamp(nearest, farthest);
        // Someone who is outside of the range already may come back, but not go on.
        if (new_depth - depth) * (factor - 1.0) <= 0.0 {
            return;
        }
        let (from, along) = self.ray_through(cursor);
        let eye = from + along * (depth - new_depth);
        self.place(eye, eye + axes.forward * new_depth, axes.up);
    }

    /// Without perspective zooming changes the height of the picture. What is under the cursor stays there.
    fn zoom_flat(&mut self, cursor: DVec2, factor: f64) {
        let (nearest, farthest) = self.depth_range();
        let reach = self.reach();
        let new_reach = (reach * factor).clamp(nearest, farthest);
        if (new_reach - reach) * (factor - 1.0) <= 0.0 {
            return;
        }
        let (from, along) = self.ray_through(cursor);
        let target = DVec3::from_array(self.camera.target);
        let aside = (from - self.eye()) * (1.0 - new_reach / reach);
        // As far from the target as a perspective camera of that height; the rest follows.
        let camera = Camera { fov_y_deg: FOV_Y_DEG, ..self.camera };
        let before = std::mem::replace(&mut self.camera, camera);
        let placed = self.place(target + aside - along * new_reach, target + aside, DVec3::from_array(before.up));
        if !placed {
            self.camera = before;
        }
    }

    /// Flies right, forward and up (along the file's z) by so many pivot distances.
    pub fn fly(&mut self, right: f64, forward: f64, up: f64) {
        let axes = self.axes();
        let mut ahead = axes.forward * forward;
        if self.is_flat() {
            // Nothing comes nearer without perspective, but larger.
            self.zoom_flat(self.size * 0.5, (-forward).exp());
            ahead = DVec3::ZERO;
        }
        let by = (axes.right * right + ahead + DVec3::Z * up) * self.reach();
        let eye = self.eye() + by;
        let center = DVec3::from_array(self.bounds.center());
        let away = eye.distance(center);
        if away > self.depth_range().1.max(2.0 * self.distance()) && away > self.eye().distance(center) {
            return;
        }
        self.place(eye, DVec3::from_array(self.camera.target) + by, axes.up);
    }

    /// Where a point of the scene is: its pixel, and its depth along the viewing direction; `None` for
    /// what is behind the eye.
    pub fn locate(&self, point: DVec3) -> Option<(DVec2, f64)> {
        let at = self.seen(point);
        (at.z > 0.0).then(|| (self.pixel_of(at), at.z))
    }

    /// The pixels of the ends of a segment, or of the part of it that lies before the eye and not far outside of the
    /// picture; `None` if no part does.
    pub fn locate_segment(&self, a: DVec3, b: DVec3) -> Option<[DVec2; 2]> {
        let (a, b) = (self.seen(a), self.seen(b));
        // A line from the picture to beside the eye has no end.
        let nearest = 1e-6 * self.distance();
        let before_eye = |from: DVec3, to: DVec3| match from.z < nearest {
            true => from + (to - from) * ((nearest - from.z) / (to.z - from.z)),
            false => from,
        };
        let is_seen = a.z >= nearest || b.z >= nearest;
        if !is_seen {
            return None;
        }
        let ends = [self.pixel_of(before_eye(a, b)), self.pixel_of(before_eye(b, a))];
        clipped(ends, -self.size, 2.0 * self.size).filter(|ends| ends[0].is_finite() && ends[1].is_finite())
    }

    /// In the picture's axes, from the eye: right, up, forward.
    fn seen(&self, point: DVec3) -> DVec3 {
        let axes = self.axes();
        let at = point - self.eye();
        DVec3::new(at.dot(axes.right), at.dot(axes.up), at.dot(axes.forward))
    }

    fn pixel_of(&self, seen: DVec3) -> DVec2 {
        let ndc = DVec2::new(seen.x, -seen.y) / self.half_size(seen.z);
        (ndc * 0.5 + DVec2::splat(0.5)) * self.size
    }

    /// Where the ray through a pixel comes from, at the depth of the eye, and where it goes: one unit along the viewing
    /// direction.
    pub fn ray_through(&self, cursor: DVec2) -> (DVec3, DVec3) {
        let axes = self.axes();
        let at = (cursor / self.size * 2.0 - DVec2::ONE) * self.half_size(1.0);
        let aside = axes.right * at.x - axes.up * at.y;
        if self.is_flat() { (self.eye() + aside, axes.forward) } else { (self.eye(), axes.forward + aside) }
    }

    /// Unit vector along which the picture is seen.
    pub fn forward(&self) -> DVec3 {
        self.axes().forward
    }

    /// The scene's box, as far as there can be points in it.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
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

    /// Distance from which a perspective camera would show as much of the pivot's surroundings as this one.
    fn reach(&self) -> f64 {
        if self.is_flat() { reach(&self.camera) } else { self.distance() }
    }

    fn is_flat(&self) -> bool {
        self.camera.projection == Projection::Orthographic
    }

    fn eye(&self) -> DVec3 {
        DVec3::from_array(self.camera.eye)
    }

    fn axes(&self) -> Axes {
        Axes::of(&self.camera)
    }

    /// Nearest and farthest that zooming goes.
    fn depth_range(&self) -> (f64, f64) {
        let step = smallest(self.grid.scale);
        let coordinate = self.camera.target.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        // Below the second bound f64 coordinates no longer tell eye and pivot apart well enough.
        let nearest = (4.0 * step).max(1e-11 * coordinate);
        (nearest, (FARTHEST * self.bounds.diagonal()).max(1e6 * step).max(nearest))
    }

    /// Whether the scene is in the picture of a camera there, or no more than its own size beside it: not all corners
    /// of its box, grown by that on all sides, are beyond one and the same edge.
    fn sees_box(&self, eye: DVec3, axes: &Axes) -> bool {
        let margin = self.bounds.diagonal();
        let corners: [DVec3; 8] = std::array::from_fn(|corner| {
            let side = |a: usize| match corner >> a & 1 {
                0 => self.bounds.min[a] - margin,
                _ => self.bounds.max[a] + margin,
            };
            let at = DVec3::new(side(0), side(1), side(2)) - eye;
            DVec3::new(at.dot(axes.right), at.dot(axes.up), at.dot(axes.forward))
        });
        // Behind the eye a perspective picture's edges have changed sides.
        let beyond: [fn(DVec3, DVec2) -> bool; 4] =
            [|c, half| c.x < -half.x, |c, half| c.x > half.x, |c, half| c.y < -half.y, |c, half| c.y > half.y];
        let is_behind = !self.is_flat() && corners.iter().all(|corner| corner.z <= 0.0);
        let is_beside = |edge: &fn(DVec3, DVec2) -> bool| corners.iter().all(|&c| edge(c, self.half_size(c.z)));
        !is_behind && !beyond.iter().any(is_beside)
    }

    /// Half of the picture's width and height at a depth, in the file's unit.
    fn half_size(&self, depth: f64) -> DVec2 {
        let depth = if self.is_flat() { self.distance() } else { depth };
        let y = depth * (0.5 * self.camera.fov_y_deg.to_radians()).tan();
        DVec2::new(y * self.size.x / self.size.y, y)
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

    /// Takes the camera there, unless it is where no picture can be drawn; true if it did.
    fn place(&mut self, eye: DVec3, target: DVec3, up: DVec3) -> bool {
        let usable = self.is_usable(eye, target, up);
        if usable {
            let camera = Camera { eye: eye.into(), target: target.into(), up: up.into(), ..self.camera };
            self.camera = if self.is_flat() { settled(camera, &self.bounds) } else { camera };
        }
        usable
    }

    /// As [`Navigation::place`], but not where the scene is farther from the picture than its own size. Who is there
    /// already (points may lie outside of the header's box) may go anywhere.
    fn place_in_sight(&mut self, eye: DVec3, target: DVec3, up: DVec3) {
        let axes = self.axes();
        if self.sees_box(eye, &axes) || !self.sees_box(self.eye(), &axes) {
            self.place(eye, target, up);
        }
    }

    fn is_usable(&self, eye: DVec3, target: DVec3, up: DVec3) -> bool {
        self.is_reachable(eye) && target.is_finite() && up.is_finite() && target != eye
    }
}

/// Distance from which a camera of the usual field of view shows as much at the target.
fn reach(camera: &Camera) -> f64 {
    0.5 * camera.height_at_target() / (0.5 * FOV_Y_DEG.to_radians()).tan()
}

/// The same picture at the target, by a camera of the usual field of view; without perspective, from so far back that
/// the scene lies before the eye.
fn settled(camera: Camera, bounds: &Bounds) -> Camera {
    let target = DVec3::from_array(camera.target);
    let eye = target - Axes::of(&camera).forward * reach(&camera);
    Camera { eye: eye.into(), fov_y_deg: FOV_Y_DEG, ..camera }.before(bounds)
}

/// Unit vectors of the picture.
#[derive(Debug)]
struct Axes {
    right: DVec3,
    forward: DVec3,
    up: DVec3,
}

impl Axes {
    /// With a level horizon: `heading` from north to the west, `pitch` upwards, radians.
    fn level(heading: f64, pitch: f64) -> Axes {
        let ahead = DVec3::new(-heading.sin(), heading.cos(), 0.0);
        let forward = ahead * pitch.cos() + DVec3::Z * pitch.sin();
        let up = DVec3::Z * pitch.cos() - ahead * pitch.sin();
        Axes { right: DVec3::new(heading.cos(), heading.sin(), 0.0), forward, up }
    }

    fn of(camera: &Camera) -> Axes {
        let forward = (DVec3::from_array(camera.target) - DVec3::from_array(camera.eye)).normalize();
        // Top views carry an `up` along y, all others one that is not the viewing direction.
        let right = forward.cross(DVec3::from_array(camera.up)).normalize();
        Axes { right, forward, up: right.cross(forward) }
    }
}

/// The part of a segment inside of a rectangle. (Liang and Barsky 1984.)
pub fn clipped([a, b]: [DVec2; 2], low: DVec2, high: DVec2) -> Option<[DVec2; 2]> {
    let along = b - a;
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let to = [low[axis] - a[axis], high[axis] - a[axis]];
        if along[axis] == 0.0 {
            if to[0] > 0.0 || to[1] < 0.0 {
                return None;
            }
            continue;
        }
        let [enters, leaves] = if along[axis] > 0.0 { to } else { [to[1], to[0]] }.map(|to| to / along[axis]);
        (first, last) = (first.max(enters), last.min(leaves));
    }
    (first <= last).then(|| [a + along * first, a + along * last])
}

fn pixels(size: [u32; 2]) -> DVec2 {
    DVec2::new(f64::from(size[0].max(1)), f64::from(size[1].max(1)))
}

fn box_corners(bounds: &Bounds) -> [DVec3; 8] {
    std::array::from_fn(|corner| {
        let side = |a: usize| if corner >> a & 1 == 0 { bounds.min[a] } else { bounds.max[a] };
        DVec3::new(side(0), side(1), side(2))
    })
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
mod tests;
