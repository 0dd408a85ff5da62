//! Points of 1, 2, 4 and 8 pixels, in motion and at rest.

use glam::DVec3;

use super::{
    StabilityError,
    experiment::{Claim, Outcome, Setup},
    picture::{Image, Strip},
    scenes::{MILLIMETRES, Scene, ratio, request, share},
};
use crate::{
    measure::converge::VIEWER_POINT_SIZE,
    render::{Camera, CpuBackend, Picture, StoreOptions},
};

const SIZE: [u32; 2] = [240, 180];
const SIZES: [u32; 4] = [1, 2, 4, 8];

/// Rolling ground of 100 m with houses, chequered in fields of 8 m: some 15 pixels wide and 8 high in the picture.
fn chequered(points: u32) -> Scene {
    let town = Scene::town(points);
    let color = |p: &[i32; 3]| {
        let is_dark = (p[0].rem_euclid(16_000) < 8000) != (p[1].rem_euclid(16_000) < 8000);
        if is_dark { [12_000, 16_000, 26_000, 0] } else { [58_000, 50_000, 34_000, 0] }
    };
    let colors = town.positions.iter().map(color).collect();
    // A shuffled file: how it is read plays no part here.
    let mut order: Vec<u32> = (0..points).collect();
    order.sort_by(|&a, &b| share(a, 9).total_cmp(&share(b, 9)));
    let colors: Vec<[u16; 4]> = colors;
    let of = |k: &u32| (town.positions[*k as usize], colors[*k as usize]);
    let (positions, colors) = order.iter().map(of).unzip();
    Scene::new(MILLIMETRES, positions, colors)
}

/// Share of the pixels covered in the truth that the frame leaves empty.
fn holes(frame: &Picture, truth: &Picture) -> f64 {
    let covered = truth.records.iter().filter(|&&record| record >= 0).count() as u32;
    let empty = truth.records.iter().zip(&frame.records).filter(|(t, f)| **t >= 0 && **f < 0).count() as u32;
    ratio(empty, covered)
}

/// Share of the pixels covered in the finest picture that have another colour: of two, so that half is the most.
fn smeared(picture: &Picture, finest: &Picture) -> f64 {
    let covered: Vec<usize> = (0..finest.records.len()).filter(|&i| finest.records[i] >= 0).collect();
    let other = covered.iter().filter(|&&i| picture.rgba[i] != finest.rgba[i]).count() as u32;
    ratio(other, covered.len() as u32)
}

pub fn point_sizes(setup: &Setup) -> Result<Outcome, StabilityError> {
    let scene = chequered(setup.pick(120_000, 300_000));
    let start = scene.camera(SIZE);
    let toward = |share: f64| {
        let (eye, target) = (DVec3::from_array(start.eye), DVec3::from_array(start.target));
        Camera { eye: eye.lerp(target, share).to_array(), ..start }
    };
    let view = scene.view(&start, SIZE, 1)?;
    let finest = {
        let mut progressive = scene.load(CpuBackend::new(None), StoreOptions::default(), &view)?;
        progressive.truth(&request(view, 0))?
    };
    // Holes after a step of 1/60 of the way to the target, by reprojection and a fill of a hundredth; the share of
    // pixels at rest with the wrong colour; and both pictures.
    let measure = |point_size: u32| {
        let view = scene.view(&start, SIZE, point_size)?;
        let mut progressive = scene.load(CpuBackend::new(None), StoreOptions::default(), &view)?;
        progressive.brute_force(&request(view, 0))?;
        let rest = progressive.read()?;
        let moved = scene.view(&toward(1.0 / 60.0), SIZE, point_size)?;
        progressive.frame(&request(moved, scene.len() / 100))?;
        let motion = progressive.read()?;
        let truth = progressive.truth(&request(moved, 0))?;
        Ok::<_, StabilityError>((holes(&motion, &truth), smeared(&rest, &finest), Image::of(&motion), Image::of(&rest)))
    };
    let mut results = Vec::new();
    for size in SIZES {
        results.push((size, measure(size)?));
    }
    let of = |size: u32| results.iter().find(|(s, _)| *s == size).map(|(_, result)| result);
    let value = |size: u32, pick: fn(&(f64, f64, Image, Image)) -> f64| of(size).map_or(f64::NAN, pick);
    let holes_quantity = "share of holes after a step of 1/60 of the way";
    let smear_quantity = "share of pixels at rest with the wrong one of two colours";
    let default = VIEWER_POINT_SIZE;
    let holes_at = |size| value(size, |r| r.0);
    let smear_at = |size| value(size, |r| r.1);
    let mut outcome = Outcome {
        claims: vec![
            Claim::fails(
                "1 px",
                holes_quantity,
                holes_at(setup.failing(1, default)),
                0.1,
                "two neighbours move apart by more than a pixel",
            ),
            Claim::fails(
                "8 px",
                smear_quantity,
                smear_at(setup.failing(8, default)),
                0.3,
                "half means that nothing is left of a pattern of two colours; a field is 8 pixels high",
            ),
            Claim::holds(
                &format!("{default} px"),
                holes_quantity,
                holes_at(setup.ours(1, default)),
                0.08,
                "half of what 1 px leaves, most of it what came into view",
            ),
            Claim::holds(
                &format!("{default} px"),
                smear_quantity,
                smear_at(setup.ours(8, default)),
                0.16,
                "a point reaches one pixel beyond the border of its field, of 8 to 15",
            ),
        ],
        ..Default::default()
    };
    let line = |pick: fn(&(f64, f64, Image, Image)) -> f64| {
        results.iter().map(|(size, result)| (f64::from(*size), pick(result))).collect::<Vec<_>>()
    };
    outcome.chart(
        "Holes in motion",
        "point size, pixels",
        "share of the covered pixels",
        vec![("1/60 of the way", line(|r| r.0))],
    );
    outcome.chart(
        "Detail at rest",
        "point size, pixels",
        "share of pixels with the wrong colour",
        vec![("all points", line(|r| r.1))],
    );
    for (title, pick) in [("In motion", 2), ("At rest", 3)] {
        let image = |(size, result): &(u32, (f64, f64, Image, Image))| {
            (format!("{size} px"), if pick == 2 { result.2.clone() } else { result.3.clone() })
        };
        let mut images: Vec<(String, Image)> = results.iter().map(image).collect();
        if pick == 3 {
            images.push(("truth: the finest picture".into(), Image::of(&finest)));
        }
        outcome.pictures.push(Strip { title: title.into(), images });
    }
    Ok(outcome)
}
