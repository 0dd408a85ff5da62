//! 40-bit depth, exact: whole nanometres along the viewing direction, from the integer positions.

use crate::render::View;

/// Nanometres in a unit of the file, which is taken to be a metre.
const NM_PER_UNIT: f64 = 1e9;
/// Bits after the point of [`Depth40`]'s rows.
const FRACTION_BITS: u32 = 32;
/// Parts of a grid step that the eye is on, as the camera rounds it.
const SUBSTEPS: i64 = 4096;

/// The largest depth that a word can hold; one more, with white, would be the empty word.
const LAST_CODE: u64 = (1 << 40) - 2;

/// A range of depths: from `start_nm` on, in steps of `step_nm`, numbered from `first_code`.
struct Range {
    start_nm: u64,
    step_nm: u64,
    first_code: u64,
}

/// 1 mm to 1.1 million km.
const UNIFORM: &[Range] = &[Range { start_nm: 0, step_nm: 1_000_000, first_code: 0 }];
/// 1 nm to 10 m, 1 µm to 10 km, 1 mm beyond.
const RANGES: &[Range] = &[
    Range { start_nm: 0, step_nm: 1, first_code: 0 },
    Range { start_nm: 10_000_000_000, step_nm: 1000, first_code: 10_000_000_000 },
    Range { start_nm: 10_000_000_000_000, step_nm: 1_000_000, first_code: 19_990_000_000 },
];

fn ranges(is_ranged: bool) -> &'static [Range] {
    if is_ranged { RANGES } else { UNIFORM }
}

/// The viewing direction in integers. Layout shared with `shaders/methods/depth40.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Depth40 {
    /// Lower halves of the rows: nanometres for each 1/4096 of a grid step, 32 bits after the point.
    pub row_low: [u32; 3],
    pub unused_a: u32,
    pub row_high: [i32; 3],
    pub unused_b: u32,
}

impl Depth40 {
    /// Of a view. The direction is rounded to 2⁻³² nm per 1/4096 of a step: 1 nm within 10⁶ steps of
    /// the eye, 1 µm within 10⁹.
    pub fn of(view: &View) -> Depth40 {
        let one = NM_PER_UNIT / SUBSTEPS as f64 * 2f64.powi(FRACTION_BITS as i32);
        let rows: [i64; 3] = std::array::from_fn(|a| (f64::from(view.row_w[a]) * one).round() as i64);
        Depth40 {
            row_low: rows.map(|row| row as u32),
            unused_a: 0,
            row_high: rows.map(|row| (row >> 32) as i32),
            unused_b: 0,
        }
    }

    /// Depth of a position in whole nanometres, rounded down; 0 behind the eye.
    pub fn nanometres(&self, view: &View, position: [i32; 3]) -> u64 {
        let sum: i128 = (0..3)
            .map(|a| {
                let eye = i64::from(view.eye_high[a]) * 65_536 + i64::from(view.eye_low[a]);
                let fraction = (view.eye_fraction[a] * SUBSTEPS as f32) as i64;
                let steps = (i64::from(position[a]) - eye) * SUBSTEPS - fraction;
                let row = i64::from(self.row_high[a]) * (1 << 32) + i64::from(self.row_low[a]);
                i128::from(row) * i128::from(steps)
            })
            .sum();
        u64::try_from((sum >> FRACTION_BITS).max(0)).unwrap_or(u64::MAX)
    }
}

/// The 40-bit number of a depth.
pub fn code(nanometres: u64, is_ranged: bool) -> u64 {
    let range = ranges(is_ranged).iter().rfind(|range| range.start_nm <= nanometres);
    range.map_or(0, |range| range.first_code + (nanometres - range.start_nm) / range.step_nm).min(LAST_CODE)
}

/// The depth in the file's unit that a 40-bit number stands for.
pub fn depth(code: u64, is_ranged: bool) -> f32 {
    let range = ranges(is_ranged).iter().rfind(|range| range.first_code <= code);
    let nm = range.map_or(0, |range| range.start_nm + (code - range.first_code) * range.step_nm);
    (nm as f64 / NM_PER_UNIT) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{render::Camera, scene::Grid};

    #[test]
    fn ranges_join_without_gap_or_overlap() {
        for pair in RANGES.windows(2) {
            let (before, after) = (pair[1].start_nm - 1, pair[1].start_nm);
            assert_eq!(code(before, true) + 1, code(after, true));
        }
        assert_eq!(code(9_999_999_999, true), 9_999_999_999);
        assert_eq!(code(10_000_000_999, true), 10_000_000_000);
        assert_eq!(code(u64::MAX, true), LAST_CODE);
        assert_eq!(code(1_999_999, false), 1);
    }

    #[test]
    fn codes_keep_the_promised_precision() {
        for (metres, precision) in
            [(0.5, 1e-9), (9.0, 1e-9), (11.0, 1e-6), (9_000.0, 1e-6), (11_000.0, 1e-3), (1e9, 1e-3)]
        {
            let nm = (metres * 1e9) as u64;
            assert_ne!(code(nm, true), code(nm + (precision * 1e9) as u64, true), "{metres} m");
            assert!((f64::from(depth(code(nm, true), true)) / metres - 1.0).abs() < 1e-6, "{metres} m");
        }
    }

    /// Against f64, whose 53 bits are enough at these distances, and which shares only the definition.
    #[test]
    fn agrees_with_floating_point() {
        let grid = Grid { scale: [0.001; 3], origin: [0.0; 3] };
        let camera = Camera { eye: [7.001_5, -20.0, 3.0], ..Default::default() };
        let view = camera.view(&grid, [640, 480], 1).expect("a camera");
        let depth40 = Depth40::of(&view);
        let row = view.row_w;
        for k in 0..2000_i32 {
            let position = [k * 7 % 9973 - 4000, k * 31 % 8887 - 4000, k * 13 % 6007 - 3000];
            let eye = [7001.5, -20_000.0, 3000.0];
            let expected: f64 = (0..3).map(|a| f64::from(row[a]) * (f64::from(position[a]) - eye[a])).sum();
            let found = depth40.nanometres(&view, position) as f64;
            assert!((found - expected * 1e9).abs() <= 1.1, "{position:?}: {found} nm, {expected} m");
            let other = depth40.nanometres(&view, [position[0] + 1, position[1], position[2]]) as f64;
            assert!((other - expected * 1e9).abs() > 1.1, "a step aside differs");
        }
    }
}
