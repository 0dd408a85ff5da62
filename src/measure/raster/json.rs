//! The report as JSON that can be kept with a program's sources: every sample, in few bytes.
//!
//! A file of one block a paragraph and one method a line shows in a diff what changed. Times and rates have six
//! significant digits, a millionth of what they tell, other fractions nine; a camera is exact, since it is read back.

use std::io::{self, Write};

use serde_json::Value;

use super::report::RasterReport;

/// Objects and lists so deep, or shorter than a line, are not broken: the rows of blocks are at 4.
const DEEP: usize = 4;
const LINE: usize = 110;

/// Writes the report.
///
/// # Errors
/// If writing fails.
pub fn write_json(out: &mut dyn Write, report: &RasterReport) -> io::Result<()> {
    let mut value = serde_json::to_value(report)?;
    shorten(&mut value, "");
    write_value(out, &value, 0)?;
    writeln!(out)
}

/// Rounds the fractions below `value`, which is called `name`.
fn shorten(value: &mut Value, name: &str) {
    match value {
        Value::Object(fields) if name != "camera" => fields.iter_mut().for_each(|(key, value)| {
            // What is within a summary of times are times.
            let is_time = |name: &str| ["secs", "_per_sec", "samples"].iter().any(|end| name.ends_with(end));
            let name = if is_time(name) && !is_time(key) { name } else { key };
            shorten(value, name);
        }),
        Value::Array(items) => items.iter_mut().for_each(|item| shorten(item, name)),
        Value::Number(number) if number.is_f64() => {
            let digits =
                if name.ends_with("secs") || name.ends_with("_per_sec") || name.ends_with("samples") { 6 } else { 9 };
            let rounded = number.as_f64().map(|exact| round(exact, digits));
            if let Some(rounded) = rounded.and_then(serde_json::Number::from_f64) {
                *number = rounded;
            }
        }
        _ => {}
    }
}

/// To so many significant digits.
fn round(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

fn write_value(out: &mut dyn Write, value: &Value, depth: usize) -> io::Result<()> {
    let compact = value.to_string();
    if depth >= DEEP || compact.len() <= LINE {
        return out.write_all(compact.as_bytes());
    }
    let indent = "  ".repeat(depth);
    match value {
        Value::Object(fields) => {
            writeln!(out, "{{")?;
            for (i, (key, value)) in fields.iter().enumerate() {
                write!(out, "{indent}  {}: ", Value::from(key.as_str()))?;
                write_value(out, value, depth + 1)?;
                writeln!(out, "{}", if i + 1 < fields.len() { "," } else { "" })?;
            }
            write!(out, "{indent}}}")
        }
        Value::Array(items) if items.iter().any(|item| item.is_object()) => {
            writeln!(out, "[")?;
            for (i, item) in items.iter().enumerate() {
                write!(out, "{indent}  ")?;
                write_value(out, item, depth + 1)?;
                writeln!(out, "{}", if i + 1 < items.len() { "," } else { "" })?;
            }
            write!(out, "{indent}]")
        }
        _ => out.write_all(compact.as_bytes()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        measure::{
            Summary,
            raster::{Accuracy, Block, Order, Row, Sample},
        },
        methods::{Encoding, FrameTime},
        render::Camera,
    };

    fn frame(secs: f64) -> FrameTime {
        FrameTime {
            clear_secs: 0.1 * secs,
            geometry_secs: vec![secs, secs / 3.0],
            resolve_secs: 1e-5,
            undivided_secs: None,
        }
    }

    /// As large as a run with every order, view and encoding can be.
    fn full() -> RasterReport {
        let mut report = RasterReport::for_tests();
        let accuracy = Accuracy {
            covered_pixels: 2_073_600,
            missing_pixels: 123_456,
            extra_pixels: 654_321,
            wrong_pixels: Some(1_234_567),
            right_share: Some(1.0 / 3.0),
            psnr_db: Some(100.0 / 3.0),
            ssim: Some(2.0 / 3.0),
            depth_error_median: Some(1.0 / 7.0),
            depth_error_p95: Some(1.0 / 9.0),
            give_ups: 0,
        };
        let eye = [1.0 / 3.0, 2e6 / 7.0, 100.0];
        let camera = Camera { eye, target: [0.0; 3], up: [0.0, 1.0, 0.0], fov_y_deg: 60.0, ..Default::default() };
        for i in 0..32 {
            let samples = (0..20).map(|k| Sample::new(k / 7 + 1, &frame(0.015 + 1e-5 * f64::from(k)))).collect();
            let mut row =
                Row { accuracy: Some(accuracy.clone()), samples, ..Row::new("reduce-early-z", 16_000_000_000) };
            row.summarize(1_000_000_000);
            report.blocks.push(Block {
                order: Order::ShuffledMorton,
                encoding: if i % 2 == 0 { Encoding::Wide } else { Encoding::Packed },
                view: "inside-none".into(),
                camera,
                fragments: 1_000_000_000,
                covered_pixels: 2_073_600,
                reference: "atomic-min",
                reference_differs: 35_000,
                reference_excused: 35_000,
                rows: vec![row; 17],
            });
        }
        report
    }

    #[test]
    fn a_full_report_is_small_and_whole() {
        let report = full();
        let mut bytes = Vec::new();
        write_json(&mut bytes, &report).unwrap();
        assert!(bytes.len() < 1_000_000, "{} bytes", bytes.len());
        let read: Value = serde_json::from_slice(&bytes).unwrap();
        let block = &read["blocks"][31];
        assert_eq!(serde_json::from_value::<Camera>(block["camera"].clone()).unwrap(), report.blocks[31].camera);
        let row = &block["rows"][16];
        let secs: Vec<f64> = serde_json::from_value(row["samples"]["frame_secs"].clone()).unwrap();
        assert_eq!(secs.len(), 20, "every sample");
        for (found, sample) in secs.iter().zip(&report.blocks[31].rows[16].samples) {
            assert!((found / sample.frame_secs - 1.0).abs() < 5.1e-6);
        }
        assert_eq!(row["samples"]["geometry_secs"][1].as_array().unwrap().len(), 20, "and every pass");
        assert_eq!(row["accuracy"]["right_share"], 0.333333333);
        let rate = row["points_per_sec"]["median"].as_f64().unwrap();
        let expected = Summary::of(&secs).unwrap().per(1e9).median;
        assert!((rate / expected - 1.0).abs() < 1.1e-5);
        let text = String::from_utf8(bytes).unwrap();
        assert!(
            text.lines().any(|line| line.contains("reduce-early-z") && line.contains("frame_secs")),
            "a row a line"
        );
    }

    #[test]
    fn digits_are_significant_ones() {
        assert_eq!(
            [round(0.001_234_567_8, 6), round(-123_456_789.0, 6), round(0.0, 6)],
            [0.001_234_57, -123_457_000.0, 0.0]
        );
        let mut value = serde_json::json!({"camera": {"secs": 0.123456789123}, "x": 0.123456789123, "frame_secs": {"median": 0.123456789123}, "n": 12345678901u64});
        shorten(&mut value, "");
        assert_eq!(
            value.to_string(),
            r#"{"camera":{"secs":0.123456789123},"x":0.123456789,"frame_secs":{"median":0.123457},"n":12345678901}"#
        );
    }
}
