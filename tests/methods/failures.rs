//! Methods that fail, in the way that they say they do.

use firstlight::methods::{Cloud, Encoding, Gpu, MethodError, NO_POINT, Runner, TooWide, by_name, twin};

use crate::{
    clouds,
    pictures::{ENCODINGS, check, differing, methods},
};

/// Many points in one pixel. All within 1 % of the front: 1,000 m away, 1 mm apart.
#[test]
fn everything_in_one_pixel() {
    let Some(gpu) = clouds::gpu() else { return };
    let size = [9, 7];
    for points in [254, 255, 256, 1022, 1023, 1024, 1025, 5000] {
        let cloud = clouds::stacked(points);
        let view = clouds::along_y(size, 1000.0);
        for encoding in ENCODINGS {
            let mut runner = Runner::new(&gpu, &cloud, encoding, size).unwrap();
            for method in methods(&gpu) {
                let case = format!("{points} points in a pixel, {encoding:?}, {}", method.name);
                let drawn = check(&gpu, &mut runner, method, &cloud, &view, &case);
                let shown = drawn.point.iter().filter(|&&point| point != NO_POINT).count();
                assert_eq!(shown, 1, "{case}");
            }
            let mut colors = |name: &str| {
                let method = by_name(name).unwrap();
                gpu.supports(method).ok().map(|()| runner.draw(method, &view).unwrap().rgba)
            };
            let hqs = colors("hqs");
            for exact in ["hqs-64", "hqs1r"] {
                assert!(colors(exact).is_none_or(|rgba| Some(rgba) == hqs), "{exact} equals hqs at {points}");
            }
            // The count of 10 bits starts again at 1,024.
            assert!(colors("hqs1").is_none_or(|rgba| (Some(rgba) == hqs) == (points < 1024)), "hqs1 at {points}");
        }
    }
}

/// What is farther than 1 % behind the front is not in the average.
#[test]
fn averages_end_one_percent_behind_the_front() {
    let Some(gpu) = clouds::gpu() else { return };
    let size = [9, 7];
    // The eye is 10 m before the origin: the border is 100 mm behind it.
    for (gap, is_averaged) in [(90, true), (110, false)] {
        let cloud = Cloud { positions: vec![[0, 0, 0], [0, gap, 0]], colors: vec![0x00_00_00, 0xff_ff_ff] };
        let mut runner = Runner::new(&gpu, &cloud, Encoding::Wide, size).unwrap();
        for method in methods(&gpu).into_iter().filter(|method| method.blends) {
            let drawn = runner.draw(method, &clouds::along_y(size, 10.0)).unwrap();
            let shown: Vec<_> = drawn.rgba.iter().filter(|rgba| rgba[3] > 0).collect();
            let grey = if is_averaged { 128 } else { 0 };
            assert_eq!(shown, [&[grey, grey, grey, 255]], "{}, {gap} mm apart", method.name);
            assert_eq!(drawn.point.iter().copied().find(|&point| point != NO_POINT), Some(0));
        }
    }
}

/// `just-set` and `racy` are wrong where it counts: many points in a pixel, the nearest first.
#[test]
fn wrong_methods_are_visibly_wrong() {
    let Some(gpu) = clouds::gpu() else { return };
    let size = [97, 61];
    let mut cloud = clouds::cube(60_000);
    // From the eye outwards, so that a later point is a farther one, and neighbours are as near.
    let view = clouds::overview(size);
    cloud.positions.sort_by_key(|&position| view.project(position).map_or(0, |point| point.depth.to_bits()));
    let mut runner = Runner::new(&gpu, &cloud, Encoding::Wide, size).unwrap();
    let right = runner.draw(by_name("two-pass-32").unwrap(), &view).unwrap();
    let just_set = runner.draw(by_name("just-set").unwrap(), &view).unwrap();
    let shown = right.point.iter().filter(|&&point| point != NO_POINT).count();
    let wrong = differing(&right, &just_set, 4);
    assert!(wrong * 2 > shown, "just-set: {wrong} of {shown} pixels wrong");
    // All in one pixel, the nearest first: the threads that begin together all find it empty.
    let mut cloud = clouds::stacked(4096);
    cloud.positions.reverse();
    let view = clouds::along_y([9, 7], 1000.0);
    let mut runner = Runner::new(&gpu, &cloud, Encoding::Wide, [9, 7]).unwrap();
    let right = runner.draw(by_name("two-pass-32").unwrap(), &view).unwrap();
    let racy = by_name("racy").unwrap();
    let wrong = (0..10).filter(|_| differing(&right, &runner.draw(racy, &view).unwrap(), 4) > 0).count();
    assert!(wrong > 0, "racy: {wrong} of 10 pictures wrong");
}

/// A busy loop that may not spin gives up, says how often, and misses no more pixels than that.
#[test]
fn give_ups_are_counted() {
    let Some(gpu) = clouds::gpu() else { return };
    let size = [9, 7];
    let cloud = clouds::stacked(4096);
    let view = clouds::along_y(size, 1000.0);
    for name in ["busy-loop", "busy-loop-n"] {
        let method = by_name(name).unwrap();
        let mut runner = Runner::new(&gpu, &cloud, Encoding::Wide, size).unwrap();
        // A busy machine may take a thread that holds a lock off its core for long; on a GPU threads of a
        // subgroup may wait for each other for ever (an H200's do).
        let is_patient = !gpu.is_software() || (0..3).any(|_| runner.draw(method, &view).unwrap().give_ups == 0);
        assert!(is_patient, "{name}: none of 3 pictures without give-ups");
        runner.set_spins(1);
        let hasty = runner.draw(method, &view).unwrap();
        assert!(hasty.give_ups > 0 && hasty.give_ups < 4096, "{name}: {} give-ups", hasty.give_ups);
        twin::is_possible(method, &cloud, &view, &hasty).unwrap();
        runner.set_spins(0);
        let idle = runner.draw(method, &view).unwrap();
        assert_eq!(idle.give_ups, 4096, "{name}");
        assert!(idle.point.iter().all(|&point| point == NO_POINT), "{name}");
        let unexcused = firstlight::methods::Drawn { give_ups: 0, ..idle };
        assert!(twin::is_possible(method, &cloud, &view, &unexcused).is_err(), "{name}: a hole needs a reason");
    }
}

/// Far points that 32 bits of float cannot tell apart, and 40 bits of integer can; normalized depth
/// fails first.
#[test]
fn depths_differ_in_precision() {
    let Some(gpu) = clouds::gpu() else { return };
    let size = [9, 7];
    let nearest = |name: &str, gap: i32, distance: f64| {
        let cloud = Cloud { positions: vec![[0, gap, 0], [0, 0, 0]], colors: vec![0x00_00_ff, 0x00_ff_00] };
        let mut runner = Runner::new(&gpu, &cloud, Encoding::Wide, size).unwrap();
        let method = by_name(name).unwrap();
        if gpu.supports(method).is_err() {
            return None;
        }
        let view = clouds::along_y(size, distance);
        let drawn = check(&gpu, &mut runner, method, &cloud, &view, name);
        if drawn.give_ups > 0 {
            return None;
        }
        drawn.point.iter().copied().find(|&point| point != NO_POINT)
    };
    // A millimetre at 100 m, where a float has 8 µm.
    for name in ["busy-loop", "two-pass-32", "depth40", "depth40-ranges"] {
        assert!(nearest(name, 1, 100.0).is_none_or(|point| point == 1), "{name}");
    }
    // A millimetre at 100 km, where a float has 8: the first of equal ones stays.
    assert_eq!(nearest("two-pass-32", 1, 100_000.0), Some(0));
    assert!(nearest("depth40", 1, 100_000.0).is_none_or(|point| point == 1));
    assert!(nearest("depth40-ranges", 1, 100_000.0).is_none_or(|point| point == 1));
    // Normalized depth at 1 km: half a metre.
    for (name, expected) in [("busy-loop-n", 0), ("busy-loop", 1)] {
        let found = nearest(name, 100, 1000.0);
        let gave_up = found.is_none() && !gpu.is_software();
        assert!(gave_up || found == Some(expected), "{name}: {found:?}");
    }
}

#[test]
fn a_device_without_features_says_so_and_runs_the_rest() {
    if clouds::gpu().is_none() {
        return;
    }
    let int64 = wgpu::Features::SHADER_INT64
        | wgpu::Features::SHADER_INT64_ATOMIC_MIN_MAX
        | wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS;
    let (cloud, size) = (clouds::cube(1000), [33, 31]);
    let plain = Gpu::without(int64 | wgpu::Features::SUBGROUP | wgpu::Features::TIMESTAMP_QUERY).unwrap();
    let mut runner = Runner::new(&plain, &cloud, Encoding::Wide, size).unwrap();
    for name in ["just-set", "busy-loop", "racy", "two-pass-32", "hqs", "points"] {
        let method = by_name(name).unwrap();
        check(&plain, &mut runner, method, &cloud, &clouds::overview(size), name);
        assert!(runner.time(method, &clouds::overview(size), 2).unwrap()[0].undivided_secs.is_some());
    }
    let missing = runner.supports(by_name("reduce-early-z").unwrap()).unwrap_err();
    assert!(missing.ends_with("cannot run reduce-early-z: it lacks 64-bit atomic minimum, subgroups"), "{missing}");
    let error = runner.draw(by_name("depth40").unwrap(), &clouds::overview(size)).unwrap_err();
    assert!(matches!(error, MethodError::Unsupported(_)), "{error}");
    let no_subgroups = Gpu::without(wgpu::Features::SUBGROUP).unwrap();
    let missing = no_subgroups.supports(by_name("dedup").unwrap()).unwrap_err();
    assert!(missing.ends_with("it lacks subgroups") || missing.contains("64-bit"), "{missing}");
}

#[test]
fn wrong_input_is_an_error() {
    let Some(gpu) = clouds::gpu() else { return };
    let cloud = clouds::cube(10);
    let new = |cloud: &Cloud, encoding, size| Runner::new(&gpu, cloud, encoding, size).map(|_| ()).unwrap_err();
    let unequal = Cloud { positions: cloud.positions.clone(), colors: vec![0] };
    assert_eq!(
        new(&unequal, Encoding::Wide, [4, 4]).to_string(),
        "10 positions and 1 colours: a cloud has one colour for each position"
    );
    assert!(matches!(new(&cloud, Encoding::Wide, [0, 4]), MethodError::NoPixels(0, 4)));
    assert!(new(&cloud, Encoding::Wide, [1 << 20, 1 << 20]).to_string().contains("choose a smaller --size"));
    let far = Cloud { positions: vec![[i32::MIN; 3], [i32::MAX; 3]], colors: vec![0; 2] };
    assert!(matches!(new(&far, Encoding::Packed, [4, 4]), MethodError::TooWide(TooWide { bits: [32, 32, 32] })));
    let mut runner = Runner::new(&gpu, &cloud, Encoding::Wide, [4, 4]).unwrap();
    let error = runner.draw(by_name("just-set").unwrap(), &clouds::overview([5, 4])).unwrap_err();
    assert_eq!(error.to_string(), "the view is of [5, 4] pixels, the runner of [4, 4]");
}
