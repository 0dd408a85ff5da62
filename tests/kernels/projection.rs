//! `View::project` against a projection in f64 that shares nothing with it: how many points fall into
//! another pixel, and how far their depths are off.

use firstlight::{
    render::{Camera, CameraError, Projection, View},
    scene::{Bounds, Grid},
};

const SIZE: [u32; 2] = [800, 600];
const POINTS: u32 = 200_000;

/// Pixel and depth, straight from the definition: a right-handed look-at camera, image y down,
/// pixel = floor((ndc · 0.5 + 0.5) · size).
fn reference(camera: &Camera, world: [f64; 3]) -> Option<([i32; 2], f64)> {
    let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let unit = |a: [f64; 3]| a.map(|c| c / dot(a, a).sqrt());
    let forward = unit(sub(camera.target, camera.eye));
    let right = unit(cross(forward, camera.up));
    let up = cross(right, forward);
    let at = sub(world, camera.eye);
    let depth = dot(at, forward);
    let tan = (camera.fov_y_deg.to_radians() / 2.0).tan();
    let (width, height) = (f64::from(SIZE[0]), f64::from(SIZE[1]));
    let along = match camera.projection {
        Projection::Perspective => depth,
        Projection::Orthographic => dot(sub(camera.target, camera.eye), forward),
    };
    let x = (dot(at, right) / (along * tan * width / height) * 0.5 + 0.5) * width;
    let y = (dot(at, up) / (along * tan) * -0.5 + 0.5) * height;
    let inside = depth > 0.0 && (0.0..width).contains(&x) && (0.0..height).contains(&y);
    inside.then(|| ([x.floor() as i32, y.floor() as i32], depth))
}

/// A scan of `extent` grid steps at `scale`, centred on `center` (in steps), seen from `eye_steps` away.
#[derive(Clone, Copy)]
struct Case {
    name: &'static str,
    scale: f64,
    origin: [f64; 3],
    center: [i32; 3],
    extent: u32,
    /// From the centre, in steps; fractions put the eye between grid positions.
    eye_steps: [f64; 3],
    /// Pixels that may differ, per million points.
    per_million: f64,
}

const UTM: [f64; 3] = [500_000.0, 5_000_000.0, 300.0];

fn cases() -> Vec<Case> {
    let case = |name, scale, origin, center, extent, eye_steps, per_million| Case {
        name,
        scale,
        origin,
        center,
        extent,
        eye_steps,
        per_million,
    };
    let oblique = [0.3, -1.1, 0.7];
    let from = |distance: f64| oblique.map(|c| c * distance);
    vec![
        case("at the origin", 0.01, [0.0; 3], [0; 3], 100_000, from(1e5), 100.0),
        case("UTM in the offset", 0.001, UTM, [0; 3], 1_000_000, from(1e6), 100.0),
        case("UTM in the integers", 0.01, [0.0; 3], [50_000_000, 500_000_000, 30_000], 100_000, from(1e5), 100.0),
        case("at the integers' end", 0.01, [0.0; 3], [2_147_000_000, -2_147_000_000, 0], 100_000, from(1e5), 100.0),
        case("a statue, eye between positions", 0.001, UTM, [0; 3], 1000, [300.37, -1100.61, 700.123], 100.0),
        // Here the eye's rounding (to 1/4096 of a step) is seen.
        case("a few steps away", 0.001, UTM, [0; 3], 20, [3.37, -21.61, 7.123], 3000.0),
        case("eye far away", 0.001, [0.0; 3], [0; 3], 2_000_000_000, from(4e9), 100.0),
        case("eye within the cloud", 0.01, [0.0; 3], [50_000_000, 500_000_000, 0], 100_000, [0.5, 0.25, 0.75], 100.0),
    ]
}

fn noise(i: u32, k: u32) -> u32 {
    let mut x = i.wrapping_mul(0x9E37_79B9) ^ k.wrapping_mul(0xC2B2_AE35);
    x = (x ^ (x >> 16)).wrapping_mul(0x7FEB_352D);
    x = (x ^ (x >> 15)).wrapping_mul(0x846C_A68B);
    x ^ (x >> 16)
}

/// Points of which one projection has another pixel (or none), of those that any has in the picture;
/// and the largest relative difference of depths beyond what the rounding of the eye explains.
fn compare(
    case: &Case,
    projection: Projection,
    project: impl Fn(&View, [i32; 3]) -> Option<([i32; 2], f32)>,
) -> (u32, u32, f64) {
    let grid = Grid { scale: [case.scale; 3], origin: case.origin };
    let place =
        |steps: [f64; 3]| std::array::from_fn(|a| case.origin[a] + case.scale * (f64::from(case.center[a]) + steps[a]));
    let target = if case.eye_steps.iter().all(|c| c.abs() < 1.0) { [5e4, 5e4, 1e3] } else { [0.0; 3] };
    let camera =
        Camera { eye: place(case.eye_steps), target: place(target), up: [0.0, 0.0, 1.0], fov_y_deg: 60.0, projection };
    let view = camera.view(&grid, SIZE, 1).unwrap();
    let (mut seen, mut other, mut depth_error) = (0, 0, 0.0_f64);
    for i in 0..POINTS {
        let position = std::array::from_fn(|a| {
            let offset = i64::from(noise(i, a as u32) % (case.extent + 1)) - i64::from(case.extent / 2);
            (i64::from(case.center[a]) + offset).clamp(i32::MIN.into(), i32::MAX.into()) as i32
        });
        let (ours, theirs) = (project(&view, position), reference(&camera, grid.world(position)));
        seen += u32::from(ours.is_some() || theirs.is_some());
        other += u32::from(ours.map(|p| p.0) != theirs.map(|p| p.0));
        if let (Some(ours), Some(theirs)) = (ours, theirs) {
            let eye_rounding = 3f64.sqrt() / 8192.0 * case.scale;
            let error = (f64::from(ours.1) - theirs.1).abs() - eye_rounding;
            // Without perspective positions are taken from the target: numbers as large as its depth cancel.
            let distance = camera.height_at_target() / (2.0 * 30f64.to_radians().tan());
            let of = if projection == Projection::Perspective { theirs.1 } else { theirs.1.max(distance) };
            depth_error = depth_error.max(error / of);
        }
    }
    (seen, other, depth_error)
}

#[test]
fn agrees_with_f64() {
    let both = [Projection::Perspective, Projection::Orthographic];
    for (case, projection) in cases().into_iter().flat_map(|case| both.map(|projection| (case, projection))) {
        let project = |view: &View, p| view.project(p).map(|p| (p.corner, p.depth));
        let (seen, other, depth_error) = compare(&case, projection, project);
        println!("{}, {projection:?}: {other} of {seen} in another pixel, depth off by {depth_error:.1e}", case.name);
        assert!(seen > POINTS / 20, "{}: {seen} points in the picture", case.name);
        assert!(f64::from(other) < 1.0 + case.per_million * 1e-6 * f64::from(seen), "{}: {other} of {seen}", case.name);
        assert!(depth_error < 5e-7, "{}", case.name);
    }
}

/// What other viewers do: positions rounded to f32 before the eye is subtracted.
#[test]
fn a_projection_of_rounded_coordinates_does_not() {
    let case = &cases()[2];
    let (seen, other, _) = compare(case, Projection::Perspective, |view, p| {
        let rounded = p.map(|c| c as f32 as i32);
        view.project(rounded).map(|p| (p.corner, p.depth))
    });
    println!("rounded: {other} of {seen} points in another pixel");
    assert!(other > seen / 100);
}

/// Kernels subtract the eye's position once where that fits 32 bits, else in halves: the same bits.
#[test]
fn one_subtraction_gives_the_bits_of_two() {
    let grid = Grid { scale: [1.0; 3], origin: [0.0; 3] };
    let at = |eye: [f64; 3]| {
        let target = [eye[0], eye[1] + 1000.0, eye[2]];
        Camera { eye, target, up: [0.0, 0.0, 1.0], fov_y_deg: 60.0, ..Default::default() }.view(&grid, SIZE, 1).unwrap()
    };
    for (eye, low, high, expected) in [
        (0.0, i32::MIN, i32::MAX, true),
        (0.25, i32::MIN, i32::MAX, true),
        (-1.0, 0, i32::MAX - 1, true),
        (-1.0, 0, i32::MAX, false),
        (1.0, i32::MIN + 1, 0, true),
        (1.0, i32::MIN, 0, false),
        (2_147_483_647.0, -1, 100, true),
        (2_147_483_648.0, 0, 100, false),
        (-7e12, 0, 100, false),
    ] {
        assert_eq!(at([eye; 3]).is_near([low; 3], [high; 3]), expected, "{eye}, {low} to {high}");
    }
    for eye in [0.0, 1234.0, -70_000.0, 1.5e9, -1.9e9] {
        let view = at([eye, eye, eye]);
        for i in 0..POINTS {
            // Differences of all sizes, so that many need rounding.
            let difference = noise(i, 0).cast_signed() >> (i % 32);
            let Some(position) = (eye as i32).checked_add(difference) else { continue };
            let high = ((position >> 16) - view.eye_high[0]) as f32;
            let low = ((position & 0xffff) - view.eye_low[0]) as f32;
            assert_eq!((high * 65536.0 + low).to_bits(), (difference as f32).to_bits(), "{position} from {eye}");
        }
    }
}

#[test]
fn degenerate_cameras() {
    let grid = Grid { scale: [0.001; 3], origin: UTM };
    let good = Camera {
        eye: UTM,
        target: [500_010.0, 5_000_000.0, 300.0],
        up: [0.0, 0.0, 1.0],
        fov_y_deg: 60.0,
        ..Default::default()
    };
    let view = |camera: Camera| camera.view(&grid, SIZE, 1);
    assert!(view(good).is_ok());
    assert_eq!(view(Camera { target: good.eye, ..good }), Err(CameraError::NoDirection));
    assert_eq!(view(Camera { eye: [f64::NAN, 0.0, 0.0], ..good }), Err(CameraError::NotFinite("eye")));
    assert_eq!(view(Camera { target: [f64::INFINITY; 3], ..good }), Err(CameraError::NotFinite("target")));
    assert_eq!(view(Camera { up: [f64::NAN; 3], ..good }), Err(CameraError::NotFinite("up")));
    for fov_y_deg in [0.0, -1.0, 180.0, f64::NAN] {
        assert!(matches!(view(Camera { fov_y_deg, ..good }), Err(CameraError::FieldOfView(_))));
    }
    assert!(matches!(view(Camera { eye: [1e300; 3], ..good }), Err(CameraError::TooFar(_))));

    // Views along `up`, without any `up`, and from the point itself: a picture without surprises.
    for up in [[1.0, 0.0, 0.0], [-5.0, 0.0, 0.0], [0.0; 3]] {
        let view = view(Camera { up, ..good }).unwrap();
        let center = view.project([10_000, 0, 0]).expect("the target is in the picture");
        assert!((center.depth - 10.0).abs() < 1e-4);
        assert!((center.corner[0] - 400).abs() <= 1 && (center.corner[1] - 300).abs() <= 1);
        assert_eq!(view.project([0, 0, 0]), None, "a point in the eye is nowhere");
        assert_eq!(view.project([-1, 0, 0]), None, "nor is one behind it");
        for position in [[i32::MAX; 3], [i32::MIN; 3], [i32::MAX, i32::MIN, 0]] {
            if let Some(p) = view.project(position) {
                assert!(p.depth.is_finite() && p.depth > 0.0);
            }
        }
    }
    // The widest and narrowest fields of view.
    for fov_y_deg in [1e-3, 179.999] {
        let center = view(Camera { fov_y_deg, ..good }).unwrap().project([10_000, 0, 0]);
        assert!(center.is_some_and(|p| (p.corner[0] - 400).abs() <= 1));
    }
}

/// Without perspective the eye's distance decides nothing but the depth, however far it is.
#[test]
fn a_far_eye_keeps_the_orthographic_picture() {
    let grid = Grid { scale: [0.001; 3], origin: UTM };
    let near = Camera {
        eye: [UTM[0] + 3.0, UTM[1] - 9.0, UTM[2] + 4.0],
        target: UTM,
        projection: Projection::Orthographic,
        ..Default::default()
    };
    let height = near.height_at_target();
    let of = |camera: &Camera| {
        let view = camera.view(&grid, SIZE, 1).unwrap();
        move |p| view.project(p).map(|p| p.corner)
    };
    let picture = of(&near);
    for share in [1.01, 10.0, 1e4] {
        // As if something lay so far behind the eye.
        let back = [0, 1, 2].map(|a| UTM[a] + share * (near.eye[a] - UTM[a]));
        let far = near.before(&Bounds { min: back, max: back });
        assert!((far.height_at_target() / height - 1.0).abs() < 1e-9, "{share}");
        let (mut seen, mut other) = (0, 0);
        let far_picture = of(&far);
        for i in 0..20_000 {
            let position = [0, 1, 2].map(|a| (noise(i, a) % 4000) as i32 - 2000);
            seen += u32::from(picture(position).is_some());
            other += u32::from(picture(position) != far_picture(position));
        }
        assert!(seen > 10_000 && other < 10, "{share}: {other} of {seen} points in another pixel");
        let view = far.view(&grid, SIZE, 1).unwrap();
        let depth = view.project([0, 0, 0]).expect("the target is in the middle").depth;
        assert!(f64::from(depth) > 10.0 * share, "the target is {depth} from the eye");
    }
    let perspective = Camera { projection: Projection::Perspective, ..near };
    assert_eq!(perspective.before(&Bounds { min: [-1e9; 3], max: [1e9; 3] }), perspective);
    assert_ne!(of(&perspective)([500, 700, 900]), picture([500, 700, 900]));
    // What lies behind the eye is not drawn.
    let behind = grid.steps(near.eye.map(|x| x + 0.0)).map(|s| (1.1 * s) as i32);
    assert_eq!((picture(behind), picture(behind.map(|s| s * 8 / 10)).is_some()), (None, true));
}

#[test]
fn a_fitted_orthographic_camera_shows_all_of_the_box() {
    let grid = Grid { scale: [0.01; 3], origin: [0.0; 3] };
    // A tower, a long street, and a single point.
    for max in [[10.0, 10.0, 300.0], [2000.0, 3.0, 2.0], [0.0; 3]] {
        let bounds = Bounds { min: [0.0; 3], max };
        for from in [[0.35, -1.0, 0.75], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]] {
            let camera = Camera::fit_as(&bounds, &grid, 4.0 / 3.0, from.into(), Projection::Orthographic);
            let view = camera.view(&grid, SIZE, 1).unwrap();
            for corner in 0..8 {
                let position = [0, 1, 2].map(|a| if corner >> a & 1 == 0 { 0 } else { (max[a] * 100.0) as i32 });
                assert!(view.project(position).is_some(), "{max:?} from {from:?}: {position:?} is outside");
            }
        }
    }
}
