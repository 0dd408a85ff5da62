//! What must hold of the accuracies, or the comparison is broken.

use super::report::{Check, RasterReport};

/// A picture with so small a share of right pixels is visibly wrong.
const VISIBLY_WRONG: f64 = 0.99;

/// Points per pixel from which it matters which of them is shown.
const OVERDRAW: f64 = 2.0;

/// Pixels in which rounding may differ between the device and the processor, as a share of the covered ones. An
/// H200 fuses multiplications and additions: 6 of 152,281 pixels.
const ROUNDING: f64 = 0.01;

/// The checks of a report.
pub fn checks(report: &RasterReport) -> Vec<Check> {
    let mut checks = Vec::new();
    for method in report.methods.iter().filter(|m| m.missing.is_none() && !m.blends) {
        let rows = report.blocks.iter().filter(|block| block.overdraw() >= OVERDRAW);
        let shares = rows.flat_map(|block| &block.rows).filter(|row| row.method == method.name);
        let shares = shares.filter_map(|row| Some(row.accuracy.right_share?));
        let worst = shares.fold(None, |worst: Option<f64>, share| Some(worst.map_or(share, |w| w.min(share))));
        let (what, holds) = match method.wrong_on_purpose {
            Some(_) => ("is wrong on purpose, so its picture must be wrong", worst.map(|w| w < VISIBLY_WRONG)),
            None => ("must show the right points", worst.map(|w| w >= VISIBLY_WRONG)),
        };
        let found = worst.map_or_else(
            || format!("no view has {OVERDRAW} points per pixel"),
            |w| format!("{:.3} % of the pixels are right where it is worst", 100.0 * w),
        );
        checks.push(Check { what: format!("{} {what}", method.name), holds, found });
    }
    let covered = |block: &&super::report::Block| block.covered_pixels > 0;
    let differs = report.blocks.iter().filter(covered);
    let worst = differs.map(|block| block.reference_differs as f64 / block.covered_pixels as f64);
    let worst = worst.fold(None, |worst: Option<f64>, share| Some(worst.map_or(share, |w| w.max(share))));
    checks.push(Check {
        what: "the device's atomic-min, what all are compared with, must agree with the processor's".into(),
        holds: worst.map(|share| share <= ROUNDING),
        found: worst.map_or_else(
            || "nothing is covered".into(),
            |share| format!("{:.4} % of the pixels differ where it is worst", 100.0 * share),
        ),
    });
    checks
}
