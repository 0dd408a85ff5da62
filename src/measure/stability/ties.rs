//! Points of equal depth, and points that are there twice.

use super::{
    StabilityError,
    experiment::{Claim, Outcome, Setup, gpu_backend, largest},
    picture::{Image, Strip},
    scenes::{MILLIMETRES, Scene, differing, noise, request},
};
use crate::render::{Backend, Camera, CpuBackend, StoreOptions, View};

const SIZE: [u32; 2] = [96, 72];

/// Which of equally near points stays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Tie {
    /// The one that was drawn first: a depth test alone.
    FirstDrawn,
    /// The one in the lowest slot.
    LowestSlot,
}

/// The nearest points per pixel, drawn from `first` on and round the end, as threads may.
fn draw_from(scene: &Scene, view: &View, first: u32, tie: Tie) -> Vec<i64> {
    let mut shown = vec![(f32::INFINITY, i64::MAX); (SIZE[0] * SIZE[1]) as usize];
    for k in (first..scene.len()).chain(0..first) {
        let Some(projected) = view.project(scene.positions[k as usize]) else { continue };
        let [x, y] = projected.corner;
        let pixel = &mut shown[(y * SIZE[0] as i32 + x) as usize];
        let record = i64::from(k);
        let wins_tie = tie == Tie::LowestSlot && projected.depth == pixel.0 && record < pixel.1;
        if projected.depth < pixel.0 || wins_tie {
            *pixel = (projected.depth, record);
        }
    }
    shown.into_iter().map(|(depth, record)| if depth.is_finite() { record } else { -1 }).collect()
}

/// Level ground from straight above, two colours at every place: all depths are equal.
pub fn equal_depths(setup: &Setup) -> Result<Outcome, StabilityError> {
    let points: u32 = setup.pick(20_000, 100_000);
    let place = |k: u32| {
        let k = k - k % 2;
        [(noise(k, 1) % 10_000) as i32 - 5000, (noise(k, 2) % 10_000) as i32 - 5000, 0]
    };
    let color = |k: u32| if k.is_multiple_of(2) { [55_000, 30_000, 20_000, 0] } else { [15_000, 30_000, 55_000, 0] };
    // The two of a place arrive half the file apart.
    let arrival = |k: u32| if k < points / 2 { 2 * k } else { 2 * (k - points / 2) + 1 };
    let order: Vec<u32> = (0..points).map(arrival).collect();
    let scene =
        Scene::new(MILLIMETRES, order.iter().map(|&k| place(k)).collect(), order.iter().map(|&k| color(k)).collect());
    let camera =
        Camera { eye: [0.0, 0.0, 9.0], target: [0.0; 3], up: [0.0, 1.0, 0.0], fov_y_deg: 60.0, ..Default::default() };
    let view = scene.view(&camera, SIZE, 1)?;
    // Pixels that differ from the first run's, in runs that begin elsewhere.
    let starts = [0, points / 2, points / 3, points - 1];
    let in_orders =
        |tie: Tie| -> Vec<Vec<i64>> { starts.iter().map(|&first| draw_from(&scene, &view, first, tie)).collect() };
    let changed =
        |runs: &[Vec<i64>]| -> Vec<f64> { runs[1..].iter().map(|run| f64::from(differing(run, &runs[0]).0)).collect() };
    let failing = in_orders(setup.failing(Tie::FirstDrawn, Tie::LowestSlot));
    let quantity = "pixels that change from run to run, the most";
    let mut outcome = Outcome::default();
    let reason = "whoever comes first stays, and threads come in any order";
    outcome.claims.push(
        Claim::fails("depth test alone", quantity, largest(&changed(&failing)), 1000.0, reason)
            .samples(changed(&failing)),
    );
    let backend_runs = |backends: Vec<Box<dyn Backend>>| {
        let mut runs = Vec::new();
        for backend in backends {
            let options = StoreOptions { insertion_points: 4096, ..Default::default() };
            let mut progressive = scene.load(backend, options, &view)?;
            progressive.brute_force(&request(view, 0))?;
            runs.push(progressive.read()?.records);
        }
        Ok::<_, StabilityError>(runs)
    };
    let cpu = |threads| -> Box<dyn Backend> { Box::new(CpuBackend::new(Some(threads))) };
    let mut ours = vec![("cpu, 1, 2, 3 and 3 threads", backend_runs(vec![cpu(1), cpu(2), cpu(3), cpu(3)])?)];
    if setup.gpu.is_some() {
        ours.push(("gpu, three times", backend_runs(vec![gpu_backend()?, gpu_backend()?, gpu_backend()?])?));
    }
    let mut strip = Vec::new();
    let image = |records: &[i64]| {
        let mut image = Image::new(SIZE);
        for (pixel, record) in image.rgb.iter_mut().zip(records) {
            if let Some(color) = usize::try_from(*record).ok().and_then(|k| scene.colors.get(k)) {
                *pixel = [0, 1, 2].map(|c| (color[c] >> 8) as u8);
            }
        }
        image
    };
    for (i, run) in failing.iter().take(2).enumerate() {
        strip.push((format!("depth test alone, run {}", i + 1), image(run)));
    }
    for (name, runs) in ours {
        let runs = setup.ours(in_orders(Tie::FirstDrawn), runs);
        let changed = changed(&runs);
        let quantity = format!("{quantity} ({name})");
        let reason = "of equally near points the lowest slot wins, and slots follow from the seed";
        strip.push((format!("firstlight, {name}"), image(&runs[0])));
        outcome
            .claims
            .push(Claim::holds("depth, then slot", &quantity, largest(&changed), 0.0, reason).samples(changed));
    }
    strip.push(("truth: the lowest record".into(), image(&draw_from(&scene, &view, 0, Tie::LowestSlot))));
    outcome.pictures.push(Strip { title: "Two colours at every place".into(), images: strip });
    outcome.notes.push("Which of two equal points is the right one is a convention: what counts is that it does not change. The truth's is the order of the file, the store's that of its slots.".into());
    Ok(outcome)
}
