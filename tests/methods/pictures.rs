//! The picture of each method against its twin's.

use firstlight::{
    methods::{Cloud, Drawn, Encoding, METHODS, Method, Runner, twin},
    render::View,
};

use crate::clouds;

/// Pixels in which two pictures differ at all.
fn differing(a: &Drawn, b: &Drawn) -> usize {
    assert_eq!(a.size, b.size);
    let same = |i: usize| a.point[i] == b.point[i] && a.depth[i] == b.depth[i] && a.rgba[i] == b.rgba[i];
    (0..a.point.len()).filter(|&i| !same(i)).count()
}

fn check(runner: &mut Runner, method: &Method, cloud: &Cloud, view: &View, case: &str) {
    if let Err(missing) = runner.supports(method) {
        return clouds::skipped(&missing);
    }
    let drawn = runner.draw(method, view).unwrap();
    let possible = twin::is_possible(method, cloud, view, &drawn);
    let off = differing(&drawn, &twin::draw(method, cloud, view, drawn.size));
    eprintln!("{case}: {}: {off} pixels differ, {} give-ups; {possible:?}", method.name, drawn.give_ups);
    if method.wrong_on_purpose.is_none() {
        possible.unwrap();
    }
}

#[test]
fn every_method_equals_its_twin() {
    let Some(gpu) = clouds::gpu() else { return };
    for cloud in [clouds::cube(30_001), clouds::lines(30_001)] {
        let size = [97, 61];
        for encoding in [Encoding::Wide, Encoding::Packed] {
            let mut runner = Runner::new(&gpu, &cloud, encoding, size).unwrap();
            for method in METHODS {
                for view in [clouds::overview(size), clouds::inside(size)] {
                    check(&mut runner, method, &cloud, &view, &format!("{encoding:?}"));
                }
            }
        }
    }
}
