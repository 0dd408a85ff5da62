//! How right a picture is: against the picture of `atomic-min`, which has 32 bits of depth and the number of
//! the point, and which is itself held to the processor's ([`Processor`](super::Processor)).
//!
//! Only pixels that one of the two pictures covers are counted, by all measures: the rest is background in
//! both, and in a view from afar 99.7 % of all pixels.

use std::ops::Range;

use serde::Serialize;

use crate::{
    measure::stats::quantile,
    methods::{Drawn, NO_POINT, parallel::map},
};

/// A picture against the right one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Accuracy {
    /// Pixels that one of the pictures covers, or both.
    pub covered_pixels: u64,
    /// Of these, covered in the right picture only.
    pub missing_pixels: u64,
    /// Of these, covered in this picture only.
    pub extra_pixels: u64,
    /// Covered pixels that show another point, or none. Null for methods that average points.
    pub wrong_pixels: Option<u64>,
    /// Share of covered pixels that show the right point, 0 to 1; null where nothing is covered, and for methods
    /// that average points.
    pub right_share: Option<f64>,
    /// Peak signal-to-noise ratio of red, green and blue, decibels; null for equal colours (infinite).
    pub psnr_db: Option<f64>,
    /// Mean structural similarity of the luma, −1 to 1; null if no window lies around a covered pixel.
    pub ssim: Option<f64>,
    /// Error of the depth, in the file's unit, where both pictures have one: the median, and the 95th percentile.
    pub depth_error_median: Option<f64>,
    pub depth_error_p95: Option<f64>,
    /// Points that a method gave up on, by its own count.
    pub give_ups: u64,
}

impl Accuracy {
    /// `drawn` against `right`; `blends` if it averages points.
    ///
    /// # Panics
    /// If the pictures differ in size.
    pub fn of(drawn: &Drawn, right: &Drawn, blends: bool) -> Accuracy {
        assert_eq!(drawn.size, right.size, "pictures of one size");
        let pixels = right.point.len();
        let bands =
            map(pixels.div_ceil(BAND), |band| Sums::of(drawn, right, band * BAND..pixels.min((band + 1) * BAND)));
        let Sums { shown, depth_errors, covered, missing, extra, wrong, squares } =
            bands.into_iter().fold(Sums::default(), Sums::and);
        let mean_square = squares as f64 / (3 * covered) as f64;
        let error = |share| (!depth_errors.is_empty()).then(|| quantile(&depth_errors, share));
        let wrong_pixels = (!blends).then_some(wrong);
        Accuracy {
            covered_pixels: covered,
            missing_pixels: missing,
            extra_pixels: extra,
            wrong_pixels,
            right_share: wrong_pixels.filter(|_| covered > 0).map(|wrong| 1.0 - wrong as f64 / covered as f64),
            psnr_db: (squares > 0).then(|| 10.0 * (255.0 * 255.0 / mean_square).log10()),
            ssim: ssim(&drawn.rgba, &right.rgba, drawn.size, &shown),
            depth_error_median: error(0.5),
            depth_error_p95: error(0.95),
            give_ups: drawn.give_ups,
        }
    }
}

/// Pixels that a thread sums up at a time.
const BAND: usize = 1 << 15;

/// What some pixels, one after the other, add to an accuracy.
#[derive(Default)]
struct Sums {
    /// Of each pixel, whether it counts.
    shown: Vec<bool>,
    depth_errors: Vec<f64>,
    covered: u64,
    missing: u64,
    extra: u64,
    wrong: u64,
    squares: u64,
}

impl Sums {
    fn of(drawn: &Drawn, right: &Drawn, pixels: Range<usize>) -> Sums {
        let is_covered = |picture: &Drawn, i: usize| picture.depth[i].is_finite() || picture.point[i] != NO_POINT;
        let mut sums = Sums::default();
        for i in pixels {
            let (here, there) = (is_covered(drawn, i), is_covered(right, i));
            sums.shown.push(here || there);
            if !(here || there) {
                continue;
            }
            sums.covered += 1;
            sums.missing += u64::from(!here);
            sums.extra += u64::from(!there);
            sums.wrong += u64::from(drawn.point[i] != right.point[i]);
            for channel in 0..3 {
                sums.squares += u64::from(drawn.rgba[i][channel].abs_diff(right.rgba[i][channel])).pow(2);
            }
            if drawn.depth[i].is_finite() && right.depth[i].is_finite() {
                sums.depth_errors.push((f64::from(drawn.depth[i]) - f64::from(right.depth[i])).abs());
            }
        }
        sums
    }

    fn and(mut self, next: Sums) -> Sums {
        self.shown.extend(next.shown);
        self.depth_errors.extend(next.depth_errors);
        self.covered += next.covered;
        self.missing += next.missing;
        self.extra += next.extra;
        self.wrong += next.wrong;
        self.squares += next.squares;
        self
    }
}

/// Width of the windows of [`ssim`], pixels.
const WINDOW: usize = 7;
/// Rows of windows that a thread looks at; always so many, so that the sum does not depend on the threads.
const WINDOW_ROWS: usize = 32;

/// Mean structural similarity of the luma (Wang, Bovik, Sheikh, Simoncelli 2004, "Image Quality Assessment: From
/// Error Visibility to Structural Similarity") over windows of 7×7 pixels whose centre is `shown`, with the
/// constants of the paper and sample covariances: what scikit-image's `structural_similarity` computes of the
/// same windows.
///
/// Not a crate's: `image-compare` brings `image`, `rayon` and `itertools`, and averages over the background too.
/// Sums over 49 integers are exact, and cost two additions each as the window slides.
pub fn ssim(a: &[[u8; 4]], b: &[[u8; 4]], size: [u32; 2], shown: &[bool]) -> Option<f64> {
    let [width, height] = size.map(|n| n as usize);
    if width < WINDOW || height < WINDOW {
        return None;
    }
    let bands = map((height + 1 - WINDOW).div_ceil(WINDOW_ROWS), |band| {
        let first = band * WINDOW_ROWS;
        let rows = first * width..(first + WINDOW_ROWS + WINDOW - 1).min(height) * width;
        sum_of_windows(&a[rows.clone()], &b[rows.clone()], width, &shown[rows])
    });
    let (total, windows) = bands.into_iter().fold((0.0, 0), |sum, band| (sum.0 + band.0, sum.1 + band.1));
    (windows > 0).then(|| total / windows as f64)
}

/// Similarities of all windows that lie in these rows, and how many there are.
fn sum_of_windows(a: &[[u8; 4]], b: &[[u8; 4]], width: usize, shown: &[bool]) -> (f64, u64) {
    let height = a.len() / width;
    let [a, b] = [a, b].map(|picture| picture.iter().map(luma).collect::<Vec<u32>>());
    let (half, count) = (WINDOW / 2, (WINDOW * WINDOW) as f64);
    let (c1, c2) = ((0.01_f64 * 255.0).powi(2), (0.03_f64 * 255.0).powi(2));
    // Per column: the sums of a, b, a², b², ab over the window's rows.
    let mut columns = vec![[0u32; 5]; width];
    let moments = |i: usize| [a[i], b[i], a[i] * a[i], b[i] * b[i], a[i] * b[i]];
    let (mut total, mut windows) = (0.0, 0u64);
    for y in 0..height {
        for (x, column) in columns.iter_mut().enumerate() {
            let enters = moments(y * width + x);
            let leaves = if y >= WINDOW { moments((y - WINDOW) * width + x) } else { [0; 5] };
            (0..5).for_each(|m| column[m] = column[m] + enters[m] - leaves[m]);
        }
        if y + 1 < WINDOW {
            continue;
        }
        let centers = (y - half) * width;
        let mut sums = [0u32; 5];
        for x in 0..width {
            let leaves = if x >= WINDOW { columns[x - WINDOW] } else { [0; 5] };
            (0..5).for_each(|m| sums[m] = sums[m] + columns[x][m] - leaves[m]);
            if x + 1 < WINDOW || !shown[centers + x - half] {
                continue;
            }
            let [mean_a, mean_b, aa, bb, ab] = sums.map(|sum| f64::from(sum) / count);
            let sample = count / (count - 1.0);
            let (var_a, var_b) = (sample * (aa - mean_a * mean_a), sample * (bb - mean_b * mean_b));
            let covariance = sample * (ab - mean_a * mean_b);
            total += (2.0 * mean_a * mean_b + c1) * (2.0 * covariance + c2)
                / ((mean_a * mean_a + mean_b * mean_b + c1) * (var_a + var_b + c2));
            windows += 1;
        }
    }
    (total, windows)
}

/// Rec. 601 luma, rounded to 8 bits.
fn luma(&[r, g, b, _]: &[u8; 4]) -> u32 {
    (299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b) + 500) / 1000
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [24, 16];

    /// A smooth picture, a margin of background around it.
    fn picture() -> Drawn {
        let mut drawn = Drawn {
            size: SIZE,
            point: vec![NO_POINT; 384],
            depth: vec![f32::INFINITY; 384],
            rgba: vec![[0, 0, 0, 255]; 384],
            give_ups: 0,
        };
        for y in 2..14 {
            for x in 2..20 {
                let i = y * 24 + x;
                drawn.point[i] = i as u32;
                drawn.depth[i] = 10.0 + x as f32;
                drawn.rgba[i] = [10 * x as u8, 12 * y as u8, 128, 255];
            }
        }
        drawn
    }

    #[test]
    fn the_right_picture_is_right() {
        let right = picture();
        let accuracy = Accuracy::of(&right, &right, false);
        assert_eq!((accuracy.covered_pixels, accuracy.wrong_pixels), (12 * 18, Some(0)));
        assert_eq!((accuracy.right_share, accuracy.psnr_db), (Some(1.0), None));
        assert!((accuracy.ssim.unwrap() - 1.0).abs() < 1e-12);
        assert_eq!((accuracy.depth_error_median, accuracy.depth_error_p95), (Some(0.0), Some(0.0)));
        let empty = Drawn { point: vec![NO_POINT; 384], depth: vec![f32::INFINITY; 384], ..picture() };
        let nothing = Accuracy::of(&empty, &empty, false);
        assert_eq!((nothing.covered_pixels, nothing.right_share, nothing.ssim), (0, None, None));
        assert_eq!(Accuracy::of(&right, &right, true).right_share, None, "an average shows no point");
    }

    #[test]
    fn every_damage_worsens_its_measure() {
        let right = picture();
        let damaged = |damage: &dyn Fn(&mut Drawn)| {
            let mut drawn = picture();
            damage(&mut drawn);
            Accuracy::of(&drawn, &right, false)
        };
        let center = 8 * 24 + 10;
        let other_point = damaged(&|d| d.point[center] = 7);
        assert_eq!((other_point.wrong_pixels, other_point.psnr_db), (Some(1), None));
        assert!(other_point.right_share.unwrap() < 1.0);
        let hole = damaged(&|d| {
            d.point[center] = NO_POINT;
            d.depth[center] = f32::INFINITY;
        });
        assert_eq!((hole.missing_pixels, hole.extra_pixels, hole.wrong_pixels), (1, 0, Some(1)));
        let speck = damaged(&|d| d.point[0] = 7);
        assert_eq!((speck.missing_pixels, speck.extra_pixels, speck.covered_pixels), (0, 1, 217));
        let tint = damaged(&|d| d.rgba[center][1] ^= 64);
        let noise = damaged(&|d| (0..384).for_each(|i| d.rgba[i][1] = d.rgba[i][1].wrapping_add((i * 97 % 101) as u8)));
        assert!(tint.psnr_db.unwrap() < 60.0 && noise.psnr_db.unwrap() < tint.psnr_db.unwrap());
        assert!(tint.ssim.unwrap() < 0.999 && noise.ssim.unwrap() < tint.ssim.unwrap());
        let one = damaged(&|d| d.depth[center] += 3.0);
        assert_eq!((one.depth_error_median, one.depth_error_p95), (Some(0.0), Some(0.0)));
        let tenth = damaged(&|d| d.depth.iter_mut().skip(1).step_by(10).for_each(|depth| *depth += 3.0));
        assert_eq!((tenth.depth_error_median, tenth.depth_error_p95), (Some(0.0), Some(3.0)));
        let all = damaged(&|d| d.depth.iter_mut().for_each(|depth| *depth += 3.0));
        assert_eq!(all.depth_error_median, Some(3.0));
    }

    #[test]
    fn psnr_is_that_of_the_definition() {
        let right = picture();
        let mut drawn = picture();
        // 5 off in every channel of every covered pixel; what no picture covers does not count.
        for (i, pixel) in drawn.rgba.iter_mut().enumerate() {
            pixel[..3].iter_mut().for_each(|c| *c = if right.point[i] == NO_POINT { 99 } else { c.saturating_add(5) });
        }
        let psnr = Accuracy::of(&drawn, &right, false).psnr_db.unwrap();
        assert!((psnr - 10.0 * (255.0 * 255.0 / 25.0_f64).log10()).abs() < 1e-9, "{psnr}");
        let mut noisy = picture();
        noisy.rgba.iter_mut().zip(0..).for_each(|(p, i)| p[1] = p[1].wrapping_add((i * 97 % 101) as u8));
        let psnr = Accuracy::of(&noisy, &right, false).psnr_db.unwrap();
        // scikit-image 0.26, peak_signal_noise_ratio(…, data_range=255) of the covered pixels' three channels.
        assert!((psnr - 17.220_770_628_115_616).abs() < 1e-12, "{psnr}");
    }

    /// Window by window, with means and covariances as the paper writes them.
    fn slow_ssim(a: &[[u8; 4]], b: &[[u8; 4]], shown: &[bool]) -> f64 {
        let (mut total, mut windows) = (0.0, 0.0);
        for y in 3..13 {
            for x in 3..21 {
                if !shown[y * 24 + x] {
                    continue;
                }
                let pixels: Vec<usize> = (0..49).map(|k| (y - 3 + k / 7) * 24 + x - 3 + k % 7).collect();
                let values = |p: &[[u8; 4]]| pixels.iter().map(|&i| f64::from(luma(&p[i]))).collect::<Vec<_>>();
                let (u, v) = (values(a), values(b));
                let mean = |w: &[f64]| w.iter().sum::<f64>() / 49.0;
                let (mu, mv) = (mean(&u), mean(&v));
                let cov = |p: &[f64], q: &[f64]| {
                    let (mp, mq) = (mean(p), mean(q));
                    p.iter().zip(q).map(|(x, y)| (x - mp) * (y - mq)).sum::<f64>() / 48.0
                };
                let (c1, c2) = (6.5025, 58.5225);
                total += (2.0 * mu * mv + c1) * (2.0 * cov(&u, &v) + c2)
                    / ((mu * mu + mv * mv + c1) * (cov(&u, &u) + cov(&v, &v) + c2));
                windows += 1.0;
            }
        }
        total / windows
    }

    #[test]
    fn sliding_sums_give_the_similarity_of_the_definition() {
        let right = picture();
        let mut drawn = picture();
        drawn.rgba.iter_mut().enumerate().for_each(|(i, p)| p[0] = p[0].wrapping_add((i * i % 37) as u8));
        for shown in [vec![true; 384], right.point.iter().map(|&p| p != NO_POINT).collect()] {
            let (fast, slow) =
                (ssim(&drawn.rgba, &right.rgba, SIZE, &shown), slow_ssim(&drawn.rgba, &right.rgba, &shown));
            assert!((fast.unwrap() - slow).abs() < 1e-9, "{fast:?} {slow}");
            assert!(slow < 0.99);
        }
        let all = ssim(&drawn.rgba, &right.rgba, SIZE, &[true; 384]).unwrap();
        // scikit-image 0.26, structural_similarity(…, data_range=255) of the same lumas.
        assert!((all - 0.986_721_866_308_437_8).abs() < 1e-12, "{all}");
        assert_eq!(ssim(&drawn.rgba, &right.rgba, SIZE, &[false; 384]), None);
        assert_eq!(ssim(&[[0; 4]; 36], &[[0; 4]; 36], [6, 6], &[true; 36]), None, "smaller than a window");
    }
}
