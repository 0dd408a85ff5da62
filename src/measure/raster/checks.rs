//! What must hold of the accuracies, or the comparison is broken.

use glam::DVec3;

use super::report::{Check, RasterReport};

/// A picture with so small a share of right pixels is visibly wrong.
const VISIBLY_WRONG: f64 = 0.99;

/// Points per pixel from which it matters which of them is shown.
const OVERDRAW: f64 = 2.0;

/// Pixels in which rounding may differ between the device and the processor, as a share of the covered ones. An
/// H200 fuses multiplications and additions: 6 of 152,281 pixels.
const ROUNDING: f64 = 0.01;

/// Error of the depth that is allowed to methods that round it (`busy-loop-n`, `depth40`), 95th percentile, as a
/// share of the distance from the eye to the target.
const DEPTH: f64 = 1e-3;

/// The checks of a report.
pub fn checks(report: &RasterReport) -> Vec<Check> {
    let mut checks = Vec::new();
    for method in report.methods.iter().filter(|m| m.missing.is_none() && !m.blends) {
        let blocks = report.blocks.iter().filter(|block| block.overdraw() >= OVERDRAW);
        let rows = blocks.flat_map(|block| block.rows.iter().map(move |row| (block, row)));
        let rows: Vec<_> = rows.filter(|(_, row)| row.method == method.name).collect();
        if method.wrong_on_purpose.is_some() {
            let worst = rows.iter().filter_map(|(_, row)| row.accuracy.right_share).reduce(f64::min);
            checks.push(Check {
                what: format!("{} is wrong on purpose, so its picture must be wrong", method.name),
                holds: worst.map(|share| share < VISIBLY_WRONG),
                found: told(worst, |share| format!("{:.3} % of the pixels are right where it is worst", 100.0 * share)),
            });
            continue;
        }
        let holes = rows.iter().map(|(_, row)| {
            let a = &row.accuracy;
            (a.missing_pixels + a.extra_pixels) as f64 / a.covered_pixels as f64
        });
        let holes = holes.reduce(f64::max);
        let errors = rows.iter().filter_map(|(block, row)| {
            let distance = DVec3::from_array(block.camera.eye).distance(DVec3::from_array(block.camera.target));
            Some(row.accuracy.depth_error_p95? / distance)
        });
        let error = errors.reduce(f64::max);
        checks.push(Check {
            what: format!("{} must show the nearest points, as well as its depth tells them apart", method.name),
            holds: holes.map(|share| share <= 1.0 - VISIBLY_WRONG && error.is_some_and(|error| error <= DEPTH)),
            found: told(holes.zip(error), |(holes, error)| {
                format!(
                    "where it is worst, {:.3} % of the pixels are covered wrongly, and the depth is off by {error:.1e} of the distance",
                    100.0 * holes
                )
            }),
        });
    }
    let covered = |block: &&super::report::Block| block.covered_pixels > 0;
    let differs = report.blocks.iter().filter(covered);
    let worst = differs.map(|block| block.reference_differs as f64 / block.covered_pixels as f64);
    let worst = worst.reduce(f64::max);
    checks.push(Check {
        what: "the device's atomic-min, what all are compared with, must agree with the processor's".into(),
        holds: worst.map(|share| share <= ROUNDING),
        found: told(worst, |share| format!("{:.4} % of the pixels differ where it is worst", 100.0 * share)),
    });
    checks
}

fn told<T>(found: Option<T>, tell: impl Fn(T) -> String) -> String {
    found.map_or_else(|| format!("no view has {OVERDRAW} points per pixel"), tell)
}
