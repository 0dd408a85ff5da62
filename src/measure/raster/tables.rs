//! The figures of a report as tables. Medians, with quartiles in brackets where they tell something.

use super::{
    orders::Order,
    reference::{METHODS, PUBLISHED, Published},
    report::{Block, RasterReport, Row},
};
use crate::{
    measure::{html::Table, stats::Summary},
    methods::Encoding,
};

/// The whole report as Markdown.
pub fn markdown(report: &RasterReport) -> String {
    let mut out = format!("{}\n\n", facts(report).join("\n"));
    for table in tables(report) {
        out.push_str(&table.markdown());
        out.push('\n');
    }
    out
}

/// What the figures depend on, line by line.
pub fn facts(report: &RasterReport) -> Vec<String> {
    let (machine, device) = (&report.machine, &report.device);
    let load = (machine.load_before.zip(machine.load_after))
        .map_or(String::new(), |(before, after)| format!(", load {before:.2} before and {after:.2} after"));
    let [width, height] = report.size_px;
    let encodings: Vec<String> =
        report.encodings.iter().map(|e| format!("{} ({} bytes a point)", e.name(), e.bytes())).collect();
    let software = if device.is_software { "; a processor that stands in for a GPU" } else { "" };
    let mut lines = vec![
        format!(
            "{}, {} rounds of up to {} frames, slow methods fewer; medians, quartiles in brackets",
            report.program, report.repeat, report.frames
        ),
        format!("{} ({}, {}){software}", device.adapter, device.api, device.driver),
        format!("{}, {} cores{load}, {}", machine.processor, machine.cores, machine.system),
        format!(
            "{}: {} points, {} encoding, {width}x{height} pixels, points of one pixel",
            report.input,
            report.points,
            encodings.join(" and ")
        ),
        if report.wall_clock {
            "timed by the wall clock around submitted frames: the device has no timestamps that tell enough".into()
        } else {
            "timed by the device's timestamps around each pass".into()
        },
    ];
    let ceilings = &report.ceilings;
    let reads = ceilings.read.iter().map(|read| {
        format!("positions only read {} ({}); ", spread(read.bytes_per_sec, 1e-9, 1), read.encoding.name())
    });
    lines.push(format!(
        "ceilings, GB/s: {}copied by a kernel {}, buffer to buffer {} (bytes read plus bytes written)",
        reads.collect::<String>(),
        spread(ceilings.copy_kernel_bytes_per_sec, 1e-9, 1),
        spread(ceilings.copy_bytes_per_sec, 1e-9, 1)
    ));
    if !report.complete {
        lines.push("NOT COMPLETE: stopped before everything was measured".into());
    }
    for method in &report.methods {
        lines.extend(method.missing.as_ref().map(|missing| format!("not measured: {missing}")));
    }
    for check in &report.checks {
        let verdict = match check.holds {
            Some(true) => continue,
            Some(false) => "CHECK FAILED",
            None => "not checked",
        };
        lines.push(format!("{verdict}: {}: {}", check.what, check.found));
    }
    lines.extend(report.problems.iter().map(|problem| format!("PROBLEM: {problem}")));
    lines
}

/// All tables: per viewpoint the speeds, then everything of every block.
pub fn tables(report: &RasterReport) -> Vec<Table> {
    let mut tables: Vec<Table> = views(report).iter().map(|view| speeds(report, view)).collect();
    tables.extend(report.blocks.iter().map(|block| block_table(report, block)));
    tables
}

/// Names of the viewpoints, in the order measured.
pub fn views(report: &RasterReport) -> Vec<&str> {
    let mut views: Vec<&str> = Vec::new();
    for block in &report.blocks {
        if !views.contains(&block.view.as_str()) {
            views.push(&block.view);
        }
    }
    views
}

/// The paper's table: a row per method, a column per order.
fn speeds(report: &RasterReport, view: &str) -> Table {
    let blocks: Vec<&Block> = report.blocks.iter().filter(|block| block.view == view).collect();
    let (scale, unit) = unit(report);
    let mut columns = vec!["method".to_owned()];
    for block in &blocks {
        columns.push(title(report, block));
        columns.extend(wide_of(&blocks, block).map(|_| "÷ wide".to_owned()));
    }
    let mut table = Table { title: format!("{view}: {unit}"), columns, rows: Vec::new() };
    for method in report.methods.iter().filter(|method| method.missing.is_none()) {
        let row_of = |block: &Block| block.rows.iter().find(|row| row.method == method.name).cloned();
        let median = |block: &Block| row_of(block)?.points_per_sec.map(|rate| rate.median);
        let mut row = vec![label(report, method.name)];
        for block in &blocks {
            row.push(row_of(block).map_or("–".into(), |row| speed(&row, scale)));
            if let Some(wide) = wide_of(&blocks, block) {
                row.push(median(block).zip(median(wide)).map_or("–".into(), |(rate, wide)| number(rate / wide, 2)));
            }
        }
        table.rows.push(row);
    }
    table
}

/// The order, and the encoding if there are two.
fn title(report: &RasterReport, block: &Block) -> String {
    match report.encodings.len() {
        0 | 1 => block.order.name().into(),
        _ => format!("{}, {}", block.order.name(), block.encoding.name()),
    }
}

/// The wide block beside a packed one.
fn wide_of<'b>(blocks: &[&'b Block], packed: &Block) -> Option<&'b Block> {
    let is_pair = |block: &&Block| block.order == packed.order && block.encoding == Encoding::Wide;
    blocks.iter().copied().find(is_pair).filter(|_| packed.encoding == Encoding::Packed)
}

/// Points per second, and what is odd about the figure.
fn speed(row: &Row, scale: f64) -> String {
    let rate = spread(row.points_per_sec, scale, 1);
    match row.abandoned {
        Some(_) => "abandoned".into(),
        None if row.is_single => format!("{rate} (one frame)"),
        None => rate,
    }
}

/// Methods that are wrong on purpose are marked wherever their speed is shown.
pub fn label(report: &RasterReport, name: &str) -> String {
    let is_wrong = report.methods.iter().any(|method| method.name == name && method.wrong_on_purpose.is_some());
    if is_wrong { format!("{name} (wrong on purpose)") } else { name.into() }
}

/// A billion, or a million, points per second: what keeps the figures short.
pub fn unit(report: &RasterReport) -> (f64, &'static str) {
    let rates = report.blocks.iter().flat_map(|block| &block.rows).filter_map(|row| row.points_per_sec);
    let fastest = rates.map(|rate| rate.median).fold(0.0, f64::max);
    if fastest >= 3e9 { (1e-9, "billion points/s") } else { (1e-6, "million points/s") }
}

fn block_table(report: &RasterReport, block: &Block) -> Table {
    let (scale, unit) = unit(report);
    let columns = [
        "method",
        "frames",
        "frame, ms",
        unit,
        "GB/s",
        "% of reading",
        "% of copying (kernel)",
        "right pixels, %",
        "wrong pixels",
        "PSNR, dB",
        "SSIM",
        "depth error, median",
        "95 %",
        "give-ups",
    ];
    let overdraw =
        if block.covered_pixels > 0 { format!(", {:.1} per pixel", block.overdraw()) } else { String::new() };
    let errors = match block.reference_differs {
        0 => String::new(),
        differ => format!(
            "; {} differs from the processor in {differ} pixels, of which rounding explains {}",
            block.reference, block.reference_excused
        ),
    };
    let title = format!(
        "{} order, {} encoding, {}: {} points in the frustum, {} pixels covered{overdraw}{errors}",
        block.order.name(),
        block.encoding.name(),
        block.view,
        block.fragments,
        block.covered_pixels
    );
    let mut table = Table::new(&title, &columns);
    table.rows.extend(block.rows.iter().map(|row| cells(report, block.encoding, row, scale)));
    table
}

fn cells(report: &RasterReport, encoding: Encoding, row: &Row, scale: f64) -> Vec<String> {
    let percent = |share: Option<f64>, digits| share.map_or("–".into(), |share| number(100.0 * share, digits));
    let small =
        |value: Option<f64>| value.map_or("–".into(), |v| if v == 0.0 { "0".into() } else { format!("{v:.1e}") });
    let mut cells = vec![
        label(report, row.method),
        if row.is_single { "1 (too long)".into() } else { row.samples.len().to_string() },
        match &row.abandoned {
            Some(left) => format!("abandoned after {} of {} points, {:.1} s", left.points, left.of, left.secs),
            None => spread(row.frame_secs, 1e3, 3),
        },
        spread(row.points_per_sec, scale, 1),
        row.bytes_per_sec.map_or("–".into(), |s| number(s.median * 1e-9, 1)),
        percent(row.share_of(report.ceilings.read_bytes_per_sec(encoding)), 1),
        percent(row.share_of(report.ceilings.copy_kernel_bytes_per_sec), 1),
    ];
    let Some(a) = &row.accuracy else {
        cells.extend(std::iter::repeat_n("–".to_owned(), 7));
        return cells;
    };
    cells.extend([
        percent(a.right_share, 3),
        a.wrong_pixels.map_or("–".into(), |n| n.to_string()),
        match (a.covered_pixels, a.psnr_db) {
            (0, _) => "–".into(),
            (_, None) => "equal".into(),
            (_, Some(db)) => number(db, 1),
        },
        a.ssim.map_or("–".into(), |ssim| number(ssim, 4)),
        small(a.depth_error_median),
        small(a.depth_error_p95),
        a.give_ups.to_string(),
    ]);
    cells
}

/// What others published, one table per device.
pub fn published() -> Vec<Table> {
    let table = |set: &Published| {
        let points = set.million_points.map_or(String::new(), |n| format!(", {n} million points"));
        let title = format!("{}, {}{points}: milliseconds per frame", set.device, set.model);
        let mut columns = vec!["method".to_owned()];
        columns.extend(set.frame_ms.iter().map(|(order, _): &(Order, _)| order.name().to_owned()));
        let row = |(i, method): (usize, &&str)| {
            let times = set.frame_ms.iter().map(|(_, ms)| match set.million_points {
                Some(millions) => format!("{:.2} ({:.1} billion points/s)", ms[i], millions / ms[i]),
                None => format!("{:.2}", ms[i]),
            });
            [(*method).to_owned()].into_iter().chain(times).collect()
        };
        Table { title, columns, rows: METHODS.iter().enumerate().map(row).collect() }
    };
    PUBLISHED.iter().map(table).collect()
}

/// `median [lower – upper]`.
fn spread(summary: Option<Summary>, scale: f64, digits: usize) -> String {
    let Some(s) = summary else { return "–".into() };
    let [low, median, high] = [s.lower_quartile, s.median, s.upper_quartile].map(|value| number(value * scale, digits));
    if s.samples == 1 { median } else { format!("{median} [{low} – {high}]") }
}

fn number(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { "–".into() }
}
