//! Averages of more fragments than a counter counts.

use super::{
    StabilityError,
    experiment::{Claim, Outcome, Setup},
    picture::{Image, Strip},
    scenes::MILLIMETRES,
};
use crate::{
    methods::{Cloud, by_name},
    render::Camera,
};

const SIZE: [u32; 2] = [24, 18];
/// All fragments of a pixel are of one of two colours, half and half.
const COLORS: [[u8; 3]; 2] = [[240, 150, 40], [200, 110, 20]];
const MEAN: [u8; 3] = [220, 130, 30];

/// Stacks of points straight behind each other, 1 mm apart, a kilometre away: all within 1 % of the front. Every
/// row of pixels has higher stacks.
pub fn many_fragments(setup: &Setup) -> Result<Outcome, StabilityError> {
    let heights: &[u32] = &[250, 1000, 1022, 1024, 1500, 2100, 5000];
    let columns = setup.pick(2, 8);
    let distance = 1000.0;
    let pitch = 2.0 * distance * 30f64.to_radians().tan() / f64::from(SIZE[1]);
    let at = |i: u32, n: u32| ((f64::from(i) + 0.5 - 0.5 * f64::from(n)) * pitch * 1000.0).round() as i32;
    let mut cloud = Cloud::default();
    for (&height, row) in heights.iter().zip(5..) {
        for column in 8..8 + columns {
            for k in 0..height {
                cloud.positions.push([at(column, SIZE[0]), k as i32, -at(row, SIZE[1])]);
                let [r, g, b] = COLORS[k as usize % 2];
                cloud.colors.push(u32::from_le_bytes([r, g, b, 0]));
            }
        }
    }
    let place = |y: f64| [0.0, y, 0.0];
    let camera = Camera {
        eye: place(-distance),
        target: place(distance),
        up: [0.0, 0.0, 1.0],
        fov_y_deg: 60.0,
        ..Default::default()
    };
    let view = camera.view(&MILLIMETRES, SIZE, 1)?;
    // For each height the largest error of a channel, in levels, and the picture.
    let errors = |name: &'static str| {
        let method = by_name(name).ok_or(StabilityError::NoMethod(name))?;
        let drawn = setup.draw(method, &cloud, &view, SIZE)?;
        let errors = (5..).zip(heights).map(|(row, &height)| {
            let pixels = (8..8 + columns).map(|column| drawn.rgba[(row * SIZE[0] + column) as usize]);
            let worst = pixels.flat_map(|rgba| (0..3).map(move |c| rgba[c].abs_diff(MEAN[c]))).max();
            (f64::from(height), f64::from(worst.unwrap_or(u8::MAX)))
        });
        let errors: Vec<(f64, f64)> = errors.collect();
        Ok::<_, StabilityError>((errors, Image::of_drawn(&drawn)))
    };
    let failing = errors(setup.failing("hqs1", "hqs1r"))?;
    let ours = errors(setup.ours("hqs1", "hqs1r"))?;
    let above = |errors: &[(f64, f64)]| -> Vec<f64> { errors.iter().filter(|e| e.0 > 1023.0).map(|e| e.1).collect() };
    let (wrong, least) = (above(&failing.0), above(&failing.0).into_iter().fold(f64::INFINITY, f64::min));
    let all: Vec<f64> = ours.0.iter().map(|e| e.1).collect();
    let mut truth = Image::new(SIZE);
    for row in 5..5 + heights.len() as i64 {
        (8..8 + i64::from(columns)).for_each(|column| truth.set([column, row], MEAN));
    }
    let mut outcome = Outcome {
        claims: vec![
            Claim::fails(
                "hqs1",
                "error of the colour beyond 1,023 fragments, levels, the least",
                least,
                16.0,
                "ten bits of count begin again at 1,024",
            )
            .samples(wrong),
            Claim::holds(
                "hqs1r",
                "error of the colour, levels, the most",
                all.iter().copied().fold(0.0, f64::max),
                1.0,
                "the mean is rounded to a level",
            )
            .samples(all),
        ],
        pictures: vec![Strip::new(
            "Rows of 250, 1,000, 1,022, 1,024, 1,500, 2,100 and 5,000 fragments per pixel",
            vec![("hqs1", failing.1), ("hqs1r", ours.1), ("truth: the mean", truth)],
        )],
        ..Default::default()
    };
    outcome.chart(
        "Error of the mean colour",
        "fragments in a pixel",
        "levels of 255",
        vec![("hqs1", failing.0), ("hqs1r", ours.0)],
    );
    if !setup
        .gpu
        .as_ref()
        .is_some_and(|gpu| ["hqs1", "hqs1r"].iter().filter_map(|n| by_name(n)).all(|m| gpu.supports(m).is_ok()))
    {
        outcome
            .notes
            .push("No device here has 64-bit atomics: the pictures are those of the methods' definitions.".into());
    }
    Ok(outcome)
}
