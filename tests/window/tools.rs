//! The tools over the picture: a known point's card, a known distance, a clipping box, by mouse and keys.

use std::{path::PathBuf, time::Duration};

use firstlight::{
    render::Camera,
    scene::{Bounds, Grid},
};
use glam::DVec3;

use super::{
    PATIENCE,
    display::{Display, Shot},
    one_at_a_time,
    viewer::Viewer,
};

const GRID: Grid = Grid { scale: [0.01; 3], origin: [637_000.0, 5_412_000.0, 0.0] };
const SIZE: [u32; 2] = [1280, 800];
const POINT_SIZE: u32 = 8;

/// Nine points, 100 m apart, from the south-west on; every number of a record says which it is.
fn points() -> Vec<[i32; 3]> {
    (0..9).map(|i| [25 + 10_000 * (i % 3), 75 + 10_000 * (i / 3), 1_000 + 111 * i]).collect()
}

/// As the header has it: with room in the south and the north, where the window's lines are.
fn bounds() -> Bounds {
    let places = points().into_iter().map(|point| GRID.world(point)).map(|p| Bounds { min: p, max: p });
    let Bounds { mut min, mut max } = places.reduce(|all, one| all.union(&one)).unwrap();
    (min[1], max[1]) = (min[1] - 60.0, max[1] + 60.0);
    Bounds { min, max }
}

/// LAS 1.2, point format 1.
fn scan() -> PathBuf {
    let (points, bounds) = (points(), bounds());
    let mut file = vec![0u8; 227];
    let mut put = |at: usize, bytes: &[u8]| file[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, b"LASF");
    put(24, &[1, 2]);
    put(94, &227u16.to_le_bytes());
    put(96, &227u32.to_le_bytes());
    put(104, &[1]);
    put(105, &28u16.to_le_bytes());
    put(107, &(points.len() as u32).to_le_bytes());
    for axis in 0..3 {
        put(131 + 8 * axis, &GRID.scale[axis].to_le_bytes());
        put(155 + 8 * axis, &GRID.origin[axis].to_le_bytes());
        put(179 + 16 * axis, &bounds.max[axis].to_le_bytes());
        put(187 + 16 * axis, &bounds.min[axis].to_le_bytes());
    }
    for (number, point) in (0u16..).zip(&points) {
        file.extend(point.iter().flat_map(|step| step.to_le_bytes()));
        file.extend((1000 + number).to_le_bytes()); // intensity
        file.extend([0b0000_1001, number as u8, 0, 0]); // returns, class, angle, user data
        file.extend((500 + number).to_le_bytes()); // point source
        file.extend((123_456.789_012 + f64::from(number)).to_le_bytes());
    }
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("window-nine.las");
    std::fs::write(&path, file).unwrap();
    path
}

/// Pixel of a place, seen from above as the window shows it.
fn pixel(place: [f64; 3]) -> [i32; 2] {
    let camera = Camera::fit_from(&bounds(), &GRID, f64::from(SIZE[0]) / f64::from(SIZE[1]), DVec3::Z);
    let view = camera.view(&GRID, SIZE, 1u32).unwrap();
    view.project(GRID.steps(place).map(|step| step.round() as i32)).unwrap().corner
}

/// A window without lines at its edge: a view of all leaves those out, and [`pixel`] knows nothing of them.
fn start<'d>(display: &'d Display) -> Viewer<'d> {
    let settings = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("window-no-bar.json");
    std::fs::write(&settings, r#"{"panel": false, "bar": false}"#).unwrap();
    let (scan, size) = (scan(), POINT_SIZE.to_string());
    let mut viewer = Viewer::start_with(display, &settings, &["--point-size", &size, scan.to_str().unwrap()]);
    viewer.wait_for_line("read 9 points", PATIENCE);
    viewer.wait_for_line("at rest", PATIENCE);
    let rests = viewer.count("at rest");
    viewer.key("7");
    viewer.wait_for_more("at rest", rests, PATIENCE);
    viewer
}

/// The points that are shown; an outline may hide some of their pixels. `all` has the colour that all of them have.
fn shown(shot: &Shot, all: &Shot) -> Vec<usize> {
    let places = points().into_iter().map(|point| pixel(GRID.world(point)).map(|at| at as usize));
    let color = all.at(640, 400);
    let is_shown = |[x, y]: [usize; 2]| {
        let reach = (POINT_SIZE / 2) as usize;
        (y - reach..=y + reach).any(|y| (x - reach..=x + reach).any(|x| shot.at(x, y) == color))
    };
    (0..).zip(places).filter(|(_, place)| is_shown(*place)).map(|(number, _)| number).collect()
}

fn click(viewer: &Viewer, [x, y]: [i32; 2]) {
    viewer.xdotool(&format!("mousemove {x} {y}"));
    viewer.xdotool("click 1");
    // Two clicks in a row are not a double click.
    std::thread::sleep(Duration::from_millis(400));
}

#[test]
fn a_known_point_has_its_card_and_a_known_distance_is_measured() {
    let _turn = one_at_a_time();
    let Some(display) = Display::start() else { return };
    let points = points();
    let at = |number: usize| pixel(GRID.world(points[number]));
    let mut viewer = start(&display);

    // A card, with what the file says, to the last digit.
    click(&viewer, at(5));
    viewer.wait_for_line("card of record 5:", PATIENCE);
    for said in ["637200.25", "5412100.75", "15.55", "123461.789012", "1005", "505"] {
        viewer.wait_for_line(said, PATIENCE);
    }
    viewer.key("ctrl+c");
    viewer.wait_for_line("copied:", PATIENCE);
    viewer.shot_at_rest().save("tools-1-card");
    // Between the points there is nothing to pin.
    click(&viewer, pixel([637_050.0, 5_412_050.0, 12.0]));
    viewer.wait_for_line("no point within", PATIENCE);
    assert_eq!(viewer.count("card of record"), 1);
    viewer.key("Escape");

    // 200 m to the east, 200 m to the north, 8.88 m up.
    viewer.key("m");
    click(&viewer, at(0));
    viewer.xdotool(&format!("mousemove {} {}", at(8)[0], at(8)[1]));
    std::thread::sleep(Duration::from_millis(500));
    viewer.key("space");
    viewer.wait_for_line("measured:", PATIENCE);
    viewer.wait_for_line("282.98", PATIENCE);
    viewer.wait_for_line("282.84", PATIENCE);
    viewer.wait_for_line("8.88", PATIENCE);
    viewer.shot_at_rest().save("tools-2-distance");

    // Along three points, and one back.
    viewer.key("p");
    for number in [0, 2, 8, 6] {
        click(&viewer, at(number));
    }
    viewer.key("BackSpace");
    viewer.key("Return");
    viewer.key("ctrl+c");
    viewer.wait_for_line("400.", PATIENCE);
    viewer.shot_at_rest().save("tools-3-line");

    // The cursor rests on a point, with its coordinates beside it: nothing goes on.
    std::thread::sleep(Duration::from_millis(500));
    let busy = viewer.cpu_time();
    std::thread::sleep(Duration::from_secs(2));
    let busy = viewer.cpu_time() - busy;
    assert!(busy < Duration::from_millis(200), "{busy:?} of processor time in 2 s at rest");
    assert!(viewer.close(PATIENCE).success());
}

#[test]
fn a_box_and_a_slab_are_pulled_by_their_handles() {
    let _turn = one_at_a_time();
    let Some(display) = Display::start() else { return };
    let mut viewer = start(&display);
    viewer.xdotool("mousemove 640 720");
    let all = viewer.shot_at_rest();
    assert_eq!(shown(&all, &all), (0..9).collect::<Vec<_>>());

    viewer.key("x");
    viewer.shot_at_rest().save("tools-4-box");
    let bounds = bounds();
    let [_, y, z] = bounds.center();
    let from = pixel([bounds.max[0], y, z]);
    let to = pixel([bounds.max[0] - 50.0, y, z]);
    viewer.xdotool(&format!("mousemove {} {}", from[0], from[1]));
    viewer.xdotool("mousedown 1");
    for step in 1..=6 {
        viewer.xdotool(&format!("mousemove {} {}", from[0] + (to[0] - from[0]) * step / 6, from[1]));
    }
    viewer.xdotool("mouseup 1");
    viewer.wait_for_line("clipped by", PATIENCE);
    viewer.shot_at_rest().save("tools-5-pulled");
    // The east column is gone; the box and its outline stay when its handles are put away.
    viewer.key("Escape");
    viewer.xdotool("mousemove 640 720");
    let clipped = viewer.shot_at_rest();
    clipped.save("tools-6-clipped");
    assert_eq!(shown(&clipped, &all), [0, 1, 3, 4, 6, 7]);
    let face = to[0] as usize;
    assert!((face - 2..=face + 2).any(|x| clipped.at(x, 300) != all.at(x, 300)), "nothing says that points are hidden");

    viewer.key("x");
    viewer.key("Delete");
    viewer.key("Escape");
    viewer.wait_for("all points again", PATIENCE, |v| (v.shot().points() == all.points()).then_some(()));

    // A slab across the view from the south: the points in the middle.
    viewer.key("shift+x");
    viewer.shot_at_rest().save("tools-7-slab");
    viewer.key("Escape");
    viewer.wait_for("a row of points", PATIENCE, |v| (shown(&v.shot(), &all) == [3, 4, 5]).then_some(()));
    assert!(viewer.close(PATIENCE).success());
}
