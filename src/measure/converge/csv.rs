//! One line per frame, for spreadsheets and scripts.

use std::io::{self, Write};

use super::{
    metrics::Metrics,
    report::ConvergeReport,
    settings::{Decoded, Fill},
};
use crate::store::Encoding;

/// Columns before the metrics. Empty: does not apply.
const COLUMNS: &str = "variant,fill,point_size_px,method,encoding,fields,round,phase,frame,start_secs,frame_secs,points_stored,\
points_tried,frame_fill,points_drawn,converged,flicker_pixels,flicker_share,expected_sample,expected_of,expected_covered_share,\
expected_covered_sigma,expected_front_share,expected_front_sigma,expected_right_share";

/// Columns of [`Metrics`], once against all points received and once against all of the file.
const METRICS: [&str; 11] = [
    "truth_pixels",
    "covered_share",
    "extra_pixels",
    "right_share",
    "front_share",
    "psnr_db",
    "ssim",
    "depth_error_median_m",
    "depth_error_p95_m",
    "edge_pixels",
    "edge_error",
];

/// Writes all samples.
///
/// # Errors
/// If writing fails.
pub fn write_csv(out: &mut dyn Write, report: &ConvergeReport) -> io::Result<()> {
    let of = |truth: &str| METRICS.map(|metric| format!(",{truth}_{metric}")).concat();
    writeln!(out, "{COLUMNS}{}{}", of("received"), of("file"))?;
    let number = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
    for run in &report.runs {
        let method = run.method.as_deref().unwrap_or("");
        // A number, where words say 10k.
        let fill = match run.fill {
            Fill::Auto => "auto".to_owned(),
            Fill::Points(points) => points.to_string(),
        };
        let (encoding, fields) = (run.encoding.map_or("", Encoding::name), run.fields.map_or("", Decoded::name));
        let (name, size) = (run.variant.name(), run.point_size_px);
        let head = format!("{name},{fill},{size},{method},{encoding},{fields},{}", run.round);
        for f in &run.frames {
            let mut cells = vec![head.clone(), f.phase.clone(), f.frame.to_string()];
            cells.push(number(f.times.map(|times| times.start_secs)));
            cells.push(number(f.times.map(|times| times.frame_secs)));
            cells.extend([f.points_stored, f.points_tried, f.fill.into(), f.points_drawn].map(|n| n.to_string()));
            cells.push(f.converged.to_string());
            cells.push(f.change.map_or_else(String::new, |change| change.flicker_pixels.to_string()));
            cells.push(number(f.change.and_then(|change| change.flicker_share)));
            match &f.expected {
                None => cells.extend(std::iter::repeat_n(String::new(), 7)),
                Some(e) => {
                    cells.extend([e.sample, e.of].map(|n| n.to_string()));
                    let shares = [e.covered_share, e.covered_sigma, e.front_share, e.front_sigma, e.right_share];
                    cells.extend(shares.map(|share| share.to_string()));
                }
            }
            cells.extend(metrics(&f.received));
            cells.extend(metrics(&f.file));
            writeln!(out, "{}", cells.join(","))?;
        }
    }
    Ok(())
}

/// In the order of [`METRICS`].
fn metrics(m: &Metrics) -> [String; 11] {
    let number = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
    [
        m.truth_pixels.to_string(),
        number(m.covered_share),
        m.extra_pixels.to_string(),
        number(m.right_share),
        number(m.front_share),
        number(m.psnr_db),
        number(m.ssim),
        number(m.depth_error_median_m),
        number(m.depth_error_p95_m),
        m.edge_pixels.to_string(),
        number(m.edge_error),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::converge::{
        headline::tests::frame,
        report::{Headline, Run},
        settings::Variant,
        theory::Expected,
    };

    #[test]
    fn every_line_has_every_column() {
        let expected = Expected {
            sample: 3,
            of: 4,
            covered_share: 0.5,
            covered_sigma: 0.1,
            front_share: 0.4,
            front_sigma: 0.1,
            right_share: 0.75,
        };
        let frames = vec![
            frame(0, "loading", 0.5, false),
            super::super::report::Frame { expected: Some(expected), ..frame(1, "still", 1.0, true) },
        ];
        let run = Run {
            variant: Variant::Firstlight,
            fill: Fill::Points(2000),
            point_size_px: 2,
            method: None,
            encoding: Some(Encoding::Packed),
            fields: None,
            is_viewers_method: true,
            round: 1,
            headline: Headline::of(&frames),
            frames,
        };
        let report = ConvergeReport { runs: vec![run], ..ConvergeReport::for_tests() };
        let mut out = Vec::new();
        write_csv(&mut out, &report).unwrap();
        let text = String::from_utf8(out).unwrap();
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!(lines.len(), 3);
        assert!(lines.iter().all(|line| line.len() == lines[0].len()), "{text}");
        let cell = |line: usize, column: &str| lines[line][lines[0].iter().position(|c| *c == column).unwrap()];
        assert_eq!((cell(1, "method"), cell(1, "encoding"), cell(1, "fields")), ("", "packed", ""));
        assert_eq!((cell(1, "fill"), cell(1, "start_secs"), cell(1, "expected_sample")), ("2000", "", ""));
        assert_eq!((cell(2, "start_secs"), cell(2, "expected_right_share")), ("1", "0.75"));
        assert_eq!((cell(1, "file_right_share"), cell(2, "received_ssim")), ("0.5", "1"));
    }
}
