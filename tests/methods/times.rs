//! Times and ceilings are there, and of the size that they must have.

use std::time::Duration;

use firstlight::methods::{Copies, Encoding, Gpu, Paced, Runner, by_name, ceilings};

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
        let ceilings = ceilings(&mut runner, &Copies::new(&gpu).unwrap(), 3).unwrap();
        assert_eq!((ceilings.copy.len(), ceilings.copy_kernel.len(), ceilings.read.len()), (3, 3, 3));
        for rate in ceilings.copy.iter().chain(&ceilings.copy_kernel).chain(&ceilings.read) {
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
        let copies = Copies::with_bytes(&gpu, 16).unwrap();
        let rates = ceilings(&mut runner, &copies, 9).unwrap().read;
        points as f64 * 8.0 / rates.into_iter().fold(0.0, f64::max)
    };
    let (few, many) = (best(25_000), best(many(&gpu)));
    assert!(many > 2.0 * few, "{few} s for 25,000 points, {many} s for many");
}

/// Sizes around the 16 bytes of a word, a thread's four, a workgroup's 1,024, and several workgroups.
#[test]
fn the_copying_kernel_copies() {
    let Some(gpu) = clouds::gpu() else { return };
    for words in [4, 8, 12, 16, 20, 1020, 1024, 1028, 4092, 4096, 4100, 40_004] {
        let copies = Copies::with_bytes(&gpu, 4 * words as u64).unwrap();
        assert_eq!(copies.bytes(), 4 * 4 * words as u64, "four pairs");
        let given: Vec<u32> = (0..words).map(|i| clouds::noise(i, 3) as u32).collect();
        assert_eq!(copies.copied(&given).unwrap(), given, "{words} words");
        let other: Vec<u32> = given.iter().map(|word| !word).collect();
        assert_ne!(copies.copied(&other).unwrap(), given, "the comparison tells them apart");
    }
}

/// In parts, with a look at the clock between them, a frame shows the same; out of patience, it is left.
#[test]
fn a_paced_frame_is_the_same_or_abandoned() {
    let Some(gpu) = clouds::gpu() else { return };
    let (size, points) = ([97, 61], (1 << 16) * 5 + 17);
    let (cloud, view) = (clouds::lines(points), clouds::overview(size));
    for (encoding, page) in [(ENCODINGS[0], None), (ENCODINGS[1], Some(100_003))] {
        let mut runner = Runner::with_pages(&gpu, &cloud, encoding, size, page).unwrap();
        for method in methods(&gpu).into_iter().filter(|method| method.wrong_on_purpose.is_none()) {
            let case = format!("{}, {encoding:?}", method.name);
            let whole = runner.draw(method, &view).unwrap();
            let Paced::Drawn { drawn, secs } = runner.draw_paced(method, &view, Duration::from_secs(600)).unwrap()
            else {
                panic!("{case}: there was time enough");
            };
            assert!(secs > 0.0 && (drawn == whole || whole.give_ups + drawn.give_ups > 0), "{case}");
            let hurried = runner.draw_paced(method, &view, Duration::ZERO).unwrap();
            let Paced::Abandoned(abandoned) = hurried else { panic!("{case}: there was no time") };
            let of = (points * method.kernels().len().max(1)) as u64;
            assert!(abandoned.points > 0 && abandoned.points < of && abandoned.of == of, "{case}: {abandoned:?}");
            // What was left behind does not show in the next frame.
            assert!(runner.draw(method, &view).unwrap() == whole || whole.give_ups > 0, "{case}");
        }
    }
}
