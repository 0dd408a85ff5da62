//! Clouds without extent, and camera poses without numbers.

use super::{
    StabilityError,
    experiment::{Claim, Outcome, Setup},
    pinhole::Pinhole,
    scenes::{MILLIMETRES, Scene, request},
};
use crate::{
    headless::default_camera,
    render::{Camera, CpuBackend, StoreOptions},
};

const SIZE: [u32; 2] = [64, 48];

fn clouds() -> [(&'static str, Vec<[i32; 3]>); 5] {
    let line = |axis: usize| {
        (0..1000).map(|k| std::array::from_fn(|a| if a == axis { 10 * k } else { 700 })).collect::<Vec<[i32; 3]>>()
    };
    [
        ("one point", vec![[1234, -567, 89]]),
        ("a level line", line(0)),
        ("an upright line", line(2)),
        ("all equal", vec![[-5, 5, 5]; 1000]),
        ("the two ends of the integers", vec![[i32::MIN; 3], [i32::MAX; 3]]),
    ]
}

/// Poses that no camera has, and some that are only odd.
fn poses() -> Vec<(&'static str, Camera)> {
    let good =
        Camera { eye: [0.0, -10.0, 2.0], target: [0.0; 3], up: [0.0, 0.0, 1.0], fov_y_deg: 60.0, ..Default::default() };
    let nan = f64::NAN;
    vec![
        ("eye not a number", Camera { eye: [nan, 0.0, 0.0], ..good }),
        ("target infinite", Camera { target: [f64::INFINITY, 0.0, 0.0], ..good }),
        ("up not a number", Camera { up: [0.0, nan, 1.0], ..good }),
        ("eye = target", Camera { eye: good.target, ..good }),
        ("up along the view", Camera { up: [0.0, -10.0, 2.0], ..good }),
        ("no up", Camera { up: [0.0; 3], ..good }),
        ("field of view 0", Camera { fov_y_deg: 0.0, ..good }),
        ("field of view 180", Camera { fov_y_deg: 180.0, ..good }),
        ("field of view not a number", Camera { fov_y_deg: nan, ..good }),
        ("eye at 1e300", Camera { eye: [1e300; 3], ..good }),
        ("eye within a step of the target", Camera { eye: [0.0, 0.0, 1e-320], ..good }),
    ]
}

/// Whether a viewer that scales the box to a cube of side 1, in f32, has numbers for all points.
fn normalizes(positions: &[[i32; 3]]) -> bool {
    let fold = |pick: fn(f32, f32) -> f32, start: f32| {
        positions.iter().fold([start; 3], |c, p| std::array::from_fn(|a| pick(c[a], p[a] as f32)))
    };
    let (low, high) = (fold(f32::min, f32::INFINITY), fold(f32::max, f32::NEG_INFINITY));
    positions.iter().all(|p| (0..3).all(|a| ((p[a] as f32 - low[a]) / (high[a] - low[a])).is_finite()))
}

/// Whether this program shows the cloud: a camera that works, and a pixel or more, the same ones twice.
fn shows(positions: &[[i32; 3]]) -> Result<bool, StabilityError> {
    let scene = Scene::new(MILLIMETRES, positions.to_vec(), vec![[50_000, 40_000, 30_000, 0]; positions.len()]);
    let first = scene.batches(positions.len()).next();
    let camera = default_camera(&scene.facts, first.as_ref(), SIZE);
    let Ok(view) = scene.view(&camera, SIZE, 1) else { return Ok(false) };
    let mut pictures = Vec::new();
    for _ in 0..2 {
        let mut progressive = scene.load(CpuBackend::new(None), StoreOptions::default(), &view)?;
        while !progressive.frame(&request(view, 10_000))?.is_converged() {}
        pictures.push(progressive.read()?);
    }
    let is_shown = pictures[0].records.iter().any(|&record| record >= 0);
    Ok(is_shown && pictures[0] == pictures[1])
}

/// Where cameras that check nothing put a point.
fn is_number_unchecked(camera: &Camera) -> bool {
    let place = Pinhole::of(camera, SIZE).place([0.5, 3.0, 0.25]);
    place.x.is_finite() && place.y.is_finite() && place.depth.is_finite()
}

/// Whether this program refuses a camera, or has numbers for every point that it shows.
fn is_refused_or_finite(camera: &Camera) -> bool {
    let Ok(view) = camera.view(&MILLIMETRES, SIZE, 1) else { return true };
    let rows = [view.row_x, view.row_y, view.row_w].concat();
    let points = [[500, 3000, 250], [0; 3], [i32::MIN; 3], [i32::MAX; 3], [i32::MAX, i32::MIN, 0]];
    let is_inside = |corner: [i32; 2]| (0..2).all(|a| (0..SIZE[a] as i32).contains(&corner[a]));
    let mut seen = points.iter().filter_map(|&point| view.project(point));
    rows.iter().all(|v| v.is_finite()) && seen.all(|p| p.depth.is_finite() && p.depth > 0.0 && is_inside(p.corner))
}

pub fn degenerate(setup: &Setup) -> Result<Outcome, StabilityError> {
    let (clouds, poses) = (clouds(), poses());
    let mut notes = Vec::new();
    let mut count_clouds = |is_normalizing: bool| {
        let mut broken = Vec::new();
        for (name, positions) in &clouds {
            if !(if is_normalizing { normalizes(positions) } else { shows(positions)? }) {
                broken.push(*name);
            }
        }
        let method = if is_normalizing { "Scaling to a cube" } else { "Fitting" };
        notes.push(format!(
            "{method} fails for: {}.",
            if broken.is_empty() { "none".into() } else { broken.join(", ") }
        ));
        Ok::<_, StabilityError>(broken.len() as f64)
    };
    let failing_clouds = count_clouds(setup.failing(true, false))?;
    let our_clouds = count_clouds(setup.ours(true, false))?;
    let mut count_poses = |is_unchecked: bool| {
        let is_fine = if is_unchecked { is_number_unchecked } else { is_refused_or_finite };
        let broken: Vec<&str> = poses.iter().filter(|(_, camera)| !is_fine(camera)).map(|pose| pose.0).collect();
        let method = if is_unchecked { "An unchecked camera" } else { "A checked camera" };
        notes.push(format!(
            "{method} gives no numbers for: {}.",
            if broken.is_empty() { "none".into() } else { broken.join(", ") }
        ));
        broken.len() as f64
    };
    let failing_poses = count_poses(setup.failing(true, false));
    let our_poses = count_poses(setup.ours(true, false));
    let clouds_quantity = format!("of {} clouds, those that are not shown, or not twice the same", clouds.len());
    let poses_quantity = format!("of {} poses, those that give no number and no error", poses.len());
    Ok(Outcome {
        claims: vec![
            Claim::fails(
                "box scaled to a cube",
                &clouds_quantity,
                failing_clouds,
                4.0,
                "0 / 0 along an axis without extent",
            ),
            Claim::fails(
                "unchecked camera",
                &poses_quantity,
                failing_poses,
                5.0,
                "directions without length, tangents of nothing",
            ),
            Claim::holds("fit to the grid", &clouds_quantity, our_clouds, 0.0, "nothing is divided by an extent"),
            Claim::holds("CameraError", &poses_quantity, our_poses, 0.0, "an error, or a picture"),
        ],
        notes,
        ..Default::default()
    })
}
