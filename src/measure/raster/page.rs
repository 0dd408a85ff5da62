//! The report as one page: tables, plots, the machine and the command.

use super::{
    plot::{Axis, Curve, Plot, Scale, front},
    reference::CITATION,
    report::{Block, CurveKind, RasterReport, Row},
    tables,
};
use crate::measure::html;

/// The page.
pub fn page(report: &RasterReport) -> String {
    let line = |line: &String| format!("<li>{}</li>", html::escape(line));
    let facts: String = tables::facts(report).iter().map(line).collect();
    let mut body = format!("<ul>{facts}</ul>\n<pre>{}</pre>\n", html::escape(&report.command));
    let mut plots = |title: &str, about: &str, plots: Vec<Plot>| {
        if !plots.is_empty() {
            let figures: String = plots.iter().map(Plot::figure).collect();
            body.push_str(&format!("<h2>{title}</h2>\n<p>{about}</p>\n<div class=\"charts\">\n{figures}</div>\n"));
        }
    };
    plots("Speed against accuracy", SPEED_ABOUT, report.blocks.iter().filter_map(|b| speed_plot(report, b)).collect());
    let kinds = [CurveKind::Points, CurveKind::Planes, CurveKind::Base];
    plots("Cost against points", COST_ABOUT, kinds.into_iter().filter_map(|kind| curve(report, kind)).collect());
    if !report.blocks.is_empty() {
        body.push_str("<h2>Method × order × viewpoint</h2>\n");
    }
    tables::tables(report).iter().for_each(|table| body.push_str(&table.html()));
    body.push_str(&methods(report));
    let citation = html::escape(CITATION);
    body.push_str(&format!(
        "<h2>What others measured</h2>\n<p>Other devices, scenes and programs, for orientation: {citation}.</p>\n"
    ));
    tables::published().iter().for_each(|table| body.push_str(&table.html()));
    html::page("firstlight bench", &body)
}

const SPEED_ABOUT: &str = "One dot per method. Accuracy is the structural similarity (SSIM) of the colours with the \
picture of <i>atomic-min</i>, over the pixels that either covers; methods that average points (<i>hqs</i> …) differ \
from it as they should. Dashed: the methods that no other beats in both. <i>just-set</i> and <i>racy</i> are wrong on \
purpose.";
const COST_ABOUT: &str = "The scan thinned evenly, in its own order, seen in the overview. Then points in random order on \
planes stacked before the camera (after Günther et al. 2013, Figure 3): first ever more planes, each with a point for \
every pixel; then as many points as the picture has pixels, their base shrunk until all of them lie in one pixel.";

fn axis(name: &str, scale: Scale) -> Axis {
    Axis { name: name.into(), scale }
}

/// A name that is short enough to stand beside a plot.
fn mark(report: &RasterReport, name: &str) -> String {
    tables::label(report, name).replace(" on purpose", "")
}

/// `None` where nothing is covered: there is nothing to be accurate about.
fn speed_plot(report: &RasterReport, block: &Block) -> Option<Plot> {
    let (scale, unit) = tables::unit(report);
    let dot = |row: &Row| Some((row.accuracy.as_ref()?.ssim?, row.points_per_sec?.median * scale));
    let dots: Vec<(&Row, (f64, f64))> = block.rows.iter().filter_map(|row| Some((row, dot(row)?))).collect();
    if dots.is_empty() {
        return None;
    }
    let curve = |(row, dot): &(&Row, (f64, f64))| Curve { name: mark(report, row.method), points: vec![*dot] };
    Some(Plot {
        title: format!("{} order, {}, {}", block.order.name(), block.encoding.name(), block.view),
        x: axis("accuracy: SSIM of colour", Scale::Linear),
        y: axis(unit, Scale::Log),
        behind: front(&dots.iter().map(|dot| dot.1).collect::<Vec<_>>()),
        curves: dots.iter().map(curve).collect(),
    })
}

fn curve(report: &RasterReport, kind: CurveKind) -> Option<Plot> {
    let runs = || report.curves.iter().filter(|runs| runs.curve == kind);
    runs().next()?;
    let line = |name: &'static str| {
        let of_method = runs().filter(|runs| runs.method == name);
        let place = |runs: &super::CurveRuns| {
            let x = if kind == CurveKind::Points { runs.points as f64 } else { runs.fragments_per_pixel };
            Some((x, runs.frame_secs?.median * 1e3))
        };
        Curve { name: mark(report, name), points: of_method.filter_map(place).collect() }
    };
    let (title, x) = match kind {
        CurveKind::Points => ("Frame time against points", "points"),
        CurveKind::Planes => ("More planes: more points, more of them per pixel", "points per pixel"),
        CurveKind::Base => ("A smaller base: as many points, more of them per pixel", "points per pixel"),
    };
    Some(Plot {
        title: title.into(),
        x: axis(x, Scale::Log),
        y: axis("frame, ms", Scale::Log),
        curves: report.methods.iter().map(|method| line(method.name)).collect(),
        behind: Vec::new(),
    })
}

/// What each method is, where it is from, and what it needs.
fn methods(report: &RasterReport) -> String {
    let mut table = html::Table::new("Methods", &["method", "what it does", "source", "needs"]);
    for method in &report.methods {
        let what = method.wrong_on_purpose.map_or(method.what.into(), |why| format!("{}; {why}", method.what));
        table.rows.push(vec![method.name.into(), what, method.source.into(), method.needs.clone()]);
    }
    format!("<h2>Methods</h2>\n{}", table.html())
}
