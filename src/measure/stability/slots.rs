//! Slots that published code takes for empty pixels.

use super::{
    StabilityError,
    experiment::{Claim, Outcome, Setup},
    picture::{Image, Strip},
    scenes::{MILLIMETRES, Scene, request},
};
use crate::render::{Backend, Camera, Progressive, Reprojection, StoreOptions, list_visible};

const SIZE: [u32; 2] = [24, 18];
const DISTANCE_M: f64 = 10.0;

/// What a pixel must hold to count as empty.
#[derive(Debug, Clone, Copy)]
enum Empty {
    /// All four bytes of the slot are 0: the slot lies in a texture that is cleared to 0.
    FourBytes,
    /// Its three bytes of colour are 0, whatever the fourth says.
    ThreeBytes,
}

/// Every slot that a 32-bit number can make trouble with.
fn slots() -> Vec<u32> {
    let mut slots = vec![1, 255, 256, 65_535, 65_536, (1 << 24) - 1, (1 << 24) + 1, u32::MAX - 1];
    slots.extend((0..=255).map(|k| k << 24));
    slots
}

fn camera(aside: f64) -> Camera {
    let at = |y: f64| [aside, y, 0.0];
    Camera { eye: at(-DISTANCE_M), target: at(0.0), up: [0.0, 0.0, 1.0], fov_y_deg: 60.0, ..Default::default() }
}

/// A point in the middle of pixel `i`.
fn place(i: u32) -> [i32; 3] {
    let pitch = 2.0 * DISTANCE_M * 30f64.to_radians().tan() / f64::from(SIZE[1]) * 1000.0;
    let at = |i: u32, n: u32| ((f64::from(i) + 0.5 - 0.5 * f64::from(n)) * pitch).round() as i32;
    [at(i % SIZE[0], SIZE[0]), 0, -at(i / SIZE[0], SIZE[1])]
}

pub fn every_slot(setup: &Setup) -> Result<Outcome, StabilityError> {
    let slots = slots();
    let view = camera(0.0).view(&MILLIMETRES, SIZE, 1)?;
    let points: Vec<(u32, [i32; 3])> = slots.iter().zip(0..).map(|(&slot, i)| (slot, place(i))).collect();
    // The slots listed for the next frame.
    let published = |empty: Empty| -> Vec<u32> {
        let is_empty = |slot: u32| {
            let [r, g, b, a] = slot.to_le_bytes();
            [r, g, b] == [0; 3] && (matches!(empty, Empty::ThreeBytes) || a == 0)
        };
        slots.iter().copied().filter(|&slot| !is_empty(slot)).collect()
    };
    let ours = || list_visible(&view, &points);
    let dropped = |listed: &[u32]| slots.iter().filter(|slot| !listed.contains(slot)).count() as f64;
    let picture = |listed: &[u32]| {
        let mut image = Image::new(SIZE);
        for (i, slot) in (0_i64..).zip(&slots) {
            let width = i64::from(SIZE[0]);
            image.set([i % width, i / width], if listed.contains(slot) { [120, 200, 140] } else { [220, 60, 50] });
        }
        image
    };
    let [four, three] = [Empty::FourBytes, Empty::ThreeBytes]
        .map(|empty| if setup.failing(true, false) { published(empty) } else { ours() });
    let kept = if setup.ours(true, false) { published(Empty::ThreeBytes) } else { ours() };
    let quantity = format!("of {} slots, those that are drawn and then not listed", slots.len());
    let mut outcome = Outcome {
        claims: vec![
            Claim::fails(
                "four bytes of 0 are empty",
                &quantity,
                dropped(&four),
                1.0,
                "slot 0 is such a pixel, as the code's own comment says",
            ),
            Claim::fails("three bytes of 0 are empty", &quantity, dropped(&three), 256.0, "every multiple of 2²⁴ is"),
            Claim::holds(
                "all bits set are empty",
                &quantity,
                dropped(&kept),
                0.0,
                "no point gets the last slot, and no depth has its bits",
            ),
        ],
        pictures: vec![Strip::new(
            "A pixel per slot; red: lost in the next frame",
            vec![
                ("four bytes", picture(&four)),
                ("three bytes", picture(&three)),
                ("firstlight", picture(&kept)),
                ("truth", picture(&slots)),
            ],
        )],
        ..Default::default()
    };

    // A scene whose only point is in slot 0, through a whole backend: seen after a move, without any fill.
    let scene = Scene::new(MILLIMETRES, vec![[0; 3]], vec![[60_000, 50_000, 40_000, 0]]);
    for (name, backend) in setup.backends()? {
        let lost = point_zero(&scene, backend, setup.ours(Reprojection::Never, Reprojection::Always))?;
        let quantity = format!("pixels without the only point, in slot 0, after a move and without fill ({name})");
        outcome.claims.push(Claim::holds(
            "all bits set are empty",
            &quantity,
            lost,
            0.0,
            "it is in the list of what was visible",
        ));
    }
    outcome.notes.push(
        "Four bytes are tested by the code named above; three by variants that keep 24 bits of a slot in a pixel's colour. \
         Slots of 2²⁴ and more would take 400 MB of points: they are drawn and listed by the rasterizer's and the index's \
         twins alone, to which tests hold the kernels; slot 0 goes through whole backends."
            .into(),
    );
    Ok(outcome)
}

fn point_zero(scene: &Scene, backend: Box<dyn Backend>, reprojection: Reprojection) -> Result<f64, StabilityError> {
    let mut progressive: Progressive<Box<dyn Backend>> =
        scene.load(backend, StoreOptions::default(), &scene.view(&camera(0.0), SIZE, 1)?)?;
    progressive.set_reprojection(reprojection);
    progressive.frame(&request(scene.view(&camera(0.5), SIZE, 1)?, 0))?;
    let shown = progressive.read()?.records.iter().filter(|&&record| record == 0).count();
    Ok(1.0 - shown as f64)
}
