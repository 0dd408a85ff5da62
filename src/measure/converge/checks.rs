//! What must hold of a measurement, or its figures mean nothing.

use super::{
    report::{ConvergeReport, Frame, Run, is_moving},
    settings::{Clock, Fill, VIEWER_POINT_SIZE, Variant},
};
use crate::measure::{raster::Check, stats::quantile};

/// Standard deviations that a uniform sample may lie off, of some thousand that a measurement looks at: less than one
/// in a hundred million does.
pub const SIGMAS: f64 = 6.0;

/// Least deviation that counts, pixels: where nearly all pixels are expected, single ones decide, and those are
/// distributed otherwise than by a bell curve.
const LEAST_SIGMA_PIXELS: f64 = 2.0;

/// How much quicker and less wrong at once another setting may be before the viewer's choice is not next to the front:
/// frame times of one setting differ by as much from run to run on a busy machine.
const NEXT_TO: f64 = 0.8;

/// Rounds from which on settings are judged by their times: on two cores that do other work too, loading the same
/// file took 0.27 s in one run and 0.67 s in the next.
const LEAST_ROUNDS: usize = 3;

/// The checks of a report.
pub fn checks(report: &ConvergeReport) -> Vec<Check> {
    let mut checks = Vec::new();
    let of = |variant: Variant| report.runs.iter().filter(move |run| run.variant == variant);
    checks.push(told(
        "no picture of the shuffled store is worse than a uniform random sample of the points tried",
        worst(of(Variant::Firstlight)),
        |z| z >= -SIGMAS,
        |z| format!("at worst {z:.1} standard deviations above"),
    ));
    checks.push(told(
        "frames at rest end with the picture of all points, record for record",
        // A rest that is cut off, after 5,000 frames, has not tried all points, and tells nothing.
        of(Variant::Firstlight)
            .flat_map(last_of_rests)
            .filter(|frame| frame.points_tried == frame.points_stored)
            .filter_map(|frame| frame.received.right_share)
            .reduce(f64::min),
        |share| share == 1.0,
        |share| format!("{:.4} % of the pixels are right where it is worst", 100.0 * share),
    ));
    if of(Variant::NoReprojection).next().is_some() {
        // At rest, a later frame shows only the last of the samples tried.
        let is_first = |frame: &&Frame| is_moving(&frame.phase) && frame.points_tried == u64::from(frame.fill);
        let frames = of(Variant::NoReprojection).flat_map(|run| &run.frames).filter(is_first);
        let both = frames.flat_map(deviations);
        checks.push(told(
            "without reprojection, frames in motion are uniform random samples, no better and no worse",
            both.map(f64::abs).reduce(f64::max),
            |z| z <= SIGMAS,
            |z| format!("at most {z:.1} standard deviations off"),
        ));
    }
    if of(Variant::Unshuffled).next().is_some() {
        let found = worst(of(Variant::Unshuffled));
        let what = "the check of the shuffle fails for an unshuffled buffer";
        // A file whose points lie in random order has nothing to tell.
        let holds = found.filter(|z| *z < -SIGMAS).map(|_| true);
        let text = found.map_or("no frame tells".into(), |z| format!("at worst {z:.1} standard deviations above"));
        checks.push(Check { what: what.into(), holds, found: text });
    }
    if report.clock == Clock::Real {
        let frames = || report.runs.iter().flat_map(|run| &run.frames);
        let unlike = frames().filter(|frame| frame.differs_from_log).count();
        checks.push(Check {
            what: "the frames that were compared are those that were timed".into(),
            holds: frames().next().map(|_| unlike == 0),
            found: format!("{unlike} frames differ"),
        });
        checks.extend(viewers_choice(report));
    } else if report.runs.iter().any(|run| run.round > 1) {
        let differs = |run: &&Run| {
            let first = report.runs.iter().find(|first| same_setting(first, run));
            first.is_some_and(|first| first.frames != run.frames)
        };
        let unlike = report.runs.iter().filter(differs).count();
        checks.push(Check {
            what: "repeated runs give the same frames".into(),
            holds: Some(unlike == 0),
            found: format!("{unlike} runs differ from the first of their setting"),
        });
    }
    checks
}

/// Whether two runs differ at most by their round.
pub fn same_setting(a: &Run, b: &Run) -> bool {
    let setting = |run: &Run| (run.variant, run.fill, run.point_size_px, run.encoding, run.fields);
    setting(a) == setting(b) && a.method == b.method
}

fn told<T: Copy>(what: &str, found: Option<T>, holds: impl Fn(T) -> bool, tell: impl Fn(T) -> String) -> Check {
    Check { what: what.into(), holds: found.map(holds), found: found.map_or("no frame tells".into(), tell) }
}

/// How many standard deviations a frame shows more than a uniform sample of the points tried: pixels covered, and
/// pixels with the nearest depth. Only where the whole file is loaded, and not all of it tried.
pub fn deviations(frame: &Frame) -> Vec<f64> {
    let Some(expected) = frame.expected.filter(|e| e.sample < e.of && frame.points_stored == e.of) else {
        return Vec::new();
    };
    let least = LEAST_SIGMA_PIXELS / frame.received.truth_pixels.max(1) as f64;
    let z = |found: Option<f64>, share: f64, sigma: f64| Some((found? - share) / sigma.max(least));
    [
        z(frame.received.covered_share, expected.covered_share, expected.covered_sigma),
        z(frame.received.front_share, expected.front_share, expected.front_sigma),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn worst<'a>(runs: impl Iterator<Item = &'a Run>) -> Option<f64> {
    runs.flat_map(|run| run.frames.iter().flat_map(deviations)).reduce(f64::min)
}

/// The last frame of each phase in which the camera rests.
fn last_of_rests(run: &Run) -> impl Iterator<Item = &Frame> {
    let phases = run.frames.chunk_by(|a, b| a.phase == b.phase);
    phases.filter_map(|frames| frames.last()).filter(|frame| frame.phase != "loading" && !is_moving(&frame.phase))
}

/// A setting's cost and error: in motion, or at rest.
pub type Dot = (f64, f64);

/// Frame time (milliseconds; points per frame with the virtual clock) and 1 − SSIM, in motion.
pub fn moving_dot(run: &Run) -> Option<Dot> {
    let h = &run.headline;
    Some((h.moving_frame_ms.or(h.moving_fill)?, h.moving_error?))
}

/// The same at rest: the area under the curve of 1 − SSIM until the picture has converged. Where every motion's last
/// frame was right nothing is drawn at rest, and that frame's time stands; points never stand among milliseconds.
pub fn rest_dot(run: &Run) -> Option<Dot> {
    let h = &run.headline;
    Some((h.rest_frame_ms.or(h.moving_frame_ms).or(h.moving_fill)?, h.rest_error_secs.or(h.rest_error_frames)?))
}

/// Whether a run is of the settings that the viewer takes by itself.
pub fn is_viewers_choice(run: &Run) -> bool {
    run.variant == Variant::Firstlight
        && run.fill == Fill::Auto
        && run.point_size_px == VIEWER_POINT_SIZE
        && run.is_viewers_method
}

/// The medians of a setting's rounds.
pub fn median_dot(report: &ConvergeReport, run: &Run, dot: fn(&Run) -> Option<Dot>) -> Option<Dot> {
    let rounds: Vec<Dot> = report.runs.iter().filter(|other| same_setting(run, other)).filter_map(dot).collect();
    let middle = |value: fn(&Dot) -> f64| quantile(&rounds.iter().map(value).collect::<Vec<_>>(), 0.5);
    (!rounds.is_empty()).then(|| (middle(|dot| dot.0), middle(|dot| dot.1)))
}

fn viewers_choice(report: &ConvergeReport) -> Vec<Check> {
    let kinds = [("in motion", moving_dot as fn(&Run) -> Option<Dot>), ("at rest", rest_dot)];
    let firsts = || report.runs.iter().filter(|run| run.variant == Variant::Firstlight && run.round == 1);
    let rounds = report.runs.iter().filter(|run| is_viewers_choice(run)).count();
    let mut checks = Vec::new();
    for (when, dot) in kinds {
        let choice = firsts().find(|run| is_viewers_choice(run));
        let Some(chosen) = choice.and_then(|run| median_dot(report, run, dot)) else { continue };
        // Fields that are not decoded make another picture, with another error.
        let fields = choice.and_then(|run| run.fields);
        let others = || firsts().filter(|run| !is_viewers_choice(run) && run.fields == fields);
        let beaten = |run: &&Run| {
            median_dot(report, run, dot).is_some_and(|(x, y)| x < NEXT_TO * chosen.0 && y < NEXT_TO * chosen.1)
        };
        let better: Vec<String> = others().filter(beaten).map(Run::label).collect();
        let found = if better.is_empty() {
            format!("no setting has a fifth less of both than {:.3} ms and an error of {:.4}", chosen.0, chosen.1)
        } else {
            format!("a fifth less of both than {:.3} ms and {:.4}: {}", chosen.0, chosen.1, better.join("; "))
        };
        let too_few =
            if rounds < LEAST_ROUNDS { format!("; judged from --repeat {LEAST_ROUNDS} on") } else { String::new() };
        checks.push(Check {
            what: format!("the viewer's choice of fill and point size lies on the front or next to it, {when}"),
            holds: others().next().filter(|_| rounds >= LEAST_ROUNDS).map(|_| better.is_empty()),
            found: found + &too_few,
        });
    }
    checks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::converge::{headline::tests::frame, report::Headline, theory::Expected};

    fn run(variant: Variant, fill: Fill, point_size_px: u32, frames: Vec<Frame>) -> Run {
        let headline = Headline::of(&frames);
        Run {
            variant,
            fill,
            point_size_px,
            method: None,
            encoding: None,
            fields: None,
            is_viewers_method: true,
            round: 1,
            headline,
            frames,
        }
    }

    /// A frame of which a sample of 100 of 1000 points should cover 0.5 ± 0.01.
    fn sampled(n: u32, phase: &str, share: f64) -> Frame {
        let expected = Expected {
            sample: 100,
            of: 1000,
            covered_share: 0.5,
            covered_sigma: 0.01,
            front_share: 0.5,
            front_sigma: 0.01,
            right_share: 0.1,
        };
        Frame { expected: Some(expected), points_stored: 1000, fill: 100, ..frame(n, phase, share, true) }
    }

    fn verdicts(runs: Vec<Run>, clock: Clock) -> Vec<Option<bool>> {
        let report = ConvergeReport { runs, clock, ..ConvergeReport::for_tests() };
        checks(&report).into_iter().map(|check| check.holds).collect()
    }

    #[test]
    fn worse_than_a_sample_fails() {
        let of = |share| {
            verdicts(vec![run(Variant::Firstlight, Fill::Auto, 2, vec![sampled(0, "orbit", share)])], Clock::Virtual)
        };
        assert_eq!(of(0.45)[0], Some(true));
        assert_eq!(of(0.9)[0], Some(true), "what was visible before comes on top");
        assert_eq!(of(0.43)[0], Some(false));
        let loading = Frame { points_stored: 100, ..sampled(0, "loading", 0.1) };
        let runs = vec![run(Variant::Firstlight, Fill::Auto, 2, vec![loading])];
        assert_eq!(verdicts(runs, Clock::Virtual)[0], None, "the order of the file is no shuffle");
    }

    #[test]
    fn a_sample_may_not_be_better_either() {
        let of = |share| {
            let frames = vec![sampled(0, "orbit", share)];
            verdicts(vec![run(Variant::NoReprojection, Fill::Auto, 2, frames)], Clock::Virtual)[2]
        };
        assert_eq!([0.43, 0.46, 0.54, 0.57].map(of), [Some(false), Some(true), Some(true), Some(false)]);
        let unshuffled = |share| {
            let frames = vec![sampled(0, "orbit", share)];
            verdicts(vec![run(Variant::Unshuffled, Fill::Auto, 2, frames)], Clock::Virtual)[2]
        };
        assert_eq!([0.3, 0.5].map(unshuffled), [Some(true), None]);
    }

    #[test]
    fn a_rest_must_end_right() {
        let of = |last, stored| {
            let frames = vec![
                frame(0, "still", 1.0, false),
                frame(1, "orbit", 0.4, false),
                Frame { points_stored: stored, ..frame(2, "after orbit", last, false) },
            ];
            let frames = frames.into_iter().map(|frame| Frame { points_tried: 200, ..frame }).collect();
            verdicts(vec![run(Variant::Firstlight, Fill::Auto, 2, frames)], Clock::Virtual)[1]
        };
        assert_eq!([1.0, 0.9999].map(|last| of(last, 200)), [Some(true), Some(false)]);
        assert_eq!(of(0.4, 201), None, "cut off before all points were tried");
    }

    #[test]
    fn rounds_of_the_virtual_clock_must_agree() {
        let of = |share| {
            let a = run(Variant::Firstlight, Fill::Points(5), 1, vec![frame(0, "loading", 0.5, false)]);
            let b = run(Variant::Firstlight, Fill::Points(5), 1, vec![frame(0, "loading", share, false)]);
            verdicts(vec![a, Run { round: 2, ..b }], Clock::Virtual).last().copied().flatten()
        };
        assert_eq!([0.5, 0.6].map(of), [Some(true), Some(false)]);
    }

    #[test]
    fn a_choice_that_is_beaten_twice_fails() {
        let timed = |ms: f64, share: f64| {
            let mut frame = frame(0, "orbit", share, true);
            frame.times.as_mut().unwrap().frame_secs = ms * 1e-3;
            vec![frame]
        };
        let with_rounds = |rounds: u32, ms, share| {
            let round = |round| {
                let chosen = run(Variant::Firstlight, Fill::Auto, 2, timed(16.0, 0.5));
                // One round went astray.
                let ms = if round == 1 { 99.0 } else { ms };
                let other = run(Variant::Firstlight, Fill::Points(5), 2, timed(ms, share));
                [Run { round, ..chosen }, Run { round, ..other }]
            };
            let verdicts = verdicts((1..=rounds).flat_map(round).collect(), Clock::Real);
            assert_eq!(verdicts.len(), 5, "in motion and at rest");
            verdicts[3]
        };
        let of = |ms, share| with_rounds(3, ms, share);
        assert_eq!(with_rounds(2, 10.0, 0.7), None, "too few to tell");
        assert_eq!(of(10.0, 0.4), Some(true), "quicker, and worse");
        assert_eq!(of(15.0, 0.55), Some(true), "next to it");
        assert_eq!(of(10.0, 0.7), Some(false));
    }

    #[test]
    fn of_several_methods_only_the_viewers_own_is_its_choice() {
        let timed = |ms: f64, share: f64, is_viewers_method: bool| {
            let mut frame = frame(0, "orbit", share, true);
            frame.times.as_mut().unwrap().frame_secs = ms * 1e-3;
            let method = Some(if is_viewers_method { "reduce" } else { "early-z" }.to_owned());
            Run { method, is_viewers_method, ..run(Variant::Firstlight, Fill::Auto, 2, vec![frame]) }
        };
        let rounds = |viewers_ms: f64, rounds: u32| {
            let round = |round| [timed(10.0, 0.7, false), timed(viewers_ms, 0.5, true)].map(|run| Run { round, ..run });
            verdicts((1..=rounds).flat_map(round).collect(), Clock::Real)[3]
        };
        assert_eq!(rounds(20.0, 3), Some(false), "the other method has less of both");
        assert_eq!(rounds(9.0, 3), Some(true));
        assert_eq!(rounds(20.0, 2), None, "rounds of other methods are no rounds of the choice");
    }

    #[test]
    fn a_dot_at_rest_is_timed_though_nothing_is_drawn_there() {
        let dot = |timed| {
            let frames = vec![frame(0, "orbit", 0.5, timed), frame(1, "orbit", 1.0, timed)];
            rest_dot(&run(Variant::Firstlight, Fill::Auto, 2, frames))
        };
        assert_eq!(dot(true), Some((500.0, 0.0)), "milliseconds of the frames in motion, not their 50 points");
        assert_eq!(dot(false), Some((50.0, 0.0)), "without a clock, points");
    }

    #[test]
    fn a_frame_that_was_not_the_timed_one_is_told() {
        let other = Frame { differs_from_log: true, ..frame(0, "loading", 0.5, true) };
        let runs = vec![run(Variant::Firstlight, Fill::Points(5), 2, vec![other])];
        assert_eq!(verdicts(runs, Clock::Real)[2], Some(false));
    }
}
