//! Curves of single runs, and settings as dots.

use super::{
    checks::{Dot, is_viewers_choice, median_dot, moving_dot, rest_dot},
    headline::image_error,
    report::{ConvergeReport, Frame, Run},
    settings::Variant,
};
use crate::measure::{
    chart::{Chart, Draw, Series, thin},
    raster::plot::{Axis, Curve, Plot, Scale, front},
};

/// Most points of a curve: more cannot be told apart, and make the page heavy.
const MOST_POINTS: usize = 400;

/// What runs along the lower axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Along {
    Milliseconds,
    Frames,
    /// Points drawn so far, but for reprojected ones.
    Points,
}

impl Along {
    /// Those that the report can tell.
    pub fn all(report: &ConvergeReport) -> Vec<Along> {
        let timed = report.runs.iter().flat_map(|run| &run.frames).any(|frame| frame.times.is_some());
        let ways = [Along::Milliseconds, Along::Frames, Along::Points];
        ways.into_iter().filter(|&along| timed || along != Along::Milliseconds).collect()
    }

    fn name(self) -> &'static str {
        match self {
            Along::Milliseconds => "milliseconds since the files were opened",
            Along::Frames => "frames",
            Along::Points => "million points drawn",
        }
    }

    fn of(self, frame: &Frame) -> f64 {
        match self {
            Along::Milliseconds => frame.times.map_or(f64::NAN, |times| times.end_secs() * 1e3),
            Along::Frames => f64::from(frame.frame) + 1.0,
            Along::Points => frame.points_drawn as f64 * 1e-6,
        }
    }
}

/// A number of a frame, with a name.
pub type Value = (&'static str, fn(&Frame) -> Option<f64>);

/// Against all points of the file.
pub const OF_FILE: [Value; 6] = [
    ("covered pixels, share of the truth's", |f| f.file.covered_share),
    ("right point, share of the truth's pixels", |f| f.file.right_share),
    ("colour: PSNR, dB", |f| f.file.psnr_db),
    ("colour: SSIM", |f| f.file.ssim),
    ("depth error, 95th percentile, m", |f| f.file.depth_error_p95_m),
    ("edge error, share of the truth's depth jumps", |f| f.file.edge_error),
];

/// In motion, against all points received.
pub const IN_MOTION: [Value; 3] = [
    ("error: 1 − SSIM", image_error),
    ("holes, share of the truth's pixels", |f| Some(1.0 - f.received.covered_share?)),
    ("flicker, share of the pixels where the truth is quiet", |f| f.change?.flicker_share),
];

/// The first run of each method, this program's last: it is drawn over the others.
pub fn compared(report: &ConvergeReport) -> Vec<&Run> {
    let mut runs: Vec<&Run> = report.runs.iter().filter(|run| run.round == 1).collect();
    runs.sort_by_key(|run| run.variant);
    runs.dedup_by_key(|run| run.variant);
    if runs.first().is_some_and(|run| run.variant == Variant::Firstlight) {
        runs.rotate_left(1);
    }
    runs
}

/// This program's settings, the first run of each.
pub fn settings(report: &ConvergeReport) -> Vec<&Run> {
    report.runs.iter().filter(|run| run.round == 1 && run.variant == Variant::Firstlight).collect()
}

/// One chart: a series per run, of the frames that `is` picks.
pub fn curves(
    runs: &[&Run],
    along: Along,
    value: Value,
    name: impl Fn(&Run) -> String,
    is: &dyn Fn(&Frame) -> bool,
) -> Chart {
    let of = |run: &&Run| {
        let frames = run.frames.iter().filter(|frame| is(frame));
        let points = frames.filter_map(|frame| Some((along.of(frame), value.1(frame)?))).collect();
        Series { name: name(run), points: thin(points, MOST_POINTS), draw: Draw::Line }
    };
    chart(value.0.into(), along, runs.iter().map(of).collect())
}

fn chart(title: String, along: Along, series: Vec<Series>) -> Chart {
    let y = title.clone();
    Chart { title, x: along.name().into(), y, x_at_least: 0.0, y_at_least: 0.0, x_is_whole: false, series }
}

/// What a run shows of some frames, and what a uniform sample would: covered pixels, and pixels with the nearest depth.
/// Both against the file's points.
pub fn theory(run: &Run, title: &str, is: &dyn Fn(&Frame) -> bool) -> Vec<Chart> {
    let series = |name: &str, value: &dyn Fn(&Frame) -> Option<f64>, draw: Draw| {
        let frames = run.frames.iter().filter(|frame| is(frame));
        // Of the file's points: what is stored while they arrive, what was tried after.
        let place = |frame: &Frame| Some((frame.expected?.sample as f64 * 1e-6, value(frame)?));
        Series { name: name.into(), points: thin(frames.filter_map(place).collect(), MOST_POINTS), draw }
    };
    let pair = |what: &str, found: fn(&Frame) -> Option<f64>, expected: fn(&Frame) -> Option<f64>| {
        let both = vec![
            series("this run", &found, Draw::LineAndDots),
            series("a uniform random sample", &expected, Draw::Dashed),
        ];
        let x = "million points of the file, as many as in the sample".into();
        Chart { x, y: what.into(), ..chart(format!("{title}: {what}"), Along::Points, both) }
    };
    vec![
        pair("covered pixels, share", |f| f.file.covered_share, |f| Some(f.expected?.covered_share)),
        pair("nearest depth, share of pixels", |f| f.file.front_share, |f| Some(f.expected?.front_share)),
    ]
}

/// Where a run is in a phase: milliseconds, or frames if there are no times, since the phase began.
fn in_phase(report: &ConvergeReport, run: &Run, phase: &str, value: Value) -> Vec<(f64, f64)> {
    let along = Along::all(report)[0];
    let first = run.frames.iter().find(|frame| frame.phase == phase);
    let begun = first.map_or(0.0, |frame| match along {
        Along::Milliseconds => frame.times.map_or(0.0, |times| times.start_secs * 1e3),
        _ => f64::from(frame.frame),
    });
    let frames = run.frames.iter().filter(|frame| frame.phase == phase);
    frames.filter_map(|frame| Some((along.of(frame) - begun, value.1(frame)?))).collect()
}

/// The name of [`in_phase`]'s axis.
fn since(report: &ConvergeReport, phase: &str) -> String {
    let unit = if Along::all(report)[0] == Along::Frames { "frames" } else { "milliseconds" };
    format!("{unit} since the phase `{phase}` began")
}

/// Methods in one phase.
pub fn phase_chart(report: &ConvergeReport, runs: &[&Run], value: Value, phase: &str) -> Chart {
    let of = |run: &&Run| {
        let points = thin(in_phase(report, run, phase, value), MOST_POINTS);
        Series { name: run.variant.name().into(), points, draw: Draw::Line }
    };
    let series = runs.iter().map(of).collect();
    let title = format!("{phase}: {}", value.0);
    Chart { x: since(report, phase), y: value.0.into(), ..chart(title, Along::Frames, series) }
}

/// Settings in one phase; there may be more of them than colours that can be told apart, so each has its name.
pub fn phase_plot(report: &ConvergeReport, runs: &[&Run], value: Value, phase: &str) -> Plot {
    let of = |run: &&Run| Curve { name: run.label(), points: thin(in_phase(report, run, phase, value), 50) };
    Plot {
        title: format!("{phase}: {}", value.0),
        x: Axis { name: since(report, phase), scale: Scale::Linear },
        y: Axis { name: value.0.into(), scale: Scale::Linear },
        curves: runs.iter().map(of).collect(),
        behind: Vec::new(),
    }
}

/// One dot per setting and baseline: cost against error, with the front of this program's settings.
pub fn speed(report: &ConvergeReport, title: &str, error: &str, dot: fn(&Run) -> Option<Dot>) -> Option<Plot> {
    let timed = report.machine.is_some();
    let firsts: Vec<&Run> = report.runs.iter().filter(|run| run.round == 1).collect();
    // Rounds of a setting are one dot.
    let dots: Vec<(&Run, Dot)> = firsts.iter().filter_map(|run| Some((*run, median_dot(report, run, dot)?))).collect();
    if dots.len() < 2 {
        return None;
    }
    let ours = dots.iter().filter(|(run, _)| run.variant == Variant::Firstlight);
    // Less is better in both.
    let best = front(&ours.map(|(_, (x, y))| (-x, -y)).collect::<Vec<_>>());
    let name = |run: &Run| match is_viewers_choice(run) {
        true => format!("★ {}", run.label()),
        false => run.label(),
    };
    let cost = if timed { "frame time, ms (median)" } else { "points tried per frame" };
    Some(Plot {
        title: title.into(),
        x: Axis { name: cost.into(), scale: Scale::Log },
        y: Axis { name: error.into(), scale: Scale::Linear },
        curves: dots.iter().map(|(run, dot)| Curve { name: name(run), points: vec![*dot] }).collect(),
        behind: best.into_iter().map(|(x, y)| (-x, -y)).rev().collect(),
    })
}

/// [`speed`] in motion and at rest.
pub fn speeds(report: &ConvergeReport) -> Vec<Plot> {
    let unit = if report.machine.is_some() { "s" } else { "frames" };
    let rest = format!("area under 1 − SSIM after the stop, {unit}");
    let both = [
        speed(report, "In motion", "error: 1 − SSIM, mean", moving_dot),
        speed(report, "At rest, after each motion", &rest, rest_dot),
    ];
    both.into_iter().flatten().collect()
}
