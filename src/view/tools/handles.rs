//! The handles of a clipping box and a slab: where they are, and what dragging one does. Pure geometry.

use glam::{DVec2, DVec3};

use crate::{
    render::{ClipBox, Slab},
    scene::Bounds,
};

/// Part of the scene's diagonal that a box's side and a slab's thickness keep at least.
const THINNEST: f64 = 1e-6;
/// A ray that meets an axis or a plane flatter than this (sine of the angle) says nothing of where on it.
const FLATTEST: f64 = 0.05;

/// What of a box or a slab the mouse can take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Handle {
    /// A face of the box: its axis, and whether it is the upper one.
    Face { axis: usize, upper: bool },
    /// One of the slab's planes: that on the side of the normal, or the other.
    Plane { upper: bool },
    /// All of it.
    Middle,
    /// Around the vertical.
    Turn,
}

impl Handle {
    pub const OF_BOX: [Handle; 8] = [
        Handle::Face { axis: 0, upper: false },
        Handle::Face { axis: 0, upper: true },
        Handle::Face { axis: 1, upper: false },
        Handle::Face { axis: 1, upper: true },
        Handle::Face { axis: 2, upper: false },
        Handle::Face { axis: 2, upper: true },
        Handle::Middle,
        Handle::Turn,
    ];
    pub const OF_SLAB: [Handle; 4] =
        [Handle::Plane { upper: false }, Handle::Plane { upper: true }, Handle::Middle, Handle::Turn];

    pub fn name(self) -> &'static str {
        match self {
            Handle::Face { axis, upper } => {
                [["west face", "east face"], ["south face", "north face"], ["lower face", "upper face"]][axis]
                    [usize::from(upper)]
            }
            Handle::Plane { upper: false } => "plane behind",
            Handle::Plane { upper: true } => "plane in front",
            Handle::Middle => "move",
            Handle::Turn => "turn",
        }
    }
}

/// A ray of the picture: where it comes from, and where it goes.
pub type Ray = (DVec3, DVec3);

/// All of the scene's box.
pub fn whole_box(bounds: &Bounds) -> ClipBox {
    ClipBox { min: bounds.min, max: bounds.max, degrees: 0.0 }
}

/// Through the middle of the scene, across a horizontal viewing direction (or north), a tenth of its size thick.
pub fn middle_slab(bounds: &Bounds, forward: DVec3) -> Slab {
    let flat = DVec3::new(forward.x, forward.y, 0.0);
    let normal = if flat.length() > 1e-3 { flat.normalize() } else { DVec3::Y };
    Slab { point: bounds.center(), normal: normal.into(), thickness: 0.1 * bounds.diagonal().max(f64::MIN_POSITIVE) }
}

/// The box's own directions: east, north and up before it is turned.
fn box_axes(clip: &ClipBox) -> [DVec3; 3] {
    let (sin, cos) = clip.degrees.to_radians().sin_cos();
    [DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0), DVec3::Z]
}

fn half(clip: &ClipBox) -> DVec3 {
    (DVec3::from_array(clip.max) - DVec3::from_array(clip.min)) * 0.5
}

/// The corners in the order of their bits: 1 east, 2 north, 4 up.
pub fn box_corners(clip: &ClipBox) -> [DVec3; 8] {
    let (center, half, axes) = (DVec3::from_array(clip.center()), half(clip), box_axes(clip));
    std::array::from_fn(|corner| {
        let side = |a: usize| axes[a] * if corner >> a & 1 == 0 { -half[a] } else { half[a] };
        center + side(0) + side(1) + side(2)
    })
}

/// Pairs of [`box_corners`] with an edge between.
pub const BOX_EDGES: [[usize; 2]; 12] =
    [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];

/// Where a handle of the box is.
pub fn place_on_box(clip: &ClipBox, handle: Handle) -> DVec3 {
    let (center, half, axes) = (DVec3::from_array(clip.center()), half(clip), box_axes(clip));
    match handle {
        Handle::Face { axis, upper } => center + axes[axis] * if upper { half[axis] } else { -half[axis] },
        // Beyond the east face's middle, as far as a quarter of the box.
        Handle::Turn => center + axes[0] * (half.x + 0.25 * half.length()),
        Handle::Middle | Handle::Plane { .. } => center,
    }
}

/// Where a handle of the slab is; `bounds` says where the scene is.
pub fn place_on_slab(slab: &Slab, handle: Handle, bounds: &Bounds) -> DVec3 {
    let normal = DVec3::from_array(slab.across());
    // The slab's point may be anywhere on its planes; handles are where the scene is.
    let center = DVec3::from_array(bounds.center());
    let middle = center - normal * (center - DVec3::from_array(slab.point)).dot(normal);
    match handle {
        Handle::Plane { upper } => middle + normal * if upper { 0.5 * slab.thickness } else { -0.5 * slab.thickness },
        Handle::Turn => middle + across(normal) * (0.3 * bounds.diagonal()),
        Handle::Middle | Handle::Face { .. } => middle,
    }
}

/// A horizontal direction along the planes.
fn across(normal: DVec3) -> DVec3 {
    let across = DVec3::Z.cross(normal);
    if across.length() > 1e-6 { across.normalize() } else { DVec3::X }
}

/// The outline of the part of a plane (through `point`, across `normal`) that lies in the scene's box; of three to six
/// corners in order, or none.
pub fn plane_outline(point: DVec3, normal: DVec3, bounds: &Bounds) -> Vec<DVec3> {
    let corners = box_corners(&whole_box(bounds));
    let above = corners.map(|corner| (corner - point).dot(normal));
    let mut crossed: Vec<DVec3> = Vec::new();
    for [a, b] in BOX_EDGES {
        if (above[a] < 0.0) != (above[b] < 0.0) {
            crossed.push(corners[a].lerp(corners[b], above[a] / (above[a] - above[b])));
        }
    }
    let middle = crossed.iter().sum::<DVec3>() / crossed.len().max(1) as f64;
    let (u, v) = (across(normal), normal.cross(across(normal)));
    let angle = |p: &DVec3| (*p - middle).dot(v).atan2((*p - middle).dot(u));
    crossed.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    crossed
}

/// How far along a line (through `point`, along the unit vector `axis`) it is nearest to a ray; `None` where the ray
/// runs along the line.
fn along(point: DVec3, axis: DVec3, (from, to): Ray) -> Option<f64> {
    let to = to.normalize_or_zero();
    let cos = axis.dot(to);
    let sin_squared = 1.0 - cos * cos;
    if sin_squared.is_nan() || sin_squared < FLATTEST * FLATTEST {
        return None;
    }
    let between = from - point;
    Some((between.dot(axis) - between.dot(to) * cos) / sin_squared).filter(|along| along.is_finite())
}

/// Where a ray meets a plane before its start.
fn meets(point: DVec3, normal: DVec3, (from, to): Ray) -> Option<DVec3> {
    let to = to.normalize_or_zero();
    let steep = to.dot(normal);
    if steep.is_nan() || steep.abs() < FLATTEST {
        return None;
    }
    let distance = (point - from).dot(normal) / steep;
    (distance > 0.0).then(|| from + to * distance)
}

/// From where to where the mouse moved a point: on the horizontal plane through it, or, seen from the side, on the
/// plane of the picture.
fn carried(point: DVec3, forward: DVec3, from: Ray, to: Ray) -> Option<DVec3> {
    let normal = if forward.z.abs() > 0.2 { DVec3::Z } else { forward };
    Some(meets(point, normal, to)? - meets(point, normal, from)?)
}

/// By how many radians the mouse turned around the vertical through `center`, holding what is at the height of `at`.
fn turned(center: DVec3, at: DVec3, forward: DVec3, from: Ray, to: Ray, moved: DVec2) -> f64 {
    let plane = DVec3::new(center.x, center.y, at.z);
    if forward.z.abs() > 0.2
        && let (Some(a), Some(b)) = (meets(plane, DVec3::Z, from), meets(plane, DVec3::Z, to))
    {
        let (a, b) = (a - plane, b - plane);
        return (a.x * b.y - a.y * b.x).atan2(a.x * b.x + a.y * b.y);
    }
    // Seen from the side: a pixel is half a degree.
    moved.x * 0.5_f64.to_radians()
}

/// A drag, seen through the picture: the rays where it began and where it is, the viewing direction, and the pixels
/// between.
#[derive(Debug, Clone, Copy)]
pub struct Drag {
    pub from: Ray,
    pub to: Ray,
    pub forward: DVec3,
    pub moved: DVec2,
}

/// The box as it was when the drag began, after it.
pub fn drag_box(clip: &ClipBox, handle: Handle, drag: &Drag, bounds: &Bounds) -> ClipBox {
    let (center, half, axes) = (DVec3::from_array(clip.center()), half(clip), box_axes(clip));
    let around = |center: DVec3, half: DVec3, degrees: f64| ClipBox {
        min: (center - half).into(),
        max: (center + half).into(),
        degrees,
    };
    let at = place_on_box(clip, handle);
    match handle {
        Handle::Face { axis, upper } => {
            let (Some(begin), Some(end)) = (along(at, axes[axis], drag.from), along(at, axes[axis], drag.to)) else {
                return *clip;
            };
            let side = if upper { 1.0 } else { -1.0 };
            let thinnest = THINNEST * bounds.diagonal();
            // The other face stays where it is.
            let out = (side * (end - begin)).max(thinnest - 2.0 * half[axis]);
            let mut half = half;
            half[axis] += 0.5 * out;
            around(center + axes[axis] * (0.5 * side * out), half, clip.degrees)
        }
        Handle::Middle | Handle::Plane { .. } => match carried(center, drag.forward, drag.from, drag.to) {
            Some(by) => around(center + by, half, clip.degrees),
            None => *clip,
        },
        Handle::Turn => {
            let by = turned(center, at, drag.forward, drag.from, drag.to, drag.moved).to_degrees();
            let degrees = (clip.degrees + by).rem_euclid(360.0);
            ClipBox { degrees: if degrees.is_finite() { degrees } else { clip.degrees }, ..*clip }
        }
    }
}

/// The slab as it was when the drag began, after it.
pub fn drag_slab(slab: &Slab, handle: Handle, drag: &Drag, bounds: &Bounds) -> Slab {
    let normal = DVec3::from_array(slab.across());
    let at = place_on_slab(slab, handle, bounds);
    let out = || Some(along(at, normal, drag.to)? - along(at, normal, drag.from)?);
    let shifted = |by: f64| (DVec3::from_array(slab.point) + normal * by).into();
    match handle {
        Handle::Plane { upper } => {
            let side = if upper { 1.0 } else { -1.0 };
            let Some(out) = out() else { return *slab };
            let out = (side * out).max(THINNEST * bounds.diagonal() - slab.thickness);
            Slab { point: shifted(0.5 * side * out), thickness: slab.thickness + out, ..*slab }
        }
        Handle::Middle | Handle::Face { .. } => match out() {
            Some(out) => Slab { point: shifted(out), ..*slab },
            None => *slab,
        },
        Handle::Turn => {
            let middle = place_on_slab(slab, Handle::Middle, bounds);
            let by = turned(middle, at, drag.forward, drag.from, drag.to, drag.moved);
            turn_slab(slab, by, bounds)
        }
    }
}

/// Turned by so many radians around the vertical through the middle of what is seen of it.
pub fn turn_slab(slab: &Slab, by: f64, bounds: &Bounds) -> Slab {
    if !by.is_finite() {
        return *slab;
    }
    let [x, y, z] = slab.normal;
    let (sin, cos) = by.sin_cos();
    let middle = place_on_slab(slab, Handle::Middle, bounds);
    Slab { point: middle.into(), normal: [x * cos - y * sin, x * sin + y * cos, z], ..*slab }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Bounds = Bounds { min: [500_000.0, 5_000_000.0, 100.0], max: [500_400.0, 5_000_300.0, 160.0] };

    /// A ray from above the south that goes through a point.
    fn ray(through: DVec3) -> Ray {
        let eye = DVec3::new(500_200.0, 4_999_500.0, 700.0);
        (eye, through - eye)
    }

    fn drag(from: DVec3, to: DVec3) -> Drag {
        let forward = (from - ray(from).0).normalize();
        Drag { from: ray(from), to: ray(to), forward, moved: DVec2::new(30.0, 0.0) }
    }

    fn assert_near(a: impl Into<DVec3>, b: impl Into<DVec3>) {
        let (a, b) = (a.into(), b.into());
        assert!(a.distance(b) < 1e-6, "{a} is not {b}");
    }

    #[test]
    fn a_face_follows_the_mouse_and_the_others_stay() {
        for degrees in [0.0, 37.0, 180.0, 301.5] {
            let clip = ClipBox { degrees, ..whole_box(&BOUNDS) };
            for handle in &Handle::OF_BOX[..6] {
                let Handle::Face { axis, upper } = *handle else { panic!("{handle:?} is no face") };
                let at = place_on_box(&clip, *handle);
                let out = (at - DVec3::from_array(clip.center())).normalize();
                for by in [12.5, -20.0] {
                    let moved = drag_box(&clip, *handle, &drag(at, at + out * by), &BOUNDS);
                    assert_near(place_on_box(&moved, *handle), at + out * by);
                    let opposite = Handle::Face { axis, upper: !upper };
                    assert_near(place_on_box(&moved, opposite), place_on_box(&clip, opposite));
                    assert!((0..3).all(|a| moved.min[a] < moved.max[a]), "{moved:?}");
                }
                // Pushed through the other face it becomes thin, not inside out.
                let pushed = drag_box(&clip, *handle, &drag(at, at - out * 5_000.0), &BOUNDS);
                assert!(pushed.max[axis] > pushed.min[axis], "{pushed:?}");
                assert!(pushed.max[axis] - pushed.min[axis] < 0.01, "{pushed:?}");
            }
        }
    }

    #[test]
    fn the_whole_box_moves_over_the_ground_and_turns_with_the_mouse() {
        let clip = ClipBox { degrees: 20.0, ..whole_box(&BOUNDS) };
        let center = DVec3::from_array(clip.center());
        let by = DVec3::new(33.0, -21.0, 0.0);
        let moved = drag_box(&clip, Handle::Middle, &drag(center, center + by), &BOUNDS);
        assert_near(moved.center(), center + by);
        assert_near(half(&moved), half(&clip));

        let at = place_on_box(&clip, Handle::Turn);
        let (sin, cos) = 40_f64.to_radians().sin_cos();
        let arm = at - center;
        let target = center + DVec3::new(arm.x * cos - arm.y * sin, arm.x * sin + arm.y * cos, arm.z);
        let turned = drag_box(&clip, Handle::Turn, &drag(at, target), &BOUNDS);
        assert!((turned.degrees - 60.0).abs() < 1e-6, "{}", turned.degrees);
        assert_near(place_on_box(&turned, Handle::Turn), target);
        let back = drag_box(&turned, Handle::Turn, &drag(target, at), &BOUNDS);
        assert!((back.degrees - 20.0).abs() < 1e-6);
    }

    #[test]
    fn a_slab_is_moved_thickened_and_turned() {
        let slab = middle_slab(&BOUNDS, DVec3::new(0.3, 1.0, -0.7));
        let normal = DVec3::from_array(slab.normal);
        assert!(normal.z == 0.0 && (normal.length() - 1.0).abs() < 1e-12);
        for (upper, side) in [(false, -1.0), (true, 1.0)] {
            let handle = Handle::Plane { upper };
            let at = place_on_slab(&slab, handle, &BOUNDS);
            let moved = drag_slab(&slab, handle, &drag(at, at + normal * (side * 9.0)), &BOUNDS);
            assert!((moved.thickness - slab.thickness - 9.0).abs() < 1e-6);
            let other = Handle::Plane { upper: !upper };
            assert_near(place_on_slab(&moved, other, &BOUNDS), place_on_slab(&slab, other, &BOUNDS));
            let pushed = drag_slab(&slab, handle, &drag(at, at - normal * (side * 1e4)), &BOUNDS);
            assert!(pushed.thickness > 0.0 && pushed.thickness < 0.01);
        }
        let at = place_on_slab(&slab, Handle::Middle, &BOUNDS);
        let moved = drag_slab(&slab, Handle::Middle, &drag(at, at + normal * 14.0), &BOUNDS);
        assert_near(place_on_slab(&moved, Handle::Middle, &BOUNDS), at + normal * 14.0);
        assert_eq!((moved.thickness, moved.normal), (slab.thickness, slab.normal));
        let turned = turn_slab(&slab, 0.5, &BOUNDS);
        assert!((DVec3::from_array(turned.normal).dot(normal) - 0.5_f64.cos()).abs() < 1e-12);
        assert_near(place_on_slab(&turned, Handle::Middle, &BOUNDS), at);
    }

    #[test]
    fn rays_that_say_nothing_change_nothing() {
        let (clip, slab) = (whole_box(&BOUNDS), middle_slab(&BOUNDS, DVec3::Y));
        let bad = [(DVec3::NAN, DVec3::Y), (DVec3::ZERO, DVec3::ZERO), (DVec3::ZERO, DVec3::NAN)];
        for ray in bad {
            let drag = Drag { from: ray, to: ray, forward: DVec3::NAN, moved: DVec2::NAN };
            for handle in Handle::OF_BOX {
                assert_eq!(drag_box(&clip, handle, &drag, &BOUNDS), clip, "{handle:?} {ray:?}");
            }
            for handle in Handle::OF_SLAB {
                assert_eq!(drag_slab(&slab, handle, &drag, &BOUNDS), slab, "{handle:?} {ray:?}");
            }
        }
        // Along the face's own axis nobody sees how far it is pulled.
        let east = place_on_box(&clip, Handle::Face { axis: 0, upper: true });
        let along = (east - DVec3::X * 900.0, DVec3::X);
        let drag = Drag { from: along, to: along, forward: DVec3::X, moved: DVec2::X };
        assert_eq!(drag_box(&clip, Handle::Face { axis: 0, upper: true }, &drag, &BOUNDS), clip);
    }

    #[test]
    fn a_plane_cuts_the_scene_in_order() {
        let center = DVec3::from_array(BOUNDS.center());
        assert_eq!(plane_outline(center, DVec3::Z, &BOUNDS).len(), 4);
        assert_eq!(plane_outline(center + DVec3::Z * 500.0, DVec3::Z, &BOUNDS).len(), 0);
        let six = plane_outline(center, DVec3::new(60.0, 80.0, 400.0).normalize(), &BOUNDS);
        assert!((4..=6).contains(&six.len()));
        for (at, &corner) in six.iter().enumerate() {
            let (next, after) = (six[(at + 1) % six.len()], six[(at + 2) % six.len()]);
            let turn = (next - corner).cross(after - next).dot(DVec3::new(60.0, 80.0, 400.0));
            assert!(turn > 0.0, "the outline is not convex at {corner}");
        }
    }
}
