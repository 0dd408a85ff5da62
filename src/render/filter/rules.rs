//! A filter as integer tests on one scene, the same on every backend. Twin of `shaders/mask.wgsl`.

use super::{Clause, Clip, Filter, steps, values::Values};
use crate::scene::{Attribute, SceneFacts};

/// What a test looks at, as an unsigned number that keeps the order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// A coordinate on the grid, plus 2³¹.
    Axis(u8),
    /// The dot product of the position and this direction, plus 2⁶³.
    Plane([i32; 3]),
    Intensity,
    Record,
}

/// A point passes if its key lies in one of the ranges.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Test {
    pub key: Key,
    /// Closed, in order, none of which overlap.
    pub ranges: Vec<[u64; 2]>,
}

/// What a [`Filter`] and a [`Clip`] come to on one scene. A point that fails any test is hidden.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MaskRules {
    pub tests: Vec<Test>,
}

/// Words of a test, and of a range, in [`MaskRules::words`]. Layout shared with `shaders/mask.wgsl`.
pub const RULE_WORDS: usize = 8;

impl MaskRules {
    /// None if every point is shown.
    pub fn new(filter: &Filter, clip: &Clip, scene: &SceneFacts) -> Option<MaskRules> {
        let mut tests: Vec<Test> = filter.clauses.iter().map(|clause| of_clause(clause, scene)).collect();
        if let Some(b) = &clip.bounds {
            let axis = |a: usize| of_axis(a, &scene.grid, &Values::new([[b.min[a], b.max[a]]]));
            if b.degrees % 360.0 == 0.0 {
                tests.extend([axis(0), axis(1)]);
            } else {
                tests.extend(steps::sides(&scene.grid, b).iter().map(of_plane));
            }
            tests.push(axis(2));
        }
        tests.extend(clip.slab.iter().map(|slab| of_plane(&steps::slab(&scene.grid, slab))));
        (!tests.is_empty()).then_some(MaskRules { tests })
    }

    /// Whether a point is shown. `colors` are red, green, blue and intensity.
    pub fn show(&self, position: [i32; 3], colors: [u16; 4], record: u32) -> bool {
        self.tests.iter().all(|test| {
            let key = match test.key {
                Key::Axis(a) => axis_key(position[usize::from(a)].into()),
                Key::Plane(a) => plane_key((0..3).map(|k| i64::from(a[k]) * i64::from(position[k])).sum()),
                Key::Intensity => colors[3].into(),
                Key::Record => record.into(),
            };
            test.ranges[..test.ranges.partition_point(|[low, _]| *low <= key)]
                .last()
                .is_some_and(|[_, high]| key <= *high)
        })
    }

    /// The rules as the kernel reads them: four words (the number of tests first), then each test, then all ranges.
    pub fn words(&self) -> Vec<u32> {
        let mut words = vec![self.tests.len() as u32, 0, 0, 0];
        let mut first_range = 0;
        for test in &self.tests {
            let (kind, a) = match test.key {
                Key::Axis(a) => (u32::from(a), [0; 3]),
                Key::Plane(a) => (3, a),
                Key::Intensity => (4, [0; 3]),
                Key::Record => (5, [0; 3]),
            };
            let [x, y, z] = a.map(i32::cast_unsigned);
            let count = test.ranges.len() as u32;
            words.extend([kind, x, y, z, first_range, count, 0, 0]);
            first_range += count;
        }
        for border in self.tests.iter().flat_map(|test| test.ranges.iter().flatten()) {
            words.extend([*border as u32, (border >> 32) as u32]);
        }
        words
    }
}

fn axis_key(steps: i64) -> u64 {
    (steps + (1 << 31)) as u64
}

fn plane_key(dot: i64) -> u64 {
    dot.cast_unsigned() ^ 1 << 63
}

fn of_plane(plane: &steps::Plane) -> Test {
    Test { key: Key::Plane(plane.a), ranges: ranges([[plane.low, plane.high]], plane_key) }
}

fn of_axis(axis: usize, grid: &crate::scene::Grid, values: &Values) -> Test {
    let all = [i64::from(i32::MIN), i64::from(i32::MAX)];
    let within = |&[low, high]: &[f64; 2]| {
        let [low, high] = steps::axis(grid, axis, low, high);
        [low.max(all[0]), high.min(all[1])]
    };
    Test { key: Key::Axis(axis as u8), ranges: ranges(values.ranges().iter().map(within), axis_key) }
}

/// Ranges of keys, in order and apart; what is inside out is left out.
fn ranges(of: impl IntoIterator<Item = [i64; 2]>, key: impl Fn(i64) -> u64) -> Vec<[u64; 2]> {
    let mut ranges: Vec<[u64; 2]> =
        of.into_iter().filter(|[low, high]| low <= high).map(|range| range.map(&key)).collect();
    ranges.sort_unstable();
    let mut apart: Vec<[u64; 2]> = Vec::new();
    for [low, high] in ranges {
        match apart.last_mut() {
            Some(last) if low <= last[1].saturating_add(1) => last[1] = last[1].max(high),
            _ => apart.push([low, high]),
        }
    }
    apart
}

/// What lies from 0 to `last` outside of these ranges.
fn others(ranges: &[[u64; 2]], last: u64) -> Vec<[u64; 2]> {
    let mut others = Vec::new();
    let mut next = Some(0);
    for &[low, high] in ranges {
        if let Some(start) = next
            && start < low
        {
            others.push([start, low - 1]);
        }
        next = high.checked_add(1);
    }
    others.extend(next.filter(|&start| start <= last).map(|start| [start, last]));
    others
}

/// Whole numbers of a set, as far as `last`.
fn whole(values: &Values, last: u32) -> Vec<[u64; 2]> {
    let last = f64::from(last);
    let borders = |&[low, high]: &[f64; 2]| [low.ceil().max(0.0), high.floor().min(last)].map(|x| x as i64);
    // One that ends below 0 is inside out then.
    ranges(values.ranges().iter().filter(|[_, high]| *high >= 0.0).map(borders), |x| x as u64)
}

fn of_clause(clause: &Clause, scene: &SceneFacts) -> Test {
    let (test, last) = match &clause.attribute {
        Attribute::Elevation => (of_axis(2, &scene.grid, &clause.values), u32::MAX),
        Attribute::Intensity => {
            (Test { key: Key::Intensity, ranges: whole(&clause.values, u16::MAX.into()) }, u16::MAX.into())
        }
        Attribute::File => {
            let records = |&[first, last]: &[u64; 2]| {
                let at = |file: u64| scene.files.get(file as usize).map(|file| i64::from(file.first_record));
                [at(first).unwrap_or(i64::MAX), at(last + 1).unwrap_or(1 << 32) - 1]
            };
            let files = whole(&clause.values, scene.files.len().saturating_sub(1) as u32);
            (Test { key: Key::Record, ranges: ranges(files.iter().map(records), |record| record as u64) }, u32::MAX)
        }
        // Not read: nothing is known of any point.
        _ => return Test { key: Key::Record, ranges: Vec::new() },
    };
    if clause.is_excluding { Test { ranges: others(&test.ranges, last.into()), ..test } } else { test }
}
