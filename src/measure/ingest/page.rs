//! The report as one page: tables, charts, the machine and the command.

use super::{
    coverage::CoverageRuns,
    report::{IngestFile, IngestReport},
    screen::ScreenRuns,
    tables,
};
use crate::measure::{
    chart::{Chart, Draw, Series, thin},
    html,
};

/// Points per series: a pixel or two apart, and a page stays below a megabyte.
const SHOWN: usize = 600;

/// The page.
pub fn page(report: &IngestReport) -> String {
    let facts: Vec<String> =
        tables::facts(report).iter().map(|line| format!("<li>{}</li>", html::escape(line))).collect();
    let mut body = format!("<ul>{}</ul>\n<pre>{}</pre>\n", facts.concat(), html::escape(&report.command));
    for file in &report.files {
        let (name, about) = (html::escape(&file.path.display().to_string()), html::escape(&tables::describe(file)));
        body.push_str(&format!("<h2>{name}</h2>\n<p>{about}</p>\n<div class=\"charts\">\n"));
        charts(file).iter().for_each(|chart| body.push_str(&chart.figure()));
        body.push_str("</div>\n");
        tables::tables(file).iter().for_each(|table| body.push_str(&table.html()));
    }
    html::page("firstlight bench-ingest", &body)
}

fn charts(file: &IngestFile) -> Vec<Chart> {
    let mut charts = vec![rates(file)];
    charts.extend(speed_up(file));
    if file.coverage.iter().any(|runs| !runs.samples.is_empty()) {
        charts.extend(coverage(file));
    }
    charts.extend(file.screen.iter().filter_map(on_screen));
    charts.extend(file.screen.iter().filter_map(frame_times));
    charts
}

fn chart(title: &str, x: &str, y: &str) -> Chart {
    Chart {
        title: title.into(),
        x: x.into(),
        y: y.into(),
        x_at_least: 0.0,
        y_at_least: 0.0,
        x_is_whole: false,
        series: Vec::new(),
    }
}

/// The reader's runs by way, each a list of threads and a value.
fn by_threads(file: &IngestFile, value: impl Fn(&super::ReaderRuns) -> Option<f64>) -> Vec<Series> {
    let mut series: Vec<Series> = Vec::new();
    for runs in &file.reader {
        let (Some(threads), Some(value)) = (runs.way.threads, value(runs)) else { continue };
        let name = runs.way.name(file.compressed);
        let at = series.iter().position(|series| series.name == name).unwrap_or_else(|| {
            series.push(Series { name, points: Vec::new(), draw: Draw::LineAndDots });
            series.len() - 1
        });
        series[at].points.push((threads as f64, value));
    }
    series
}

fn most_threads(file: &IngestFile) -> f64 {
    file.read_alone.iter().map(|runs| runs.threads as f64).fold(1.0, f64::max)
}

fn rates(file: &IngestFile) -> Chart {
    let mut chart = chart("Reader: points per second", "decoder threads", "M points/s");
    chart.x_is_whole = true;
    chart.series = by_threads(file, |runs| Some(runs.points_per_sec?.median * 1e-6));
    for runs in &file.against {
        if let Some(rate) = runs.points_per_sec {
            let y = rate.median * 1e-6;
            let points = vec![(0.0, y), (most_threads(file), y)];
            chart.series.push(Series { name: format!("against: {}", runs.command), points, draw: Draw::Dashed });
        }
    }
    chart
}

/// None where only one number of threads was measured.
fn speed_up(file: &IngestFile) -> Option<Chart> {
    let mut chart = chart("Scaling", "threads", "times as fast as with one");
    chart.x_is_whole = true;
    chart.series = by_threads(file, |runs| Some(runs.points_per_sec?.median));
    let ceilings = [("read alone", &file.read_alone), ("memcpy", &file.memcpy)];
    chart.series.extend(ceilings.map(|(name, runs)| Series {
        name: name.into(),
        points: runs.iter().filter_map(|runs| Some((runs.threads as f64, runs.bytes_per_sec?.median))).collect(),
        draw: Draw::LineAndDots,
    }));
    for series in &mut chart.series {
        let one = series.points.iter().find(|point| point.0 == 1.0)?.1;
        series.points.iter_mut().for_each(|point| point.1 /= one);
    }
    let most = most_threads(file);
    chart.series.push(Series { name: "ideal".into(), points: vec![(1.0, 1.0), (most, most)], draw: Draw::Dashed });
    (most > 1.0).then_some(chart)
}

/// By time in seconds, by share of the time, by share of the points.
fn coverage(file: &IngestFile) -> [Chart; 3] {
    let title = "Coverage: cells of a 64×64 grid";
    let series = |curve: &dyn Fn(&super::Coverage) -> Vec<(f64, f64)>| -> Vec<Series> {
        let of = |runs: &CoverageRuns| {
            let points = thin(curve(runs.median()?), SHOWN);
            Some(Series { name: runs.way.name(file.compressed), points, draw: Draw::Line })
        };
        file.coverage.iter().filter_map(of).collect()
    };
    let y = "% of those finally occupied";
    let mut secs = chart(&format!("{title}, against time"), "seconds from opening", y);
    secs.series = series(&|run| run.stairs(|step| step.secs, run.total_secs));
    let mut time = chart(&format!("{title}, against the share of the time"), "% of the total time", y);
    time.series = series(&|run| run.stairs(|step| 100.0 * step.secs / run.total_secs, 100.0));
    // The goal that the order was chosen for.
    time.series.push(Series {
        name: "goal: 90 % after 7 % of the time".into(),
        points: vec![(7.0, 0.0), (7.0, 90.0), (0.0, 90.0)],
        draw: Draw::Dashed,
    });
    let mut points = chart(&format!("{title}, against points"), "% of the points", y);
    points.series = series(&|run| run.stairs(|step| 100.0 * step.points as f64 / run.total_points as f64, 100.0));
    [secs, time, points]
}

fn on_screen(runs: &ScreenRuns) -> Option<Chart> {
    let sample = runs.median()?;
    let mut chart = chart("Points in the picture, against time", "seconds from the start", "M points");
    let mut points: Vec<(f64, f64)> =
        sample.frames.iter().map(|frame| (frame.at_secs, frame.points_stored as f64 * 1e-6)).collect();
    // Until the first picture there is nothing.
    points.splice(0..0, [(0.0, 0.0), (points.first().map_or(0.0, |point| point.0), 0.0)]);
    chart.series.push(Series { name: "points stored and drawn".into(), points: thin(points, SHOWN), draw: Draw::Line });
    if let Some(converged) = sample.secs_to_converged {
        let stored = sample.points_stored as f64 * 1e-6;
        let name = "converged: every point tried in one view".into();
        chart.series.push(Series { name, points: vec![(converged, 0.0), (converged, stored)], draw: Draw::Dashed });
    }
    Some(chart)
}

fn frame_times(runs: &ScreenRuns) -> Option<Chart> {
    let mut chart = chart("Frames while loading, all runs", "seconds from the start", "frame time, ms");
    let frames = || runs.samples.iter().flat_map(|sample| &sample.frames);
    let points: Vec<(f64, f64)> = frames().map(|frame| (frame.at_secs, frame.wall_ms)).collect();
    let end = points.iter().map(|point| point.0).fold(0.0, f64::max);
    let level = |name: String, y: f64| Series { name, points: vec![(0.0, y), (end, y)], draw: Draw::Dashed };
    let p99 = runs.median()?.frame_ms_p99?;
    chart.series = vec![
        // Every frame: the slowest are the ones that count.
        Series { name: "a frame".into(), points, draw: Draw::Dots },
        level(format!("target, {} ms", runs.target_ms), runs.target_ms),
        level(format!("99th percentile, {p99:.1} ms"), p99),
    ];
    Some(chart)
}
