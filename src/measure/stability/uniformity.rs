//! Tests that tell orders of points from uniformly random ones: chi-square, coverage, and spectra. Each has an
//! order that it must reject and one that is known to be good (Fisher & Yates) and that it must accept; what
//! tests/shuffle.rs and the experiment `shuffles` hold the store's order to.

use std::f64::consts::TAU;

use crate::store::{Insertion, Permutation, ROUNDS};

/// How points get their slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shuffle {
    /// The store's, with so many Feistel rounds.
    Feistel(u32),
    /// The textbook's, on all points at once.
    FisherYates,
    /// Each batch among itself, behind the older ones.
    BatchOnly,
    /// None: slot = arrival.
    Unshuffled,
}

/// What the store does.
pub const STORE: Shuffle = Shuffle::Feistel(ROUNDS as u32);

/// Arrival numbers by slot, after points arrived in batches of the given sizes.
pub fn shuffled(shuffle: Shuffle, batches: &[u32], seed: u64) -> Vec<u32> {
    let total: u32 = batches.iter().sum();
    match shuffle {
        Shuffle::Unshuffled => (0..total).collect(),
        Shuffle::FisherYates => {
            let mut slots: Vec<u32> = (0..total).collect();
            let mut random = Pcg::new(seed);
            for i in (1..total).rev() {
                slots.swap(i as usize, random.below(i + 1) as usize);
            }
            slots
        }
        Shuffle::BatchOnly => {
            let mut slots = Vec::new();
            for (index, &new) in (0..).zip(batches) {
                let permutation = Permutation::new(new, seed, index);
                let old = slots.len() as u32;
                slots.extend((0..new).map(|slot| old + permutation.invert(slot)));
            }
            slots
        }
        Shuffle::Feistel(rounds) => {
            let mut slots: Vec<u32> = Vec::new();
            for (index, &new) in (0..).zip(batches) {
                let old = slots.len() as u32;
                let permutation = Permutation::with_rounds(old + new, seed, index, rounds);
                let insertion = Insertion { old, new, permutation };
                let arrivals: Vec<u32> = (old..old + new).collect();
                insertion.apply(&mut slots, &arrivals, &insertion.moved_to());
            }
            slots
        }
    }
}

/// PCG-XSH-RR 64/32 (O'Neill 2014); shares nothing with the store's hash.
#[derive(Debug, Clone)]
pub struct Pcg(u64);

impl Pcg {
    pub fn new(seed: u64) -> Pcg {
        let mut pcg = Pcg(seed.wrapping_mul(0x5851_F42D_4C95_7F2D) ^ 0xDA3E_39CB_94B9_5BDB);
        pcg.next();
        pcg
    }

    fn next(&mut self) -> u32 {
        let state = self.0;
        self.0 = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((((state >> 18) ^ state) >> 27) as u32).rotate_right((state >> 59) as u32)
    }

    /// A number below `n`.
    pub fn below(&mut self, n: u32) -> u32 {
        ((u64::from(self.next()) * u64::from(n)) >> 32) as u32
    }
}

/// Batches of `size`, the last one smaller if need be.
pub fn batches_of(size: u32, total: u32) -> Vec<u32> {
    (0..total.div_ceil(size)).map(|k| size.min(total - k * size)).collect()
}

/// Standard deviations between a chi-square and its mean.
fn z_score(chi_square: f64, degrees_of_freedom: f64) -> f64 {
    (chi_square - degrees_of_freedom) / (2.0 * degrees_of_freedom).sqrt()
}

/// Number of points in each of `classes` equal classes of `[0, total)`, `class_of` being `x * classes / total`.
fn class_sizes(total: u32, classes: u32) -> Vec<f64> {
    let mut sizes = vec![0.0; classes as usize];
    (0..total).for_each(|x| sizes[class_of(x, total, classes)] += 1.0);
    sizes
}

fn class_of(x: u32, total: u32, classes: u32) -> usize {
    (u64::from(x) * u64::from(classes) / u64::from(total)) as usize
}

/// Slot against arrival, in `classes` × `classes` cells, summed over seeds: standard deviations from what independent
/// ones give.
pub fn z_slot_against_arrival(shuffle: Shuffle, batches: &[u32], seeds: u64, classes: u32) -> f64 {
    let total: u32 = batches.iter().sum();
    let side = classes as usize;
    let mut table = vec![0_u64; side * side];
    for seed in 0..seeds {
        for (slot, &arrival) in shuffled(shuffle, batches, seed).iter().enumerate() {
            table[class_of(slot as u32, total, classes) * side + class_of(arrival, total, classes)] += 1;
        }
    }
    let sizes = class_sizes(total, classes);
    let n = f64::from(total);
    let chi_square: f64 = (0..side * side)
        .map(|cell| {
            let expected = seeds as f64 * sizes[cell / side] * sizes[cell % side] / n;
            (table[cell] as f64 - expected).powi(2) / expected
        })
        .sum();
    // Rows and columns of a permutation have fixed sums: (classes - 1)² degrees of freedom remain. Its
    // cells are hypergeometric, n / (n - 1) times as far from their mean as independent draws are.
    z_score(chi_square * (n - 1.0) / n, f64::from(classes - 1).powi(2))
}

/// Steps from the slot of a point to that of the next to arrive, around the end: for each of `rows`
/// classes of arrival a table of `columns` classes of steps, summed over seeds.
pub fn z_neighbours(shuffle: Shuffle, batches: &[u32], seeds: u64, rows: u32, columns: u32) -> f64 {
    let total: u32 = batches.iter().sum();
    let mut table = vec![vec![0_u64; columns as usize]; rows as usize];
    let mut slot_of = vec![0; total as usize];
    for seed in 0..seeds {
        for (slot, &arrival) in shuffled(shuffle, batches, seed).iter().enumerate() {
            slot_of[arrival as usize] = slot as u32;
        }
        for (arrival, pair) in slot_of.windows(2).enumerate() {
            let step = (pair[1] + total - pair[0]) % total; // 1 to total - 1, all alike
            table[class_of(arrival as u32, total - 1, rows)][class_of(step - 1, total - 1, columns)] += 1;
        }
    }
    let sizes = class_sizes(total - 1, columns);
    let chi_square: f64 = table
        .iter()
        .flat_map(|row| {
            let in_row = row.iter().sum::<u64>() as f64;
            row.iter().zip(&sizes).map(move |(&count, size)| {
                let expected = in_row * size / f64::from(total - 1);
                (count as f64 - expected).powi(2) / expected
            })
        })
        .sum();
    z_score(chi_square, f64::from(rows) * f64::from(columns - 1))
}

/// Standard deviations between the mean number of grid cells that the first 1 % of the slots touch and
/// that of a random sample. The points lie in scan lines, 100 to each of the 64 × 64 cells.
pub fn z_coverage(shuffle: Shuffle, seeds: u64) -> f64 {
    const SIDE: u32 = 64;
    const PER_CELL_SIDE: u32 = 10;
    let cells = f64::from(SIDE * SIDE);
    let line = SIDE * PER_CELL_SIDE;
    let total = line * line;
    let sample = total / 100;
    let cell_of = |arrival: u32| arrival / line / PER_CELL_SIDE * SIDE + arrival % line / PER_CELL_SIDE;

    let touched: f64 = (0..seeds)
        .map(|seed| {
            let slots = shuffled(shuffle, &batches_of(65_536, total), seed);
            let mut seen = vec![false; cells as usize];
            slots[..sample as usize].iter().for_each(|&arrival| seen[cell_of(arrival) as usize] = true);
            seen.iter().filter(|&&s| s).count() as f64
        })
        .sum();

    // Chance that a sample misses `m` given points: ∏ (1 - m / (total - k)) over its draws k.
    let missed = |m: f64| (0..sample).map(|k| (1.0 - m / f64::from(total - k)).ln()).sum::<f64>().exp();
    let per_cell = f64::from(PER_CELL_SIDE.pow(2));
    let (one, two) = (missed(per_cell), missed(2.0 * per_cell));
    let mean = cells * (1.0 - one);
    let variance = cells * one * (1.0 - one) + cells * (cells - 1.0) * (two - one * one);
    (touched / seeds as f64 - mean) / (variance / seeds as f64).sqrt()
}

/// Chi-square of the arrivals in the first slots, in so many classes of `[0, total)`: standard deviations from a
/// random sample's.
pub fn z_first_slots(first: &[u32], total: u32, classes: u32) -> f64 {
    let mut counts = vec![0.0; classes as usize];
    first.iter().for_each(|&arrival| counts[class_of(arrival, total, classes)] += 1.0);
    let expected = first.len() as f64 / f64::from(classes);
    let chi_square: f64 = counts.iter().map(|count| (count - expected).powi(2) / expected).sum();
    // A sample without replacement varies less, by the share that is left.
    let left = 1.0 - first.len() as f64 / f64::from(total);
    z_score(chi_square / left.max(f64::MIN_POSITIVE), f64::from(classes - 1))
}

/// Most differences of differences that [`spectral_peak`] takes: 4 straighten a fourth power.
const DIFFERENCES: usize = 4;

/// The spectral test of an order. Arrivals `a` of successive slots are angles `2π a / total`; of the unit vectors at
/// these angles, and at those of their first to fourth differences, the periodogram over the slots is taken, each
/// divided by its length. Of a random order every value is exponential with mean 1. Returns the largest, which in a
/// random order exceeds ln(bins) + x with a chance of e^−x: of 4,096 slots, 22 once in 200,000. An even lattice, a
/// square or a fourth power is one line, as high as there are slots.
///
/// Takes a power of two of slots from the beginning of `first`.
pub fn spectral_peak(first: &[u32], total: u32) -> f64 {
    let mut steps: Vec<u64> = first.iter().map(|&a| a.into()).collect();
    let total = u64::from(total);
    let mut peak = 0.0_f64;
    for difference in 0..=DIFFERENCES {
        if difference > 0 {
            steps = steps.windows(2).map(|pair| (pair[1] + total - pair[0]) % total).collect();
        }
        let Some(len) = steps.len().checked_ilog2().map(|bits| 1 << bits) else { return peak };
        let angle = |&step: &u64| TAU * step as f64 / total as f64;
        let mut wave: Vec<[f64; 2]> = steps[..len].iter().map(angle).map(|a| [a.cos(), a.sin()]).collect();
        fourier(&mut wave);
        peak = wave.iter().fold(peak, |peak, [re, im]| peak.max((re * re + im * im) / len as f64));
    }
    peak
}

/// Discrete Fourier transform in place (Cooley & Tukey 1965), of a power of two of complex numbers.
fn fourier(wave: &mut [[f64; 2]]) {
    let len = wave.len();
    if len < 2 {
        return;
    }
    let bits = len.trailing_zeros();
    for i in 0..len {
        let j = i.reverse_bits() >> (usize::BITS - bits);
        if i < j {
            wave.swap(i, j);
        }
    }
    let mut span = 1;
    while span < len {
        for group in wave.chunks_exact_mut(2 * span) {
            let (low, high) = group.split_at_mut(span);
            for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
                let (sin, cos) = (-TAU * k as f64 / (2 * span) as f64).sin_cos();
                let turned = [b[0] * cos - b[1] * sin, b[0] * sin + b[1] * cos];
                (*a, *b) = ([a[0] + turned[0], a[1] + turned[1]], [a[0] - turned[0], a[1] - turned[1]]);
            }
        }
        span *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transform_is_the_definition() {
        for len in [1, 2, 8, 64] {
            let wave: Vec<[f64; 2]> =
                (0..len).map(|i| [f64::from(i * i % 7) - 3.0, f64::from(i * 5 % 11) - 5.0]).collect();
            let mut found = wave.clone();
            fourier(&mut found);
            for (k, found) in found.iter().enumerate() {
                let mut sum = [0.0; 2];
                for (n, value) in wave.iter().enumerate() {
                    let (sin, cos) = (-TAU * (k * n) as f64 / f64::from(len)).sin_cos();
                    sum = [sum[0] + value[0] * cos - value[1] * sin, sum[1] + value[0] * sin + value[1] * cos];
                }
                assert!((sum[0] - found[0]).abs() + (sum[1] - found[1]).abs() < 1e-9, "{len} {k}");
            }
        }
    }

    #[test]
    fn spectra_show_what_is_regular() {
        let total = 1_000_003_u64;
        let power = |e: u32| (0..5000_u64).map(|s| (s.pow(e) % total) as u32).collect::<Vec<_>>();
        for e in 1..=4 {
            assert!(spectral_peak(&power(e), total as u32) > 1000.0, "power {e}");
        }
        let random = shuffled(Shuffle::FisherYates, &[1_000_003], 3);
        assert!(spectral_peak(&random[..5000], total as u32) < 22.0);
        assert_eq!(spectral_peak(&[], 5), 0.0);
    }

    #[test]
    fn first_slots_from_one_corner_are_told_from_random_ones() {
        let total = 100_000;
        let random = shuffled(Shuffle::FisherYates, &[total], 1);
        assert!(z_first_slots(&random[..1000], total, 50).abs() < 4.0);
        let corner: Vec<u32> = (0..1000).collect();
        assert!(z_first_slots(&corner, total, 50) > 100.0);
    }
}
