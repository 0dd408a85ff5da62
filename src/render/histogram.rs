//! How the values of an attribute are spread: what ranges, legends and counts are made of.
//!
//! Nothing depends on the order in which points arrive, so that a picture's range does not depend on the timing of
//! threads. Whole numbers of 16 bits are counted each. Others fall into bins whose width is a power of two, and whose
//! borders are multiples of it: where the range outgrows them, two bins become one, exactly.

use crate::scene::{ColorStats, INTENSITY_BINS, intensity_of_bin, last_of_bin};

/// Bins of numbers that are not counted each.
pub const BINS: usize = 16_384;

/// Counts of an attribute's values so far.
#[derive(Debug, Clone)]
pub enum AttributeStats {
    /// Of each whole number from 0 on, 65,535 at most.
    Counted(Box<[u64]>),
    Binned(Histogram),
    Intensities(SampledIntensities),
}

/// A sample of intensities, of which the smallest and the largest are known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SampledIntensities {
    /// By [`intensity_bin`](crate::scene::intensity_bin).
    counts: Vec<u64>,
    extent: [u16; 2],
}

impl SampledIntensities {
    /// Of files whose points say this; `None` if no intensity was read.
    pub fn new(stats: &[ColorStats]) -> Option<SampledIntensities> {
        let mut all = ColorStats::default();
        let mut counts = vec![0; INTENSITY_BINS];
        for stats in stats {
            all.intensity_min = all.intensity_min.min(stats.intensity_min);
            all.intensity_max = all.intensity_max.max(stats.intensity_max);
            counts.iter_mut().zip(stats.intensity.iter()).for_each(|(sum, &n)| *sum += u64::from(n));
        }
        let extent = [all.intensity_min, all.intensity_max];
        (extent[0] <= extent[1]).then_some(SampledIntensities { counts, extent })
    }

    fn clipped(&self, clip_percent: f64) -> Option<[f64; 2]> {
        let [least, most] = self.extent;
        let [low, high] = match clip_percent {
            0.0 => self.extent,
            _ => {
                let [low, high] = clipped_bins(&self.counts, clip_percent)?;
                [intensity_of_bin(low).clamp(least, most), last_of_bin(high).clamp(least, most)]
            }
        };
        Some([low.into(), high.into()])
    }

    /// The middle of each bin, and its count.
    fn each(&self, mut count: impl FnMut(f64, u64)) {
        let [least, most] = self.extent.map(f64::from);
        for (bin, &n) in self.counts.iter().enumerate() {
            let middle = f64::midpoint(intensity_of_bin(bin).into(), last_of_bin(bin).into());
            count(middle.clamp(least, most), n);
        }
    }
}

impl AttributeStats {
    /// `is_small`: whole numbers of 16 bits.
    pub fn new(is_small: bool) -> AttributeStats {
        if is_small {
            AttributeStats::Counted(vec![0; 1 << 16].into_boxed_slice())
        } else {
            AttributeStats::Binned(Histogram::default())
        }
    }

    /// Points with a value.
    pub fn total(&self) -> u64 {
        match self {
            AttributeStats::Counted(counts) => counts.iter().sum(),
            AttributeStats::Binned(histogram) => histogram.total,
            AttributeStats::Intensities(sample) => sample.counts.iter().sum(),
        }
    }

    /// Smallest and largest value.
    pub fn extent(&self) -> Option<[f64; 2]> {
        match self {
            AttributeStats::Counted(counts) => {
                let low = counts.iter().position(|&n| n > 0)?;
                let high = counts.iter().rposition(|&n| n > 0)?;
                Some([low as f64, high as f64])
            }
            AttributeStats::Binned(histogram) => histogram.extent(),
            AttributeStats::Intensities(sample) => Some(sample.extent.map(f64::from)),
        }
    }

    /// The values between which all but `clip_percent` of the points at either end lie: exact where each value is
    /// counted, else to the width of a bin.
    pub fn clipped(&self, clip_percent: f64) -> Option<[f64; 2]> {
        match self {
            AttributeStats::Counted(counts) => {
                let [low, high] = clipped_bins(counts, clip_percent)?;
                Some([low as f64, high as f64])
            }
            AttributeStats::Binned(histogram) => histogram.clipped(clip_percent),
            AttributeStats::Intensities(sample) => sample.clipped(clip_percent),
        }
    }

    /// The numbers of points in `bins` equal parts of `[low, high]`; a value at a border counts with the part above.
    pub fn bins(&self, [low, high]: [f64; 2], bins: usize) -> Vec<u64> {
        let mut parts = vec![0; bins];
        let mut count = |value: f64, n: u64| {
            let at = ((value - low) / (high - low) * bins as f64).floor();
            if n > 0 && value >= low && value <= high && bins > 0 {
                parts[(at.max(0.0) as usize).min(bins - 1)] += n;
            }
        };
        match self {
            AttributeStats::Counted(counts) => counts.iter().enumerate().for_each(|(v, &n)| count(v as f64, n)),
            AttributeStats::Binned(histogram) => histogram.each(count),
            AttributeStats::Intensities(sample) => sample.each(count),
        }
        parts
    }

    /// The numbers of points of each value that there is, by value; none of values that are not counted each.
    pub fn counts(&self) -> Vec<(u16, u64)> {
        match self {
            AttributeStats::Counted(counts) => {
                (0..=u16::MAX).zip(counts.iter().copied()).filter(|&(_, n)| n > 0).collect()
            }
            AttributeStats::Binned(_) | AttributeStats::Intensities(_) => Vec::new(),
        }
    }

    /// Counts values by their small keys.
    pub fn add_small(&mut self, keys: &[u32]) {
        if let AttributeStats::Counted(counts) = self {
            for &key in keys {
                if let Some(n) = counts.get_mut(key.wrapping_sub(1) as usize) {
                    *n += 1;
                }
            }
        }
    }

    /// Counts values by their wide keys, which mean these values.
    pub fn add_wide(&mut self, keys: &[u64], value: impl Fn(u64) -> Option<f64>) {
        if let AttributeStats::Binned(histogram) = self {
            histogram.add(|| keys.iter().filter_map(|&key| value(key)));
        }
    }
}

/// The first and the last bin with what is left when this share of all is taken off at either end.
fn clipped_bins(counts: &[u64], clip_percent: f64) -> Option<[usize; 2]> {
    let total: u64 = counts.iter().sum();
    let off = (total as f64 * clip_percent / 100.0) as u64;
    let low = first_beyond(counts.iter(), off)?;
    let high = counts.len() - 1 - first_beyond(counts.iter().rev(), off)?;
    // With half of all taken off they may have passed each other.
    Some([low.min(high), high.max(low)])
}

/// The first bin with which more than `off` are counted.
fn first_beyond<'a>(mut counts: impl Iterator<Item = &'a u64>, off: u64) -> Option<usize> {
    let mut seen = 0;
    counts.position(|&n| {
        seen += n;
        seen > off
    })
}

/// Numbers in bins that grow with their range.
#[derive(Debug, Clone)]
pub struct Histogram {
    /// A bin is `2^exponent` wide.
    exponent: i32,
    /// The first bin holds `[first, first + 1) · 2^exponent`.
    first: i64,
    counts: Vec<u64>,
    min: f64,
    max: f64,
    total: u64,
}

impl Default for Histogram {
    fn default() -> Self {
        let (min, max) = (f64::INFINITY, f64::NEG_INFINITY);
        Histogram { exponent: 0, first: 0, counts: Vec::new(), min, max, total: 0 }
    }
}

/// The narrowest bins that hold numbers from `min` to `max`: it depends on nothing else.
fn exponent_for(min: f64, max: f64) -> i32 {
    let largest = min.abs().max(max.abs()).max(f64::MIN_POSITIVE);
    // Numbers of bins stay below 2⁵², so that they are exact in between.
    let mut exponent = (largest.log2().ceil() as i32 - 51).max(-1000);
    while bin(max, exponent) - bin(min, exponent) >= BINS as i64 {
        exponent += 1;
    }
    exponent
}

fn bin(value: f64, exponent: i32) -> i64 {
    (value * 2f64.powi(-exponent)).floor() as i64
}

impl Histogram {
    pub fn extent(&self) -> Option<[f64; 2]> {
        (self.total > 0).then_some([self.min, self.max])
    }

    /// The same counts of numbers that, as is known otherwise, lie between these, both among them.
    pub fn between(mut self, min: f64, max: f64) -> Histogram {
        if self.total > 0 {
            self.widen(min.min(self.min), max.max(self.max));
        }
        self
    }

    /// Counts numbers, which are gone through twice; infinite ones are left out.
    pub fn add<I: Iterator<Item = f64>>(&mut self, values: impl Fn() -> I) {
        let finite = || values().filter(|value| value.is_finite());
        let [min, max] = finite().fold([self.min, self.max], |[min, max], v| [min.min(v), max.max(v)]);
        if min > max {
            return;
        }
        self.widen(min, max);
        let scale = 2f64.powi(-self.exponent);
        for value in finite() {
            // Within the bins, which were made to hold it.
            self.counts[((value * scale).floor() as i64 - self.first) as usize] += 1;
            self.total += 1;
        }
    }

    fn widen(&mut self, min: f64, max: f64) {
        if self.total > 0 && min == self.min && max == self.max {
            return;
        }
        let exponent = exponent_for(min, max);
        let first = bin(min, exponent);
        let mut counts = vec![0; (bin(max, exponent) - first + 1) as usize];
        for (at, &n) in (self.first..).zip(&self.counts) {
            // Rounds down, as `floor` does; the exponent never falls, for the range only grows.
            counts[((at >> (exponent - self.exponent).min(63)) - first) as usize] += n;
        }
        (self.exponent, self.first, self.counts, self.min, self.max) = (exponent, first, counts, min, max);
    }

    fn width(&self) -> f64 {
        2f64.powi(self.exponent)
    }

    /// As [`AttributeStats::clipped`].
    pub fn clipped(&self, clip_percent: f64) -> Option<[f64; 2]> {
        if clip_percent == 0.0 {
            return self.extent();
        }
        let [low, high] = clipped_bins(&self.counts, clip_percent)?;
        let edge = |bin: i64| (bin as f64 * self.width()).clamp(self.min, self.max);
        Some([edge(self.first + low as i64), edge(self.first + high as i64 + 1)])
    }

    /// The middle of each bin, and its count.
    fn each(&self, mut count: impl FnMut(f64, u64)) {
        for (at, &n) in (self.first..).zip(&self.counts) {
            count(((at as f64 + 0.5) * self.width()).clamp(self.min, self.max), n);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        render::scale::{key_of, value_of},
        scene::intensity_bin,
    };

    fn binned(values: &[f64], piece: usize) -> AttributeStats {
        let mut stats = AttributeStats::new(false);
        for piece in values.chunks(piece) {
            stats.add_wide(&piece.iter().map(|&v| key_of(v)).collect::<Vec<_>>(), value_of);
        }
        stats
    }

    /// Values that wander over many sizes, with a few far out.
    fn values() -> Vec<f64> {
        let mut x = 1u64;
        (0..20_000)
            .map(|n| {
                x = x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let unit = (x >> 11) as f64 / (1u64 << 53) as f64;
                if n % 5000 == 4999 { -1e6 * unit } else { 3e8 + 1000.0 * unit }
            })
            .collect()
    }

    #[test]
    fn the_order_of_arrival_changes_nothing() {
        let mut values = values();
        let whole = binned(&values, usize::MAX);
        let AttributeStats::Binned(expected) = &whole else { unreachable!() };
        for piece in [1, 7, 1000] {
            values.reverse();
            let AttributeStats::Binned(found) = binned(&values, piece) else { unreachable!() };
            assert_eq!(
                (found.exponent, found.first, &found.counts),
                (expected.exponent, expected.first, &expected.counts)
            );
            assert_eq!((found.min, found.max, found.total), (expected.min, expected.max, expected.total));
        }
        let mut other = values.clone();
        other[77] = 0.0;
        let AttributeStats::Binned(found) = binned(&other, 7) else { unreachable!() };
        assert!(found.counts != expected.counts, "the comparison can fail");
    }

    #[test]
    fn ranges_leave_out_the_ends() {
        let mut values: Vec<f64> = (0..10_000).map(|n| f64::from(n) * 0.001).collect();
        values.extend([1e4; 50]);
        let stats = binned(&values, 100);
        assert_eq!(stats.extent(), Some([0.0, 1e4]));
        assert_eq!(stats.clipped(0.0), Some([0.0, 1e4]));
        let [low, high] = stats.clipped(1.0).unwrap();
        assert!(low < 0.11 && (9.9..=11.0).contains(&high), "{low} {high}");
        assert_eq!(stats.bins([0.0, 1e4], 10).iter().sum::<u64>(), 10_050);
        assert_eq!(stats.bins([0.0, 1e4], 10)[9], 50);
        // GPS times differ in their last digits.
        let times: Vec<f64> = (0..1000).map(|n| 302_745_223.0 + f64::from(n) * 1e-4).collect();
        let [low, high] = binned(&times, 100).clipped(1.0).unwrap();
        assert!((low - times[10]).abs() < 2e-5 && (high - times[989]).abs() < 2e-5, "{low} {high}");
    }

    #[test]
    fn small_numbers_are_counted_each() {
        let mut stats = AttributeStats::new(true);
        let keys: Vec<u32> = (0..1000).map(|n| if n < 5 { 0 } else { 1 + n % 3 }).chain([65_536]).collect();
        stats.add_small(&keys);
        assert_eq!(stats.counts(), [(0, 332), (1, 331), (2, 332), (65_535, 1)]);
        assert_eq!((stats.total(), stats.extent()), (996, Some([0.0, 65_535.0])));
        assert_eq!(stats.clipped(1.0), Some([0.0, 2.0]));
        assert_eq!(AttributeStats::new(true).clipped(1.0), None);
    }

    #[test]
    fn a_sample_of_intensities_ends_where_the_points_do() {
        let mut stats = ColorStats { intensity_min: 3, intensity_max: 60_001, ..Default::default() };
        for value in (100..50_000).step_by(100) {
            stats.intensity[intensity_bin(value)] += 1;
        }
        let dark = ColorStats { intensity_min: 7, intensity_max: 90, ..Default::default() };
        let sample = AttributeStats::Intensities(
            SampledIntensities::new(&[dark, stats, ColorStats::default()]).expect("intensities"),
        );
        assert_eq!((sample.total(), sample.extent()), (499, Some([3.0, 60_001.0])));
        assert_eq!(sample.clipped(0.0), sample.extent());
        // The fifth from either end, to the ends of their bins.
        assert_eq!(sample.clipped(1.0), Some([496.0, 51_199.0]));
        assert_eq!(sample.bins([0.0, 65_536.0], 2).iter().sum::<u64>(), 499);
        assert_eq!(SampledIntensities::new(&[ColorStats::default()]), None);
    }

    #[test]
    fn known_ends_are_the_extent_of_a_sample() {
        let AttributeStats::Binned(sample) = binned(&[5.0, 6.0, 7.0, 7.0], 4) else { unreachable!() };
        let wider = sample.clone().between(-1e6, 9.0);
        assert_eq!((wider.extent(), wider.total), (Some([-1e6, 9.0]), 4));
        assert_eq!(sample.clone().between(6.0, 6.5).extent(), sample.extent());
        assert_eq!(Histogram::default().between(1.0, 2.0).extent(), None);
    }

    #[test]
    fn odd_numbers_do_no_harm() {
        let stats = binned(&[f64::INFINITY, f64::NAN, -1e300, 5e-324, f64::NEG_INFINITY], 1);
        assert_eq!((stats.total(), stats.extent()), (2, Some([-1e300, 5e-324])));
        assert!(binned(&[f64::MAX, f64::MIN], 1).clipped(1.0).is_some());
        assert_eq!(binned(&[f64::NAN], 1).clipped(1.0), None);
        assert_eq!(binned(&[5.0; 10], 3).clipped(1.0), Some([5.0, 5.0]));
    }
}
