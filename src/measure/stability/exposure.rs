//! Colours of 8 bits in fields of 16, and dark scans of 16 bits.

use super::{
    StabilityError,
    experiment::{Claim, Outcome, Setup},
    picture::{Image, Strip},
    scenes::{MILLIMETRES, Scene, noise, request},
};
use crate::{
    render::{Camera, CpuBackend, FileColor, Picture, StoreOptions, elevation_ramp},
    scene::ColorRule,
};

const SIZE: [u32; 2] = [96, 72];

/// How a viewer decides what the numbers mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Exposure {
    /// As the standard says: 16 bits.
    Always16,
    /// By the first batch: 8 bits if none of its values is above 255.
    FirstBatch,
    /// By all points so far.
    AllSoFar,
}

/// A wall of patches; `store` turns a level of 255 into what the file holds. Its left edge, which comes first, is
/// nearly black.
fn wall(points: u32, store: impl Fn(u8) -> u16) -> (Scene, Vec<[u8; 3]>) {
    let columns = f64::from(points).sqrt().ceil() as u32;
    let mut levels = Vec::new();
    let mut positions = Vec::new();
    for k in 0..points {
        let (column, row) = (k / columns, k % columns);
        let (x, z) = (column * 12_000 / columns, row * 9000 / columns);
        positions.push([x as i32 - 6000, 0, z as i32 - 4500]);
        let patch = x / 2000 * 7 + z / 1500;
        let is_edge = x < 2400;
        let level = |c: u32| if is_edge { 0 } else { 30 + (noise(patch, c) % 170) as u8 };
        levels.push([level(1), level(2), level(3)]);
    }
    let colors = levels.iter().map(|l| [store(l[0]), store(l[1]), store(l[2]), 0]).collect();
    (Scene::new(MILLIMETRES, positions, colors), levels)
}

pub fn exposure(setup: &Setup) -> Result<Outcome, StabilityError> {
    let points = setup.pick(30_000, 120_000);
    let camera =
        Camera { eye: [0.0, -8.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0], fov_y_deg: 60.0, ..Default::default() };
    // What a file holds of a level, and the level that is then right to show.
    let eight = |level: u8| u16::from(level);
    let sixteen = |level: u8| u16::from(level) * 256;
    // A quarter of the light; the edge of the wall is 0 to 255 in 16 bits.
    let dark = |level: u8| u16::from(level) * 64 + 90;
    type Case = (&'static str, fn(u8) -> u16, fn(u16) -> u8, Exposure);
    let cases: [Case; 3] = [
        ("8 bits in fields of 16", eight, |v| v as u8, Exposure::Always16),
        ("16 bits", sixteen, |v| (v >> 8) as u8, Exposure::FirstBatch),
        ("dark 16 bits", dark, |v| (v >> 8) as u8, Exposure::FirstBatch),
    ];
    let mut outcome = Outcome::default();
    for (case, store, right, failing) in cases {
        let (scene, _) = wall(points, store);
        let view = scene.view(&camera, SIZE, 1)?;
        let first = scene.batches(4096).next().map(|batch| batch.stats.rule());
        let options = StoreOptions { insertion_points: 4096, ..Default::default() };
        let mut progressive = scene.load(CpuBackend::new(None), options, &view)?;
        progressive.brute_force(&request(view, 0))?;
        let picture = progressive.read()?;
        let shown_by = |exposure: Exposure| -> Vec<Option<[u8; 3]>> {
            let rule = match exposure {
                Exposure::AllSoFar => None,
                Exposure::Always16 => Some(ColorRule::Rgb16),
                // Nothing but zeros is taken for 8 bits too: the file has colours.
                Exposure::FirstBatch => Some(match first {
                    Some(ColorRule::Rgb16) => ColorRule::Rgb16,
                    _ => ColorRule::Rgb8,
                }),
            };
            recolored(&picture, &scene, rule)
        };
        let truth: Vec<Option<[u8; 3]>> = picture
            .records
            .iter()
            .map(|&record| scene.colors.get(usize::try_from(record).ok()?).map(|&[r, g, b, _]| [r, g, b].map(right)))
            .collect();
        let error = |shown: &[Option<[u8; 3]>]| {
            let pairs = shown.iter().zip(&truth).filter_map(|(s, t)| Some(((*s)?, (*t)?)));
            let errors: Vec<f64> = pairs.flat_map(|(s, t)| [0, 1, 2].map(|c| f64::from(s[c].abs_diff(t[c])))).collect();
            errors.iter().sum::<f64>() / errors.len() as f64
        };
        let (bad, good) =
            (shown_by(setup.failing(failing, Exposure::AllSoFar)), shown_by(setup.ours(failing, Exposure::AllSoFar)));
        let name = if failing == Exposure::Always16 { "always 16 bits" } else { "8 bits by the first batch" };
        let quantity = format!("{case}: mean error of a channel, levels");
        outcome.claims.push(Claim::fails(
            name,
            &quantity,
            error(&bad),
            20.0,
            "black, or the lower bytes: noise that looks blown out",
        ));
        outcome.claims.push(Claim::holds(
            "all points so far",
            &quantity,
            error(&good),
            0.5,
            "what is stored, to the level",
        ));
        let image = |shown: &[Option<[u8; 3]>]| {
            let mut image = Image::new(SIZE);
            image.rgb.iter_mut().zip(shown).for_each(|(pixel, shown)| *pixel = shown.unwrap_or(*pixel));
            image
        };
        outcome
            .pictures
            .push(Strip::new(case, vec![(name, image(&bad)), ("firstlight", image(&good)), ("truth", image(&truth))]));
    }
    outcome.notes.push("A dark 16-bit scan stays dark: its colours are what the file says. One whose values are all 255 or less cannot be told from 8 bits, and is shown as such.".into());
    Ok(outcome)
}

/// The picture's colours, by another rule if one is given.
fn recolored(picture: &Picture, scene: &Scene, rule: Option<ColorRule>) -> Vec<Option<[u8; 3]>> {
    let ramp = elevation_ramp();
    let of = |(&record, &[r, g, b, _]): (&i64, &[u8; 4])| {
        let k = usize::try_from(record).ok()?;
        Some(match rule {
            None => [r, g, b],
            Some(rule) => FileColor::new(0, rule).color(*scene.colors.get(k)?, 0, &ramp),
        })
    };
    picture.records.iter().zip(&picture.rgba).map(of).collect()
}
