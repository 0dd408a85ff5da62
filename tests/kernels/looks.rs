//! Projections and sizes of points: in motion every backend draws what the processor's does, and at rest exactly all
//! points, with high-quality shading and without.

use firstlight::{
    render::{
        Backend, Camera, CpuBackend, FillBudget, FrameRequest, MAX_WORLD_PX, Picture, PointWidth, Progressive,
        Projection, Shading,
    },
    scene::{Bounds, Grid},
};

use crate::{
    backends,
    cloud::Cloud,
    convergence::{Session, covered, difference, options},
};

const SIZE: [u32; 2] = [97, 61];

/// Projections and sizes, and how wide the points of the scene may get.
fn cases() -> Vec<(Projection, PointWidth)> {
    use Projection::{Orthographic, Perspective};
    vec![
        (Orthographic, PointWidth::Pixels(1)),
        (Orthographic, PointWidth::Pixels(3)),
        (Orthographic, PointWidth::World(5.0)),
        (Orthographic, PointWidth::World(1e6)),
        // A few pixels, and more the nearer; one pixel nearly everywhere; as wide as any.
        (Perspective, PointWidth::World(5.0)),
        (Perspective, PointWidth::World(0.5)),
        (Perspective, PointWidth::World(1e6)),
    ]
}

fn request(cloud: &Cloud, projection: Projection, size: PointWidth, step: usize, high_quality: bool) -> FrameRequest {
    let camera = Camera { projection, ..cloud.camera_moved(step) }.before(&cloud.facts.bounds);
    let view = camera.view(&cloud.facts.grid, SIZE, size).unwrap();
    FrameRequest { view, fill: FillBudget::Fixed(700), shading: Shading { high_quality, ..Default::default() } }
}

/// Frames of a moving camera while the scene loads.
fn in_motion(session: &mut Session, cloud: &Cloud, request: impl Fn(usize) -> FrameRequest) -> Vec<Picture> {
    let piece = cloud.len() / 6;
    let draw = |step: usize| {
        session.offer(cloud, step * piece..(step + 1) * piece, piece);
        session.frame(&request(step));
        session.read()
    };
    let pictures = (0..6).map(draw).collect();
    session.progressive.end_of_input();
    pictures
}

/// Pixels that differ by more than one level of lighting, whose logarithms devices round as they like, or in a depth by
/// more than a part in a million, as their quotients do (without that, 286 of 5,917 pixels differ on an H100).
fn unlike(a: &Picture, b: &Picture) -> usize {
    let near = |a: [u8; 4], b: [u8; 4]| a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 1);
    let as_far = |a: f32, b: f32| a == b || (a - b).abs() <= 1e-6 * a.abs();
    let same =
        |&p: &usize| a.records[p] == b.records[p] && as_far(a.depth[p], b.depth[p]) && near(a.rgba[p], b.rgba[p]);
    (0..a.records.len()).filter(|p| !same(p)).count()
}

#[test]
fn every_projection_and_size_is_exact() {
    let cloud = Cloud::town(3_000);
    for (case, (projection, size)) in cases().into_iter().enumerate() {
        let mut reference: Option<Vec<Picture>> = None;
        for mut session in Session::all(&cloud, options(777)) {
            let is_high = case % 2 == 1;
            let of = |step| request(&cloud, projection, size, step, is_high);
            let pictures = in_motion(&mut session, &cloud, of);
            let what = format!("{projection:?}, {size:?}");
            let rest = session.assert_exact(&of(5), &what);
            assert!(covered(&rest) > 200, "{what}: {} pixels", covered(&rest));
            let info = session.progressive.backend().info().clone();
            let is_exact = info.api == "cpu" || info.adapter.starts_with("llvmpipe");
            match &reference {
                None => reference = Some(pictures),
                Some(expected) => {
                    for (step, (picture, expected)) in pictures.iter().zip(expected).enumerate() {
                        let off = unlike(picture, expected);
                        let allowed = if is_exact { 0 } else { picture.records.len() / 50 };
                        assert!(!is_exact || picture.depth == expected.depth, "{}, {what}: depths", session.name);
                        assert!(off <= allowed, "{}, {what}: {off} pixels in frame {step}", session.name);
                    }
                    let differ = unlike(&pictures[0], &expected[1]);
                    assert!(differ > 100, "{what}: the comparison can fail");
                }
            }
        }
    }
}

fn draw_all(cloud: &Cloud, request: &FrameRequest) -> Picture {
    let backend: Box<dyn Backend> = Box::new(CpuBackend::new(None));
    let mut session = Session::new("cpu".into(), backend, &cloud.facts, options(65_536));
    session.offer(cloud, 0..cloud.len(), cloud.len());
    session.progressive.end_of_input();
    session.converge(request, |_| ());
    session.brute_force(request)
}

/// A sheet of points straight before the eye: as wide as the definition says, in steps of depth, never below a pixel
/// and never above the limit.
#[test]
fn a_point_is_as_wide_as_it_is_from_there() {
    let grid = Grid { scale: [0.001; 3], origin: [0.0; 3] };
    for projection in [Projection::Perspective, Projection::Orthographic] {
        let camera = Camera { eye: [0.0, -2.0, 0.0], target: [0.0, 0.0, 0.0], projection, ..Default::default() };
        let view = camera.view(&grid, [640, 480], PointWidth::World(0.05)).unwrap();
        let mut widths = std::collections::BTreeSet::new();
        for depth in [0.01, 0.1, 0.5, 0.7, 0.9, 1.0, 1.4, 2.0, 3.0, 8.0, 20.0, 50.0, 1e3, 1e6] {
            let along = if projection == Projection::Perspective { depth } else { 2.0 };
            let pixels = 0.05 * 240.0 / 30f64.to_radians().tan() / along;
            let found = view.project([0, ((depth - 2.0) * 1000.0) as i32, 0]).expect("before the eye").size;
            assert_eq!(found, pixels.round().clamp(1.0, MAX_WORLD_PX.into()) as u32, "{projection:?}, {depth}");
            widths.insert(found);
        }
        let all = if projection == Projection::Perspective { 9 } else { 1 };
        assert!(widths.len() >= all, "{projection:?}: {widths:?}");
    }
}

/// The same integers on grids of 10⁻⁹ to 10⁶ units a step: the same pictures, lighting included, bit for bit, since a
/// power of two rounds nothing.
#[test]
fn no_unit_changes_a_picture() {
    for projection in [Projection::Perspective, Projection::Orthographic] {
        let picture = |power: i32, strength: f32| {
            let cloud = Cloud::town(20_000).with_scale(2f64.powi(power));
            let mut request = request(&cloud, projection, PointWidth::Pixels(2), 3, false);
            request.shading.edl_strength = strength;
            draw_all(&cloud, &request)
        };
        let usual = picture(-10, 0.4);
        for power in [-30, -20, 0, 10, 20] {
            let scaled = picture(power, 0.4);
            let factor = 2f32.powi(power + 10);
            assert!(scaled.rgba == usual.rgba && scaled.records == usual.records, "{projection:?}, 2^{power}");
            assert!(scaled.depth.iter().zip(&usual.depth).all(|(a, b)| *a == b * factor), "{projection:?}, 2^{power}");
        }
        assert!(difference(&usual, &picture(-10, 0.0)).is_some(), "the comparison can fail: there is lighting");
        assert!(difference(&usual, &picture(-10, 0.41)).is_some(), "the comparison can fail: a little less");
    }
}

/// How dark a step of `height` is, seen from above, from so far away that the picture is `across` high.
fn shade(projection: Projection, height: f64, across: f64, eye: f64) -> u8 {
    let step = across / 4000.0;
    let grid = Grid { scale: [step; 3], origin: [0.0; 3] };
    let top = (height / step).round() as i32;
    let mut cloud = Cloud::town(1);
    cloud.replace(
        (0..400)
            .flat_map(|x| (0..400).map(move |y| [x * 10 - 2000, y * 10 - 2000, if x < 200 { top } else { 0 }]))
            .collect(),
    );
    cloud.facts.grid = grid;
    let distance = across / (2.0 * 30f64.to_radians().tan());
    let fov_y_deg = 2.0 * (across / (2.0 * distance * eye)).atan().to_degrees();
    let camera =
        Camera { eye: [0.0, 0.0, distance * eye], up: [0.0, 1.0, 0.0], fov_y_deg, projection, ..Default::default() };
    let view = camera.view(&grid, [200, 200], 1).unwrap();
    let shading = Shading { background: [0; 3], ..Default::default() };
    let lit = FrameRequest { view, fill: FillBudget::Fixed(1_000_000), shading };
    let unlit = FrameRequest { shading: Shading { edl_strength: 0.0, ..shading }, ..lit };
    let (lit, unlit) = (draw_all(&cloud, &lit), draw_all(&cloud, &unlit));
    // The column behind the edge; points have colours at random, so that one alone says little.
    let column =
        |picture: &Picture, x: usize| -> f64 { (20..180).map(|y| f64::from(picture.rgba[y * 200 + x][1])).sum() };
    let darkest = (95..105).map(|x| (255.0 * column(&lit, x) / column(&unlit, x)) as u8);
    darkest.min().unwrap_or(255)
}

/// Without perspective a step is as dark as in a perspective picture of the same height, whatever the unit and however
/// far the eye is; and twice the step is darker.
#[test]
fn orthographic_lighting_is_that_of_perspective() {
    let usual = shade(Projection::Perspective, 4.0, 200.0, 1.0);
    assert!((20..200).contains(&usual), "{usual}");
    for (scale, eye) in [(1e-3, 1.0), (1.0, 1.0), (1e6, 1.0), (1.0, 50.0), (1e-3, 1e4)] {
        let found = shade(Projection::Orthographic, 4.0 * scale, 200.0 * scale, eye);
        assert!(found.abs_diff(usual) <= 6, "{scale}, eye {eye}: {found}, in perspective {usual}");
    }
    let higher = shade(Projection::Orthographic, 8.0, 200.0, 1.0);
    assert!(higher + 10 < usual, "{higher} of {usual}");
    // With the logarithm of depths alone, a far eye would light nothing.
    let flat = shade(Projection::Perspective, 4.0, 200.0, 50.0);
    assert!(flat > 240, "{flat}");
}

/// What is a millimetre away and what is 10⁶ m away, side by side: black at worst, and no colour that is no number.
#[test]
fn lighting_bears_any_range_of_depths() {
    let grid = Grid { scale: [0.001; 3], origin: [0.0; 3] };
    let mut cloud = Cloud::town(1);
    cloud.replace(
        (0..60_000)
            .map(|i: i32| {
                let depth = [1, 1000, 1_000_000, 1_000_000_000][(i % 4) as usize];
                let aside = |k: i32| ((f64::from((i.wrapping_mul(k) >> 3) % 1000) / 1000.0) * f64::from(depth)) as i32;
                [aside(7919), depth, aside(104_729)]
            })
            .collect(),
    );
    cloud.facts.grid = grid;
    cloud.facts.bounds = Bounds { min: [-1e6; 3], max: [1e6; 3] };
    for projection in [Projection::Perspective, Projection::Orthographic] {
        for strength in [0.4, 100.0] {
            // All lie within the cone of a perspective camera; in the other picture, some.
            let target = [0.0, if projection == Projection::Perspective { 0.002 } else { 2e3 }, 0.0];
            let camera = Camera { eye: [0.0; 3], target, projection, ..Default::default() };
            let view = camera.view(&grid, SIZE, 1).unwrap();
            let shading = Shading { edl_strength: strength, ..Default::default() };
            let request = FrameRequest { view, fill: FillBudget::Fixed(1_000_000), shading };
            let mut pictures = Vec::new();
            for (name, backend) in backends::all() {
                let mut progressive = Progressive::new(backend, options(65_536));
                progressive.open(std::sync::Arc::new(cloud.facts.clone()));
                progressive.offer(cloud.batch(0..cloud.len()));
                progressive.end_of_input();
                let mut session = Session { name, progressive };
                let picture = session.converge(&request, |_| ());
                let is_exact = session.progressive.backend().info().adapter.starts_with("llvmpipe");
                pictures.push((session.name, is_exact, picture));
            }
            let (_, _, first) = &pictures[0];
            assert!(covered(first) > 300, "{} pixels", covered(first));
            for (name, is_exact, picture) in &pictures[1..] {
                let off = unlike(first, picture);
                let allowed = if *is_exact || name.starts_with("cpu") { 0 } else { first.records.len() / 50 };
                assert!(off <= allowed, "{name}, {projection:?}, {strength}: {off} pixels");
            }
        }
    }
}

/// Filled holes are the same on every backend, and leave records and depths alone; and there are some.
#[test]
fn holes_are_filled_alike_and_change_colours_only() {
    let cloud = Cloud::town(9_000);
    for (points, strength) in [(PointWidth::Pixels(1), 0.0), (PointWidth::Pixels(2), 0.4)] {
        let mut reference: Option<Picture> = None;
        for mut session in Session::all(&cloud, options(4096)) {
            session.offer(&cloud, 0..cloud.len(), 3000);
            session.progressive.end_of_input();
            let mut request = request(&cloud, Projection::Perspective, points, 4, false);
            request.shading.edl_strength = strength;
            let open = session.converge(&request, |_| ());
            request.shading.fill_holes = true;
            assert!(session.frame(&request).drawn, "a shading of its own");
            let filled = session.read();
            assert!(filled.records == open.records && filled.depth == open.depth, "{}", session.name);
            let changed: Vec<usize> = (0..open.rgba.len()).filter(|&p| open.rgba[p] != filled.rgba[p]).collect();
            assert!(changed.iter().all(|&p| open.records[p] < 0), "{}: only background is filled", session.name);
            assert!(changed.len() > 50, "{}: {} pixels", session.name, changed.len());
            match &reference {
                None => reference = Some(filled),
                Some(expected) => {
                    let info = session.progressive.backend().info();
                    let is_exact = info.api == "cpu" || info.adapter.starts_with("llvmpipe");
                    let off = unlike(&filled, expected);
                    let allowed = if is_exact { 0 } else { expected.records.len() / 50 };
                    assert!(!is_exact || filled.depth == expected.depth, "{}: depths", session.name);
                    assert!(off <= allowed, "{}: {off} pixels", session.name);
                    assert!(unlike(&open, expected) > 50, "the comparison can fail");
                }
            }
            request.shading.fill_holes = false;
            session.frame(&request);
            assert!(session.read() == open, "{}: switched off, they are open again", session.name);
        }
    }
}
