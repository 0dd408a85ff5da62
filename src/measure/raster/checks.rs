//! What must hold of the accuracies, or the comparison is broken.

use glam::DVec3;

use super::report::{Check, RasterReport};

/// A picture with so small a share of right pixels is visibly wrong.
const VISIBLY_WRONG: f64 = 0.99;

/// Points per pixel from which it matters which of them is shown.
const OVERDRAW: f64 = 2.0;

/// Error of the depth that is allowed to methods that round it (`busy-loop-n`, `depth40`), 95th percentile, as a
/// share of the distance from the eye to the target.
const DEPTH: f64 = 1e-3;

/// The checks of a report.
pub fn checks(report: &RasterReport) -> Vec<Check> {
    let mut checks = Vec::new();
    for method in report.methods.iter().filter(|m| m.missing.is_none() && !m.blends) {
        let blocks = report.blocks.iter().filter(|block| block.overdraw() >= OVERDRAW);
        let rows = blocks.flat_map(|block| block.rows.iter().map(move |row| (block, row)));
        let rows = rows.filter(|(_, row)| row.method == method.name);
        // One that was abandoned has no picture.
        let rows: Vec<_> = rows.filter_map(|(block, row)| Some((block, row.accuracy.as_ref()?))).collect();
        if method.wrong_on_purpose.is_some() {
            let worst = rows.iter().filter_map(|(_, accuracy)| accuracy.right_share).reduce(f64::min);
            checks.push(Check {
                what: format!("{} is wrong on purpose, so its picture must be wrong", method.name),
                holds: worst.map(|share| share < VISIBLY_WRONG),
                found: told(worst, |share| format!("{:.3} % of the pixels are right where it is worst", 100.0 * share)),
            });
            continue;
        }
        // A busy loop that gave up has said so, in numbers; it is judged where it did not.
        let give_ups = rows.iter().map(|(_, accuracy)| accuracy.give_ups).min().unwrap_or(0);
        let rows: Vec<_> = rows.into_iter().filter(|(_, accuracy)| accuracy.give_ups == 0).collect();
        if give_ups > 0 && rows.is_empty() {
            checks.push(Check {
                what: format!("{} must show the nearest points where none gives up", method.name),
                holds: None,
                found: format!("{give_ups} points gave up where there were the fewest"),
            });
            continue;
        }
        let holes = rows.iter().map(|(_, a)| (a.missing_pixels + a.extra_pixels) as f64 / a.covered_pixels as f64);
        let holes = holes.reduce(f64::max);
        let errors = rows.iter().filter_map(|(block, accuracy)| {
            let distance = DVec3::from_array(block.camera.eye).distance(DVec3::from_array(block.camera.target));
            Some(accuracy.depth_error_p95? / distance)
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
    // Among all blocks, the most wrong pixels; with as many, the most that differ.
    let differs = report.blocks.iter().filter(|block| block.covered_pixels > 0);
    let worst = differs.max_by_key(|block| (block.reference_errors(), block.reference_differs));
    checks.push(Check {
        what: "the device's picture, what all are compared with, must be the processor's but for rounding".into(),
        holds: worst.map(|block| block.reference_errors() == 0),
        found: told(worst, |block| {
            format!(
                "of {} pixels {} differ where it is worst, of which rounding explains {}",
                block.covered_pixels, block.reference_differs, block.reference_excused
            )
        }),
    });
    checks
}

fn told<T>(found: Option<T>, tell: impl Fn(T) -> String) -> String {
    found.map_or_else(|| format!("no view has {OVERDRAW} points per pixel"), tell)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        measure::raster::{Accuracy, Block, MethodEntry, Order, RasterReport, Row},
        methods::{Encoding, by_name},
        render::Camera,
    };

    fn accuracy() -> Accuracy {
        Accuracy {
            covered_pixels: 1000,
            missing_pixels: 0,
            extra_pixels: 0,
            wrong_pixels: Some(0),
            right_share: Some(1.0),
            psnr_db: None,
            ssim: Some(1.0),
            depth_error_median: Some(0.0),
            depth_error_p95: Some(0.0),
            give_ups: 0,
        }
    }

    /// One block of a hundred metres' distance in which a method came out like this.
    fn report(method: &str, accuracy: Accuracy, fragments: u64) -> RasterReport {
        let method = by_name(method).unwrap();
        let camera = Camera {
            eye: [0.0, 0.0, 100.0],
            target: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            fov_y_deg: 60.0,
            ..Default::default()
        };
        let block = Block {
            order: Order::Original,
            view: "overview".into(),
            camera,
            fragments,
            covered_pixels: 1000,
            encoding: Encoding::Wide,
            reference: "atomic-min",
            reference_differs: 0,
            reference_excused: 0,
            rows: vec![Row { accuracy: Some(accuracy), ..Row::new(method.name, 16_000) }],
        };
        RasterReport { methods: vec![MethodEntry::new(method, None)], blocks: vec![block], ..RasterReport::for_tests() }
    }

    fn verdict(method: &str, accuracy: Accuracy, fragments: u64) -> Option<bool> {
        checks(&report(method, accuracy, fragments))[0].holds
    }

    #[test]
    fn wrong_on_purpose_must_be_wrong() {
        let wrong = Accuracy { wrong_pixels: Some(200), right_share: Some(0.8), ..accuracy() };
        assert_eq!(verdict("just-set", wrong, 5000), Some(true));
        assert_eq!(verdict("racy", accuracy(), 5000), Some(false), "then nothing is shown by the comparison");
        assert_eq!(verdict("racy", accuracy(), 1500), None, "with a point per pixel there is nothing to get wrong");
    }

    #[test]
    fn a_loop_that_gave_up_everywhere_says_so() {
        let report = report("busy-loop", Accuracy { give_ups: 7, ..accuracy() }, 5000);
        let check = &checks(&report)[0];
        assert_eq!((check.holds, check.found.as_str()), (None, "7 points gave up where there were the fewest"));
    }

    #[test]
    fn the_others_must_be_right() {
        assert_eq!(verdict("early-z", accuracy(), 5000), Some(true));
        let other_points = Accuracy { right_share: Some(0.8), depth_error_p95: Some(0.09), ..accuracy() };
        assert_eq!(
            verdict("busy-loop-n", other_points.clone(), 5000),
            Some(true),
            "rounded depth, the front all the same"
        );
        let behind = Accuracy { depth_error_p95: Some(0.11), ..other_points };
        assert_eq!(verdict("early-z", behind, 5000), Some(false));
        let mut unseen = report("busy-loop", accuracy(), 5000);
        unseen.blocks[0].rows[0].accuracy = None;
        assert_eq!(checks(&unseen)[0].holds, None, "abandoned: nothing is known");
        assert_eq!(verdict("early-z", Accuracy { missing_pixels: 11, ..accuracy() }, 5000), Some(false));
        assert_eq!(verdict("early-z", Accuracy { extra_pixels: 11, ..accuracy() }, 5000), Some(false));
    }

    #[test]
    fn the_device_must_agree_with_the_processor() {
        let mut report = report("early-z", accuracy(), 5000);
        assert_eq!(checks(&report)[1].holds, Some(true));
        (report.blocks[0].reference_differs, report.blocks[0].reference_excused) = (500, 500);
        assert_eq!(checks(&report)[1].holds, Some(true), "rounding, all of it");
        assert_eq!(
            checks(&report)[1].found,
            "of 1000 pixels 500 differ where it is worst, of which rounding explains 500"
        );
        report.blocks[0].reference_excused = 499;
        assert_eq!(checks(&report)[1].holds, Some(false), "one pixel is enough");
        report.blocks[0].covered_pixels = 0;
        assert_eq!(checks(&report)[1].holds, None);
    }
}
