//! Times and ceilings are there, and of the size that they must have.

use firstlight::methods::{Encoding, Gpu, Runner, by_name, ceilings};

use crate::{
    clouds,
    pictures::{ENCODINGS, methods},
};

#[test]
fn every_method_is_timed() {
    let Some(gpu) = clouds::gpu() else { return };
    let size = [64, 48];
    let mut runner = Runner::new(&gpu, &clouds::cube(2000), Encoding::Wide, size).unwrap();
    for method in methods(&gpu) {
        let times = runner.time(method, &clouds::overview(size), 3).unwrap();
        assert_eq!(times.len(), 3, "{}", method.name);
        for time in times {
            assert!(time.total_secs() > 0.0 && time.total_secs() < 10.0, "{}: {time:?}", method.name);
            if time.undivided_secs.is_none() {
                assert_eq!(time.geometry_secs.len(), method.kernels().len().max(1), "{}", method.name);
            }
        }
        assert!(runner.time(method, &clouds::overview(size), 0).unwrap().is_empty());
    }
}

/// Enough points for their work to show beside what a frame costs without any.
fn many(gpu: &Gpu) -> usize {
    if gpu.is_software() { 1_000_000 } else { 32_000_000 }
}

/// Many more points take longer; so the clock measures the work.
#[test]
fn more_points_take_longer() {
    let Some(gpu) = clouds::gpu() else { return };
    let size = [64, 48];
    let median = |points: usize| {
        let mut runner = Runner::new(&gpu, &clouds::cube(points), Encoding::Wide, size).unwrap();
        let method = by_name("two-pass-32").unwrap();
        let mut secs: Vec<f64> =
            runner.time(method, &clouds::overview(size), 9).unwrap().iter().map(|t| t.total_secs()).collect();
        secs.sort_by(f64::total_cmp);
        secs[4]
    };
    let (few, many) = (median(25_000), median(many(&gpu)));
    assert!(many > 2.0 * few, "{few} s for 25,000 points, {many} s for many");
}

#[test]
fn ceilings_are_measured() {
    let Some(gpu) = clouds::gpu() else { return };
    for encoding in ENCODINGS {
        let mut runner = Runner::new(&gpu, &clouds::cube(100_000), encoding, [8, 8]).unwrap();
        let ceilings = ceilings(&mut runner, 3).unwrap();
        assert_eq!((ceilings.copy.len(), ceilings.read.len()), (3, 3));
        for rate in ceilings.copy.iter().chain(&ceilings.read) {
            // From a slow processor to ten times what the fastest memory does.
            assert!((1e5..1e14).contains(rate), "{encoding:?}: {ceilings:?}");
        }
    }
}

/// Reading costs, so the compiler did not leave it out: many more points take longer.
#[test]
fn the_reading_kernel_reads() {
    let Some(gpu) = clouds::gpu() else { return };
    let best = |points: usize| {
        let mut runner = Runner::new(&gpu, &clouds::cube(points), Encoding::Packed, [8, 8]).unwrap();
        let rates = ceilings(&mut runner, 9).unwrap().read;
        points as f64 * 8.0 / rates.into_iter().fold(0.0, f64::max)
    };
    let (few, many) = (best(25_000), best(many(&gpu)));
    assert!(many > 2.0 * few, "{few} s for 25,000 points, {many} s for many");
}
