//! The figures of a report as tables. Medians, with quartiles in brackets where they tell something.

use super::{
    coverage::CoverageRuns,
    report::{CeilingRuns, IngestFile, IngestReport, ReaderRuns},
    screen::ScreenRuns,
};
use crate::measure::{
    html::Table,
    stats::{Summary, quantile},
};

/// Shares of the points, or of the time, that coverage is told at, percent.
const SHARES: [f64; 6] = [1.0, 2.0, 5.0, 7.0, 10.0, 20.0];

/// The whole report as Markdown.
pub fn markdown(report: &IngestReport) -> String {
    let mut out = format!("{}\n\n", facts(report).join("\n"));
    for file in &report.files {
        out.push_str(&format!("## {}\n\n{}\n\n", file.path.display(), describe(file)));
        for table in tables(file) {
            out.push_str(&table.markdown());
            out.push('\n');
        }
    }
    out
}

/// What the figures depend on, line by line.
pub fn facts(report: &IngestReport) -> Vec<String> {
    let machine = &report.machine;
    let memory =
        machine.memory_bytes.map_or(String::new(), |n| format!(", {:.0} GiB memory", n as f64 / 2f64.powi(30)));
    let load = machine
        .load_before
        .zip(machine.load_after)
        .map_or(String::new(), |(before, after)| format!(", load {before:.2} before and {after:.2} after"));
    let mut lines = vec![
        format!("{}, {} rounds; medians, quartiles in brackets", report.program, report.repeat),
        format!("{}, {} cores{memory}{load}, {}", machine.processor, machine.cores, machine.system),
    ];
    if let (Some(backend), Some([width, height])) = (&report.backend, report.size_px) {
        lines.push(format!("{} ({}), {}, {width}x{height} pixels", backend.adapter, backend.api, backend.method));
    }
    lines.extend(report.problems.iter().map(|problem| format!("PROBLEM: {problem}")));
    lines
}

/// One file in a line.
pub fn describe(file: &IngestFile) -> String {
    format!(
        "{}, {:.2} M points, {:.1} MB of points ({} bytes each), {:.1} MB as batches",
        file.kind,
        file.points as f64 * 1e-6,
        file.point_bytes as f64 * 1e-6,
        number(file.bytes_per_point(), 2),
        file.batch_bytes as f64 * 1e-6
    )
}

/// All tables of a file.
pub fn tables(file: &IngestFile) -> Vec<Table> {
    let mut tables = vec![rates(file), ceilings(file)];
    tables.extend(against(file));
    tables.extend(stages(file));
    if !file.coverage.iter().all(|runs| runs.samples.is_empty()) {
        tables.extend(coverage(file));
    }
    tables.extend(file.screen.iter().map(screen));
    tables
}

fn rates(file: &IngestFile) -> Table {
    let mut table = Table::new(
        "Reader: everything decoded, nothing drawn",
        &[
            "way",
            "threads",
            "M points/s",
            "M points per core-second",
            "MB/s of the file",
            "of read alone, %",
            "of memcpy, %",
            "× one thread",
            "headers read, ms",
            "first batch, ms",
            "all points, s",
        ],
    );
    for runs in &file.reader {
        let secs = runs.seconds.map_or(f64::NAN, |s| s.median);
        let batch_bytes = runs.samples.first().map_or(0, |sample| sample.batch_bytes);
        let of = |ceilings: &[CeilingRuns], bytes: u64| {
            let rate = CeilingRuns::rate(ceilings, runs.way.threads);
            rate.map_or("–".into(), |rate| number(100.0 * bytes as f64 / secs / rate, 1))
        };
        let single = file.reader.iter().find(|r| r.way.threads == Some(1) && same_way(r, runs));
        let speed_up = single.and_then(|single| Some(single.seconds?.median / secs));
        let opened: Vec<f64> = runs.samples.iter().map(|s| 1e3 * s.secs_to_opened).collect();
        let per_core: Vec<f64> =
            runs.samples.iter().filter_map(|s| Some(s.points as f64 / s.counted_secs()?)).collect();
        let first: Vec<f64> = runs.samples.iter().filter_map(|s| Some(1e3 * s.secs_to_first_batch?)).collect();
        table.rows.push(vec![
            runs.way.name(file.compressed),
            threads(runs.way.threads),
            spread(runs.points_per_sec, 1e-6, 2),
            spread(Summary::of(&per_core), 1e-6, 2),
            runs.bytes_per_sec.map_or("–".into(), |s| number(s.median * 1e-6, 0)),
            of(&file.read_alone, file.point_bytes),
            of(&file.memcpy, batch_bytes),
            speed_up.map_or("–".into(), |s| number(s, 2)),
            number(quantile(&opened, 0.5), 1),
            spread(Summary::of(&first), 1.0, 1),
            number(secs, 3),
        ]);
    }
    table
}

fn same_way(a: &ReaderRuns, b: &ReaderRuns) -> bool {
    (a.way.order, a.way.decoder, a.way.fields) == (b.way.order, b.way.decoder, b.way.fields)
}

fn ceilings(file: &IngestFile) -> Table {
    let mut table = Table::new(
        "Ceilings, measured between the runs",
        &["threads", "read alone, MB/s", "read alone, M points/s", "memcpy, MB/s", "memcpy, M points/s"],
    );
    for (read, copy) in file.read_alone.iter().zip(&file.memcpy) {
        let points = |seconds: Option<Summary>| {
            seconds.map_or("–".into(), |s| number(file.points as f64 / s.median * 1e-6, 0))
        };
        table.rows.push(vec![
            threads(Some(read.threads)),
            spread(read.bytes_per_sec, 1e-6, 0),
            points(read.seconds),
            spread(copy.bytes_per_sec, 1e-6, 0),
            points(copy.seconds),
        ]);
    }
    table
}

fn against(file: &IngestFile) -> Option<Table> {
    let mut table = Table::new(
        "Against other programs, round by round",
        &["program", "M points/s", "s", "our way", "our threads", "times as fast as it", "by processor time"],
    );
    for theirs in &file.against {
        for ours in &file.reader {
            table.rows.push(vec![
                theirs.command.clone(),
                spread(theirs.points_per_sec, 1e-6, 2),
                theirs.seconds.map_or("–".into(), |s| number(s.median, 3)),
                ours.way.name(file.compressed),
                threads(ours.way.threads),
                spread(Summary::of(&theirs.ratios(ours)), 1.0, 2),
                spread(Summary::of(&theirs.processor_ratios(ours)), 1.0, 2),
            ]);
        }
    }
    (!table.rows.is_empty()).then_some(table)
}

/// Where the reader's threads spent their time, in the run of median length.
fn stages(file: &IngestFile) -> Option<Table> {
    let mut table = Table::new(
        "Stages of the reader, milliseconds per thread (the run of median length)",
        &["way", "of threads", "thread", "read", "decode", "convert", "wait on the channel", "M points", "MB"],
    );
    for runs in &file.reader {
        let mut sorted: Vec<_> = runs.samples.iter().collect();
        sorted.sort_by(|a, b| a.secs.total_cmp(&b.secs));
        let Some(sample) = sorted.get((sorted.len().max(1) - 1) / 2) else { continue };
        let head = [runs.way.name(file.compressed), threads(runs.way.threads)];
        for thread in &sample.threads {
            let secs = [thread.read_secs, thread.decode_secs, thread.convert_secs, thread.wait_secs];
            let mut row = head.to_vec();
            row.push(thread.name.clone());
            row.extend(secs.map(|secs| number(1e3 * secs, 1)));
            row.push(number(thread.points as f64 * 1e-6, 2));
            row.push(number(thread.bytes as f64 * 1e-6, 1));
            table.rows.push(row);
        }
        let mut row = head.to_vec();
        row.extend(["the receiver".into(), "–".into(), "–".into(), "–".into()]);
        row.push(number(1e3 * sample.receiver_wait_secs, 1));
        row.push(number(sample.points as f64 * 1e-6, 2));
        row.push("–".into());
        table.rows.push(row);
    }
    (!table.rows.is_empty()).then_some(table)
}

/// Two tables: by time and by points.
fn coverage(file: &IngestFile) -> [Table; 2] {
    let make = |title: &str, share: fn(&super::coverage::Coverage, f64) -> f64| {
        let mut columns = vec!["way".to_owned(), "threads".to_owned()];
        columns.extend(SHARES.map(|share| format!("{share} %")));
        let mut table = Table { title: title.into(), columns, rows: Vec::new() };
        for runs in &file.coverage {
            let mut row = vec![runs.way.name(file.compressed), threads(runs.way.threads)];
            row.extend(SHARES.map(|at| number(100.0 * median_share(runs, |c| share(c, at / 100.0)), 1)));
            table.rows.push(row);
        }
        table
    };
    [
        make("Cells of a 64×64 grid covered, % of those finally occupied, after a share of the total time", |c, s| {
            c.share_after_time(s)
        }),
        make("The same, after a share of the points (whole batches)", |c, s| c.share_after_points(s)),
    ]
}

fn median_share(runs: &CoverageRuns, share: impl Fn(&super::coverage::Coverage) -> f64) -> f64 {
    quantile(&runs.samples.iter().map(share).collect::<Vec<_>>(), 0.5)
}

fn screen(runs: &ScreenRuns) -> Table {
    let mut table = Table::new("From the start to the screen, camera in motion, median of the runs", &["", ""]);
    let median = |value: fn(&super::ScreenSample) -> Option<f64>, scale: f64, digits| {
        let values: Vec<f64> = runs.samples.iter().filter_map(value).collect();
        spread(Summary::of(&values), scale, digits)
    };
    let mut row = |name: &str, value: String| table.rows.push(vec![name.into(), value]);
    row("device ready, s", median(|s| Some(s.setup_secs), 1.0, 3));
    row("first batch taken, s", median(|s| s.secs_to_first_batch, 1.0, 3));
    row("first picture, s", median(|s| s.secs_to_first_picture, 1.0, 3));
    row("all points in the store, s", median(|s| s.secs_to_all_loaded, 1.0, 3));
    row("all points on screen (converged), s", median(|s| s.secs_to_converged, 1.0, 3));
    row("upload, s in all", median(|s| s.upload_secs, 1.0, 3));
    row("scatter, ms per insertion", median(|s| Some(s.scatter_secs? / s.scatter_insertions as f64), 1e3, 3));
    row("frames while loading", median(|s| Some(s.frames.len() as f64), 1.0, 0));
    row("frame while loading, ms", median(|s| s.frame_ms_median, 1.0, 1));
    row("99th percentile, ms", median(|s| s.frame_ms_p99, 1.0, 1));
    row("target, ms", number(runs.target_ms, 1));
    table
}

fn threads(threads: Option<usize>) -> String {
    threads.map_or("auto".into(), |n| n.to_string())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads_show_what_is_known() {
        assert_eq!(spread(None, 1.0, 1), "–");
        assert_eq!(spread(Summary::of(&[2e6]), 1e-6, 2), "2.00");
        assert_eq!(spread(Summary::of(&[1.0, 2.0, 3.0, 9.0]), 1.0, 1), "2.0 [1.0 – 3.0]");
        assert_eq!(number(f64::NAN, 1), "–");
    }
}
