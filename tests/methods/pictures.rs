//! The picture of each method against its twin's.

use firstlight::{
    methods::{Arranged, Cloud, Drawn, Encoding, Gpu, Launch, METHODS, Method, NO_POINT, Runner, by_name, twin},
    render::View,
};

use crate::clouds;

pub const ENCODINGS: [Encoding; 2] = [Encoding::Wide, Encoding::Packed];

/// Pixels in which two pictures differ, in depth by more than so many units in the last place.
pub fn differing(a: &Drawn, b: &Drawn, ulps: u32) -> usize {
    assert_eq!(a.size, b.size);
    let same = |i: usize| {
        a.point[i] == b.point[i]
            && a.depth[i].to_bits().abs_diff(b.depth[i].to_bits()) <= ulps
            && a.rgba[i] == b.rgba[i]
    };
    (0..a.point.len()).filter(|&i| !same(i)).count()
}

/// Pixels that may be wrong: none on a processor. Elsewhere float rounding may decide a pixel, where a
/// device fuses multiplication and addition.
fn allowed(gpu: &Gpu, pixels: usize) -> usize {
    if gpu.is_software() { 0 } else { pixels / 1000 + 1 }
}

pub fn check(gpu: &Gpu, runner: &mut Runner, method: &Method, cloud: &Cloud, view: &View, case: &str) -> Drawn {
    let drawn = runner.draw(method, view).unwrap();
    let impossible = twin::impossible(method, cloud, view, &drawn);
    let allowed = allowed(gpu, drawn.point.len());
    assert!(impossible.len() <= allowed, "{case}: {} pixels, the first {:?}", impossible.len(), impossible.first());
    let is_unordered = method.wrong_on_purpose.is_some();
    if !is_unordered && drawn.give_ups == 0 {
        let ulps = if gpu.is_software() { 0 } else { 4 };
        let off = differing(&drawn, &twin::draw(method, cloud, view, drawn.size), ulps);
        assert!(off <= allowed, "{case}: {}: {off} pixels unlike the twin's", method.name);
    }
    drawn
}

/// All methods that run here; the others are named.
pub fn methods(gpu: &Gpu) -> Vec<&'static Method> {
    let is_able = |method: &&Method| gpu.supports(method).map_err(|missing| clouds::skipped(&missing)).is_ok();
    METHODS.iter().filter(is_able).collect()
}

#[test]
fn every_method_equals_its_twin() {
    let Some(gpu) = clouds::gpu() else { return };
    let size = [97, 61];
    for (name, cloud) in [("cube", clouds::cube(30_001)), ("lines", clouds::lines(30_001))] {
        for encoding in ENCODINGS {
            let mut runner = Runner::new(&gpu, &cloud, encoding, size).unwrap();
            for method in methods(&gpu) {
                for (place, view) in [("overview", clouds::overview(size)), ("inside", clouds::inside(size))] {
                    let case = format!("{name}, {encoding:?}, {place}, {}", method.name);
                    let drawn = check(&gpu, &mut runner, method, &cloud, &view, &case);
                    let shown = drawn.point.iter().filter(|&&point| point != NO_POINT).count();
                    assert!(shown > 500, "{case}: only {shown} pixels show a point");
                }
            }
        }
    }
}

/// Sizes around those of a subgroup, a workgroup and a page; also pages that begin within a subgroup.
#[test]
fn sizes_around_groups_and_pages() {
    let Some(gpu) = clouds::gpu() else { return };
    let size = [33, 31];
    for points in [0, 1, 2, 7, 8, 9, 31, 32, 33, 63, 65, 255, 256, 257, 999, 1000, 1001, 4097] {
        let cloud = clouds::cube(points);
        for (encoding, page, launch) in [
            (Encoding::Wide, None, Launch::PLAIN),
            (Encoding::Packed, Some(1000), Launch::tuned(Encoding::Packed)),
            (Encoding::Wide, Some(63), Launch { threads: 128, points: 2, is_spread: true }),
        ] {
            let mut runner = Runner::with_pages(&gpu, &cloud, encoding, size, page).unwrap();
            runner.set_launch(launch);
            assert_eq!(runner.points(), points as u64);
            for method in methods(&gpu) {
                let case = format!("{points} points, {encoding:?}, pages {page:?}, {launch}, {}", method.name);
                check(&gpu, &mut runner, method, &cloud, &clouds::overview(size), &case);
            }
        }
    }
}

/// A cloud is uploaded in pieces of 2²³ points; the second piece once overran the wide encoding's colours.
#[test]
fn a_cloud_of_several_uploads() {
    let Some(gpu) = clouds::gpu() else { return };
    let (cloud, size) = (clouds::cube((1 << 23) + 3), [160, 120]);
    for (encoding, name) in [(Encoding::Wide, "two-pass-32"), (Encoding::Packed, "hqs")] {
        let mut runner = Runner::new(&gpu, &cloud, encoding, size).unwrap();
        check(&gpu, &mut runner, by_name(name).unwrap(), &cloud, &clouds::overview(size), name);
    }
}

/// More than 65,535 workgroups for one page, where a dispatch has rows: only the last points are in the
/// picture, the very last in front. Packed, so that a page of the smallest binding holds them all.
#[test]
fn a_dispatch_of_several_rows() {
    let Some(gpu) = clouds::gpu() else { return };
    let (points, size) = (65_536 * 256, [9, 7]);
    let mut cloud = Cloud { positions: vec![[0, -5000, 0]; points], colors: vec![0x0a_0b_0c; points] };
    for k in 1..=3 {
        cloud.positions[points - k] = [0, k as i32, 0];
    }
    let mut runner = Runner::new(&gpu, &cloud, Encoding::Packed, size).unwrap();
    // The eye is between the two.
    let view = clouds::along_y(size, 0.000_5);
    for (name, launch) in [
        ("early-z", Launch::PLAIN),
        ("reduce", Launch::tuned(Encoding::Packed)),
        ("two-pass-32", Launch::tuned(Encoding::Packed)),
    ] {
        let method = by_name(name).unwrap();
        if gpu.supports(method).is_ok() {
            runner.set_launch(launch);
            let drawn = runner.draw(method, &view).unwrap();
            let shown: Vec<u32> = drawn.point.iter().copied().filter(|&point| point != NO_POINT).collect();
            assert_eq!(shown, [points as u32 - 1], "{name}");
        }
    }
}

#[test]
fn packed_equals_wide_bit_for_bit() {
    let Some(gpu) = clouds::gpu() else { return };
    let size = [64, 48];
    // Boxes of 15 bits on each axis, of 32 + 32 + 0, of none.
    let wide_box = Cloud {
        positions: vec![[i32::MIN, i32::MAX, 7], [i32::MAX, i32::MIN, 7], [0, 5_000, 7], [-300, 4_000, 7]],
        colors: (0..4).map(clouds::color).collect(),
    };
    let one = Cloud { positions: vec![[500, 1000, 50]; 3], colors: (0..3).map(clouds::color).collect() };
    for cloud in [clouds::cube(5_000), wide_box, one] {
        let [mut wide, mut packed] = ENCODINGS.map(|encoding| Runner::new(&gpu, &cloud, encoding, size).unwrap());
        assert_eq!((wide.bytes_per_point(), packed.bytes_per_point()), (16, 8));
        for method in methods(&gpu).into_iter().filter(|method| method.wrong_on_purpose.is_none()) {
            for view in [clouds::overview(size), clouds::inside(size)] {
                let [a, b] = [&mut wide, &mut packed].map(|runner| runner.draw(method, &view).unwrap());
                if a.give_ups + b.give_ups > 0 {
                    // A busy loop on a GPU whose threads wait for each other: what is missing is counted.
                    continue;
                }
                let off = differing(&a, &b, 0);
                assert!(off <= allowed(&gpu, a.point.len()), "{}: {off} pixels differ", method.name);
                assert!(a.point.iter().any(|&point| point != NO_POINT), "{}: something is shown", method.name);
            }
        }
    }
}

/// One runner with one cloud after the other draws what new runners would; unloaded, nothing.
#[test]
fn a_runner_takes_other_clouds() {
    let Some(gpu) = clouds::gpu() else { return };
    let (size, view) = ([64, 48], clouds::overview([64, 48]));
    let few = clouds::lines(501);
    let back: Vec<u32> = (0..3000).rev().collect();
    let cube = clouds::cube(4000);
    for encoding in ENCODINGS {
        let mut runner = Runner::new(&gpu, &few, encoding, size).unwrap();
        for method in methods(&gpu) {
            runner.load(&few).unwrap();
            check(&gpu, &mut runner, method, &few, &view, method.name);
            // In an order that leaves points out: as a cloud that has the rest, turned round.
            runner.load(Arranged { cloud: &cube, order: Some(&back) }).unwrap();
            assert_eq!(runner.points(), 3000);
            let turned = Cloud {
                positions: back.iter().map(|&i| cube.positions[i as usize]).collect(),
                colors: back.iter().map(|&i| cube.colors[i as usize]).collect(),
            };
            check(&gpu, &mut runner, method, &turned, &view, method.name);
            runner.unload().unwrap();
            let nothing = runner.draw(method, &view).unwrap();
            assert!(nothing.point.iter().all(|&point| point == NO_POINT), "{}", method.name);
        }
    }
}

#[test]
fn what_is_behind_the_eye_is_not_shown() {
    let Some(gpu) = clouds::gpu() else { return };
    let size = [40, 30];
    let mut cloud = clouds::cube(3_000);
    // The eye is in the origin and looks along y: all is behind it, or beside.
    for position in &mut cloud.positions {
        position[1] = -position[1].abs();
    }
    let mut runner = Runner::new(&gpu, &cloud, Encoding::Packed, size).unwrap();
    for method in methods(&gpu) {
        let drawn = runner.draw(method, &clouds::along_y(size, 0.0)).unwrap();
        let is_empty = drawn.point.iter().all(|&point| point == NO_POINT)
            && drawn.depth.iter().all(|depth| *depth == f32::INFINITY)
            && drawn.rgba.iter().all(|rgba| *rgba == [0; 4]);
        assert!(is_empty, "{}", method.name);
        let drawn = runner.draw(method, &clouds::along_y(size, 30.0)).unwrap();
        assert!(drawn.point.iter().any(|&point| point != NO_POINT), "{}: from outside something is", method.name);
    }
}

/// The comparison fails on wrong kernels, and on each kind of damage to a right picture.
#[test]
fn comparisons_can_fail() {
    let Some(gpu) = clouds::gpu() else { return };
    let size = [97, 61];
    let (cloud, view) = (clouds::lines(30_001), clouds::overview(size));
    let mut runner = Runner::new(&gpu, &cloud, Encoding::Wide, size).unwrap();
    let nearest = by_name("two-pass-32").unwrap();
    for wrong in ["just-set", "racy", "hqs"] {
        let drawn = runner.draw(by_name(wrong).unwrap(), &view).unwrap();
        assert!(twin::is_possible(nearest, &cloud, &view, &drawn).is_err(), "{wrong} passes for {}", nearest.name);
    }
    let just_set = by_name("just-set").unwrap();
    let right = twin::draw(nearest, &cloud, &view, size);
    assert!(twin::is_possible(just_set, &cloud, &view, &right).is_ok(), "the nearest is among the possible");
    let shown = right.point.iter().position(|&point| point != NO_POINT).unwrap();
    let empty = right.point.iter().position(|&point| point == NO_POINT).unwrap();
    type Damage = fn(&mut Drawn, usize, usize);
    let damages: [(&str, Damage); 5] = [
        ("another point", |drawn, shown, _| drawn.point[shown] = (drawn.point[shown] + 15_000) % 30_001),
        ("another depth", |drawn, shown, _| drawn.depth[shown] *= 1.00001),
        ("another colour", |drawn, shown, _| drawn.rgba[shown][1] ^= 1),
        ("a hole", |drawn, shown, empty| {
            (drawn.point[shown], drawn.depth[shown], drawn.rgba[shown]) =
                (drawn.point[empty], drawn.depth[empty], drawn.rgba[empty]);
        }),
        ("a point too many", |drawn, shown, empty| {
            (drawn.point[empty], drawn.depth[empty], drawn.rgba[empty]) =
                (drawn.point[shown], drawn.depth[shown], drawn.rgba[shown]);
        }),
    ];
    for (what, damage) in damages {
        let mut damaged = right.clone();
        damage(&mut damaged, shown, empty);
        for method in [nearest, just_set] {
            assert!(twin::is_possible(method, &cloud, &view, &damaged).is_err(), "{}: {what}", method.name);
        }
    }
}
