//! One line per run, for spreadsheets and scripts.

use std::io::{self, Write};

use super::{
    reader::Way,
    report::{IngestFile, IngestReport},
};

/// Columns. Empty: does not apply. `run` says what was run: reader, read_alone, memcpy, against,
/// coverage, screen. `bytes` are the file's, for memcpy those copied.
const COLUMNS: [&str; 25] = [
    "file",
    "kind",
    "run",
    "round",
    "threads",
    "order",
    "decoder",
    "fields",
    "command",
    "points",
    "bytes",
    "secs",
    "processor_secs",
    "points_per_sec",
    "bytes_per_sec",
    "secs_to_first_batch",
    "secs_to_first_picture",
    "secs_to_converged",
    "frame_ms_p99",
    "read_secs",
    "decode_secs",
    "convert_secs",
    "wait_secs",
    "share_at_7_percent_of_time",
    "share_at_7_percent_of_points",
];

/// Writes all samples.
///
/// # Errors
/// If writing fails.
pub fn write_csv(out: &mut dyn Write, report: &IngestReport) -> io::Result<()> {
    writeln!(out, "{}", COLUMNS.join(","))?;
    for file in &report.files {
        for runs in &file.reader {
            for (round, sample) in runs.samples.iter().enumerate() {
                let mut line = Line::new(file, "reader", round);
                line.way(&runs.way).speed(file.points, file.point_bytes, sample.secs);
                line.number("processor_secs", sample.processor_secs);
                line.number("secs_to_first_batch", sample.secs_to_first_batch);
                if !sample.threads.is_empty() {
                    let sum =
                        |stage: fn(&crate::source::ThreadTimes) -> f64| Some(sample.threads.iter().map(stage).sum());
                    line.number("read_secs", sum(|t| t.read_secs));
                    line.number("decode_secs", sum(|t| t.decode_secs));
                    line.number("convert_secs", sum(|t| t.convert_secs));
                    line.number("wait_secs", sum(|t| t.wait_secs));
                }
                line.write(out)?;
            }
        }
        for (name, ceilings) in [("read_alone", &file.read_alone), ("memcpy", &file.memcpy)] {
            for runs in ceilings {
                for (round, &secs) in runs.samples_secs.iter().enumerate() {
                    let mut line = Line::new(file, name, round);
                    line.text("threads", &runs.threads.to_string()).speed(file.points, runs.bytes, secs);
                    line.write(out)?;
                }
            }
        }
        for runs in &file.against {
            for (round, sample) in runs.samples.iter().enumerate() {
                let mut line = Line::new(file, "against", round);
                line.text("command", &runs.command).speed(file.points, file.point_bytes, sample.secs);
                line.number("processor_secs", sample.processor_secs).write(out)?;
            }
        }
        for runs in &file.coverage {
            for (round, sample) in runs.samples.iter().enumerate() {
                let mut line = Line::new(file, "coverage", round);
                line.way(&runs.way).speed(sample.total_points, file.point_bytes, sample.total_secs);
                line.number("share_at_7_percent_of_time", Some(sample.share_at_7_percent_of_time));
                line.number("share_at_7_percent_of_points", Some(sample.share_at_7_percent_of_points));
                line.write(out)?;
            }
        }
        if let Some(runs) = &file.screen {
            for (round, sample) in runs.samples.iter().enumerate() {
                let mut line = Line::new(file, "screen", round);
                line.way(&runs.way);
                if let Some(secs) = sample.secs_to_all_loaded {
                    line.speed(sample.points_stored, file.point_bytes, secs);
                }
                line.number("secs_to_first_batch", sample.secs_to_first_batch);
                line.number("secs_to_first_picture", sample.secs_to_first_picture);
                line.number("secs_to_converged", sample.secs_to_converged);
                line.number("frame_ms_p99", sample.frame_ms_p99);
                line.write(out)?;
            }
        }
    }
    Ok(())
}

struct Line([String; COLUMNS.len()]);

impl Line {
    fn new(file: &IngestFile, run: &str, round: usize) -> Line {
        let mut line = Line(Default::default());
        line.text("file", &file.path.display().to_string()).text("kind", &file.kind);
        line.text("run", run).text("round", &(round + 1).to_string());
        line
    }

    fn text(&mut self, column: &str, value: &str) -> &mut Line {
        if let Some(at) = COLUMNS.iter().position(|&name| name == column) {
            self.0[at] = quoted(value);
        }
        self
    }

    fn number(&mut self, column: &str, value: Option<f64>) -> &mut Line {
        let text = value.filter(|v| v.is_finite()).map_or_else(String::new, |v| v.to_string());
        self.text(column, &text)
    }

    fn way(&mut self, way: &Way) -> &mut Line {
        let [order, decoder, fields] = way.words();
        self.text("threads", &way.threads.map_or_else(|| "auto".into(), |n| n.to_string()));
        self.text("order", &order).text("decoder", &decoder).text("fields", &fields)
    }

    fn speed(&mut self, points: u64, bytes: u64, secs: f64) -> &mut Line {
        self.text("points", &points.to_string()).text("bytes", &bytes.to_string());
        self.number("secs", Some(secs)).number("points_per_sec", Some(points as f64 / secs));
        self.number("bytes_per_sec", Some(bytes as f64 / secs))
    }

    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "{}", self.0.join(","))
    }
}

/// As RFC 4180 has it.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_needs_quotes_has_them() {
        assert_eq!(["a b", "a,b", "say \"x\""].map(quoted), ["a b", "\"a,b\"", "\"say \"\"x\"\"\""]);
    }
}
