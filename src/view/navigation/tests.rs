use super::*;
use crate::render::ClipBox;

const SIZE: [u32; 2] = [1280, 800];

fn utm_grid() -> Grid {
    Grid { scale: [0.001; 3], origin: [500_000.0, 5_000_000.0, 0.0] }
}

fn town() -> Navigation {
    let bounds = Bounds { min: [500_010.0, 5_000_020.0, 300.0], max: [500_510.0, 5_000_320.0, 380.0] };
    Navigation::new(utm_grid(), &bounds, SIZE)
}

/// The part of the picture that the box's corners span.
fn spanned(n: &Navigation) -> [DVec2; 2] {
    let pixels = box_corners(&n.bounds).map(|corner| pixel(n, corner));
    pixels.into_iter().fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
}

/// Nothing of the scene lies behind the bar, it fills the free picture in one direction, and margins there are alike.
#[test]
fn views_of_all_leave_out_what_is_covered() {
    for projection in [Projection::Perspective, Projection::Orthographic] {
        for (size, covered) in [([1280, 800], 53.0), ([330, 260], 53.0), ([300, 900], 106.0), ([200, 150], 53.0)] {
            for from in [SOUTH_AND_ABOVE, DVec3::Z, -DVec3::Y, DVec3::X, DVec3::new(1.0, -1.0, 1.0)] {
                let mut n = town();
                n.resize(size);
                n.set_projection(projection);
                n.cover(covered);
                n.look_from(from);
                let what = format!("{size:?} {projection:?} from {from}: {:?}", spanned(&n));
                let [low, high] = spanned(&n);
                let free = DVec2::new(n.size.x, n.size.y - covered);
                assert!(low.cmpge(DVec2::ZERO).all() && high.cmple(free).all(), "{what}");
                let filled = (high - low) / free;
                let tight = if filled.x > filled.y { 0 } else { 1 };
                assert!(filled[tight] > 0.9, "{what} fills {filled}");
                assert!((low - (free - high))[tight].abs() < 0.01, "{what}: margins differ");
            }
        }
    }
}

#[test]
fn a_covered_scene_is_the_reason() {
    let mut n = town();
    n.look_from(DVec3::Z);
    assert!(spanned(&n)[1].y < 800.0, "the box fills the width alone");
    n.resize([500, 300]);
    n.look_from(DVec3::Z);
    assert!(spanned(&n)[1].y > 300.0 - 53.0, "without a word of it, some lies behind the bar");
}

/// The pixel that shows `point`.
fn pixel(navigation: &Navigation, point: DVec3) -> DVec2 {
    navigation.locate(point).expect("before the eye").0
}

fn assert_near(a: DVec2, b: DVec2) {
    assert!(a.distance(b) < 1e-3, "{a} is not {b}");
}

fn assert_usable(navigation: &Navigation) {
    let view = navigation.camera.view(&navigation.grid, SIZE, 2).expect("camera");
    for row in [view.row_x, view.row_y, view.row_w] {
        assert!(row.iter().all(|x| x.is_finite()), "{navigation:?}");
    }
}

#[test]
fn the_first_camera_is_that_of_the_headless_picture() {
    let n = town();
    assert_eq!(*n.camera(), Camera::fit(&n.bounds, &n.grid, 1.6));
}

#[test]
fn pixels_agree_with_the_kernels() {
    let mut n = town();
    n.orbit(DVec2::new(77.0, -31.0));
    let view = n.camera.view(&n.grid, SIZE, 1).expect("camera");
    for cursor in [DVec2::new(3.5, 5.5), DVec2::new(640.5, 400.5), DVec2::new(1200.5, 700.5)] {
        let steps = n.grid.steps(n.grab(cursor, Some(300.0)).to_array()).map(|s| s.round() as i32);
        let projected = view.project(steps).expect("visible");
        assert_eq!(projected.corner, [cursor.x as i32, cursor.y as i32]);
        assert!((projected.depth - 300.0).abs() < 0.01, "{}", projected.depth);
    }
}

#[test]
fn fit_shows_all_corners_from_everywhere_and_in_any_window() {
    for size in [[1280, 800], [300, 900], [2000, 100], [1, 1]] {
        for from in [DVec3::Z, -DVec3::Y, DVec3::X, DVec3::new(0.35, -1.0, 0.75)] {
            let mut n = town();
            n.resize(size);
            n.look_from(from);
            for corner in 0..8 {
                let side = |a: usize| if corner >> a & 1 == 0 { n.bounds.min[a] } else { n.bounds.max[a] };
                let at = pixel(&n, DVec3::new(side(0), side(1), side(2)));
                assert!(at.x >= 0.0 && at.x < n.size.x && at.y >= 0.0 && at.y < n.size.y, "{size:?} {from}: {at}");
            }
        }
    }
}

#[test]
fn orbit_keeps_pivot_and_distance() {
    let mut n = town();
    let (target, distance) = (n.camera.target, n.distance());
    for i in 0..2000 {
        n.orbit(DVec2::new(13.0, f64::from(i % 7) * 3.0 - 9.0));
    }
    assert_eq!(n.camera.target, target);
    assert!((n.distance() / distance - 1.0).abs() < 1e-6, "{} of {distance}", n.distance());
    assert_near(pixel(&n, DVec3::from_array(target)), n.size * 0.5);
}

#[test]
fn orbit_keeps_any_point_under_the_cursor_and_at_its_distance() {
    for cursor in [DVec2::new(100.0, 650.0), DVec2::new(1200.0, 30.0)] {
        let mut n = town();
        let (point, distance) = (n.grab(cursor, Some(222.0)), n.distance());
        for i in 0..1000 {
            n.orbit_about(point, DVec2::new(17.0, f64::from(i % 5) * 4.0 - 8.0));
            let (at, depth) = n.locate(point).expect("before the eye");
            assert_near(at, cursor);
            assert!((depth - 222.0).abs() < 1e-5, "{depth}");
        }
        assert!((n.distance() / distance - 1.0).abs() < 1e-6);
        assert!(n.axes().right.z.abs() < 1e-9 && n.axes().up.z > 0.0);
        assert_usable(&n);
    }
}

#[test]
fn looking_around_keeps_the_eye_and_follows_the_hand() {
    let mut n = town();
    let (eye, distance, right) = (n.eye(), n.distance(), n.axes().right);
    n.look_around(DVec2::new(30.0, 0.0));
    assert!(n.axes().forward.dot(right) > 0.0, "the mouse to the right turns to the right");
    let down = n.axes().forward.z;
    n.look_around(DVec2::new(0.0, 30.0));
    assert!(n.axes().forward.z < down, "the mouse down turns down");
    for _ in 0..500 {
        n.look_around(DVec2::new(11.0, 90.0));
    }
    assert_eq!(n.eye(), eye);
    assert!((n.distance() / distance - 1.0).abs() < 1e-6 && n.axes().up.z > -1e-9);
    assert_usable(&n);
}

/// Of a clipped scene all that is left is shown, and as large as that allows.
#[test]
fn standard_views_show_what_a_clipping_box_leaves() {
    let mut n = town();
    n.home();
    let whole = n.distance();
    let (min, size) =
        (DVec3::from_array(n.bounds.min), DVec3::from_array(n.bounds.max) - DVec3::from_array(n.bounds.min));
    let [low, high] = [0.4, 0.6].map(|share| min + size * share);
    n.follow_clip(&Clip { bounds: Some(ClipBox { min: low.into(), max: high.into(), degrees: 0.0 }), slab: None });
    for view in [StandardView::Fit, StandardView::Top, StandardView::Front] {
        n.show(view);
        assert!(n.distance() < 0.4 * whole, "{view:?}: {} of {whole}", n.distance());
        for corner in 0..8 {
            let side = |a: usize| if corner >> a & 1 == 0 { low[a] } else { high[a] };
            let at = pixel(&n, DVec3::new(side(0), side(1), side(2)));
            assert!(at.cmpge(DVec2::ZERO).all() && at.cmplt(n.size).all(), "{view:?}: {at}");
        }
    }
    n.follow_clip(&Clip::default());
    n.home();
    assert_eq!(n.distance(), whole);
}

#[test]
fn every_standard_view_looks_along_its_axis_and_shows_everything() {
    let views = [
        (StandardView::Top, -DVec3::Z),
        (StandardView::Bottom, DVec3::Z),
        (StandardView::Front, DVec3::Y),
        (StandardView::Back, -DVec3::Y),
        (StandardView::Left, DVec3::X),
        (StandardView::Right, -DVec3::X),
        (StandardView::Isometric, DVec3::new(-1.0, 1.0, -1.0).normalize()),
    ];
    for (view, forward) in views {
        let mut n = town();
        n.show(view);
        // Eye and target lie on the grid, so a millimetre of 300 m may be missing.
        assert!(n.axes().forward.distance(forward) < 1e-4, "{view:?}: {}", n.axes().forward);
        for corner in 0..8 {
            let side = |a: usize| if corner >> a & 1 == 0 { n.bounds.min[a] } else { n.bounds.max[a] };
            let at = pixel(&n, DVec3::new(side(0), side(1), side(2)));
            assert!(at.cmpge(DVec2::ZERO).all() && at.cmplt(n.size).all(), "{view:?}: {at}");
        }
        let before = n.axes().forward;
        n.zoom(DVec2::new(9.0, 9.0), 0.1, None);
        n.show(StandardView::Fit);
        assert!(n.axes().forward.distance(before) < 1e-4, "{view:?}: all of it, from the same side");
        n.show(StandardView::Home);
        assert_eq!(*n.camera(), Camera::fit(&n.bounds, &n.grid, 1.6));
    }
}

#[test]
fn a_camera_from_elsewhere_is_taken_if_it_sees_anything() {
    let mut n = town();
    let good = Camera { eye: [500_000.0, 5_000_000.0, 999.0], ..*n.camera() };
    n.set_camera(good);
    assert_eq!(*n.camera(), good);
    let broken = [
        Camera { eye: [f64::NAN; 3], ..good },
        Camera { eye: good.target, ..good },
        Camera { target: [f64::INFINITY; 3], ..good },
        Camera { up: [0.0; 3], ..good },
        Camera { up: [f64::NAN; 3], ..good },
        Camera { fov_y_deg: f64::NAN, ..good },
        Camera { fov_y_deg: 180.0, ..good },
        Camera { eye: [1e300; 3], ..good },
    ];
    for camera in broken {
        n.set_camera(camera);
        assert_eq!(*n.camera(), good, "{camera:?}");
    }
}

#[test]
fn broken_numbers_move_nothing() {
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308];
    for x in bad {
        let mut n = town();
        n.orbit(DVec2::new(x, 0.0));
        n.orbit_about(DVec3::splat(x), DVec2::ONE);
        n.look_around(DVec2::new(0.0, x));
        n.pan(DVec3::splat(x), DVec2::ONE);
        n.pan(DVec3::ZERO, DVec2::splat(x));
        n.zoom(DVec2::splat(x), 0.5, None);
        n.zoom(DVec2::ONE, x, None);
        n.zoom(DVec2::ONE, 0.5, Some(x));
        n.zoom(DVec2::ONE, 1.0 / x, Some(-x));
        n.fly(x, x, x);
        n.center_on(DVec3::splat(x));
        n.look_from(DVec3::splat(x));
        n.look_from(DVec3::ZERO);
        assert_usable(&n);
        assert!(n.axes().right.z.abs() < 1e-6 && n.axes().up.z > -1e-6, "{x}: {n:?}");
    }
}

#[test]
fn orbit_follows_the_hand() {
    let mut n = town();
    let eye = n.eye();
    let near_side = n.eye() + (DVec3::from_array(n.camera.target) - eye) * 0.8;
    let before = pixel(&n, near_side);
    n.orbit(DVec2::new(20.0, 10.0));
    let moved = pixel(&n, near_side) - before;
    assert!(moved.x > 0.0 && moved.y > 0.0, "{moved}");
}

#[test]
fn orbit_stops_at_the_poles_and_keeps_the_horizon_level() {
    let mut n = town();
    for (dy, pole) in [(10_000.0, -1.0), (-50_000.0, 1.0)] {
        for part in 0..10 {
            n.orbit(DVec2::new(f64::from(part) * 5.0, dy / 10.0));
            let axes = n.axes();
            assert!(axes.up.z > -1e-9, "upside down: {axes:?}");
            assert!(axes.right.z.abs() < 1e-9, "the horizon tilts: {}", axes.right);
        }
        assert!((n.axes().forward.z - pole).abs() < 1e-9);
        // At the pole, turning still turns, and the way back is as smooth.
        let right = n.axes().right;
        n.orbit(DVec2::new(400.0, 0.0));
        assert!(n.axes().right.dot(right).abs() < 1e-6, "half the height is a quarter turn");
        n.orbit(DVec2::new(-400.0, 0.0));
        assert!(n.axes().right.distance(right) < 1e-6);
        assert_usable(&n);
    }
}

#[test]
fn orbit_goes_on_from_a_top_view() {
    let mut n = town();
    n.look_from(DVec3::Z);
    let right = n.axes().right;
    n.orbit(DVec2::new(0.0, -100.0));
    assert!(n.axes().right.distance(right) < 1e-9, "the picture must not spin");
    assert!(n.axes().forward.z > -0.99);
}

#[test]
fn pan_keeps_the_grabbed_point_under_the_cursor() {
    for depth in [None, Some(123.4)] {
        let mut n = town();
        let distance = n.distance();
        let grabbed = n.grab(DVec2::new(100.0, 700.0), depth);
        for cursor in [DVec2::new(105.0, 690.0), DVec2::new(900.0, 20.0), DVec2::new(-50.0, 1000.0)] {
            n.pan(grabbed, cursor);
            assert_near(pixel(&n, grabbed), cursor);
        }
        assert!((n.distance() - distance).abs() < 1e-6);
    }
}

#[test]
fn zoom_keeps_the_point_under_the_cursor() {
    for depth in [None, Some(200.0)] {
        let mut n = town();
        let cursor = DVec2::new(1000.0, 150.0);
        let point = n.grab(cursor, depth);
        let before = n.eye().distance(point);
        n.zoom(cursor, 0.5, depth);
        assert_near(pixel(&n, point), cursor);
        assert!((n.eye().distance(point) / before - 0.5).abs() < 1e-9);
        n.zoom(cursor, 3.0, Some((point - n.eye()).dot(n.axes().forward)));
        assert_near(pixel(&n, point), cursor);
    }
}

#[test]
fn panning_again_and_again_does_not_lose_the_scene() {
    for [dx, dy] in [[300.0, 0.0], [-300.0, 0.0], [0.0, 300.0], [0.0, -300.0], [200.0, 200.0]] {
        let mut n = town();
        for _ in 0..200 {
            let grabbed = n.grab(n.size * 0.5, None);
            n.pan(grabbed, n.size * 0.5 + DVec2::new(dx, dy));
        }
        let center = DVec3::from_array(n.bounds.center());
        assert!(n.eye().distance(center) < 8.0 * n.bounds.diagonal(), "{}", n.eye() - center);
        // The way back is open.
        let away = n.eye().distance(center);
        let grabbed = n.grab(n.size * 0.5, None);
        n.pan(grabbed, n.size * 0.5 - DVec2::new(dx, dy));
        assert!(n.eye().distance(center) < away);
    }
}

#[test]
fn zoom_ends_before_numbers_do() {
    let mut n = town();
    for _ in 0..500 {
        n.zoom(DVec2::new(640.0, 400.0), 0.7, None);
        assert_usable(&n);
    }
    let (nearest, farthest) = n.depth_range();
    assert!(n.distance() < 1.01 * nearest, "{}", n.distance());
    for _ in 0..500 {
        n.zoom(DVec2::new(3.0, 4.0), 1.5, None);
        assert_usable(&n);
    }
    assert!(n.distance() > 0.99 * farthest);
    // A surface closer than the nearest pivot does not push the camera away.
    let (n, mut at_wall) = (town(), town());
    at_wall.zoom(DVec2::new(640.0, 400.0), 0.9, Some(0.001));
    assert_eq!(at_wall.camera, n.camera);
}

#[test]
fn a_new_pivot_comes_to_the_middle_and_nothing_turns() {
    let mut n = town();
    let forward = n.axes().forward;
    let point = n.grab(DVec2::new(1000.0, 150.0), Some(250.0));
    n.center_on(point);
    assert_near(pixel(&n, point), n.size * 0.5);
    assert!((n.distance() - 250.0).abs() < 1e-6 && n.axes().forward.distance(forward) < 1e-9);
    assert!(n.locate(n.eye() - forward).is_none(), "behind the eye");
}

#[test]
fn fly_moves_eye_and_pivot_alike() {
    let mut n = town();
    let (eye, distance, forward) = (n.eye(), n.distance(), n.axes().forward);
    n.fly(0.0, 0.5, 0.0);
    assert!((n.eye() - eye).distance(forward * 0.5 * distance) < 1e-6);
    n.fly(0.1, 0.0, 0.2);
    assert!((n.distance() - distance).abs() < 1e-6);
    for _ in 0..100_000 {
        n.fly(0.0, 1e9, 0.0);
    }
    assert_usable(&n);
}

#[test]
fn broken_boxes_still_give_a_camera() {
    let nothing = Bounds { min: [0.0; 3], max: [0.0; 3] };
    let boxes = [
        nothing,
        Bounds { min: [f64::NAN; 3], max: [1.0; 3] },
        Bounds { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] },
        Bounds { min: [f64::MAX; 3], max: [f64::MIN; 3] },
        Bounds { min: [-1e300; 3], max: [1e300; 3] },
        Bounds { min: [1e30; 3], max: [1e30; 3] },
        Bounds { min: [0.0, 0.0, -1e9], max: [0.0, 0.0, 1e9] },
    ];
    for bounds in boxes {
        for grid in [utm_grid(), Grid { scale: [1e-7, 1e-7, 0.01], origin: [7.0, 51.0, 0.0] }] {
            let mut n = Navigation::new(grid, &bounds, [0, 0]);
            n.resize(SIZE);
            assert_usable(&n);
            n.orbit(DVec2::new(10.0, 10.0));
            n.zoom(DVec2::new(10.0, 10.0), 0.5, None);
            let grabbed = n.grab(DVec2::ZERO, None);
            n.pan(grabbed, DVec2::new(400.0, 400.0));
            n.fly(1.0, 1.0, 1.0);
            assert_usable(&n);
        }
    }
}

#[test]
fn segments_are_drawn_as_far_as_they_are_seen() {
    let n = town();
    let [a, b] = [n.grab(DVec2::new(100.0, 200.0), Some(300.0)), n.grab(DVec2::new(900.0, 700.0), Some(200.0))];
    let [at_a, at_b] = n.locate_segment(a, b).expect("before the eye");
    assert_near(at_a, DVec2::new(100.0, 200.0));
    assert_near(at_b, DVec2::new(900.0, 700.0));
    // From the picture to behind the eye: the end is on the way there, and no number is huge.
    let behind = n.eye() - n.axes().forward * 500.0 + n.axes().right * 40.0;
    let [at_a, end] = n.locate_segment(a, behind).expect("one end is seen");
    assert_near(at_a, DVec2::new(100.0, 200.0));
    assert!(end.is_finite() && end.abs().max_element() < 1e4, "{end}");
    let between = pixel(&n, a.lerp(behind, 0.1));
    assert!((between - at_a).perp_dot(end - at_a).abs() < 1e-3 * (end - at_a).length(), "not on the line");
    assert_eq!(n.locate_segment(behind, behind * 2.0 - a), None);
    // Beside the picture, by more than its size.
    let far = [-9_000.0, -8_000.0].map(|x| n.grab(DVec2::new(x, 300.0), Some(300.0)));
    assert_eq!(n.locate_segment(far[0], far[1]), None);
    assert_eq!(n.locate_segment(DVec3::NAN, b), None);
}

/// Every move, without perspective: the same rules.
#[test]
fn moves_without_perspective_keep_the_same_rules() {
    let flat = || {
        let mut n = town();
        n.set_projection(Projection::Orthographic);
        n
    };
    let mut n = flat();
    let (cursor, height) = (DVec2::new(1000.0, 150.0), n.camera.height_at_target());
    assert!(
        (height / town().camera.height_at_target() - 1.0).abs() < 1e-9,
        "the pivot's depth stays as large as it was"
    );

    // Where the scene is: what lies behind the eye is not drawn, and zooming may bring the eye closer.
    let point = n.grab(cursor, None);
    n.zoom(cursor, 0.25, None);
    assert_near(pixel(&n, point), cursor);
    assert!((n.camera.height_at_target() / height - 0.25).abs() < 1e-9);
    n.zoom(cursor, 4.0, None);
    assert_near(pixel(&n, point), cursor);
    assert!((n.camera.height_at_target() / height - 1.0).abs() < 1e-9);

    n.pan(point, DVec2::new(70.0, 600.0));
    assert_near(pixel(&n, point), DVec2::new(70.0, 600.0));
    for i in 0..500 {
        n.orbit_about(point, DVec2::new(17.0, f64::from(i % 5) * 4.0 - 8.0));
        assert_near(pixel(&n, point), DVec2::new(70.0, 600.0));
    }
    assert!((n.camera.height_at_target() / height - 1.0).abs() < 1e-6 && n.axes().right.z.abs() < 1e-9);
    assert_usable(&n);

    // All of the scene is before the eye, and in every standard view in the picture.
    for view in [StandardView::Home, StandardView::Top, StandardView::Left, StandardView::Isometric, StandardView::Fit]
    {
        n.show(view);
        assert_eq!(n.camera.projection, Projection::Orthographic);
        for corner in 0..8 {
            let side = |a: usize| if corner >> a & 1 == 0 { n.bounds.min[a] } else { n.bounds.max[a] };
            let at = pixel(&n, DVec3::new(side(0), side(1), side(2)));
            assert!(at.cmpge(DVec2::ZERO).all() && at.cmplt(n.size).all(), "{view:?}: {at}");
        }
    }

    // Zooming ends before numbers do, both ways, and comes back.
    for factor in [0.7, 1.5, 0.7] {
        for _ in 0..300 {
            n.zoom(DVec2::new(640.0, 400.0), factor, None);
            assert_usable(&n);
        }
    }
    n.home();
    let height = n.camera.height_at_target();
    n.fly(0.0, 0.5, 0.0);
    assert!(n.camera.height_at_target() < height, "flying ahead makes things larger");
    n.look_around(DVec2::new(40.0, 10.0));
    assert_usable(&n);
    let taken = *n.camera();
    n.set_camera(taken);
    assert_eq!(*n.camera(), taken, "a camera that was kept is the same when it comes back");
    n.set_projection(Projection::Perspective);
    assert!((n.camera.height_at_target() / taken.height_at_target() - 1.0).abs() < 1e-9);
    assert_eq!(n.camera.projection, Projection::Perspective);
}

#[test]
fn pixels_without_perspective_agree_with_the_kernels() {
    let mut n = town();
    n.set_projection(Projection::Orthographic);
    n.orbit(DVec2::new(77.0, -31.0));
    let view = n.camera.view(&n.grid, SIZE, 1).expect("camera");
    for cursor in [DVec2::new(3.5, 5.5), DVec2::new(640.5, 400.5), DVec2::new(1200.5, 700.5)] {
        let depth = n.distance() + 10.0;
        let steps = n.grid.steps(n.grab(cursor, Some(depth)).to_array()).map(|s| s.round() as i32);
        let projected = view.project(steps).expect("visible");
        assert_eq!(projected.corner, [cursor.x as i32, cursor.y as i32]);
        assert!((f64::from(projected.depth) - depth).abs() < 0.01, "{} is not {depth}", projected.depth);
    }
}
