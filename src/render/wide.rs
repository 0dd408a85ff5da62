//! Wide keys: how values of more than 16 bits become whole numbers that are larger for a larger value, the same for all
//! files of a scene, and with them the borders that people type in the digits they see.
//!
//! Integers that all files scale alike are keys by themselves: exact, also beyond the 2⁵³ up to which f64 has all of them.
//! Everything else is known by the bits of an f64, see [`key_of`]: that nearest to the digits of the value.

use std::cmp::Ordering;

use super::{
    filter::{Border, Ranges},
    scale::{Scale, Transfer, key_of, value_of},
};
use crate::scene::{Attribute, Decimal, ExtraDimension, ExtraKind, FileFacts, Number, Scaled, SceneFacts};

/// The keys of one attribute of a scene. 0 is the key of no value.
#[derive(Debug, Clone, PartialEq)]
pub enum WideKeys {
    Integers(IntegerKeys),
    /// Of numbers that all files hold as f32. Borders are rounded to f32 too: 0.1 is met by what is written 0.1.
    Singles,
    Doubles,
}

/// Keys of integers that mean `scale * n + offset`: their numbers from the one of the smallest value on, which is 1.
#[derive(Debug, Clone, PartialEq)]
pub struct IntegerKeys {
    scaled: Scaled,
    scale: f64,
    offset: f64,
    /// Smallest and largest that any file's type holds.
    least: i128,
    most: i128,
}

impl WideKeys {
    pub fn new(attribute: &Attribute, scene: &SceneFacts) -> WideKeys {
        let Attribute::Extra(name) = attribute else { return WideKeys::Doubles };
        let dimensions: Vec<_> = scene.files.iter().filter_map(|file| file.record.extra(name)).collect();
        let Some((first, element)) = dimensions.first() else { return WideKeys::Doubles };
        let scaling = first.scaling(*element);
        let are_alike = dimensions.iter().all(|(d, element)| d.scaling(*element) == scaling);
        if are_alike && scaling.is_none() && dimensions.iter().all(|(d, _)| d.kind == ExtraKind::F32) {
            return WideKeys::Singles;
        }
        let types: Option<Vec<[i128; 2]>> = dimensions.iter().map(|(d, _)| d.kind.integers()).collect();
        let integers = types.filter(|_| are_alike).and_then(|types| {
            let (scale, offset) = scaling.unwrap_or((1.0, 0.0));
            let least = types.iter().map(|[least, _]| *least).min()?;
            let most = types.iter().map(|[_, most]| *most).max()?;
            // Signed and unsigned ones of 64 bits are too many together.
            let are_few = most - least <= u64::MAX.into();
            let scaled = Scaled::new(scale, offset).filter(|_| scale != 0.0 && are_few)?;
            Some(IntegerKeys { scaled, scale, offset, least, most })
        });
        integers.map_or(WideKeys::Doubles, WideKeys::Integers)
    }

    /// The value of a key, for statistics: rounded twice where the digits are too many for an f64, since exact decimals
    /// would take a microsecond for each point.
    pub fn value(&self, key: u64) -> Option<f64> {
        match self {
            WideKeys::Integers(keys) => (key != 0).then(|| {
                let number = keys.number(key.into());
                keys.scaled.short(number).unwrap_or(number as f64 * keys.scale + keys.offset)
            }),
            WideKeys::Singles | WideKeys::Doubles => value_of(key),
        }
    }

    /// The keys of values in ranges; neither in order nor apart.
    pub fn ranges(&self, ranges: &Ranges) -> Vec<[u64; 2]> {
        match self {
            WideKeys::Integers(keys) => ranges.exact().iter().filter_map(|[low, high]| keys.range(low, high)).collect(),
            WideKeys::Singles => {
                let border = |border: &Border, open: f32| border.as_ref().map_or(open, Decimal::nearest_f32);
                let keys = ranges.exact().iter().map(|[low, high]| {
                    [border(low, f32::NEG_INFINITY), border(high, f32::INFINITY)].map(|border| key_of(border.into()))
                });
                keys.collect()
            }
            WideKeys::Doubles => ranges.ranges().iter().map(|range| range.map(key_of)).collect(),
        }
    }

    /// The smallest key of each of 256 colours.
    pub fn thresholds(&self, scale: &Scale) -> [u64; 256] {
        match self {
            WideKeys::Integers(keys) => keys.thresholds(scale),
            WideKeys::Singles | WideKeys::Doubles => scale.wide_thresholds(),
        }
    }

    /// The same from the first to the last of these keys, if f64 has not all numbers between: 2⁶⁰ and the nine integers
    /// after it are one number there.
    pub fn thresholds_between(&self, [first, last]: [u64; 2]) -> Option<[u64; 256]> {
        let WideKeys::Integers(keys) = self else { return None };
        let largest = [first, last].map(|key| keys.scaled.nearest(keys.number(key.into())).abs());
        let spacing = largest[0].max(largest[1]).next_up() - largest[0].max(largest[1]);
        let steps = (last - first) as f64;
        let is_coarse = first < last && spacing * 256.0 > steps * keys.scale.abs();
        let scale = Scale { low: 0.0, high: steps, transfer: Transfer::Linear };
        is_coarse.then(|| spread(first.into(), &scale.beyond_low()))
    }

    /// Whether [`WideKeys::thresholds_between`] may be asked: of other keys nobody has to know the first and the last.
    pub fn needs_extent(&self) -> bool {
        matches!(self, WideKeys::Integers(_))
    }

    /// What gives the keys of an extra dimension's numbers in one file.
    pub fn of_extra<'a>(&'a self, file: &'a FileFacts, name: &str) -> Option<impl Fn(&[u8]) -> u64 + 'a> {
        let (dimension, element) = file.record.extra(name)?;
        let double = Doubles::new(dimension, element);
        Some(move |extra: &[u8]| {
            let Some(number) = dimension.data(extra, element) else { return 0 };
            match (self, number) {
                (WideKeys::Integers(keys), Number::Signed(n)) => keys.key(n.into()),
                (WideKeys::Integers(keys), Number::Unsigned(n)) => keys.key(n.into()),
                (WideKeys::Singles, number) => key_of(number.as_f64()),
                (_, number) => key_of(double.value(number)),
            }
        })
    }
}

impl IntegerKeys {
    /// Of a negative scale, larger numbers are smaller values.
    fn key(&self, n: i128) -> u64 {
        let key = if self.scale > 0.0 { n - self.least } else { self.most - n } + 1;
        key.try_into().unwrap_or(u64::MAX)
    }

    /// The number of a key, of which there may be one more than 64 bits hold: i64 and u64 have 2⁶⁴ numbers. The largest
    /// two values share the largest key then.
    fn number(&self, key: i128) -> i128 {
        if self.scale > 0.0 { self.least + key - 1 } else { self.most - key + 1 }
    }

    /// The first key whose value is `order` to a border, or beyond; one after the last if none is.
    fn first(&self, border: &Decimal, is_before: impl Fn(Ordering) -> bool) -> i128 {
        let (mut first, mut end) = (1, self.most - self.least + 2);
        while first < end {
            let middle = first + (end - first) / 2;
            if is_before(self.scaled.exact(self.number(middle)).compare(border)) {
                first = middle + 1;
            } else {
                end = middle;
            }
        }
        first
    }

    /// The keys of all values between two borders, both among them.
    fn range(&self, low: &Border, high: &Border) -> Option<[u64; 2]> {
        let first = low.as_ref().map_or(1, |low| self.first(low, Ordering::is_lt));
        let end = high.as_ref().map_or(self.most - self.least + 2, |high| self.first(high, Ordering::is_le));
        let key = |key: i128| key.try_into().unwrap_or(u64::MAX);
        (first < end).then(|| [key(first), key(end - 1)])
    }

    fn thresholds(&self, scale: &Scale) -> [u64; 256] {
        // Counted from the first integer of the range, for keys have more digits than f64.
        let low = Decimal::from_f64(scale.low).unwrap_or(Decimal::from_integer(0));
        let first = self.first(&low, Ordering::is_lt);
        let step = self.scale.abs();
        let ahead = self.scaled.exact(self.number(first)).minus(&low).nearest() / step;
        spread(first, &scale.beyond_low().map(|beyond| beyond / step - ahead))
    }
}

/// The keys of 256 colours, so many steps behind the first key; the first colour's is any.
fn spread(first: i128, steps: &[f64; 256]) -> [u64; 256] {
    let key = |steps: f64| first.saturating_add(steps.ceil() as i128).clamp(0, u64::MAX.into()) as u64;
    std::array::from_fn(|level| if level == 0 { 0 } else { key(steps[level]) })
}

/// From the numbers of an extra dimension to the f64 nearest to their digits.
struct Doubles<'a> {
    dimension: &'a ExtraDimension,
    scaling: Option<(f64, f64)>,
    /// Of scale and offset, where these are finite.
    scaled: Option<Scaled>,
}

impl<'a> Doubles<'a> {
    fn new(dimension: &'a ExtraDimension, element: usize) -> Doubles<'a> {
        let scaling = dimension.scaling(element);
        let (scale, offset) = scaling.unwrap_or((1.0, 0.0));
        Doubles { dimension, scaling, scaled: Scaled::new(scale, offset) }
    }

    fn value(&self, number: Number) -> f64 {
        let (scale, offset) = self.scaling.unwrap_or((1.0, 0.0));
        let digits = match (number, self.dimension.kind) {
            (Number::Float(n), ExtraKind::F32) => Decimal::from_f32(n as f32),
            (Number::Float(n), _) if self.scaling.is_none() => return n,
            (Number::Float(n), _) => Decimal::from_f64(n),
            (Number::Unsigned(_) | Number::Signed(_), _) => None,
        };
        match (&self.scaled, number, digits) {
            (Some(scaled), Number::Signed(n), _) => scaled.nearest(n.into()),
            (Some(scaled), Number::Unsigned(n), _) => scaled.nearest(n.into()),
            (Some(scaled), Number::Float(_), Some(digits)) => scaled.of(&digits).nearest(),
            // Infinite, or not a number.
            _ => number.as_f64() * scale + offset,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        render::scale::level,
        scene::{Grid, RecordFacts},
    };

    fn dimension(kind: ExtraKind, scaling: Option<(f64, f64)>) -> ExtraDimension {
        ExtraDimension {
            name: "x".into(),
            description: String::new(),
            at: 0,
            kind,
            elements: 1,
            no_data: None,
            min: None,
            max: None,
            scale: scaling.map(|(scale, _)| vec![scale; 3]),
            offset: scaling.map(|(_, offset)| vec![offset; 3]),
        }
    }

    fn scene(dimensions: &[ExtraDimension]) -> SceneFacts {
        let file = |d: &ExtraDimension| FileFacts {
            record: RecordFacts { extra_bytes: d.bytes(), extra_dimensions: vec![d.clone()], ..Default::default() },
            ..Default::default()
        };
        let grid = Grid { scale: [1.0; 3], origin: [0.0; 3] };
        let files = dimensions.iter().map(file).collect();
        SceneFacts { grid, bounds: Default::default(), files, warnings: Vec::new() }
    }

    fn keys(scene: &SceneFacts) -> WideKeys {
        WideKeys::new(&Attribute::Extra("x".into()), scene)
    }

    /// Which of these numbers of a file the ranges hold.
    fn held<const N: usize>(scene: &SceneFacts, file: usize, numbers: &[[u8; N]], ranges: &str) -> Vec<usize> {
        let wide = keys(scene);
        let key = wide.of_extra(&scene.files[file], "x").expect("the dimension");
        let ranges = wide.ranges(&ranges.parse().expect("ranges"));
        let holds = |key: u64| ranges.iter().any(|[low, high]| (*low..=*high).contains(&key));
        (0..numbers.len()).filter(|&i| holds(key(&numbers[i]))).collect()
    }

    #[test]
    fn borders_in_the_digits_of_the_file_are_met() {
        let numbers: Vec<[u8; 4]> = (9_990..10_020i32).map(i32::to_le_bytes).collect();
        for (scale, offset) in
            [(0.1, -1000.0), (0.01, 0.0), (1e-7, 180.0), (-0.1, 7.0), (0.300_000_000_000_000_04, 1e5)]
        {
            let scene = scene(&[dimension(ExtraKind::I32, Some((scale, offset)))]);
            let digits = Scaled::new(scale, offset).unwrap();
            for i in 0..30 {
                let text = digits.exact(9_990 + i as i128).to_string();
                assert_eq!(held(&scene, 0, &numbers, &text), [i], "{text}");
                let count = if scale > 0.0 { i + 1 } else { 30 - i };
                assert_eq!(held(&scene, 0, &numbers, &format!("..{text}")).len(), count, "..{text}");
                assert_eq!(held(&scene, 0, &numbers, &format!("{text}..")).len(), 31 - count, "{text}..");
            }
            assert_eq!(held(&scene, 0, &numbers, "..").len(), 30);
        }
    }

    #[test]
    fn singles_are_met_by_their_digits() {
        let numbers: Vec<[u8; 4]> = (0..10).map(|i| (0.1 * i as f32).to_le_bytes()).collect();
        let single = dimension(ExtraKind::F32, None);
        let double = dimension(ExtraKind::F64, None);
        // In a scene with doubles the digits count as well.
        for scene in [scene(std::slice::from_ref(&single)), scene(&[single.clone(), double])] {
            for (ranges, expected) in [("0.1", 1..2), ("..0.1", 0..2), ("0.1..0.2", 1..3), ("0.4..", 4..10)] {
                assert_eq!(held(&scene, 0, &numbers, ranges), expected.collect::<Vec<_>>(), "{ranges}");
            }
        }
    }

    #[test]
    fn integers_of_64_bits_are_told_apart() {
        for first in [1 << 53, 1 << 60, i64::MAX - 11, i64::MIN, -5] {
            let numbers: Vec<[u8; 8]> = (0..10).map(|i| (first + i).to_le_bytes()).collect();
            let scene = scene(&[dimension(ExtraKind::I64, None)]);
            for i in 0..10 {
                let typed = (first + i).to_string();
                assert_eq!(held(&scene, 0, &numbers, &typed), [i as usize], "{typed}");
                assert_eq!(held(&scene, 0, &numbers, &format!("..{typed}")).len(), i as usize + 1);
            }
        }
        // Their number is one too many for keys: the largest two are one.
        let ends = [u64::MAX - 2, u64::MAX - 1, u64::MAX].map(u64::to_le_bytes);
        let scene = scene(&[dimension(ExtraKind::U64, None)]);
        for (ranges, expected) in
            [("18446744073709551613", vec![0]), ("18446744073709551614..", vec![1, 2]), ("1e30..", vec![])]
        {
            assert_eq!(held(&scene, 0, &ends, ranges), expected, "{ranges}");
        }
    }

    #[test]
    fn files_of_different_scales_meet_the_same_borders() {
        let scene = scene(&[
            dimension(ExtraKind::I32, Some((0.1, -1000.0))),
            dimension(ExtraKind::I16, Some((0.05, 0.0))),
            dimension(ExtraKind::F64, None),
        ]);
        assert_eq!(keys(&scene), WideKeys::Doubles);
        let wide: Vec<[u8; 4]> = (10_000..10_010i32).map(i32::to_le_bytes).collect();
        let short: Vec<[u8; 2]> = (0..10i16).map(i16::to_le_bytes).collect();
        let doubles = [0.1, 0.3, 0.1 + 0.2].map(f64::to_le_bytes);
        assert_eq!(held(&scene, 0, &wide, "0.1..0.3"), [1, 2, 3]);
        assert_eq!(held(&scene, 1, &short, "0.1..0.3"), [2, 3, 4, 5, 6]);
        assert_eq!(held(&scene, 2, &doubles, "0.1..0.3"), [0, 1], "0.1 + 0.2 is more than 0.3 there");
    }

    #[test]
    fn integers_have_the_colours_of_their_values() {
        let scene = scene(&[dimension(ExtraKind::I32, Some((0.1, -1000.0)))]);
        let wide = keys(&scene);
        let key = wide.of_extra(&scene.files[0], "x").unwrap();
        for (low, high) in [(0.0, 3.0), (-0.05, 77.77), (-2000.0, -1500.0), (1e12, 2e12), (5.0, 5.0), (-1e12, 1e12)] {
            let scale = Scale { low, high, transfer: Transfer::Linear };
            let (found, expected) = (wide.thresholds(&scale), scale.wide_thresholds());
            for n in 9_000..12_000i32 {
                let key = key(&n.to_le_bytes());
                let value = wide.value(key).unwrap();
                let (found, expected) = (level(&found, key), level(&expected, key_of(value)));
                // At the very border between two colours rounding decides.
                let is_border = high > low && ((scale.place(value) * 255.0).fract() - 0.5).abs() < 1e-6;
                assert!(
                    found == expected || (is_border && found.abs_diff(expected) == 1),
                    "{value} of {low} to {high}"
                );
            }
        }
    }

    #[test]
    fn integers_that_are_one_as_f64_have_their_colours() {
        let scene = scene(&[dimension(ExtraKind::I64, None)]);
        let wide = keys(&scene);
        let key = wide.of_extra(&scene.files[0], "x").unwrap();
        for first in [1i64 << 53, 1 << 60] {
            let keys: Vec<u64> = (0..10).map(|i| key(&(first + i).to_le_bytes())).collect();
            let thresholds = wide.thresholds_between([keys[0], keys[9]]).expect("f64 has too few numbers");
            let levels: Vec<usize> = keys.iter().map(|&key| level(&thresholds, key)).collect();
            assert_eq!(levels, (0..10).map(|i| (i * 255 * 2 + 9) / 18).collect::<Vec<_>>());
        }
        let near = [1i64, 1000].map(|n| key(&n.to_le_bytes()));
        assert_eq!(wide.thresholds_between(near), None);
    }

    #[test]
    fn elements_are_named_by_their_number() {
        let mut triple = dimension(ExtraKind::U8, Some((2.0, 0.0)));
        triple.elements = 3;
        let scene = scene(&[triple]);
        let file = &scene.files[0];
        let value = |name: &str| {
            let wide = WideKeys::new(&Attribute::Extra(name.into()), &scene);
            wide.of_extra(file, name).and_then(|key| wide.value(key(&[10, 20, 30])))
        };
        let found = ["x", "x[0]", "x[1]", "x[2]", "x[3]", "x[", "y[0]"].map(value);
        assert_eq!(found, [Some(20.0), Some(20.0), Some(40.0), Some(60.0), None, None, None]);
        assert_eq!(file.record.extra_names().collect::<Vec<_>>(), ["x", "x[1]", "x[2]"]);
        let mut bytes = file.clone();
        bytes.record.extra_dimensions[0] = dimension(ExtraKind::Bytes(3), None);
        assert!(!Attribute::Extra("x".into()).is_in(&bytes) && bytes.record.extra_names().next().is_none());
    }
}
