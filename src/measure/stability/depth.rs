//! Two planes a millimetre apart, and depths of 24, 32 and 40 bits.

use super::{
    StabilityError,
    experiment::{Claim, Outcome, Setup},
    picture::{Image, Strip},
    scenes::{MILLIMETRES, noise, ratio},
};
use crate::{
    methods::{Cloud, Drawn, NO_POINT, by_name, twin},
    render::{Camera, View},
};

/// A depth test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Depth {
    /// 24 bits of a depth buffer between a near plane at 0.1 m and a far one at 1,000 km.
    Hyperbolic24,
    /// As a float, without a far plane: the definition of `busy-loop-n`.
    HyperbolicFloat,
    /// A method by its name.
    Method(&'static str),
}

impl Depth {
    fn name(self) -> &'static str {
        match self {
            Depth::Hyperbolic24 => "24-bit hyperbolic",
            Depth::HyperbolicFloat => "float hyperbolic",
            Depth::Method("early-z") => "linear float (early-z)",
            Depth::Method(name) => name,
        }
    }
}

const FRONT: [u8; 3] = [70, 160, 90];
const BACK: [u8; 3] = [200, 60, 50];
const SIZE: [u32; 2] = [48, 36];
const DISTANCES_M: [f64; 3] = [1.0, 1000.0, 100_000.0];

/// A point of either plane in the middle of each pixel; either may come first.
fn planes(distance_m: f64) -> Cloud {
    let pitch = 2.0 * distance_m * 30f64.to_radians().tan() / f64::from(SIZE[1]);
    let mut cloud = Cloud::default();
    for pixel in 0..SIZE[0] * SIZE[1] {
        let at = |i: u32, n: u32| ((f64::from(i) + 0.5 - 0.5 * f64::from(n)) * pitch * 1000.0).round() as i32;
        let (x, z) = (at(pixel % SIZE[0], SIZE[0]), at(pixel / SIZE[0], SIZE[1]));
        let front_first = noise(pixel, 1) % 2;
        for i in 0..2 {
            let is_front = i == front_first;
            cloud.positions.push([x, i32::from(!is_front), z]);
            let [r, g, b] = if is_front { FRONT } else { BACK };
            cloud.colors.push(u32::from_le_bytes([r, g, b, 0]));
        }
    }
    cloud
}

fn draw(setup: &Setup, depth: Depth, cloud: &Cloud, view: &View) -> Result<Drawn, StabilityError> {
    let method = |name| by_name(name).ok_or(StabilityError::NoMethod(name));
    Ok(match depth {
        Depth::Hyperbolic24 => hyperbolic_24(cloud, view),
        // The definition: a busy loop may give up on a GPU, which is another failure.
        Depth::HyperbolicFloat => twin::draw(method("busy-loop-n")?, cloud, view, SIZE),
        Depth::Method(name) => setup.draw(method(name)?, cloud, view, SIZE)?,
    })
}

/// As a depth buffer of fixed-point numbers does it, the first of equal ones staying.
fn hyperbolic_24(cloud: &Cloud, view: &View) -> Drawn {
    let (near, far) = (0.1, 1e6);
    let code = |depth: f32| {
        let share = far / (far - near) * (1.0 - near / f64::from(depth));
        (share.clamp(0.0, 1.0) * f64::from((1 << 24) - 1)).round() as u32
    };
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let mut shown = vec![(u32::MAX, NO_POINT); pixels];
    for (&position, point) in cloud.positions.iter().zip(0..) {
        let Some(projected) = view.project(position) else { continue };
        let [x, y] = projected.corner;
        let pixel = &mut shown[(y * SIZE[0] as i32 + x) as usize];
        if code(projected.depth) < pixel.0 {
            *pixel = (code(projected.depth), point);
        }
    }
    let of = |point: u32| cloud.colors.get(point as usize).map_or([0; 4], |c| (c | 0xff00_0000).to_le_bytes());
    Drawn {
        size: SIZE,
        point: shown.iter().map(|pixel| pixel.1).collect(),
        depth: vec![0.0; pixels],
        rgba: shown.iter().map(|pixel| of(pixel.1)).collect(),
        give_ups: 0,
    }
}

/// Share of the pixels that do not show the front plane.
fn wrong(drawn: &Drawn) -> f64 {
    let right = drawn.rgba.iter().filter(|rgba| rgba[..3] == FRONT).count() as u32;
    1.0 - ratio(right, SIZE[0] * SIZE[1])
}

pub fn planes_apart(setup: &Setup) -> Result<Outcome, StabilityError> {
    let all = [
        Depth::Hyperbolic24,
        Depth::HyperbolicFloat,
        Depth::Method("early-z"),
        Depth::Method("depth40"),
        Depth::Method("depth40-ranges"),
    ];
    let mut outcome = Outcome::default();
    let mut lines: Vec<(&str, Vec<(f64, f64)>)> = all.iter().map(|depth| (depth.name(), Vec::new())).collect();
    let mut far_pictures = Vec::new();
    for distance in DISTANCES_M {
        let cloud = planes(distance);
        let at = |y: f64| [0.0, y, 0.0];
        let camera = Camera {
            eye: at(-distance),
            target: at(distance),
            up: [0.0, 0.0, 1.0],
            fov_y_deg: 60.0,
            ..Default::default()
        };
        let view = camera.view(&MILLIMETRES, SIZE, 1)?;
        let quantity = format!("share of pixels with the plane behind, from {distance} m");
        for (depth, line) in all.iter().zip(&mut lines) {
            let is_hyperbolic = matches!(depth, Depth::Hyperbolic24 | Depth::HyperbolicFloat);
            let instead = if is_hyperbolic {
                setup.failing(*depth, Depth::Method("depth40"))
            } else {
                setup.ours(Depth::Hyperbolic24, *depth)
            };
            let drawn = draw(setup, instead, &cloud, &view)?;
            let share = wrong(&drawn);
            line.1.push((distance.log10(), share));
            let claim = match depth {
                _ if is_hyperbolic && distance > 1.0 => Claim::fails(
                    depth.name(),
                    &quantity,
                    share,
                    0.4,
                    "its step is 0.6 m at 1 km, 6 km at 100 km; ties fall to either plane",
                ),
                _ if is_hyperbolic => Claim::fails(depth.name(), &quantity, share, 0.0, "a step is below 1 µm there")
                    .not_counted("nothing fails at this distance"),
                Depth::Method("early-z") if distance > 10_000.0 => {
                    Claim::holds(depth.name(), &quantity, share, 0.0, "no claim: a float's step is 7.8 mm there")
                        .not_counted(
                            "a float's step is 7.8 mm at this distance: whoever needs a millimetre takes depth40",
                        )
                }
                Depth::Method("early-z") => {
                    Claim::holds(depth.name(), &quantity, share, 0.0, "a float's step is 0.06 mm at 1 km")
                }
                _ => Claim::holds(depth.name(), &quantity, share, 0.0, "its step is 1 mm or less"),
            };
            outcome.claims.push(claim);
            if distance == 1000.0 {
                far_pictures.push((depth.name(), Image::of_drawn(&drawn)));
            }
        }
    }
    let mut truth = Image::new(SIZE);
    truth.rgb.fill(FRONT);
    far_pictures.push(("truth", truth));
    outcome.pictures.push(Strip::new("From 1 km", far_pictures));
    outcome.chart("Two planes 1 mm apart", "log10 of the distance, m", "share of wrong pixels", lines);
    Ok(outcome)
}
