//! What a uniform random sample of the points would show, computed exactly for one view.
//!
//! Of `n` points, `m` cover a pixel and `t` of these lie at its front (as near as any). A sample of `k` points,
//! drawn without putting back, misses all of `m` given ones with the hypergeometric probability
//! `q(m) = C(n − m, k) / C(n, k) = Π (n − k − j) / (n − j)`, `j` from 0 to `m − 1`. So the pixel is covered with
//! probability `1 − q(m)` and shows the front with `1 − q(t)`. A frame tries a run of slots of a shuffled store: if
//! the shuffle is uniform, that is such a sample, and what it shows of the last frame besides can only add to it.
//!
//! The shares of all pixels scatter. With points of one pixel, pixels have no points in common, and drawing without
//! putting back makes them repel one another: the variance is at most `Σ p (1 − p)`. Points of `s` pixels' width tie
//! neighbours together; pixels `s` apart in both directions have none in common, so the picture falls into `s²` such
//! sets, and the deviation is at most `s √(Σ p (1 − p))`. Being a bound, it makes the check mild, never wrong.
//!
//! Points are projected on the processor ([`View::project`]); where a GPU rounds otherwise, a few pixels in a hundred
//! thousand differ, far less than the deviation.

use std::{
    collections::BTreeMap,
    sync::atomic::{AtomicU64, Ordering::Relaxed},
    thread,
};

use serde::Serialize;

use super::metrics::significant;
use crate::{render::View, scene::PointBatch};

/// Points of each pixel, in all and at the front, counted: `(m, t)` → pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Counts {
    points: u64,
    point_size: u32,
    pixels: BTreeMap<(u32, u32), u64>,
}

/// What a sample should show.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Expected {
    /// Points in the sample, and in all.
    pub sample: u64,
    pub of: u64,
    /// Share of the covered pixels that the sample covers, and at most its standard deviation.
    pub covered_share: f64,
    pub covered_sigma: f64,
    /// Share of the covered pixels in which the sample shows the nearest depth, and at most its standard deviation.
    pub front_share: f64,
    pub front_sigma: f64,
    /// Share of the covered pixels that show one given point of theirs: `sample / of`.
    pub right_share: f64,
}

impl Counts {
    /// Counts on all threads.
    pub fn of(batches: &[PointBatch], view: &View) -> Counts {
        let size = view.width as usize * view.height as usize;
        // Of each pixel: the number of points, and the depth of the nearest above how many lie there, up to 2³².
        let totals: Vec<AtomicU64> = (0..size).map(|_| AtomicU64::new(0)).collect();
        let nearest: Vec<AtomicU64> = (0..size).map(|_| AtomicU64::new(u64::from(u32::MAX) << 32)).collect();
        let threads = thread::available_parallelism().map_or(1, usize::from);
        thread::scope(|scope| {
            for part in batches.chunks(batches.len().div_ceil(threads).max(1)) {
                let (totals, nearest) = (&totals, &nearest);
                scope.spawn(move || {
                    for &position in part.iter().flat_map(|batch| &batch.positions) {
                        count(view, position, totals, nearest);
                    }
                });
            }
        });
        let mut pixels = BTreeMap::new();
        for (total, nearest) in totals.iter().zip(&nearest) {
            let m = total.load(Relaxed).min(u32::MAX.into()) as u32;
            if m > 0 {
                *pixels.entry((m, nearest.load(Relaxed) as u32)).or_insert(0) += 1;
            }
        }
        let points = batches.iter().map(|batch| batch.len() as u64).sum();
        Counts { points, point_size: view.point_size, pixels }
    }

    /// Pixels with any point.
    pub fn covered(&self) -> u64 {
        self.pixels.values().sum()
    }

    /// Points that fall into the picture, once per pixel that they cover.
    pub fn fragments(&self) -> u64 {
        self.pixels.iter().map(|(&(m, _), pixels)| u64::from(m) * pixels).sum()
    }

    /// What `sample` of the points should show; `None` if there is nothing to be seen.
    pub fn expect(&self, sample: u64) -> Option<Expected> {
        let (k, n, covered) = (sample.min(self.points), self.points, self.covered());
        if covered == 0 {
            return None;
        }
        let most = self.pixels.keys().map(|&(m, _)| m).max().unwrap_or(0);
        let misses = misses(k, n, most);
        let (mut sums, mut variances) = ([0.0; 2], [0.0; 2]);
        for (&(m, t), &pixels) in &self.pixels {
            for (i, count) in [m, t].into_iter().enumerate() {
                let q = misses.get(count as usize).copied().unwrap_or(0.0);
                sums[i] += (1.0 - q) * pixels as f64;
                variances[i] += q * (1.0 - q) * pixels as f64;
            }
        }
        let share = |sum: f64| significant(sum / covered as f64);
        let sigma = |variance: f64| share(f64::from(self.point_size) * variance.sqrt());
        Some(Expected {
            sample: k,
            of: n,
            covered_share: share(sums[0]),
            covered_sigma: sigma(variances[0]),
            front_share: share(sums[1]),
            front_sigma: sigma(variances[1]),
            right_share: significant(k as f64 / n as f64),
        })
    }
}

/// Adds a point to the pixels that it covers.
fn count(view: &View, position: [i32; 3], totals: &[AtomicU64], nearest: &[AtomicU64]) {
    let Some(point) = view.project(position) else { return };
    let size = point.size as i32;
    let depth = u64::from(point.depth.to_bits()) << 32;
    let clip = |at: i32, end: u32| at.max(0) as usize..(at + size).clamp(0, end as i32) as usize;
    for y in clip(point.corner[1], view.height) {
        for x in clip(point.corner[0], view.width) {
            let i = y * view.width as usize + x;
            totals[i].fetch_add(1, Relaxed);
            // Depths are positive, so their bits are in their order.
            let _ = nearest[i].fetch_update(Relaxed, Relaxed, |held| match (held >> 32).cmp(&(depth >> 32)) {
                std::cmp::Ordering::Less => None,
                std::cmp::Ordering::Equal => Some(held + 1),
                std::cmp::Ordering::Greater => Some(depth + 1),
            });
        }
    }
}

/// `q(0)`, `q(1)`, … as long as they are not nearly zero: the probability that `k` of `n` points miss so many.
fn misses(k: u64, n: u64, most: u32) -> Vec<f64> {
    let mut q = vec![1.0];
    for j in 0..u64::from(most).min(n) {
        let last = q[j as usize];
        // None left to miss with, or too few to matter.
        if last < 1e-18 {
            break;
        }
        q.push(last * (n - k).saturating_sub(j) as f64 / (n - j) as f64);
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{render::Camera, scene::Grid, store::Permutation};

    /// Points in no order, many per pixel in places, every fourth twice.
    fn cloud(points: u32) -> PointBatch {
        let noise = |i: u32, k: u32| ((i.wrapping_mul(0x9E37_79B9) ^ k).wrapping_mul(0x85EB_CA6B) >> 12) as i32;
        let place = |i: u32| {
            let i = i - u32::from(i % 4 == 3);
            // Denser in the middle.
            [noise(i, 1) % 900 - 450, noise(i, 2) % 300, (noise(i, 3) % 60 - 30) * (noise(i, 4) % 14)]
        };
        PointBatch { positions: (0..points).map(place).collect(), ..Default::default() }
    }

    fn view(size: [u32; 2], point_size: u32) -> View {
        let camera = Camera { eye: [0.0, -10.0, 0.0], ..Default::default() };
        camera.view(&Grid { scale: [0.01; 3], origin: [0.0; 3] }, size, point_size).unwrap()
    }

    #[test]
    fn a_sample_misses_as_often_as_counting_says() {
        // 2 of 5 points: C(5, 2) = 10 samples; those without one given point C(4, 2) = 6, without two 3, three 1.
        let q = misses(2, 5, 5);
        for (found, wanted) in q.iter().zip([1.0, 0.6, 0.3, 0.1, 0.0]) {
            assert!((found - wanted).abs() < 1e-15, "{q:?}");
        }
        assert_eq!(misses(0, 5, 5), [1.0; 6], "no sample misses everything");
        assert_eq!(misses(5, 5, 5)[1], 0.0, "all points miss nothing");
        assert!(misses(1_000_000, 4_000_000_000, 1_000_000_000).len() < 200_000, "it ends when nothing is left");
    }

    #[test]
    fn counts_are_those_of_the_definition() {
        for point_size in [1, 2, 3] {
            for points in [0, 1, 2, 255, 256, 257, 4097] {
                let (view, batch) = (view([61, 37], point_size), cloud(points));
                let batches: Vec<PointBatch> = batch
                    .positions
                    .chunks(100)
                    .map(|p| PointBatch { positions: p.to_vec(), ..Default::default() })
                    .collect();
                let counts = Counts::of(&batches, &view);
                // Every pixel looks at every point.
                let mut expected = BTreeMap::new();
                for i in 0..61 * 37 {
                    let (x, y) = (i % 61, i / 61);
                    let size = point_size as i32;
                    let covers = |c: [i32; 2]| (0..size).contains(&(x - c[0])) && (0..size).contains(&(y - c[1]));
                    let here = batch.positions.iter().filter_map(|&p| view.project(p)).filter(|p| covers(p.corner));
                    let depths: Vec<f32> = here.map(|p| p.depth).collect();
                    let nearest = depths.iter().copied().fold(f32::INFINITY, f32::min);
                    let front = depths.iter().filter(|&&d| d == nearest).count();
                    if !depths.is_empty() {
                        *expected.entry((depths.len() as u32, front as u32)).or_insert(0u64) += 1;
                    }
                }
                assert_eq!(counts.pixels, expected, "{points} points of {point_size} pixels");
                assert_eq!(counts.points, u64::from(points));
            }
        }
    }

    /// Pixels that a sample covers, and pixels in which it shows the nearest depth of all.
    fn seen(positions: &[[i32; 3]], sample: impl Iterator<Item = usize>, view: &View) -> [f64; 2] {
        let draw = |points: &mut dyn Iterator<Item = usize>| {
            let mut depth = vec![f32::INFINITY; (view.width * view.height) as usize];
            for p in points.filter_map(|i| view.project(positions[i])) {
                let size = view.point_size as i32;
                for y in p.corner[1].max(0)..(p.corner[1] + size).min(view.height as i32) {
                    for x in p.corner[0].max(0)..(p.corner[0] + size).min(view.width as i32) {
                        let pixel = &mut depth[(y * view.width as i32 + x) as usize];
                        *pixel = pixel.min(p.depth);
                    }
                }
            }
            depth
        };
        let all = draw(&mut (0..positions.len()));
        let shown = draw(&mut { sample });
        let covered = all.iter().filter(|d| d.is_finite()).count() as f64;
        let share = |count: usize| count as f64 / covered;
        [
            share(shown.iter().filter(|d| d.is_finite()).count()),
            share(shown.iter().zip(&all).filter(|(a, b)| a.is_finite() && a == b).count()),
        ]
    }

    #[test]
    fn true_random_samples_agree_and_others_do_not() {
        const SAMPLES: u32 = 300;
        let points = 4000;
        let batch = cloud(points);
        for (point_size, k) in [(1, 40), (1, 400), (2, 400), (3, 1500)] {
            let view = view([61, 37], point_size);
            let counts = Counts::of(std::slice::from_ref(&batch), &view);
            let expected = counts.expect(u64::from(k)).unwrap();
            let sample = |seed: u32| {
                let order = Permutation::new(points, 99, u64::from(seed));
                seen(&batch.positions, (0..k).map(move |i| order.apply(i) as usize), &view)
            };
            let drawn: Vec<[f64; 2]> = (0..SAMPLES).map(sample).collect();
            let by_theory =
                [(expected.covered_share, expected.covered_sigma), (expected.front_share, expected.front_sigma)];
            for (i, (share, sigma)) in by_theory.into_iter().enumerate() {
                let mean = drawn.iter().map(|s| s[i]).sum::<f64>() / f64::from(SAMPLES);
                let variance = drawn.iter().map(|s| (s[i] - mean).powi(2)).sum::<f64>() / f64::from(SAMPLES - 1);
                // The mean of 300 samples scatters by a seventeenth of one.
                let off = (mean - share).abs() / (variance / f64::from(SAMPLES)).sqrt();
                assert!(off < 5.0, "{k} points of {point_size}: {mean} for {share}, {off} standard errors");
                assert!(variance.sqrt() < 1.1 * sigma, "{k}: the deviation {} is at most {sigma}", variance.sqrt());
                assert!(variance.sqrt() > 0.1 * sigma, "{k}: and {} not far from it", variance.sqrt());
            }
            // A sample from one side of the cloud is none.
            let mut by_x: Vec<usize> = (0..points as usize).collect();
            by_x.sort_by_key(|&i| batch.positions[i][0]);
            let side = seen(&batch.positions, by_x.into_iter().take(k as usize), &view);
            assert!(side[0] < expected.covered_share - 4.0 * expected.covered_sigma, "{side:?} {expected:?}");
        }
        let nothing = Counts::of(&[], &view([8, 8], 1));
        assert_eq!(nothing.expect(0), None);
        let all = Counts::of(std::slice::from_ref(&batch), &view([61, 37], 1)).expect(4000).unwrap();
        assert_eq!((all.covered_share, all.covered_sigma, all.front_share, all.right_share), (1.0, 0.0, 1.0, 1.0));
    }
}
