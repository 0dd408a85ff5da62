//! From values to colours by whole numbers alone, so that every backend gives the same.
//!
//! A value is known by its *key*, a whole number that is larger for a larger value. A scale is the smallest key of each
//! of 256 colours; which one a point has is found by eight comparisons. Whatever lies between value and colour (a
//! range, a root, a logarithm) is worked out for these 256 keys, on the host.

use serde::Serialize;

use crate::scene::Grid;

/// The last of the 256 thresholds that `key` reaches. The first is reached by every key. Twin of `level_of` in
/// `shaders/color.wgsl`, `small_level` and `wide_level` in `shaders/column.wgsl`.
pub fn level<K: PartialOrd>(thresholds: &[K; 256], key: K) -> usize {
    let mut at = 0;
    for step in [128, 64, 32, 16, 8, 4, 2, 1] {
        if thresholds[at + step] <= key {
            at += step;
        }
    }
    at
}

/// The key of a number: its bits, so turned that they are in order. Never 0, which is the key of a point without a
/// value, for numbers that are none have no key.
pub fn key_of(value: f64) -> u64 {
    if value.is_nan() {
        return 0;
    }
    // −0 equals 0.
    let bits = (value + 0.0).to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

/// The number of a key, `None` for that of none.
pub fn value_of(key: u64) -> Option<f64> {
    (key != 0).then(|| f64::from_bits(if key >> 63 == 1 { key & !(1 << 63) } else { !key }))
}

/// How values are spread over the colours.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Transfer {
    #[default]
    Linear,
    /// Equal steps of reflectance look equal on a display.
    Root,
}

/// The values that have the first and the last colour, and what lies between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    pub low: f64,
    pub high: f64,
    pub transfer: Transfer,
}

impl Scale {
    /// Where a value lies between the first (0) and the last (1) colour.
    pub fn place(&self, value: f64) -> f64 {
        if self.high <= self.low {
            return 0.5;
        }
        let share = ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        match self.transfer {
            Transfer::Linear => share,
            Transfer::Root => share.sqrt(),
        }
    }

    /// The smallest value of each colour; that of the first is any.
    fn values(&self) -> [f64; 256] {
        let beyond = self.beyond_low();
        std::array::from_fn(|level| match level {
            0 => f64::NEG_INFINITY,
            _ if self.high <= self.low && beyond[level] > 0.0 => self.low.next_up(),
            _ => self.low + beyond[level],
        })
    }

    /// By how much the smallest value of each colour is beyond `low`; that of the first says nothing.
    pub fn beyond_low(&self) -> [f64; 256] {
        std::array::from_fn(|level| {
            // A colour is that of the values nearest to its own.
            let place = (level as f64 - 0.5) / 255.0;
            let share = match self.transfer {
                Transfer::Linear => place,
                Transfer::Root => place * place,
            };
            match level {
                // All values that are shown are one: it has the middle colour.
                0..=128 if self.high <= self.low => 0.0,
                _ if self.high <= self.low => f64::MIN_POSITIVE,
                _ => share * (self.high - self.low),
            }
        })
    }

    /// As [`key_of`].
    pub fn wide_thresholds(&self) -> [u64; 256] {
        self.thresholds(0, key_of)
    }

    /// For whole numbers from 0 to 65,535, whose keys are one more.
    pub fn small_thresholds(&self) -> [u32; 256] {
        // Above 65,536 there is no key.
        self.thresholds(0, |value| (value.ceil().clamp(0.0, 65_536.0) as u32) + 1)
    }

    /// For the third coordinate of a grid, whose keys are [`grid_key`]'s.
    pub fn grid_thresholds(&self, grid: &Grid) -> [u32; 256] {
        self.thresholds(0, |value| grid_key(first_at_or_above(grid, value)))
    }

    fn thresholds<K: Copy>(&self, least: K, key: impl Fn(f64) -> K) -> [K; 256] {
        let values = self.values();
        std::array::from_fn(|level| if level == 0 { least } else { key(values[level]) })
    }
}

/// Grid coordinates in order as unsigned numbers.
pub fn grid_key(z: i32) -> u32 {
    z.cast_unsigned() ^ 1 << 31
}

/// The lowest grid coordinate whose world coordinate is `value` or more; the highest there is if none is.
fn first_at_or_above(grid: &Grid, value: f64) -> i32 {
    let world = |z: i32| grid.world([0, 0, z])[2];
    // A float becomes an integer within its limits. Its rounding may be a step off at either side.
    let mut z = ((value - grid.origin[2]) / grid.scale[2]).ceil() as i32;
    while z > i32::MIN && world(z - 1) >= value {
        z -= 1;
    }
    while z < i32::MAX && world(z) < value {
        z += 1;
    }
    z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_in_the_order_of_their_values() {
        let ordered = [
            f64::NEG_INFINITY,
            f64::MIN,
            -1.5,
            (-1.5f64).next_up(),
            -f64::MIN_POSITIVE,
            -5e-324,
            0.0,
            5e-324,
            1.0,
            1.0f64.next_up(),
            302_745_223.114_093_2,
            f64::MAX,
            f64::INFINITY,
        ];
        assert!(ordered.windows(2).all(|pair| key_of(pair[0]) < key_of(pair[1])));
        assert!(ordered.iter().all(|&value| key_of(value) > 0 && value_of(key_of(value)) == Some(value)));
        assert_eq!(key_of(-0.0), key_of(0.0));
        assert_eq!((key_of(f64::NAN), key_of(-f64::NAN), value_of(0)), (0, 0, None));
    }

    #[test]
    fn a_level_is_the_last_threshold_reached() {
        let thresholds: [u32; 256] = std::array::from_fn(|i| 3 * i as u32);
        for key in 0..1000 {
            assert_eq!(level(&thresholds, key), (key as usize / 3).min(255));
        }
        assert_eq!(level(&[0u32; 256], 0), 255, "of equal thresholds the last");
    }

    /// The level by the formula, in floating point.
    fn by_formula(scale: &Scale, value: f64) -> usize {
        (scale.place(value) * 255.0 + 0.5) as usize
    }

    #[test]
    fn thresholds_are_those_of_the_formula() {
        for transfer in [Transfer::Linear, Transfer::Root] {
            for (low, high) in [(0.0, 1.0), (-20.0, 13.5), (100.0, 60_000.0), (3.0, 7.0)] {
                let scale = Scale { low, high, transfer };
                let (wide, small) = (scale.wide_thresholds(), scale.small_thresholds());
                for n in 0..5000u32 {
                    let value = low - 1.0 + (high - low + 2.0) * f64::from(n) / 4999.0;
                    // At the very border between two colours rounding decides.
                    let formula = by_formula(&scale, value).abs_diff(level(&wide, key_of(value)));
                    let is_border = (scale.place(value) * 255.0).fract() - 0.5 < 1e-6;
                    assert!(formula == 0 || (formula == 1 && is_border), "{value} of {low} to {high}");
                    let whole = 13 * n;
                    let of_whole = level(&wide, key_of(whole.into()));
                    assert_eq!(
                        level(&small, whole.min(65_535) + 1),
                        if whole < 65_536 { of_whole } else { level(&wide, key_of(65_535.0)) }
                    );
                }
            }
        }
    }

    #[test]
    fn grid_coordinates_have_the_level_of_their_world_coordinates() {
        for (scale, origin) in [(0.001, 0.0), (0.01, -312.45), (0.25, 1e7), (1e-5, 3.3)] {
            let grid = Grid { scale: [scale; 3], origin: [origin; 3] };
            let range = Scale { low: origin - 100.0 * scale, high: origin + 900.0 * scale, transfer: Transfer::Linear };
            let (on_grid, wide) = (range.grid_thresholds(&grid), range.wide_thresholds());
            for z in -300..1200 {
                let world = grid.world([0, 0, z])[2];
                assert_eq!(level(&on_grid, grid_key(z)), level(&wide, key_of(world)), "{z} at {scale}");
            }
        }
        assert!(grid_key(i32::MIN) == 0 && grid_key(-1) < grid_key(0) && grid_key(i32::MAX) == u32::MAX);
    }

    #[test]
    fn one_value_has_the_middle_colour() {
        let scale = Scale { low: 5.0, high: 5.0, transfer: Transfer::Linear };
        let levels = [4.9, 5.0, 5.1].map(|value| level(&scale.wide_thresholds(), key_of(value)));
        assert_eq!(levels, [0, 128, 255]);
        assert_eq!([4, 5, 6].map(|value| level(&scale.small_thresholds(), value + 1)), [0, 128, 255]);
    }
}
