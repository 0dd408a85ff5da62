//! One integer grid for all files of a scene, and the way onto it from each file's own integers.

use crate::scene::{Bounds, Grid};

/// What the grid needs to know of a file.
#[derive(Debug, Clone, Copy)]
pub struct FileGrid {
    pub scale: [f64; 3],
    pub offset: [f64; 3],
    /// World coordinates that must fit.
    pub bounds: Bounds,
}

/// Largest grid coordinate that a header's box may reach: half of what `i32` holds, so that points
/// outside of the box, and differences between two points, still fit.
const REACH: f64 = (1 << 30) as f64;

/// Chooses the grid: a single file's own, else the finest scale of all, from the first file's offset.
/// Where `i32` would overflow, first the origin moves to the middle of the scene, then the scale
/// grows tenfold; the latter is said in the warnings.
pub fn choose(files: &[FileGrid]) -> (Grid, Vec<String>) {
    let mut warnings = Vec::new();
    let Some(first) = files.first() else {
        return (Grid { scale: [1.0; 3], origin: [0.0; 3] }, warnings);
    };
    let mut grid = Grid { scale: first.scale.map(f64::abs), origin: first.offset };
    if files.len() == 1 {
        return (grid, warnings);
    }
    let bounds = files.iter().map(|f| f.bounds).reduce(|a, b| a.union(&b)).unwrap_or(first.bounds);
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let finest = files.iter().map(|f| f.scale[axis].abs()).fold(f64::INFINITY, f64::min);
        let (low, high) = (bounds.min[axis], bounds.max[axis]);
        let mut scale = finest;
        loop {
            let fits = |origin: f64| (low - origin).abs().max((high - origin).abs()) / scale <= REACH;
            // Whole steps away from the first file's offset: files that share its lattice stay on it.
            let steps = ((0.5 * (low + high) - first.offset[axis]) / scale).round();
            let middle = first.offset[axis] + steps * scale;
            let origin = if fits(first.offset[axis]) { first.offset[axis] } else { middle };
            if fits(origin) || !(high - low).is_finite() {
                (grid.scale[axis], grid.origin[axis]) = (scale, origin);
                break;
            }
            scale *= 10.0;
        }
        if scale > finest {
            warnings.push(format!(
                "the files together span {:e} steps of {finest:e} along {name}, more than 32-bit coordinates hold: \
                 a scale of {scale:e} is used there",
                (high - low) / finest
            ));
        }
    }
    (grid, warnings)
}

/// The way from a file's integers to the scene's grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    axes: [Axis; 3],
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Axis {
    /// `i * times + plus`: exact.
    Whole { times: i64, plus: i64 },
    /// `round(i * times + plus)`.
    Rounded { times: f64, plus: f64 },
}

impl Placement {
    pub const IDENTITY: Placement = Placement { axes: [Axis::Whole { times: 1, plus: 0 }; 3] };

    pub fn new(file: &FileGrid, grid: &Grid) -> Placement {
        let axes = std::array::from_fn(|a| {
            let times = file.scale[a] / grid.scale[a];
            let plus = (file.offset[a] - grid.origin[a]) / grid.scale[a];
            // Scales are decimal fractions written in binary: 0.01 / 0.001 is not quite 10.
            let whole = times.round();
            if (times - whole).abs() < 1e-9 * whole.abs() && plus.abs() < 9e15 {
                Axis::Whole { times: whole as i64, plus: plus.round() as i64 }
            } else {
                Axis::Rounded { times, plus }
            }
        });
        Placement { axes }
    }

    /// Moves positions onto the grid; returns how many did not fit and were put on its border.
    pub fn apply(&self, positions: &mut [[i32; 3]]) -> u64 {
        let mut beyond = 0;
        for position in positions {
            let exact: [i64; 3] = std::array::from_fn(|a| match self.axes[a] {
                Axis::Whole { times, plus } => i64::from(position[a]).saturating_mul(times).saturating_add(plus),
                Axis::Rounded { times, plus } => (f64::from(position[a]) * times + plus).round() as i64,
            });
            *position = exact.map(|i| i.clamp(i32::MIN.into(), i32::MAX.into()) as i32);
            beyond += u64::from(exact != position.map(i64::from));
        }
        beyond
    }
}

/// The header's box in the record's own integers, half a step wider; `None` if it makes no sense.
pub fn box_in_steps(bounds: &Bounds, scale: [f64; 3], offset: [f64; 3]) -> Option<([i32; 3], [i32; 3])> {
    if !bounds.is_sane() {
        return None;
    }
    let mut low = [0; 3];
    let mut high = [0; 3];
    for a in 0..3 {
        let (p, q) = ((bounds.min[a] - offset[a]) / scale[a], (bounds.max[a] - offset[a]) / scale[a]);
        // A hair more than half a step, for what the division rounds. Casts saturate.
        low[a] = (p.min(q) - 0.501).ceil() as i32;
        high[a] = (p.max(q) + 0.501).floor() as i32;
    }
    Some((low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(scale: f64, offset: f64, low: f64, high: f64) -> FileGrid {
        FileGrid { scale: [scale; 3], offset: [offset; 3], bounds: Bounds { min: [low; 3], max: [high; 3] } }
    }

    #[test]
    fn one_file_keeps_its_integers() {
        let f = file(0.01, 500_000.0, 499_000.0, 501_000.0);
        let (grid, warnings) = choose(&[f]);
        assert_eq!((grid.scale, grid.origin), (f.scale, f.offset));
        assert_eq!(Placement::new(&f, &grid), Placement::IDENTITY);
        assert!(warnings.is_empty());
    }

    #[test]
    fn a_negative_scale_is_mirrored_onto_a_positive_grid() {
        let f = file(-0.5, 10.0, 0.0, 20.0);
        let (grid, _) = choose(&[f]);
        let mut positions = [[4, -4, i32::MIN]];
        let beyond = Placement::new(&f, &grid).apply(&mut positions);
        assert_eq!(grid.world(positions[0])[..2], [8.0, 12.0]);
        assert_eq!((positions[0][2], beyond), (i32::MAX, 1), "-i32::MIN does not fit, and is counted");
    }

    #[test]
    fn several_files_share_the_finest_scale_and_stay_exact() {
        let files = [file(0.01, 500_000.0, 5e5, 6e5), file(0.001, 510_000.0, 5e5, 6e5), file(0.01, 400.0, 5e5, 6e5)];
        let (grid, warnings) = choose(&files);
        assert!(warnings.is_empty());
        assert_eq!((grid.scale, grid.origin), ([0.001; 3], [500_000.0; 3]));
        for f in &files {
            let placement = Placement::new(f, &grid);
            for i in [-7, 0, 3, 12_345] {
                let mut positions = [[i; 3]];
                placement.apply(&mut positions);
                let expected = f.offset[0] + f.scale[0] * f64::from(i);
                let found = grid.world(positions[0])[0];
                assert!((found - expected).abs() < 1e-6, "{found} is not {expected}");
            }
        }
    }

    #[test]
    fn overflow_moves_the_origin_first_and_coarsens_second() {
        let far = [file(0.001, 0.0, 2.0e6, 2.1e6), file(0.0001, 2.0e6, 2.0e6, 2.1e6)];
        let (grid, warnings) = choose(&far);
        assert_eq!(grid.scale, [0.0001; 3]);
        assert!((grid.origin[0] - 2.05e6).abs() < 1.0 && warnings.is_empty());

        let wide = [file(0.001, 0.0, 0.0, 10.0), file(0.001, 5.0e7, 5.0e7, 5.1e7)];
        let (grid, warnings) = choose(&wide);
        assert!((grid.scale[0] - 0.1).abs() < 1e-12);
        assert_eq!(warnings.len(), 3);
        let mut positions = [[1_000_000; 3]];
        assert_eq!(Placement::new(&wide[1], &grid).apply(&mut positions), 0);
        assert!((grid.world(positions[0])[0] - 5.0001e7).abs() <= 0.05 + 1e-6);
    }

    #[test]
    fn half_a_step_outside_the_box_is_inside() {
        let bounds = Bounds { min: [0.0; 3], max: [10.004, 10.006, 1e300] };
        let (low, high) = box_in_steps(&bounds, [0.01; 3], [0.0; 3]).unwrap();
        assert_eq!((low, high), ([0; 3], [1000, 1001, i32::MAX]));
        assert!(box_in_steps(&Bounds { min: [f64::NAN; 3], max: [0.0; 3] }, [1.0; 3], [0.0; 3]).is_none());
    }
}
