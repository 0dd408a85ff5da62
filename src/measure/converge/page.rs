//! The report as one page and as Markdown: headlines, charts, checks.

use super::{
    charts::{self, Along, IN_MOTION, OF_FILE},
    checks::SIGMAS,
    headline::image_error,
    metrics::{CHANGE_LEVELS, EDGE_STEP},
    report::{ConvergeReport, Frame, Reached, Run, is_moving, is_rest},
    settings::{Clock, Variant},
};
use crate::{
    headless::grouped,
    measure::html::{self, Table},
};

/// The headlines as Markdown, with what they depend on.
pub fn markdown(report: &ConvergeReport) -> String {
    format!("{}\n\n{}", facts(report).join("\n"), headlines(report).markdown())
}

/// What the figures depend on, line by line.
fn facts(report: &ConvergeReport) -> Vec<String> {
    let [width, height] = report.size_px;
    let unit = match report.metres_per_unit {
        Some(metres) => format!("a unit of the file is {metres} m"),
        None => "the file does not say what its unit is: a unit counts as a metre".into(),
    };
    let mut lines = vec![
        format!("{}, {}", report.program, report.adapter),
        format!("{}: {} points, {width}x{height} pixels; {unit}", report.inputs.join(", "), grouped(report.points)),
    ];
    match (report.clock, report.load) {
        (Clock::Virtual, Some(load)) => {
            lines.push(format!("virtual clock: {} points arrive per frame; no times", grouped(load)));
        }
        _ => lines.push("real clock: frames at most sixty times a second, each timed to its end; then compared".into()),
    }
    if let Some(machine) = &report.machine {
        let load = (machine.load_before.zip(machine.load_after))
            .map_or(String::new(), |(before, after)| format!(", load {before:.2} before and {after:.2} after"));
        lines.push(format!("{}, {} cores{load}, {}", machine.processor, machine.cores, machine.system));
    }
    if !report.complete {
        lines.push("NOT COMPLETE: stopped before every setting was run".into());
    }
    for check in &report.checks {
        let verdict = match check.holds {
            Some(true) => "holds",
            Some(false) => "CHECK FAILED",
            None => "not checked",
        };
        lines.push(format!("{verdict}: {} ({})", check.what, check.found));
    }
    lines.extend(report.problems.iter().map(|problem| format!("PROBLEM: {problem}")));
    lines
}

/// A row per run.
fn headlines(report: &ConvergeReport) -> Table {
    let timed = report.machine.is_some();
    let unit = if timed { "s" } else { "frames" };
    let mut columns = vec!["run".to_owned()];
    for what in ["first picture", "50 % right", "90 %", "99 %", "100 %", "area under the error"] {
        columns.push(format!("{what}, {unit}"));
    }
    if timed {
        columns.extend(["frame p99, ms", "while loading p99, ms", "in motion, ms"].map(String::from));
    }
    columns.extend(["error in motion", "holes, %", "flicker, %"].map(String::from));
    columns.push(format!("back to converged, {unit}"));
    let title =
        "Pixels with the right point, of the picture of the whole file; in motion, of all points received".into();
    let mut table = Table { title, columns, rows: Vec::new() };
    let several = report.runs.iter().any(|run| run.round > 1);
    for run in &report.runs {
        let h = &run.headline;
        let reached = |reached: &Option<Reached>| match reached {
            None => "–".into(),
            Some(reached) => reached.secs.map_or(reached.frames.to_string(), |secs| number(Some(secs), 3)),
        };
        let mut row = vec![if several { format!("{} (round {})", run.label(), run.round) } else { run.label() }];
        row.extend([&h.first_picture, &h.right_50, &h.right_90, &h.right_99, &h.right_100].map(reached));
        row.push(if timed { number(h.error_secs, 3) } else { number(Some(h.error_frames), 2) });
        if timed {
            row.extend([h.frame_ms_p99, h.loading_frame_ms_p99, h.moving_frame_ms].map(|ms| number(ms, 1)));
        }
        row.push(number(h.moving_error, 4));
        row.extend([h.moving_holes, h.moving_flicker].map(|share| number(share.map(|s| 100.0 * s), 2)));
        row.push(if timed { number(h.rest_secs, 3) } else { number(h.rest_frames.map(f64::from), 0) });
        table.rows.push(row);
    }
    table
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("–".into(), |value| format!("{value:.digits$}"))
}

/// The page.
pub fn page(report: &ConvergeReport) -> String {
    let line = |line: &String| format!("<li>{}</li>", html::escape(line));
    let facts: String = facts(report).iter().map(line).collect();
    let command = report.command.as_ref().map_or(String::new(), |c| format!("<pre>{}</pre>\n", html::escape(c)));
    let mut body = format!("<ul>{facts}</ul>\n{command}{}", headlines(report).html());
    let mut section = |title: &str, about: &str, figures: Vec<String>| {
        if !figures.is_empty() {
            let (title, figures) = (html::escape(title), figures.concat());
            body.push_str(&format!("<h2>{title}</h2>\n<p>{about}</p>\n<div class=\"charts\">\n{figures}</div>\n"));
        }
    };
    section("Cost against error", SPEED_ABOUT, charts::speeds(report).iter().map(|plot| plot.figure()).collect());
    let (compared, settings) = (charts::compared(report), charts::settings(report));
    let variant = |run: &Run| run.variant.name().to_owned();
    if let Some(ours) = settings.first() {
        let mut figures = charts::theory(ours, "while loading", &|frame| frame.phase == "loading");
        for phase in report.phases.iter().filter(|phase| is_rest(phase)) {
            figures.extend(charts::theory(ours, phase, &|frame| frame.phase == *phase));
        }
        let with_points = figures.iter().filter(|chart| chart.series.iter().any(|series| series.points.len() > 1));
        section("Against theory", &theory_about(), with_points.map(|chart| chart.figure()).collect());
    }
    let before_motion = |frame: &Frame| matches!(frame.phase.as_str(), "loading" | "still");
    let mut figures = Vec::new();
    for value in OF_FILE {
        for along in Along::all(report) {
            figures.push(charts::curves(&compared, along, value, variant, &before_motion).figure());
        }
    }
    section("While loading and at rest, against the picture of the whole file", LOADING_ABOUT, figures);
    let mut figures = Vec::new();
    let of_phase = |phase: &String, value| {
        let mut both = charts::phase_chart(report, &compared, value, phase).figure();
        if settings.len() > 1 {
            both.push_str(&charts::phase_plot(report, &settings, value, phase).figure());
        }
        both
    };
    // A jump is a single frame.
    let has_curve = |phase: &&String| {
        let frames = |run: &&Run| run.frames.iter().filter(|frame| frame.phase == **phase).count() > 1;
        compared.iter().any(frames)
    };
    for phase in report.phases.iter().filter(|phase| is_moving(phase)).filter(has_curve) {
        figures.extend(IN_MOTION.map(|value| of_phase(phase, value)));
    }
    section("In motion, against all points received", &motion_about(), figures);
    let error = ("error: 1 − SSIM", image_error as fn(&Frame) -> Option<f64>);
    let rests = report.phases.iter().filter(|phase| is_rest(phase)).filter(has_curve);
    section("After each stop", REST_ABOUT, rests.map(|phase| of_phase(phase, error)).collect());
    body.push_str(&methods());
    html::page(TITLE, &body)
}

const TITLE: &str = "firstlight measure";

const SPEED_ABOUT: &str = "One dot per setting (fill budget, point size) and per baseline; left and down is better. Dashed: the \
settings that no other beats in both. Each is compared with the picture of all points at its own point size. ★: what \
the viewer takes by itself.";

const LOADING_ABOUT: &str = "The camera stands still. Against all points <i>received so far</i> this program's picture is right in \
every frame but for ties: points are drawn as they arrive.";

const REST_ABOUT: &str = "The camera stands still again, until the picture has converged.";

fn theory_about() -> String {
    format!(
        "Dashed: what a uniform random sample of as many of the file's points shows on this view, computed exactly from \
         the points of every pixel (hypergeometric). While loading, the curve shows how evenly the points are <i>read</i>; \
         after a motion, the points tried of the shuffled store, which must not lie below by more than {SIGMAS} standard \
         deviations; what was visible before comes on top."
    )
}

fn motion_about() -> String {
    format!(
        "Holes: pixels that all points cover and the frame does not. Flicker: pixels whose colour changes by more than \
         {CHANGE_LEVELS} levels from the frame before although that of all points does not. Depth jumps, for the edge \
         error above, are steps of {} % of the distance.",
        100.0 * EDGE_STEP
    )
}

fn methods() -> String {
    let mut table = Table::new("What is compared", &["run", "what it does"]);
    let about = [
        (Variant::Firstlight, "shuffled store, reprojection, points drawn as they arrive, random fill"),
        (Variant::BruteForce, "all points received so far, in every frame"),
        (Variant::Unshuffled, "points lie and are read in the order of the file; else as this program"),
        (Variant::BatchShuffled, "each insertion is shuffled and put behind the old points"),
        (Variant::NoReprojection, "every frame is a new random sample: a still picture never converges"),
        (Variant::NoMovedTo, "reprojection that does not follow points which insertions move"),
        (Variant::ClearOnMove, "the picture begins anew whenever the camera moves, as in common desktop viewers"),
    ];
    table.rows.extend(about.map(|(variant, what)| vec![variant.name().into(), what.into()]));
    table.html()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::converge::{Fill, Headline, headline::tests::frame};

    #[test]
    fn the_page_needs_nothing_else_and_no_name_breaks_it() {
        let frames = vec![
            frame(0, "loading", 0.5, false),
            frame(1, "still", 1.0, false),
            frame(2, "orbit", 0.7, false),
            frame(3, "after orbit", 1.0, false),
        ];
        let run = |variant, fill| Run {
            variant,
            fill: Fill::Points(fill),
            point_size_px: 2,
            method: None,
            encoding: None,
            fields: None,
            is_viewers_method: true,
            round: 1,
            headline: Headline::of(&frames),
            frames: frames.clone(),
        };
        let runs = vec![run(Variant::Firstlight, 1000), run(Variant::Firstlight, 5000), run(Variant::Unshuffled, 1000)];
        let report = ConvergeReport { runs, ..ConvergeReport::for_tests() };
        let page = page(&report);
        assert!(page.contains("a &lt;scan&gt;.laz") && page.contains("unshuffled"));
        assert_eq!(page.matches("http").count(), page.matches("xmlns=\"http").count(), "no address but SVG's name");
        assert!(page.contains("Cost against error") && page.contains("In motion"));
        let text = markdown(&report);
        assert!(text.contains("| 1k, 2 px | 1 | 1 | 2 | 2 | 2 |"), "{text}");
        let nothing = ConvergeReport::for_tests();
        assert!(super::page(&nothing).contains("What is compared"));
    }
}
