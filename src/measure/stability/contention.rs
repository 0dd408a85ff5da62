//! Threads that want the same pixel: how long they wait, and what happens if they don't.

use super::{
    StabilityError,
    experiment::{Claim, Outcome, Role, Setup, largest},
    picture::{Image, Strip},
    scenes::{MILLIMETRES, noise, ratio, share},
};
use crate::{
    measure::stats::quantile,
    methods::{Cloud, Encoding, FrameTime, Gpu, Method, NO_POINT, Runner, by_name, twin},
    render::{Camera, View},
};

const NO_GPU: &str = "there is no GPU here";

fn method(name: &'static str) -> Result<&'static Method, StabilityError> {
    by_name(name).ok_or(StabilityError::NoMethod(name))
}

/// The method of a viewer on this device: with an early test where it has 64-bit atomics.
fn chosen(gpu: &Gpu) -> &'static str {
    let has = |name| by_name(name).is_some_and(|method| gpu.supports(method).is_ok());
    if has("early-z") { "early-z" } else { "two-pass-32" }
}

fn camera() -> Camera {
    Camera { eye: [0.0, -100.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0], fov_y_deg: 60.0, ..Default::default() }
}

/// A frame that is so many times its usual time has exploded.
const EXPLODED: f64 = 2.0;
/// A chosen method may take so many times its usual time.
const STEADY: f64 = 1.3;

/// Time that the frames of a method may take in each scene, about.
const SECS_PER_SCENE: f64 = 3.0;
/// The scenes are timed in turn, so many times: a clock that rises meanwhile rises for all.
const ROUNDS: u32 = 8;

/// What points cost: not clearing and colouring, which take the same time in all scenes; where the passes cannot be
/// told apart, the whole frame.
fn geometry_secs(frame: &FrameTime) -> f64 {
    frame.geometry_secs.iter().sum::<f64>() + frame.undivided_secs.unwrap_or(0.0)
}

/// The claim about one method in one scene, from its times there and its usual ones, seconds. `is_software`: the
/// times are shown, and not judged.
fn judge(role: Role, name: &str, place: &str, times: &[f64], usual: &[f64], is_software: bool) -> Claim {
    let ratio = quantile(times, 0.5) / quantile(usual, 0.5);
    let quantity = format!("time with all points in {place}, in times that of points all over the picture");
    let samples = times.iter().map(|time| time / quantile(usual, 0.5)).collect();
    let claim = match role {
        Role::Fails => Claim::fails(name, &quantity, ratio, EXPLODED, "a device adds to one word one at a time"),
        Role::Holds => Claim::holds(
            name,
            &quantity,
            ratio,
            STEADY,
            "most points are rejected by a plain read, which threads share",
        ),
    };
    let claim = claim.samples(samples);
    if is_software {
        claim.not_counted("a software rasterizer runs a few threads at once, which hardly wait for each other, and its clock is the wall's")
    } else {
        claim
    }
}

/// All points in one pixel, in one tile of 16×16, and all over the picture, in random order of depth.
pub fn one_pixel(setup: &Setup) -> Result<Outcome, StabilityError> {
    let mut outcome = Outcome::default();
    let Some(gpu) = &setup.gpu else {
        outcome.claims.push(Claim::fails("atomic-min, busy-loop", "times", f64::NAN, EXPLODED, "").not_counted(NO_GPU));
        return Ok(outcome);
    };
    let is_software = gpu.is_software();
    let (points, size): (u32, [u32; 2]) = if is_software {
        (setup.pick(20_000, 300_000), [640, 360])
    } else {
        // Four million take an H200 17 µs, of which the dispatch itself is a good part.
        (setup.pick(1_000_000, 16_000_000), [1920, 1080])
    };
    // Per round.
    let frames = setup.pick(1, 8);
    let view = camera().view(&MILLIMETRES, size, 1)?;
    // 115 m of the plane through the target are as high as the picture.
    let pixel = 115_470.0 / f64::from(size[1]);
    let cloud = |side_pixels: [f64; 2]| {
        let place = |k: u32| {
            let along = |stream, side: f64| ((share(k, stream) - 0.5) * side * pixel) as i32;
            // In the middle of the pixel to the right of and below the centre.
            let middle = (0.5 * pixel) as i32;
            [along(1, side_pixels[0]) + middle, (noise(k, 3) % 2000) as i32, along(2, side_pixels[1]) - middle]
        };
        Cloud { positions: (0..points).map(place).collect(), colors: vec![0x80_80_80; points as usize] }
    };
    let [width, height] = size.map(f64::from);
    let scenes =
        [("the picture", [width - 4.0, height - 4.0]), ("a 16×16 tile", [16.0, 16.0]), ("one pixel", [0.5, 0.5])];
    let mut runners = Vec::new();
    for (_, side) in scenes {
        runners.push(Runner::new(gpu, &cloud(side), Encoding::Wide, size)?);
    }
    let ours = chosen(gpu);
    let sides = [
        (Role::Fails, "atomic-min", setup.failing("atomic-min", ours)),
        (Role::Fails, "busy-loop", setup.failing("busy-loop", ours)),
        (Role::Holds, ours, setup.ours("atomic-min", ours)),
    ];
    let mut lines = Vec::new();
    for (role, label, name) in sides {
        let method = method(name)?;
        if let Err(missing) = gpu.supports(method) {
            outcome.notes.push(missing);
            continue;
        }
        let mut give_ups = [0; 3];
        let mut per_round = [0; 3];
        for ((runner, lost), frames_of) in runners.iter_mut().zip(&mut give_ups).zip(&mut per_round) {
            // The second: making pipelines, and a clock that was at rest, are nobody's usual time. A method that takes a
            // second for a frame is not asked for many.
            *lost = runner.draw(method, &view)?.give_ups;
            let second = runner.time(method, &view, 2)?.last().map_or(0.0, geometry_secs);
            let most = SECS_PER_SCENE / f64::from(ROUNDS) / second.max(1e-6);
            *frames_of = most.clamp(1.0, f64::from(frames)) as u32;
        }
        let mut times: [Vec<f64>; 3] = Default::default();
        for _ in 0..ROUNDS {
            for ((runner, times), &frames) in runners.iter_mut().zip(&mut times).zip(&per_round) {
                times.extend(runner.time(method, &view, frames)?.iter().map(geometry_secs));
            }
        }
        let [usual, tile, pixel] = &times;
        lines.push((label, times.iter().zip([0.0, 1.0, 2.0]).map(|(t, x)| (x, quantile(t, 0.5) * 1e3)).collect()));
        let lost = give_ups[1] + give_ups[2];
        match role {
            // Whatever the place, it must hold; to fail, one place is enough.
            Role::Holds => {
                for (times, (place, _)) in [(tile, scenes[1]), (pixel, scenes[2])] {
                    outcome.claims.push(judge(role, label, place, times, usual, is_software));
                }
            }
            // Its turns are bounded, and so is its time.
            Role::Fails if lost > 0 && !is_software => outcome.claims.push(Claim::fails(
                label,
                "points given up with all in a tile, then in one pixel",
                lost as f64,
                1.0,
                "threads that wait for a lock for 4,096 turns give up",
            )),
            Role::Fails => {
                let is_tile = quantile(tile, 0.5) > quantile(pixel, 0.5);
                let (times, (place, _)) = if is_tile { (tile, scenes[1]) } else { (pixel, scenes[2]) };
                outcome.claims.push(judge(role, label, place, times, usual, is_software));
            }
        }
    }
    let what = format!("{points} points, {}×{}: 0 all over the picture, 1 in a tile, 2 in one pixel", size[0], size[1]);
    outcome.chart("Time of drawing where points crowd", &what, "milliseconds, median", lines);
    Ok(outcome)
}

/// A depth test that compares and then writes, with nothing to keep other threads out.
pub fn racy(setup: &Setup) -> Result<Outcome, StabilityError> {
    let mut outcome = Outcome::default();
    let Some(gpu) = &setup.gpu else {
        outcome.claims.push(Claim::fails("racy", "share of wrong pixels", f64::NAN, 0.01, "").not_counted(NO_GPU));
        return Ok(outcome);
    };
    let size = [32, 24];
    let layers: u32 = setup.pick(64, 256);
    let pictures: u32 = setup.pick(3, 10);
    let distance = 100.0;
    let pitch = 2.0 * distance * 30f64.to_radians().tan() / f64::from(size[1]);
    let mut cloud = Cloud::default();
    for pixel in 0..size[0] * size[1] {
        let at = |i: u32, n: u32| ((f64::from(i) + 0.5 - 0.5 * f64::from(n)) * pitch * 1000.0).round() as i32;
        for layer in 0..layers {
            // The nearest first: threads that begin together all find the pixel empty, and the last to write stays.
            cloud.positions.push([at(pixel % size[0], size[0]), layer as i32, at(pixel / size[0], size[1])]);
            // Green in front, red behind.
            let [r, g, b] = if layer == 0 { [70, 160, 90] } else { [200, 60, 50] };
            cloud.colors.push(u32::from_le_bytes([r, g, b, 0]));
        }
    }
    let view: View = camera().view(&MILLIMETRES, size, 1)?;
    let right_name = if gpu.supports(method("atomic-min")?).is_ok() { "atomic-min" } else { "two-pass-32" };
    let truth = twin::draw(method(right_name)?, &cloud, &view, size);
    let covered = truth.point.iter().filter(|&&point| point != NO_POINT).count() as u32;
    let run = |name: &'static str| {
        let mut runner = Runner::new(gpu, &cloud, Encoding::Wide, size)?;
        let (mut wrong, mut worst) = (Vec::new(), None);
        for _ in 0..pictures {
            let drawn = runner.draw(method(name)?, &view)?;
            let differing = drawn.point.iter().zip(&truth.point).filter(|(a, b)| a != b).count() as u32;
            wrong.push(ratio(differing, covered));
            worst = Some(Image::of_drawn(&drawn));
        }
        Ok::<_, StabilityError>((wrong, worst.unwrap_or_else(|| Image::new(size))))
    };
    let failing = run(setup.failing("racy", right_name))?;
    let ours = run(setup.ours("racy", right_name))?;
    let quantity = format!("share of wrong pixels, the most of {pictures} pictures");
    outcome.claims = vec![
        Claim::fails(
            "racy",
            &quantity,
            largest(&failing.0),
            0.01,
            "threads that begin together do not see each other's depth",
        )
        .samples(failing.0),
        Claim::holds(right_name, &quantity, largest(&ours.0), 0.0, "the minimum is one operation").samples(ours.0),
    ];
    outcome.pictures.push(Strip::new(
        &format!("{layers} points in each pixel"),
        vec![("racy", failing.1), (right_name, ours.1), ("truth", Image::of_drawn(&truth))],
    ));
    Ok(outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_judged_on_gpus() {
        let verdict = |role, factor: f64, is_software| {
            let usual = [1.0, 1.1, 0.9];
            let times = usual.map(|time| time * factor);
            judge(role, "m", "one pixel", &times, &usual, is_software).is_true
        };
        assert_eq!(verdict(Role::Fails, 8.0, false), Some(true));
        assert_eq!(verdict(Role::Fails, 1.1, false), Some(false), "then nothing explodes");
        assert_eq!(verdict(Role::Holds, 1.1, false), Some(true));
        assert_eq!(verdict(Role::Holds, 0.5, false), Some(true));
        assert_eq!(verdict(Role::Holds, 1.5, false), Some(false));
        assert_eq!(verdict(Role::Holds, 1.5, true), None);
        assert_eq!(verdict(Role::Fails, 1.1, true), None);
    }
}
