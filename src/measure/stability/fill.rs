//! How points that were not visible before come into the picture: clustered fills, and fills that starve.

use glam::DVec3;

use super::{
    StabilityError,
    experiment::{Claim, Outcome, Setup, numbered},
    picture::{Image, Strip},
    scenes::{Scene, differing, ratio, request},
};
use crate::{
    device::{PassTimes, Passes},
    render::{BudgetController, Camera, CpuBackend, FillBudget, Picture, Progressive, Reprojection, StoreOptions},
    store::SlotOrder,
};

const SIZE: [u32; 2] = [160, 120];
/// Side of the tiles in which coverage is counted, pixels.
const TILE: usize = 10;

/// For each tile with at least a quarter of its pixels in the truth: the share of these that the frame covers.
fn tiles(frame: &Picture, truth: &Picture) -> Vec<Option<f64>> {
    let columns = SIZE[0] as usize / TILE;
    let mut counts = vec![[0_u32; 2]; columns * (SIZE[1] as usize / TILE)];
    for (i, (&shown, &right)) in frame.records.iter().zip(&truth.records).enumerate() {
        let (x, y) = (i % SIZE[0] as usize, i / SIZE[0] as usize);
        let tile = &mut counts[y / TILE * columns + x / TILE];
        tile[0] += u32::from(right >= 0 && shown >= 0);
        tile[1] += u32::from(right >= 0);
    }
    let enough = (TILE * TILE / 4) as u32;
    counts.into_iter().map(|[covered, all]| (all >= enough).then(|| ratio(covered, all))).collect()
}

/// An unshuffled buffer against a shuffled one: a sixteenth of the points per frame, under a camera that turns.
pub fn clusters(setup: &Setup) -> Result<Outcome, StabilityError> {
    let scene = Scene::town(setup.pick(60_000, 400_000));
    let camera = scene.camera(SIZE);
    let frames: u32 = 24;
    let budget = scene.len() / 16;
    // Per order: share of the tiles that the first frame leaves empty; per frame of the turn, the share of tiles whose
    // coverage changes by more than a quarter; the first frame.
    let run = |order: SlotOrder| {
        let view = scene.view(&camera, SIZE, 1)?;
        let options = StoreOptions { insertion_points: 4096, order, ..Default::default() };
        let mut progressive = scene.load(CpuBackend::new(None), options, &view)?;
        // What a frame shows of its own points: nothing is left from loading.
        progressive.set_reprojection(Reprojection::Never);
        let seen = scene.view(&camera.turned(90.0), SIZE, 1)?;
        progressive.frame(&request(seen, budget))?;
        let first = progressive.read()?;
        let truth = progressive.truth(&request(seen, budget))?;
        let first_tiles: Vec<f64> = tiles(&first, &truth).into_iter().flatten().collect();
        let empty = first_tiles.iter().filter(|&&share| share == 0.0).count() as f64 / first_tiles.len() as f64;
        progressive.set_reprojection(Reprojection::Always);
        let (mut last, mut flicker) = (None::<Vec<Option<f64>>>, Vec::new());
        for frame in 0..frames {
            let seen = scene.view(&camera.turned(90.0 + 3.0 * f64::from(frame)), SIZE, 1)?;
            progressive.frame(&request(seen, budget))?;
            let picture = progressive.read()?;
            let now = tiles(&picture, &progressive.truth(&request(seen, budget))?);
            if let Some(last) = &last {
                let both = || now.iter().zip(last).filter_map(|(now, last)| Some((*now.as_ref()?, *last.as_ref()?)));
                let changed = both().filter(|(now, last)| (now - last).abs() > 0.25).count();
                flicker.push(changed as f64 / both().count() as f64);
            }
            last = Some(now);
        }
        Ok::<_, StabilityError>((empty, flicker, Image::of(&first), Image::of(&truth)))
    };
    let failing = run(setup.failing(SlotOrder::Arrival, SlotOrder::Shuffled))?;
    let ours = run(setup.ours(SlotOrder::Arrival, SlotOrder::Shuffled))?;
    // The first quarter of the turn still fills the first picture.
    let settled = |flicker: &[f64]| {
        let rest = &flicker[flicker.len() / 4..];
        rest.iter().sum::<f64>() / rest.len() as f64
    };
    let empty = "share of tiles left empty by a sixteenth of the points";
    let flicker = "share of 10×10 tiles whose coverage changes by over a quarter, mean per frame";
    let mut outcome = Outcome {
        claims: vec![
            Claim::fails("file order", empty, failing.0, 0.5, "a sixteenth of the file is a strip of the scene"),
            Claim::fails(
                "file order",
                flicker,
                settled(&failing.1),
                0.05,
                "each tile is filled once in sixteen frames, and thins out between",
            )
            .samples(failing.1.clone()),
            Claim::holds("shuffled", empty, ours.0, 0.02, "a tile of 25 pixels and more has dozens of points"),
            Claim::holds("shuffled", flicker, settled(&ours.1), 0.02, "every frame fills every tile alike")
                .samples(ours.1.clone()),
        ],
        pictures: vec![Strip::new(
            "A sixteenth of the points",
            vec![("file order", failing.2), ("shuffled", ours.2), ("truth: all points", ours.3)],
        )],
        ..Default::default()
    };
    outcome.chart(
        "Flicker under a turning camera",
        "frame",
        "share of tiles",
        vec![("file order", numbered(&failing.1)), ("shuffled", numbered(&ours.1))],
    );
    Ok(outcome)
}

/// A pan across a dense scan with a tiny budget, then rest.
pub fn starvation(setup: &Setup) -> Result<Outcome, StabilityError> {
    let scene = Scene::town(setup.pick(60_000, 300_000));
    let budget = scene.len() / setup.pick(40, 150);
    let bound = scene.len().div_ceil(budget) + 1;
    // After so many frames at rest a picture has not converged, and will not.
    let patience = 2 * bound;
    // So near that the pan brings mostly points into view that were not seen before.
    let whole = scene.camera(SIZE);
    let eye = DVec3::from_array(whole.eye).lerp(DVec3::from_array(whole.target), 0.55);
    let camera = Camera { eye: eye.to_array(), ..whole };
    let pan = |frame: u32| {
        let aside = 4.0 * f64::from(frame.min(12)) - 30.0;
        let along = |p: [f64; 3]| [p[0] + aside, p[1], p[2]];
        Camera { eye: along(camera.eye), target: along(camera.target), ..camera }
    };
    // Frames from the stop to convergence, at most twice the bound; then whether the picture is that of all
    // points; and the share of right pixels per frame.
    let run = |is_shared: bool| {
        let view = scene.view(&camera, SIZE, 2)?;
        let mut progressive: Progressive<CpuBackend> =
            scene.load(CpuBackend::new(None), StoreOptions::default(), &view)?;
        let (mut visible, mut right, mut frames_at_rest, mut last) = (0_u32, Vec::new(), 0, Vec::new());
        for frame in 0..12 + patience {
            let seen = scene.view(&pan(frame), SIZE, 2)?;
            // One budget for both: what reprojection leaves is for the fill.
            let fill = if is_shared { budget.saturating_sub(visible) } else { budget };
            let report = progressive.frame(&request(seen, fill))?;
            let picture = progressive.read()?;
            let mut shown: Vec<i64> = picture.records.iter().copied().filter(|&r| r >= 0).collect();
            shown.sort_unstable();
            shown.dedup();
            visible = shown.len() as u32;
            let truth = progressive.truth(&request(seen, fill))?;
            let (wrong, all) = differing(&picture.records, &truth.records);
            right.push(1.0 - ratio(wrong, all));
            last = vec![Image::of(&picture), Image::of(&truth)];
            if frame >= 12 {
                frames_at_rest += 1;
                if report.is_converged() {
                    break;
                }
            }
        }
        let wrong_at_end = 1.0 - right.last().copied().unwrap_or(0.0);
        Ok::<_, StabilityError>((f64::from(frames_at_rest), wrong_at_end, right, last))
    };
    let failing = run(setup.failing(true, false))?;
    let ours = run(setup.ours(true, false))?;

    // The automatic budget of a device whose other passes alone take three times the target.
    let automatic = |is_shared: bool| {
        let mut controller = BudgetController::default();
        for _ in 0..200 {
            let fill_points = controller.points(FillBudget::Target(0.016), Passes::Depths);
            let fill = f64::from(fill_points) * 2e-8;
            let times = PassTimes { reproject: 0.048, fill, fill_points, ..Default::default() };
            controller.learn(&times, 0.0, 0.016);
        }
        let left = if is_shared {
            0.0_f64.max(0.016 - 0.048) / 2e-8
        } else {
            f64::from(controller.points(FillBudget::Target(0.016), Passes::Depths))
        };
        // A thousand million stand for never.
        (f64::from(scene.len()) / left).ceil().min(1e9)
    };
    let quantity = format!("frames from the stop to convergence (given up after {patience})");
    let mut outcome = Outcome {
        claims: vec![
            Claim::fails(
                "one budget for reprojection and fill",
                &quantity,
                failing.0,
                patience.into(),
                "the visible points alone use the budget up",
            ),
            Claim::fails(
                "one budget for reprojection and fill",
                "share of wrong pixels then",
                failing.1,
                0.001,
                "what came into view during the pan stays missing",
            ),
            Claim::fails(
                "one budget, automatic",
                "frames to convergence if reprojection takes three times the target",
                automatic(setup.failing(true, false)),
                1e6,
                "nothing is left",
            ),
            Claim::holds(
                "a budget of its own for the fill",
                &quantity,
                ours.0,
                bound.into(),
                "⌈points / budget⌉ + 1: every frame tries so many slots that were not tried",
            ),
            Claim::holds(
                "a budget of its own for the fill",
                "share of wrong pixels then",
                ours.1,
                0.0,
                "converged means equal to the picture of all points",
            ),
            Claim::holds(
                "automatic budget",
                "frames to convergence if reprojection takes three times the target",
                automatic(setup.ours(true, false)),
                (f64::from(scene.len()) / 10_000.0).ceil(),
                "⌈points / 10,000⌉: the fill gets half of the target's time at least, and never fewer points than that",
            ),
        ],
        notes: vec![format!("The bound: after the camera stops, ⌈{} / {budget}⌉ + 1 = {bound} frames.", scene.len())],
        ..Default::default()
    };
    let mut strip = Vec::new();
    for (name, pictures) in [("one budget", failing.3), ("own budget", ours.3)] {
        strip.extend(pictures.into_iter().zip([name, "truth"]).map(|(image, name)| (name.to_owned(), image)));
    }
    strip.remove(1);
    outcome.pictures.push(Strip { title: "At the end".into(), images: strip });
    outcome.chart(
        "Right pixels during the pan (12 frames) and at rest",
        "frame",
        "share of pixels",
        vec![("one budget", numbered(&failing.2)), ("a budget of its own for the fill", numbered(&ours.2))],
    );
    Ok(outcome)
}
