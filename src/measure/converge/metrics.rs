//! How far a frame is from the truth, and what changed between two frames.
//!
//! Shares are of the pixels that the truth covers: what a frame shows beyond it is counted apart. Colours and depths
//! are compared by [`Accuracy`], over the pixels that either covers.

use serde::Serialize;

use crate::{
    measure::raster::Accuracy,
    methods::{Drawn, NO_POINT},
    render::Picture,
};

/// Where two neighbouring pixels of the truth are so much farther apart than the nearer one is from the eye, its
/// depth jumps: an outline. A pixel there is wrong if its depth is off by as much: it shows the other side.
pub const EDGE_STEP: f32 = 0.05;

/// A colour changes if a channel changes by more levels than this; less is what neighbouring points differ by.
pub const CHANGE_LEVELS: u8 = 16;

/// A frame against the truth. Null: there is nothing to compare.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Metrics {
    /// Pixels that the truth covers.
    pub truth_pixels: u64,
    /// Share of them that the frame covers.
    pub covered_share: Option<f64>,
    /// Pixels that only the frame covers.
    pub extra_pixels: u64,
    /// Share of the truth's pixels that show its record.
    pub right_share: Option<f64>,
    /// Share of the truth's pixels that show its depth, to the last bit: its record, or another point just as near.
    pub front_share: Option<f64>,
    /// Peak signal-to-noise ratio of red, green and blue, decibels; null for equal colours (infinite).
    pub psnr_db: Option<f64>,
    /// Mean structural similarity of the luma, −1 to 1.
    pub ssim: Option<f64>,
    /// Error of the depth where both have one, metres.
    pub depth_error_median_m: Option<f64>,
    pub depth_error_p95_m: Option<f64>,
    /// Pixels where the truth's depth jumps ([`EDGE_STEP`]).
    pub edge_pixels: u64,
    /// Share of them that show nothing, or the other side.
    pub edge_error: Option<f64>,
}

impl Metrics {
    /// `frame` against `truth`; `metres` is the length of the file's unit.
    ///
    /// # Panics
    /// If the pictures differ in size.
    pub fn of(frame: &Picture, truth: &Picture, metres: f64) -> Metrics {
        let accuracy = Accuracy::of(&drawn(frame), &drawn(truth), false);
        let truth_pixels = accuracy.covered_pixels - accuracy.extra_pixels;
        let share = |count: u64| (truth_pixels > 0).then(|| significant(count as f64 / truth_pixels as f64));
        let depths = || frame.depth.iter().zip(&truth.depth);
        let front = depths().filter(|(d, t)| t.is_finite() && d.to_bits() == t.to_bits()).count();
        let edges = edges(truth);
        let wrong_side = |&&i: &&usize| {
            let (d, t) = (frame.depth[i], truth.depth[i]);
            !d.is_finite() || (d - t).abs() > EDGE_STEP * t
        };
        let wrong_edges = edges.iter().filter(wrong_side).count();
        Metrics {
            truth_pixels,
            covered_share: share(truth_pixels - accuracy.missing_pixels),
            extra_pixels: accuracy.extra_pixels,
            // Whatever only the frame covers is wrong too, but not a pixel of the truth.
            right_share: share(accuracy.covered_pixels - accuracy.wrong_pixels.unwrap_or(0)),
            front_share: share(front as u64),
            psnr_db: accuracy.psnr_db.filter(|_| accuracy.covered_pixels > 0).map(significant),
            ssim: accuracy.ssim.map(significant),
            depth_error_median_m: accuracy.depth_error_median.map(|error| significant(error * metres)),
            depth_error_p95_m: accuracy.depth_error_p95.map(|error| significant(error * metres)),
            edge_pixels: edges.len() as u64,
            edge_error: (!edges.is_empty()).then(|| significant(wrong_edges as f64 / edges.len() as f64)),
        }
    }
}

/// What changed from one frame to the next.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Change {
    /// Pixels whose colour changes ([`CHANGE_LEVELS`]) although the truth's does not.
    pub flicker_pixels: u64,
    /// Share of the pixels where the truth's colour does not change, of those that it covers in either frame.
    pub flicker_share: Option<f64>,
}

impl Change {
    /// From `before` to `now`, each a frame and its truth; all of one size.
    pub fn of(before: [&Picture; 2], now: [&Picture; 2]) -> Change {
        let covered = |i: usize| before[1].depth[i].is_finite() || now[1].depth[i].is_finite();
        let changes = |which: usize, i: usize| {
            let (a, b) = (before[which].rgba[i], now[which].rgba[i]);
            (0..3).any(|c| a[c].abs_diff(b[c]) > CHANGE_LEVELS)
        };
        let (mut quiet, mut flicker) = (0u64, 0u64);
        for i in (0..now[1].depth.len()).filter(|&i| covered(i) && !changes(1, i)) {
            quiet += 1;
            flicker += u64::from(changes(0, i));
        }
        let flicker_share = (quiet > 0).then(|| significant(flicker as f64 / quiet as f64));
        Change { flicker_pixels: flicker, flicker_share }
    }
}

/// To nine digits: what mathematical libraries of different systems agree on, so that the same run gives the same
/// report on all of them.
pub fn significant(value: f64) -> f64 {
    format!("{value:.8e}").parse().unwrap_or(value)
}

/// A frame as the measure of accuracy takes it.
fn drawn(picture: &Picture) -> Drawn {
    let point = |&record: &i64| u32::try_from(record).unwrap_or(NO_POINT);
    Drawn {
        size: [picture.width, picture.height],
        point: picture.records.iter().map(point).collect(),
        depth: picture.depth.clone(),
        rgba: picture.rgba.clone(),
        give_ups: 0,
    }
}

/// Covered pixels beside a jump of the depth, or beside background.
fn edges(truth: &Picture) -> Vec<usize> {
    let (width, height) = (truth.width as usize, truth.height as usize);
    let jumps = |i: usize, j: usize| {
        let (a, b) = (truth.depth[i], truth.depth[j]);
        // Infinite for background, so that it is one too.
        (a - b).abs() > EDGE_STEP * a.min(b)
    };
    let is_edge = |&i: &usize| {
        let (x, y) = (i % width, i / width);
        truth.depth[i].is_finite()
            && ((x > 0 && jumps(i, i - 1))
                || (x + 1 < width && jumps(i, i + 1))
                || (y > 0 && jumps(i, i - width))
                || (y + 1 < height && jumps(i, i + width)))
    };
    (0..width * height).filter(is_edge).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: f32 = f32::INFINITY;

    /// Records count the pixels from 100, colours are grey levels.
    fn picture(width: u32, depth: &[f32], grey: &[u8]) -> Picture {
        let record = |(i, depth): (usize, &f32)| if depth.is_finite() { 100 + i as i64 } else { -1 };
        Picture {
            width,
            height: depth.len() as u32 / width,
            rgba: grey.iter().map(|&g| [g, g, g, 255]).collect(),
            records: depth.iter().enumerate().map(record).collect(),
            depth: depth.to_vec(),
        }
    }

    /// Ten pixels in a row, eight of them covered; between the third and the fourth the depth jumps.
    fn truth() -> Picture {
        picture(10, &[10.0, 10.1, 10.2, 20.0, 20.0, 20.1, 20.2, 20.0, NONE, NONE], &[100; 10])
    }

    #[test]
    fn the_truth_is_right_and_its_edges_are_where_depth_jumps() {
        let m = Metrics::of(&truth(), &truth(), 1.0);
        assert_eq!(
            (m.truth_pixels, m.covered_share, m.right_share, m.front_share),
            (8, Some(1.0), Some(1.0), Some(1.0))
        );
        assert_eq!((m.psnr_db, m.extra_pixels), (None, 0));
        assert_eq!((m.depth_error_median_m, m.depth_error_p95_m), (Some(0.0), Some(0.0)));
        assert_eq!(edges(&truth()), [2, 3, 7], "both sides of the jump, and the pixel beside the background");
        assert_eq!(m.edge_error, Some(0.0));
        let above = picture(1, &[10.0, 11.0, 11.2, NONE], &[0; 4]);
        assert_eq!(edges(&above), [0, 1, 2], "rows too");
    }

    #[test]
    fn every_metric_by_hand() {
        let mut frame = truth();
        // A hole, a pixel with another record behind, one with another record just as near, and one too many.
        (frame.records[0], frame.depth[0], frame.rgba[0]) = (-1, NONE, [0, 0, 0, 255]);
        (frame.records[2], frame.depth[2]) = (7, 20.2);
        frame.records[4] = 8;
        (frame.records[9], frame.depth[9]) = (9, 5.0);
        let m = Metrics::of(&frame, &truth(), 0.5);
        assert_eq!((m.truth_pixels, m.extra_pixels), (8, 1));
        assert_eq!(m.covered_share, Some(7.0 / 8.0));
        assert_eq!(m.right_share, Some(5.0 / 8.0));
        assert_eq!(m.front_share, Some(6.0 / 8.0), "a tie is as near");
        // Of 9 pixels that either covers, one is off by 100 in all channels.
        assert!((m.psnr_db.unwrap() - 10.0 * (255.0_f64.powi(2) / (100.0_f64.powi(2) / 9.0)).log10()).abs() < 1e-6);
        // Seven depths to compare: six zeros, and ten units of half a metre.
        assert_eq!(m.depth_error_median_m, Some(0.0));
        assert!((m.depth_error_p95_m.unwrap() - 5.0).abs() < 1e-6);
        assert_eq!(m.edge_error, Some(significant(1.0 / 3.0)), "pixel 2 shows the far side");
        assert_eq!(m.ssim, None, "no window of seven rows");
        frame.depth[2] = NONE;
        frame.records[2] = -1;
        assert_eq!(Metrics::of(&frame, &truth(), 1.0).edge_error, Some(significant(1.0 / 3.0)), "a hole is wrong too");
    }

    #[test]
    fn nothing_to_see_is_no_number() {
        let nothing = picture(8, &[NONE; 64], &[0; 64]);
        let m = Metrics::of(&nothing, &nothing, 1.0);
        assert_eq!((m.truth_pixels, m.covered_share, m.psnr_db, m.ssim, m.edge_error), (0, None, None, None, None));
        let change = Change::of([&nothing, &nothing], [&nothing, &nothing]);
        assert_eq!(change, Change { flicker_pixels: 0, flicker_share: None });
    }

    #[test]
    fn flicker_is_change_that_the_truth_does_not_show() {
        let (before, mut now, mut truth_now) = (truth(), truth(), truth());
        now.rgba[0] = [100, 117, 100, 255]; // flickers
        now.rgba[1] = [116, 84, 100, 255]; // too little
        now.rgba[2] = [0, 0, 0, 255]; // as the truth does
        truth_now.rgba[2] = [0, 0, 0, 255];
        now.rgba[9] = [0, 0, 0, 255]; // nothing there in either
        let change = Change::of([&before, &truth()], [&now, &truth_now]);
        assert_eq!(change, Change { flicker_pixels: 1, flicker_share: Some(significant(1.0 / 7.0)) });
        assert_eq!(Change::of([&before, &before], [&before, &before]).flicker_pixels, 0);
    }

    #[test]
    fn nine_digits_are_kept() {
        assert_eq!([0.1 + 0.2, 1.0 / 3.0, 0.0, -2.5e-9].map(significant), [0.3, 0.333333333, 0.0, -2.5e-9]);
        assert!(significant(f64::NAN).is_nan());
    }
}
