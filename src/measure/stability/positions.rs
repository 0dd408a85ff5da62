//! Coordinates that 32 bits of float cannot hold.

use super::{
    StabilityError,
    experiment::{Claim, Outcome, Setup, largest, numbered},
    picture::{Image, Strip},
    pinhole::{Pinhole, Place, nearest},
    scenes::{Scene, differing, noise, ratio, request, share},
};
use crate::{
    render::{Camera, CpuBackend, INSERTION_POINTS, StoreOptions},
    scene::Grid,
};

/// How a viewer holds a point's position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Positions {
    AbsoluteF32,
    Integers,
}

/// A survey's false origin, so that coordinates are as in UTM.
const UTM: [f64; 3] = [500_000.0, 5_000_000.0, 300.0];

/// A surface of 0.8 m with points on millimetres, seen from a metre away by a camera that moves a millimetre per frame.
pub fn jitter(setup: &Setup) -> Result<Outcome, StabilityError> {
    let size = [160, 120];
    let frames = setup.pick(60, 120);
    let grid = Grid { scale: [0.001; 3], origin: UTM };
    let points: Vec<[i32; 3]> = (0..setup.pick(300, 3000))
        .map(|k| [(noise(k, 1) % 800) as i32 - 400, (noise(k, 3) % 40) as i32, (noise(k, 2) % 600) as i32 - 300])
        .collect();
    let camera = |frame: u32| {
        let x = UTM[0] + 0.001 * f64::from(frame);
        let at = |y: f64| [x, UTM[1] + y, UTM[2]];
        Camera { eye: at(-1.0), target: at(0.0), up: [0.0, 0.0, 1.0], fov_y_deg: 35.0, ..Default::default() }
    };
    // Where a method sees a point: the middle of its pixel for one that tells only pixels.
    let see = |positions: Positions, frame: u32, point: [i32; 3]| -> Result<Option<Place>, StabilityError> {
        let camera = camera(frame);
        let world = grid.world(point);
        Ok(match positions {
            Positions::AbsoluteF32 => Some(Pinhole::of(&camera, size).place_f32(world.map(|c| c as f32))),
            Positions::Integers => camera.view(&grid, size, 1)?.project(point).map(|p| {
                let [x, y] = p.corner.map(|c| f64::from(c) + 0.5);
                Place { x, y, depth: p.depth.into() }
            }),
        })
    };
    // Per frame, by how many pixels the worst point is off, and by how many the worst one jumps, beyond its true
    // motion. Points within a hundredth of a pixel of a border may fall to either side: the eye is rounded to 1/4096
    // of a millimetre, 0.0001 pixels here.
    let jitter = |positions: Positions| -> Result<[Vec<f64>; 2], StabilityError> {
        let (mut worst, mut jumps) = (Vec::new(), Vec::new());
        let mut last = vec![None::<[f64; 2]>; points.len()];
        for frame in 0..frames {
            let exact = Pinhole::of(&camera(frame), size);
            let (mut farthest, mut jump) = (0.0_f64, 0.0_f64);
            for (&point, last) in points.iter().zip(&mut last) {
                let truth = exact.place(grid.world(point));
                let pixel = truth.pixel(size).filter(|_| truth.border_distance() > 0.01);
                let Some(pixel) = pixel else {
                    *last = None;
                    continue;
                };
                // What is seen nowhere is off by the whole picture.
                let seen = see(positions, frame, point)?.filter(|seen| seen.x.is_finite() && seen.y.is_finite());
                let off = seen.map_or([f64::from(size[0]); 2], |seen| {
                    [seen.x.floor() - pixel[0] as f64, seen.y.floor() - pixel[1] as f64]
                });
                farthest = farthest.max(off[0].abs()).max(off[1].abs());
                if let Some(last) = *last {
                    jump = jump.max((off[0] - last[0]).abs()).max((off[1] - last[1]).abs());
                }
                *last = Some(off);
            }
            worst.push(farthest);
            jumps.push(jump);
        }
        Ok([worst, jumps])
    };
    let (failing, ours) = (
        setup.failing(Positions::AbsoluteF32, Positions::Integers),
        setup.ours(Positions::AbsoluteF32, Positions::Integers),
    );
    let ([f32_off, f32_jumps], [ours_off, ours_jumps]) = (jitter(failing)?, jitter(ours)?);
    let picture = |see: &dyn Fn([i32; 3]) -> Result<Option<Place>, StabilityError>| -> Result<Image, StabilityError> {
        let mut image = Image::new(size);
        for &point in &points {
            let Some(at) = see(point)?.and_then(|place| place.pixel(size)) else { continue };
            image.set(at, [200, (120 + point[0] / 4) as u8, (120 + point[2] / 4) as u8]);
        }
        Ok(image)
    };
    let exact = Pinhole::of(&camera(5), size);
    let quantity = "largest distance from the right pixel, pixels";
    let jump = "largest jump from frame to frame, beyond the true motion, pixels";
    let mut outcome = Outcome {
        claims: vec![
            Claim::fails(
                "absolute f32",
                quantity,
                largest(&f32_off),
                1.0,
                "at 500,000 m an f32 has steps of 3 cm, at 5,000,000 m of 0.5 m; a pixel is 5 mm",
            )
            .samples(f32_off.clone()),
            Claim::holds("integers", quantity, largest(&ours_off), 0.0, "the difference to the eye is exact")
                .samples(ours_off.clone()),
            Claim::fails("absolute f32", jump, largest(&f32_jumps), 2.0, "all points move at once, a step of an f32")
                .samples(f32_jumps.clone()),
            Claim::holds("integers", jump, largest(&ours_jumps), 0.0, "every frame is right, so none jumps")
                .samples(ours_jumps.clone()),
        ],
        pictures: vec![Strip::new(
            "The sixth frame",
            vec![
                ("absolute f32", picture(&|p| see(failing, 5, p))?),
                ("integers", picture(&|p| see(ours, 5, p))?),
                ("truth (f64)", picture(&|p| Ok(Some(exact.place(grid.world(p)))))?),
            ],
        )],
        ..Default::default()
    };
    outcome.chart(
        "Distance of the worst point from its pixel",
        "frame",
        "pixels",
        vec![("absolute f32", numbered(&f32_off)), ("integers", numbered(&ours_off))],
    );
    outcome.chart(
        "Jumps from frame to frame",
        "frame",
        "pixels",
        vec![("absolute f32", numbered(&f32_jumps)), ("integers", numbered(&ours_jumps))],
    );
    Ok(outcome)
}

/// Distance from the origin at which it is moved to the camera.
const SHIFT_AT: f64 = 10_000.0;

/// A flight of 25 km over a strip of points.
pub fn origin_shift(setup: &Setup) -> Result<Outcome, StabilityError> {
    let size = [96, 72];
    let grid = Grid { scale: [0.01; 3], origin: [0.0; 3] };
    let points = setup.pick(8_000, 60_000);
    let frames = 50;
    // Frames that it takes to upload all points again.
    let refill_frames = 10;
    let place = |k| [share(k, 1) * 3e6, (share(k, 2) - 0.5) * 1e5, share(k, 3) * 5e3].map(|c| c as i32);
    let positions: Vec<[i32; 3]> = (0..points).map(place).collect();
    // Red in the west, blue in the east: who shows a place 10 km away shows another colour.
    let color = |p: &[i32; 3]| [(60_000 - p[0] / 55) as u16, 30_000, (5_000 + p[0] / 55) as u16, 0];
    let colors = positions.iter().map(color).collect();
    let scene = Scene::new(grid, positions, colors);
    let camera = |frame: u32| {
        let x = 500.0 * f64::from(frame);
        Camera {
            eye: [x, 0.0, 300.0],
            target: [x + 1000.0, 0.0, 0.0],
            up: [0.0, 0.0, 1.0],
            fov_y_deg: 60.0,
            ..Default::default()
        }
    };
    let world = |k: usize| grid.world(scene.positions[k]);
    let truth = |frame: u32| {
        let pinhole = Pinhole::of(&camera(frame), size);
        nearest(size, (0..points as usize).map(|k| (k as i64, pinhole.place(world(k)))))
    };

    // Records shown in each frame, and points that were uploaded again.
    let floating = || {
        let mut origin = [0.0; 3];
        let relative = |k: usize, origin: [f64; 3]| -> [f32; 3] {
            let world = world(k);
            std::array::from_fn(|a| (world[a] - origin[a]) as f32)
        };
        let mut pool: Vec<[f32; 3]> = (0..points as usize).map(|k| relative(k, origin)).collect();
        let mut refilled = pool.len();
        let (mut shown, mut uploads) = (Vec::new(), 0_u64);
        for frame in 0..frames {
            let camera = camera(frame);
            let far: f64 = (0..3).map(|a| (camera.eye[a] - origin[a]).powi(2)).sum::<f64>().sqrt();
            if far >= SHIFT_AT {
                (origin, refilled) = (camera.eye, 0);
            }
            let end = (refilled + pool.len().div_ceil(refill_frames)).min(pool.len());
            for (k, point) in pool.iter_mut().enumerate().take(end).skip(refilled) {
                *point = relative(k, origin);
                uploads += 1;
            }
            refilled = end;
            let to_origin = |p: [f64; 3]| std::array::from_fn(|a| p[a] - origin[a]);
            let moved = Camera { eye: to_origin(camera.eye), target: to_origin(camera.target), ..camera };
            let pinhole = Pinhole::of(&moved, size);
            let places = pool.iter().zip(0..).map(|(&point, record)| (record, pinhole.place_f32(point)));
            shown.push(nearest(size, places));
        }
        Ok::<_, StabilityError>((shown, uploads))
    };
    let integers = || {
        let view = scene.view(&camera(0), size, 1)?;
        let mut progressive = scene.load(CpuBackend::new(None), StoreOptions::default(), &view)?;
        let loaded = progressive.insertions();
        let mut shown = Vec::new();
        for frame in 0..frames {
            progressive.frame(&request(scene.view(&camera(frame), size, 1)?, points))?;
            shown.push(progressive.read()?.records);
        }
        // The only way into the store.
        let uploads = (progressive.insertions() - loaded) * u64::from(INSERTION_POINTS);
        Ok::<_, StabilityError>((shown, uploads))
    };
    let wrong = |shown: &[Vec<i64>]| -> Vec<f64> {
        let of_frame = |(frame, shown): (u32, &Vec<i64>)| {
            let (wrong, all) = differing(shown, &truth(frame));
            ratio(wrong, all)
        };
        (0..).zip(shown).map(of_frame).collect()
    };
    let (failing_shown, failing_uploads) = if setup.failing(true, false) { floating()? } else { integers()? };
    let (ours_shown, ours_uploads) = if setup.ours(true, false) { floating()? } else { integers()? };
    let (failing, ours) = (wrong(&failing_shown), wrong(&ours_shown));
    let stalled = failing.iter().filter(|&&share| share > 0.1).count() as f64;
    let worst_frame = (0..failing.len()).max_by(|&a, &b| failing[a].total_cmp(&failing[b])).unwrap_or(0);
    let image = |records: &[i64]| {
        let mut image = Image::new(size);
        for (pixel, &record) in image.rgb.iter_mut().zip(records) {
            if let Some(color) = usize::try_from(record).ok().and_then(|k| scene.colors.get(k)) {
                *pixel = [0, 1, 2].map(|c| (color[c] >> 8) as u8);
            }
        }
        image
    };
    let quantity = "share of pixels with the wrong point, worst frame";
    let mut outcome = Outcome {
        claims: vec![
            Claim::fails(
                "moving origin",
                quantity,
                largest(&failing),
                0.5,
                "the pool still holds the old origin's numbers",
            )
            .samples(failing.clone()),
            Claim::fails(
                "moving origin",
                "frames with over 10 % wrong",
                stalled,
                4.0,
                "a tenth of the pool is uploaded per frame",
            ),
            Claim::fails(
                "moving origin",
                "points uploaded again",
                failing_uploads as f64,
                f64::from(points),
                "all of them, each time",
            ),
            Claim::holds("integers", quantity, largest(&ours), 0.005, "only rounding at pixel borders, against f64")
                .samples(ours.clone()),
            Claim::holds(
                "integers",
                "points uploaded again",
                ours_uploads as f64,
                0.0,
                "positions do not depend on the camera",
            ),
        ],
        pictures: vec![Strip::new(
            &format!("Frame {worst_frame}: the origin has just moved"),
            vec![
                ("moving origin", image(&failing_shown[worst_frame])),
                ("integers", image(&ours_shown[worst_frame])),
                ("truth (f64)", image(&truth(worst_frame as u32))),
            ],
        )],
        ..Default::default()
    };
    outcome.chart(
        "Wrong pixels along a flight",
        "frame (500 units each)",
        "share of pixels",
        vec![("moving origin", numbered(&failing)), ("integers", numbered(&ours))],
    );
    Ok(outcome)
}
