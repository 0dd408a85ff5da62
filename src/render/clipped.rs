//! What a clipping box and a slab leave of a scene's box.

use glam::DVec3;

use super::filter::{Clip, ClipBox, Slab};
use crate::scene::Bounds;

/// All places `p` with `normal · p <= reach`.
#[derive(Debug, Clone, Copy)]
struct HalfSpace {
    normal: DVec3,
    reach: f64,
}

/// The smallest upright box around what `clip` shows of `bounds`; `None` if that is nothing.
///
/// What is shown is convex, so its corners say all: where three of the planes meet, inside of all others. Of 14 planes
/// these are 364 places to look at.
pub fn clipped(bounds: &Bounds, clip: &Clip) -> Option<Bounds> {
    // From the middle, so that large coordinates leave digits for the differences.
    let middle = DVec3::from_array(bounds.center());
    let whole = ClipBox { min: bounds.min, max: bounds.max, degrees: 0.0 };
    let boxes = [Some(whole), clip.bounds].into_iter().flatten().flat_map(|of| sides(&of, middle));
    let planes: Vec<HalfSpace> = boxes.chain(clip.slab.iter().flat_map(|slab| faces(slab, middle))).collect();
    let slack = 1e-9 * bounds.diagonal();
    let is_inside = |p: &DVec3| planes.iter().all(|plane| plane.normal.dot(*p) <= plane.reach + slack);
    let mut shown: Option<(DVec3, DVec3)> = None;
    for (i, a) in planes.iter().enumerate() {
        for (j, b) in planes.iter().enumerate().skip(i + 1) {
            for corner in planes[j + 1..].iter().filter_map(|c| meet(a, b, c)).filter(is_inside) {
                let (low, high) = shown.unwrap_or((corner, corner));
                shown = Some((low.min(corner), high.max(corner)));
            }
        }
    }
    let (low, high) = shown?;
    Some(Bounds { min: (middle + low).to_array(), max: (middle + high).to_array() })
}

/// The six sides of a box, taken from `middle`.
fn sides(of: &ClipBox, middle: DVec3) -> [HalfSpace; 6] {
    let center = DVec3::from_array(of.center());
    let turned = DVec3::from_array([of.degrees.to_radians().cos(), of.degrees.to_radians().sin(), 0.0]);
    let axes = [turned, DVec3::Z.cross(turned), DVec3::Z];
    std::array::from_fn(|side| {
        let axis = side / 2;
        let normal = if side % 2 == 0 { axes[axis] } else { -axes[axis] };
        let half = 0.5 * (of.max[axis] - of.min[axis]);
        HalfSpace { normal, reach: normal.dot(center - middle) + half }
    })
}

/// The two faces of a slab, taken from `middle`.
fn faces(slab: &Slab, middle: DVec3) -> [HalfSpace; 2] {
    let across = DVec3::from_array(slab.across());
    [across, -across].map(|normal| {
        let at = normal.dot(DVec3::from_array(slab.point) - middle);
        HalfSpace { normal, reach: at + 0.5 * slab.thickness }
    })
}

/// Where three planes meet, unless two of them are (nearly) parallel.
fn meet(a: &HalfSpace, b: &HalfSpace, c: &HalfSpace) -> Option<DVec3> {
    let (bc, ca, ab) = (b.normal.cross(c.normal), c.normal.cross(a.normal), a.normal.cross(b.normal));
    let volume = a.normal.dot(bc);
    let at = (bc * a.reach + ca * b.reach + ab * c.reach) / volume;
    (volume.abs() > 1e-9 && at.is_finite()).then_some(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: Bounds = Bounds { min: [500_000.0, 5_000_000.0, 200.0], max: [500_100.0, 5_000_050.0, 240.0] };

    /// From the scene's lower corner.
    fn left_of(clip: Clip) -> Option<[[f64; 3]; 2]> {
        let from_corner = |p: [f64; 3]| [0, 1, 2].map(|a| (1e6 * (p[a] - SCENE.min[a])).round() / 1e6);
        clipped(&SCENE, &clip).map(|left| [from_corner(left.min), from_corner(left.max)])
    }

    fn of_box(text: &str) -> Option<[[f64; 3]; 2]> {
        left_of(Clip { bounds: Some(text.parse().unwrap()), slab: None })
    }

    fn of_slab(text: &str) -> Option<[[f64; 3]; 2]> {
        left_of(Clip { bounds: None, slab: Some(text.parse().unwrap()) })
    }

    #[test]
    fn boxes_leave_what_is_in_both() {
        assert_eq!(left_of(Clip::default()), Some([[0.0; 3], [100.0, 50.0, 40.0]]));
        // Over one corner, above and below.
        assert_eq!(of_box("500090,5000040,-1e6,500190,5000140,1e6"), Some([[90.0, 40.0, 0.0], [100.0, 50.0, 40.0]]));
        assert_eq!(of_box("500010,5000010,210,500030,5000020,220"), Some([[10.0, 10.0, 10.0], [30.0, 20.0, 20.0]]));
        // A square of 20 m turned by 45° is 28.28 m wide; by 90°, the sides of another change places.
        let half = 200f64.sqrt();
        let [low, high] = of_box("500040,5000015,210,500060,5000035,220,45").unwrap();
        let near = |found: [f64; 3], expected: [f64; 3]| (0..3).all(|a| (found[a] - expected[a]).abs() < 1e-5);
        assert!(near(low, [50.0 - half, 25.0 - half, 10.0]) && near(high, [50.0 + half, 25.0 + half, 20.0]));
        assert_eq!(of_box("500040,5000020,210,500060,5000030,220,90"), Some([[45.0, 15.0, 10.0], [55.0, 35.0, 20.0]]));
        assert_eq!(of_box("500200,5000000,200,500300,5000050,240"), None);
    }

    #[test]
    fn slabs_cut_the_box() {
        assert_eq!(of_slab("500020,0,0,1,0,0,0.5"), Some([[19.75, 0.0, 0.0], [20.25, 50.0, 40.0]]));
        // Of any length, and from either side.
        assert_eq!(of_slab("0,0,230,0,0,-7,4"), Some([[0.0, 0.0, 28.0], [100.0, 50.0, 32.0]]));
        // Along the diagonal of the ground, through the lower corner: 10 m on both sides, √200 along an axis.
        let [low, high] = of_slab("500000,5000000,0,1,1,0,20").unwrap();
        assert_eq!((low, high.map(|x| (1e3 * x).round() / 1e3)), ([0.0; 3], [14.142, 14.142, 40.0]));
        assert_eq!(of_slab("500000,5000000,0,1,1,0.5,0.1"), None, "far below the scene it would meet it");
        assert_eq!(of_slab("500300,0,0,1,0,0,1"), None);
        let both = Clip {
            bounds: Some("500010,5000010,210,500030,5000020,220".parse().unwrap()),
            slab: Some("500030,0,0,1,0,0,2".parse().unwrap()),
        };
        assert_eq!(left_of(both), Some([[29.0, 10.0, 10.0], [30.0, 20.0, 20.0]]));
    }

    #[test]
    fn flat_scenes_and_single_points_have_corners_too() {
        let flat = Bounds { min: [0.0, 0.0, 5.0], max: [10.0, 10.0, 5.0] };
        let clip = Clip { bounds: None, slab: Some("5,5,5,1,0,0,2".parse().unwrap()) };
        assert_eq!(clipped(&flat, &clip), Some(Bounds { min: [4.0, 0.0, 5.0], max: [6.0, 10.0, 5.0] }));
        let point = Bounds { min: [0.1; 3], max: [0.1; 3] };
        assert_eq!(clipped(&point, &Clip::default()), Some(point));
    }
}
