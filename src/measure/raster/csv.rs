//! One line per frame, for spreadsheets and scripts.

use std::io::{self, Write};

use super::report::{CurveKind, RasterReport};

/// Columns. Empty: does not apply. `run` says what was run: block (an order seen from a viewpoint), points,
/// planes, base (the curves), copy, read (the ceilings).
const COLUMNS: &str = "run,order,view,method,round,points,fragments_per_pixel,frame_secs,points_per_sec,bytes_per_sec,\
right_share,wrong_pixels,psnr_db,ssim,depth_error_median,depth_error_p95,give_ups";

/// Writes all samples.
///
/// # Errors
/// If writing fails.
pub fn write_csv(out: &mut dyn Write, report: &RasterReport) -> io::Result<()> {
    writeln!(out, "{COLUMNS}")?;
    let number = |value: Option<f64>| value.filter(|v| v.is_finite()).map_or_else(String::new, |v| v.to_string());
    for block in &report.blocks {
        for row in &block.rows {
            let a = &row.accuracy;
            let wrong = a.wrong_pixels.map(|n| n as f64);
            let measures = [a.right_share, wrong, a.psnr_db, a.ssim, a.depth_error_median, a.depth_error_p95];
            let measures = measures.map(number).join(",");
            for sample in &row.samples {
                let (order, view, secs) = (block.order.name(), &block.view, sample.frame_secs);
                let points = report.points as f64;
                let rates = [points / secs, points * report.bytes_per_point as f64 / secs].map(|v| number(Some(v)));
                writeln!(
                    out,
                    "block,{order},{view},{},{},{points},{},{secs},{},{measures},{}",
                    row.method,
                    sample.round,
                    number(Some(block.overdraw())),
                    rates.join(","),
                    a.give_ups
                )?;
            }
        }
    }
    for runs in &report.curves {
        let run = match runs.curve {
            CurveKind::Points => "points",
            CurveKind::Planes => "planes",
            CurveKind::Base => "base",
        };
        for (i, &secs) in runs.samples_secs.iter().enumerate() {
            let round = i as u32 / report.frames.max(1) + 1;
            let (points, fragments) = (runs.points as f64, runs.fragments_per_pixel);
            let rate = number(Some(points / secs));
            let bytes = number(Some(points * report.bytes_per_point as f64 / secs));
            writeln!(
                out,
                "{run},,,{},{round},{points},{},{secs},{rate},{bytes},,,,,,,",
                runs.method,
                number(Some(fragments))
            )?;
        }
    }
    for (run, samples) in [("copy", &report.ceilings.copy_samples), ("read", &report.ceilings.read_samples)] {
        for (i, rate) in samples.iter().enumerate() {
            writeln!(out, "{run},,,,{},,,,,{rate},,,,,,,", i + 1)?;
        }
    }
    Ok(())
}
