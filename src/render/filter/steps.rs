//! From world coordinates to integers on the scene's grid: which steps lie within borders.
//!
//! Positions are integers, so every border can be one too, and all backends agree on every point. A border counts as
//! met by what lies within [`ON_BORDER`] of it: `10.01` as typed and 1001 steps of 0.01 differ by rounding alone.

use super::clip::{ClipBox, Slab};
use crate::scene::Grid;

/// In steps of the grid: nearer to a border than this is on it. World coordinates of some 10⁷ m on a grid of 0.1 mm
/// are rounded to 2·10⁻⁵ of a step in f64.
const ON_BORDER: f64 = 1e-3;

/// Largest coefficient of a [`Plane`]: the sum of three products with 32-bit positions stays below 2⁶².
const LARGEST: f64 = (1 << 29) as f64;

/// Positions `p` with `low <= a·p <= high`, the dot product in exact 64-bit integers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plane {
    pub a: [i32; 3],
    pub low: i64,
    pub high: i64,
}

/// Steps of one axis that lie from `low` to `high` in world coordinates; empty if the first is larger.
pub fn axis(grid: &Grid, axis: usize, low: f64, high: f64) -> [i64; 2] {
    let step = |world: f64| (world - grid.origin[axis]) / grid.scale[axis];
    let (a, b) = (step(low), step(high));
    // A scale may be negative.
    [(a.min(b) - ON_BORDER).ceil() as i64, (a.max(b) + ON_BORDER).floor() as i64]
}

/// What lies no farther than `reach` from the plane through `point` across `normal`, which has length 1.
fn plane(grid: &Grid, point: [f64; 3], normal: [f64; 3], reach: f64) -> Plane {
    let per_step: [f64; 3] = std::array::from_fn(|k| normal[k] * grid.scale[k]);
    let largest = per_step.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let factor = LARGEST / largest;
    let a = per_step.map(|x| (x * factor).round() as i32);
    // Through the point with the rounded direction: that error grows with the distance from the point, by
    // 10⁻⁹ of it, and not with that from the grid's origin.
    let steps = grid.steps(point);
    let middle: f64 = (0..3).map(|k| f64::from(a[k]) * steps[k]).sum();
    let reach = reach * factor + ON_BORDER * LARGEST;
    Plane { a, low: (middle - reach).ceil() as i64, high: (middle + reach).floor() as i64 }
}

/// The slab's two planes.
pub fn slab(grid: &Grid, slab: &Slab) -> Plane {
    plane(grid, slab.point, slab.across(), 0.5 * slab.thickness)
}

/// The four upright faces of a box that is turned.
pub fn sides(grid: &Grid, b: &ClipBox) -> [Plane; 2] {
    let (sin, cos) = b.degrees.to_radians().sin_cos();
    let across = |normal, a: usize| plane(grid, b.center(), normal, 0.5 * (b.max[a] - b.min[a]));
    [across([cos, sin, 0.0], 0), across([-sin, cos, 0.0], 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid = Grid { scale: [0.01, 0.01, 0.001], origin: [500_000.0, 5_400_000.0, -3.0] };

    fn dot(plane: &Plane, p: [i32; 3]) -> i64 {
        (0..3).map(|k| i64::from(plane.a[k]) * i64::from(p[k])).sum()
    }

    #[test]
    fn borders_as_typed_are_met_by_their_steps() {
        for i in [-2_000_000_000, -1001, 0, 1, 1001, 123_457, 2_000_000_000] {
            for a in 0..3 {
                // As a person types it: the digits that the file has.
                let world: f64 = format!("{:.3}", GRID.world([i; 3])[a]).parse().unwrap();
                assert_eq!(axis(&GRID, a, world, world), [i64::from(i); 2]);
                assert_eq!(axis(&GRID, a, world + 1e-4, world + 2e-4), [i64::from(i) + 1, i64::from(i)], "between two");
            }
        }
        let all = axis(&GRID, 0, f64::NEG_INFINITY, f64::INFINITY);
        assert!(all[0] < i32::MIN.into() && all[1] > i32::MAX.into());
        let down = Grid { scale: [-0.5; 3], origin: [0.0; 3] };
        assert_eq!(axis(&down, 0, 1.0, 2.0), [-4, -2]);
    }

    #[test]
    fn a_slab_holds_what_lies_between_its_planes() {
        let s = Slab { point: [500_100.0, 5_400_050.0, 7.0], normal: [3.0, -4.0, 0.0], thickness: 2.0 };
        let plane = slab(&GRID, &s);
        let mut counts = [0, 0];
        for i in 0..40_000 {
            let p = [9_000 + (i * 7919) % 2000, 4_000 + (i * 4_729) % 2000, i];
            let w = GRID.world(p);
            let distance = (w[0] - s.point[0]) * 0.6 - (w[1] - s.point[1]) * 0.8;
            let is_in = (plane.low..=plane.high).contains(&dot(&plane, p));
            counts[usize::from(is_in)] += 1;
            if (distance.abs() - 1.0).abs() > 2e-5 {
                assert_eq!(is_in, distance.abs() < 1.0, "{w:?}: {distance}");
            }
        }
        assert!(counts[0] > 1000 && counts[1] > 1000, "{counts:?}");
    }

    #[test]
    fn faces_of_a_turned_box_belong_to_it() {
        let b = ClipBox { min: [500_010.0, 5_400_020.0, 0.0], max: [500_030.0, 5_400_024.0, 1.0], degrees: 90.0 };
        // Turned by a right angle, it is 4 wide and 20 deep around (500 020, 5 400 022).
        let [u, v] = sides(&GRID, &b);
        let is_in = |x: f64, y: f64| {
            let p = GRID.steps([x, y, 0.0]).map(|s| s.round() as i32);
            [u, v].iter().all(|plane| (plane.low..=plane.high).contains(&dot(plane, p)))
        };
        for (x, y, inside) in [
            (500_018.0, 5_400_012.0, true),
            (500_022.0, 5_400_032.0, true),
            (500_017.99, 5_400_022.0, false),
            (500_022.01, 5_400_022.0, false),
            (500_020.0, 5_400_032.01, false),
            (500_020.0, 5_400_011.99, false),
        ] {
            assert_eq!(is_in(x, y), inside, "{x} {y}");
        }
    }
}
