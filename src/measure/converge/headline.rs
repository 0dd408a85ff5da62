//! A few figures that stand for all frames of a run.

use super::{
    metrics::significant,
    report::{Frame, Headline, Reached, Times, is_moving, is_rest},
};
use crate::measure::stats::quantile;

impl Headline {
    /// Of a run's frames, in order.
    pub fn of(frames: &[Frame]) -> Headline {
        let before_motion = frames.iter().take_while(|f| matches!(f.phase.as_str(), "loading" | "still"));
        let before_motion: Vec<&Frame> = before_motion.collect();
        let reached = |is: &dyn Fn(&Frame) -> bool| {
            let frame = before_motion.iter().find(|frame| is(frame))?;
            let secs = frame.times.map(|times| times.end_secs());
            Some(Reached { frames: frame.frame + 1, points_stored: frame.points_stored, secs })
        };
        let right = |share: f64| reached(&|frame| frame.file.right_share.is_some_and(|right| right >= share));
        let errors: Vec<(f64, Option<Times>)> =
            before_motion.iter().map(|f| (1.0 - f.file.right_share.unwrap_or(0.0), f.times)).collect();
        // Before the first frame nothing is right.
        let first_secs = errors.first().and_then(|(_, times)| Some(times.as_ref()?.end_secs()));
        let (error_frames, error_secs) = area(&errors);

        let moving: Vec<&Frame> = frames.iter().filter(|f| is_moving(&f.phase)).collect();
        let mean = |value: &dyn Fn(&Frame) -> Option<f64>| {
            let values: Vec<f64> = moving.iter().filter_map(|frame| value(frame)).collect();
            (!values.is_empty()).then(|| significant(values.iter().sum::<f64>() / values.len() as f64))
        };
        let stops: Vec<&[Frame]> = stops(frames);
        let areas: Vec<(f64, Option<f64>)> = (stops.iter())
            .map(|stop| area(&stop.iter().map(|f| (image_error(f).unwrap_or(0.0), f.times)).collect::<Vec<_>>()))
            .collect();
        // Without reprojection all points are tried and the picture is still that of the last few.
        let is_back = |frame: &Frame| frame.converged && frame.received.right_share.is_none_or(|share| share == 1.0);
        let back = |stop: &&[Frame]| stop.iter().position(is_back).map(|at| at as u32);
        let back_secs = |stop: &&[Frame]| {
            let end = |frame: &Frame| Some(frame.times?.end_secs());
            Some(end(stop.iter().find(|frame| is_back(frame))?)? - end(stop.first()?)?)
        };
        let times = |is: &dyn Fn(&str) -> bool, share: f64| {
            let ms: Vec<f64> =
                (frames.iter().filter(|f| is(&f.phase))).filter_map(|f| Some(f.times?.frame_secs * 1e3)).collect();
            (!ms.is_empty()).then(|| quantile(&ms, share))
        };
        Headline {
            first_picture: reached(&|frame| frame.file.covered_share.is_some_and(|share| share > 0.0)),
            right_50: right(0.5),
            right_90: right(0.9),
            right_99: right(0.99),
            right_100: right(1.0),
            error_frames: significant(1.0 + error_frames),
            error_secs: first_secs.zip(error_secs).map(|(first, rest)| significant(first + rest)),
            moving_error: mean(&image_error),
            moving_holes: mean(&|frame| Some(1.0 - frame.received.covered_share?)),
            moving_flicker: mean(&|frame| frame.change?.flicker_share),
            moving_fill: mean(&|frame| Some(f64::from(frame.fill))),
            rest_error_frames: (!areas.is_empty()).then(|| significant(areas.iter().map(|area| area.0).sum())),
            rest_error_secs: areas.iter().map(|area| area.1).sum::<Option<f64>>().filter(|_| !areas.is_empty()),
            rest_frames: stops.iter().map(back).collect::<Option<Vec<u32>>>().and_then(|all| all.into_iter().max()),
            rest_secs: (stops.iter().map(back_secs).collect::<Option<Vec<f64>>>())
                .and_then(|all| all.into_iter().reduce(f64::max)),
            frame_ms_p99: times(&|_| true, 0.99),
            loading_frame_ms_p99: times(&|phase| phase == "loading", 0.99),
            moving_frame_ms: times(&is_moving, 0.5),
            rest_frame_ms: times(&is_rest, 0.5),
        }
    }
}

/// How unlike the truth's the colours are: 1 − SSIM. `None` where nothing is to be seen.
pub fn image_error(frame: &Frame) -> Option<f64> {
    Some(significant(1.0 - frame.received.ssim?))
}

/// The last frame of each motion, and what is drawn of the rest after it: nothing if that frame was right already.
fn stops(frames: &[Frame]) -> Vec<&[Frame]> {
    let is_last = |&i: &usize| {
        let next = frames.get(i + 1);
        is_moving(&frames[i].phase) && next.is_none_or(|next| next.phase != frames[i].phase)
    };
    let resting = |i: usize| frames[i + 1..].iter().take_while(|frame| is_rest(&frame.phase)).count();
    (0..frames.len()).filter(is_last).map(|i| &frames[i..=i + resting(i)]).collect()
}

/// Area under a curve of steps: each frame's error holds until the next frame. In frames, and in seconds from the end
/// of the first; the last error has no end, and counts for nothing.
fn area(errors: &[(f64, Option<Times>)]) -> (f64, Option<f64>) {
    let (mut frames, mut secs) = (0.0, Some(0.0));
    for pair in errors.windows(2) {
        let [(error, from), (_, to)] = pair else { continue };
        frames += error;
        let held = from.zip(*to).map(|(from, to)| error * (to.end_secs() - from.end_secs()));
        secs = secs.zip(held).map(|(sum, held)| sum + held);
    }
    let timed = errors.first().is_some_and(|(_, times)| times.is_some());
    (frames, secs.filter(|_| timed))
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::measure::converge::metrics::{Change, Metrics};

    /// A frame of a second's half, with this share of right and covered pixels, and as SSIM.
    pub fn frame(n: u32, phase: &str, right: f64, timed: bool) -> Frame {
        let metrics = Metrics {
            truth_pixels: 1000,
            covered_share: Some(right),
            extra_pixels: 0,
            right_share: Some(right),
            front_share: Some(right),
            psnr_db: None,
            ssim: Some(right),
            depth_error_median_m: None,
            depth_error_p95_m: None,
            edge_pixels: 0,
            edge_error: None,
        };
        Frame {
            frame: n,
            phase: phase.into(),
            points_stored: u64::from(n) * 100,
            points_tried: 100,
            fill: 50,
            points_drawn: u64::from(n) * 150,
            converged: right == 1.0,
            expected: None,
            received: metrics.clone(),
            file: metrics,
            change: Some(Change { flicker_pixels: 1, flicker_share: Some(0.25) }),
            times: timed.then(|| Times { start_secs: f64::from(n), frame_secs: 0.5 }),
            differs_from_log: false,
        }
    }

    #[test]
    fn figures_by_hand() {
        let phases = [
            ("loading", 0.0),
            ("loading", 0.5),
            ("loading", 0.95),
            ("still", 1.0),
            ("orbit", 0.5),
            ("orbit", 0.7),
            ("after orbit", 0.8),
            ("after orbit", 0.9),
            ("after orbit", 1.0),
        ];
        let run = |timed| -> Vec<Frame> {
            (0..).zip(phases).map(|(n, (phase, right))| frame(n, phase, right, timed)).collect()
        };
        let h = Headline::of(&run(true));
        assert_eq!(h.first_picture, Some(Reached { frames: 2, points_stored: 100, secs: Some(1.5) }));
        assert_eq!(h.right_50, h.first_picture);
        assert_eq!((h.right_90.unwrap().frames, h.right_99.unwrap().frames), (3, 4));
        assert_eq!(h.right_100.unwrap().secs, Some(3.5));
        assert_eq!(h.error_frames, 1.0 + 1.0 + 0.5 + 0.05);
        assert_eq!(
            h.error_secs,
            Some(0.5 + 1.0 + 0.5 + 0.05),
            "frames end a second apart, the first after half of one"
        );
        assert_eq!((h.moving_error, h.moving_holes, h.moving_flicker), (Some(0.4), Some(0.4), Some(0.25)));
        assert_eq!((h.rest_error_frames, h.rest_frames), (Some(0.6), Some(3)));
        assert!((h.rest_error_secs.unwrap() - 0.6).abs() < 1e-9);
        assert_eq!(h.rest_secs, Some(3.0));
        assert_eq!((h.frame_ms_p99, h.loading_frame_ms_p99), (Some(500.0), Some(500.0)));
        let untimed = Headline::of(&run(false));
        assert_eq!((untimed.error_secs, untimed.rest_secs, untimed.frame_ms_p99), (None, None, None));
        assert_eq!(untimed.error_frames, h.error_frames);
    }

    #[test]
    fn what_was_not_reached_is_no_figure() {
        let at_once = [frame(0, "orbit", 1.0, true), frame(1, "walk", 0.5, true), frame(2, "after walk", 1.0, true)];
        let h = Headline::of(&at_once);
        assert_eq!(
            (h.rest_frames, h.rest_secs, h.rest_error_frames),
            (Some(1), Some(1.0), Some(0.5)),
            "0 and 1 frames"
        );
        let never = [frame(0, "loading", 0.3, true), frame(1, "orbit", 0.4, true), frame(2, "after orbit", 0.4, true)];
        let h = Headline::of(&never);
        assert_eq!((h.right_50, h.rest_frames, h.moving_error), (None, None, Some(0.6)));
        let wrong = [frame(0, "orbit", 0.4, true), Frame { converged: true, ..frame(1, "after orbit", 0.4, true) }];
        let h = Headline::of(&wrong);
        assert_eq!((h.rest_frames, h.rest_secs), (None, None), "all points were tried, and the picture is not theirs");
        let nothing = Headline::of(&[]);
        assert_eq!((nothing.first_picture, nothing.error_secs, nothing.rest_error_frames), (None, None, None));
    }
}
