//! One line per frame, for spreadsheets and scripts.

use std::io::{self, Write};

use super::report::{CurveKind, RasterReport};

/// Columns. Empty: does not apply. `run` says what was run: block (an order seen from a viewpoint), points,
/// planes, base (the curves), copy, copy-kernel, read (the ceilings).
const COLUMNS: &str = "run,order,encoding,view,method,round,points,fragments_per_pixel,frame_secs,points_per_sec,bytes_per_sec,\
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
            let measures = row.accuracy.as_ref().map_or([None; 6], |a| {
                let wrong = a.wrong_pixels.map(|n| n as f64);
                [a.right_share, wrong, a.psnr_db, a.ssim, a.depth_error_median, a.depth_error_p95]
            });
            let measures = measures.map(number).join(",");
            let give_ups = row.accuracy.as_ref().map_or(0, |a| a.give_ups);
            for sample in &row.samples {
                let (order, encoding) = (block.order.name(), block.encoding.name());
                let (view, secs) = (&block.view, sample.frame_secs);
                let points = report.points as f64;
                let rates = [points / secs, row.bytes as f64 / secs].map(|v| number(Some(v)));
                writeln!(
                    out,
                    "block,{order},{encoding},{view},{},{},{points},{},{secs},{},{measures},{give_ups}",
                    row.method,
                    sample.round,
                    number(Some(block.overdraw())),
                    rates.join(",")
                )?;
            }
        }
    }
    let encoding = report.encodings.first().map_or("", |encoding| encoding.name());
    for runs in &report.curves {
        let run = match runs.curve {
            CurveKind::Points => "points",
            CurveKind::Planes => "planes",
            CurveKind::Base => "base",
        };
        for &secs in &runs.samples_secs {
            let (points, fragments) = (runs.points as f64, runs.fragments_per_pixel);
            let (fragments, rate) = (number(Some(fragments)), number(Some(points / secs)));
            writeln!(out, "{run},,{encoding},,{},,{points},{fragments},{secs},{rate},,,,,,,,", runs.method)?;
        }
    }
    let ceilings = &report.ceilings;
    let copies = [("copy", &ceilings.copy_samples), ("copy-kernel", &ceilings.copy_kernel_samples)];
    let all = copies.into_iter().map(|(run, samples)| (run, "", samples));
    for (run, encoding, samples) in all.chain(ceilings.read.iter().map(|r| ("read", r.encoding.name(), &r.samples))) {
        for (i, rate) in samples.iter().enumerate() {
            writeln!(out, "{run},,{encoding},,,{},,,,,{rate},,,,,,,", i + 1)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::Encoding;

    #[test]
    fn every_line_has_every_column() {
        let mut report = RasterReport::for_tests();
        report.ceilings.add(Encoding::Packed, &[1.0], &[2.0], &[3.0]);
        let mut csv = Vec::new();
        write_csv(&mut csv, &report).unwrap();
        let csv = String::from_utf8(csv).unwrap();
        let commas: Vec<usize> = csv.lines().map(|line| line.matches(',').count()).collect();
        assert_eq!(commas, [17; 4], "{csv}");
        assert!(csv.contains("\nread,,packed,"));
    }
}
