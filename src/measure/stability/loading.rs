//! Slots that an insertion moves while the list of visible ones names them.

use super::{
    StabilityError,
    experiment::{Claim, Outcome, Setup, largest, numbered},
    picture::{Image, Strip},
    scenes::{Scene, request},
};
use crate::{
    render::{Backend, Progressive, StoreOptions},
    scene::PointBatch,
};

/// Loads a scene batch by batch under a camera that stands still.
pub fn moved_slots(setup: &Setup) -> Result<Outcome, StabilityError> {
    let size = [160, 120];
    let scene = Scene::town(setup.pick(40_000, 200_000));
    let view = scene.view(&scene.camera(size), size, 1)?;
    // Pixels per frame that were covered in the frame before and no longer are; the last frame.
    let run = |backend: Box<dyn Backend>, follows: bool| {
        let mut backend = backend;
        backend.set_relocation(follows);
        let insertion_points = scene.len() / 40;
        let mut progressive = Progressive::new(backend, StoreOptions { insertion_points, ..Default::default() });
        progressive.open(scene.facts.clone());
        let (mut lost, mut last) = (Vec::new(), Vec::<i64>::new());
        let batches: Vec<PointBatch> = scene.batches(insertion_points as usize).collect();
        let mut picture = None;
        for batch in batches {
            progressive.offer(batch);
            // The smallest fill: what is visible must not be found again by chance.
            progressive.frame(&request(view, 1))?;
            let now = progressive.read()?;
            let gone = last.iter().zip(&now.records).filter(|(last, now)| **last >= 0 && **now < 0).count();
            lost.push(gone as f64);
            last.clone_from(&now.records);
            picture = Some(now);
        }
        let truth = progressive.truth(&request(view, 1))?;
        Ok::<_, StabilityError>((lost, picture.as_ref().map(Image::of), Image::of(&truth)))
    };
    let mut outcome = Outcome::default();
    for (i, (name, backend)) in setup.backends()?.into_iter().enumerate() {
        let failing = run(backend, setup.failing(false, true))?;
        let Some((_, backend)) = setup.backends()?.into_iter().nth(i) else { continue };
        let ours = run(backend, setup.ours(false, true))?;
        let quantity = format!("covered pixels lost in a frame of loading, the most ({name})");
        outcome.claims.push(
            Claim::fails(
                "slots as they were",
                &quantity,
                largest(&failing.0),
                100.0,
                "a slot that was taken over shows another point",
            )
            .samples(failing.0.clone()),
        );
        outcome.claims.push(
            Claim::holds(
                "moved_to",
                &quantity,
                largest(&ours.0),
                0.0,
                "the camera stands still, and no point leaves the store",
            )
            .samples(ours.0.clone()),
        );
        if i == 0 {
            outcome.chart(
                "Pixels lost while loading",
                "frame",
                "pixels",
                vec![("slots as they were", numbered(&failing.0)), ("moved_to", numbered(&ours.0))],
            );
            if let (Some(failing_picture), Some(ours_picture)) = (failing.1, ours.1) {
                outcome.pictures.push(Strip::new(
                    "The last frame of loading",
                    vec![
                        ("slots as they were", failing_picture),
                        ("moved_to", ours_picture),
                        ("truth: all points", ours.2),
                    ],
                ));
            }
        }
    }
    Ok(outcome)
}
