//! A filter as integer tests on one scene, the same on every backend. Twin of `shaders/mask.wgsl`.

use super::{Clause, Clip, Filter, Ranges, steps};
use crate::{
    render::{column::ColumnId, wide::WideKeys},
    scene::{Attribute, Grid, SceneFacts},
};

/// What a test looks at, as an unsigned number that keeps the order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// A coordinate on the grid, plus 2³¹.
    Axis(u8),
    /// The dot product of the position and this direction, plus 2⁶³.
    Plane([i32; 3]),
    Intensity,
    Record,
    /// The key of the record in a column, see [`ColumnColors`](crate::render::ColumnColors); 0 is in no range.
    Column {
        column: ColumnId,
        is_wide: bool,
    },
}

/// Where an attribute's values are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// With the points.
    Slots,
    /// In a column. Tests of another version are to be looked at anew: more values have come.
    Column { column: ColumnId, version: u64 },
    /// They were not read: nothing is known of any point.
    Nowhere,
}

/// A point passes if its key lies in one of the ranges.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Test {
    pub key: Key,
    /// Closed, in order, none of which overlap.
    pub ranges: Vec<[u64; 2]>,
    /// As [`Place::Column`] has it; 0 of other places.
    pub version: u64,
}

/// What a [`Filter`] and a [`Clip`] come to on one scene. A point that fails any test is hidden.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MaskRules {
    pub tests: Vec<Test>,
}

impl MaskRules {
    /// None if every point is shown. `place` says where an attribute's values are.
    pub fn new(
        filter: &Filter,
        clip: &Clip,
        scene: &SceneFacts,
        place: impl Fn(&Attribute) -> Place,
    ) -> Option<MaskRules> {
        let of_clause = |clause: &Clause| of_clause(clause, scene, place(&clause.attribute));
        let mut tests: Vec<Test> = filter.clauses.iter().map(of_clause).collect();
        if let Some(b) = &clip.bounds {
            let axis = |a: usize| of_axis(a, &scene.grid, &Ranges::new([[b.min[a], b.max[a]]]));
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

    /// Whether a point is shown. `colors` are red, green, blue and intensity; `key` is that of its record in a column.
    pub fn show(&self, position: [i32; 3], colors: [u16; 4], record: u32, key: impl Fn(ColumnId) -> u64) -> bool {
        self.tests.iter().all(|test| {
            let key = match test.key {
                Key::Axis(a) => axis_key(position[usize::from(a)].into()),
                Key::Plane(a) => plane_key((0..3).map(|k| i64::from(a[k]) * i64::from(position[k])).sum()),
                Key::Intensity => colors[3].into(),
                Key::Record => record.into(),
                Key::Column { column, .. } => key(column),
            };
            test.ranges[..test.ranges.partition_point(|[low, _]| *low <= key)]
                .last()
                .is_some_and(|[_, high]| key <= *high)
        })
    }

    /// The tests of what is with the points.
    pub fn of_slots(&self) -> Vec<&Test> {
        self.tests.iter().filter(|test| !matches!(test.key, Key::Column { .. })).collect()
    }

    /// The tests of columns: which, and whether its keys are wide.
    pub fn of_columns(&self) -> impl Iterator<Item = (ColumnId, bool, &Test)> {
        self.tests.iter().filter_map(|test| match test.key {
            Key::Column { column, is_wide } => Some((column, is_wide, test)),
            _ => None,
        })
    }

    /// Tests as the kernels read them: four words (the number of tests first), then each test in eight, then all ranges.
    /// Layout shared with `shaders/mask_rules.wgsl`.
    pub fn words(tests: &[&Test]) -> Vec<u32> {
        let mut words = vec![tests.len() as u32, 0, 0, 0];
        let mut first_range = 0;
        for test in tests {
            let (kind, a) = match test.key {
                Key::Axis(a) => (u32::from(a), [0; 3]),
                Key::Plane(a) => (3, a),
                Key::Intensity => (4, [0; 3]),
                // The kernel of columns takes its keys from nowhere else.
                Key::Record | Key::Column { .. } => (5, [0; 3]),
            };
            let [x, y, z] = a.map(i32::cast_unsigned);
            let count = test.ranges.len() as u32;
            words.extend([kind, x, y, z, first_range, count, 0, 0]);
            first_range += count;
        }
        for border in tests.iter().flat_map(|test| test.ranges.iter().flatten()) {
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

fn test(key: Key, ranges: Vec<[u64; 2]>) -> Test {
    Test { key, ranges, version: 0 }
}

fn of_plane(plane: &steps::Plane) -> Test {
    test(Key::Plane(plane.a), ranges([[plane.low, plane.high]], plane_key))
}

fn of_axis(axis: usize, grid: &Grid, values: &Ranges) -> Test {
    let all = [i64::from(i32::MIN), i64::from(i32::MAX)];
    let within = |&[low, high]: &[f64; 2]| {
        let [low, high] = steps::axis(grid, axis, low, high);
        [low.max(all[0]), high.min(all[1])]
    };
    test(Key::Axis(axis as u8), ranges(values.ranges().iter().map(within), axis_key))
}

/// Ranges of keys, in order and apart; what is inside out is left out.
fn ranges(of: impl IntoIterator<Item = [i64; 2]>, key: impl Fn(i64) -> u64) -> Vec<[u64; 2]> {
    apart(of.into_iter().filter(|[low, high]| low <= high).map(|range| range.map(&key)).collect())
}

/// The same in order; what overlaps or touches is one.
fn apart(mut ranges: Vec<[u64; 2]>) -> Vec<[u64; 2]> {
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

/// What lies from `first` to `last` outside of these ranges.
fn others(ranges: &[[u64; 2]], first: u64, last: u64) -> Vec<[u64; 2]> {
    let mut others = Vec::new();
    let mut next = Some(first);
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
fn whole(values: &Ranges, last: u32) -> Vec<[u64; 2]> {
    let last = f64::from(last);
    let borders = |&[low, high]: &[f64; 2]| [low.ceil().max(0.0), high.floor().min(last)].map(|x| x as i64);
    // One that ends below 0 is inside out then.
    ranges(values.ranges().iter().filter(|[_, high]| *high >= 0.0).map(borders), |x| x as u64)
}

fn of_clause(clause: &Clause, scene: &SceneFacts, place: Place) -> Test {
    let small = u64::from(u16::MAX);
    // The first and the last key that a value may have.
    let (test, first, last) = match (&clause.attribute, place) {
        (Attribute::Elevation, _) => (of_axis(2, &scene.grid, &clause.values), 0, u32::MAX.into()),
        (Attribute::File, _) => {
            let records = |&[first, last]: &[u64; 2]| {
                let at = |file: u64| scene.files.get(file as usize).map(|file| i64::from(file.first_record));
                [at(first).unwrap_or(i64::MAX), at(last + 1).unwrap_or(1 << 32) - 1]
            };
            let files = whole(&clause.values, scene.files.len().saturating_sub(1) as u32);
            (test(Key::Record, ranges(files.iter().map(records), |record| record as u64)), 0, u32::MAX.into())
        }
        (Attribute::Intensity, Place::Slots) => {
            (test(Key::Intensity, whole(&clause.values, u16::MAX.into())), 0, small)
        }
        (attribute, Place::Column { column, version }) => {
            let is_wide = !attribute.is_small();
            let (ranges, last) = if is_wide {
                (apart(WideKeys::new(attribute, scene).ranges(&clause.values)), u64::MAX)
            } else {
                let values = whole(&clause.values, u16::MAX.into());
                (values.iter().map(|range| range.map(|value| value + 1)).collect(), small + 1)
            };
            (Test { key: Key::Column { column, is_wide }, ranges, version }, 1, last)
        }
        (_, Place::Slots | Place::Nowhere) => return test(Key::Record, Vec::new()),
    };
    if clause.is_excluding { Test { ranges: others(&test.ranges, first, last), ..test } } else { test }
}
