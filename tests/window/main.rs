//! The window, for real: under Xvfb, with a mouse and keys, judged by screenshots.

#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a test fails where it stands, and says that it is skipped"
)]
#![cfg(target_os = "linux")]

mod display;
mod moves;
mod panels;
mod tools;
mod viewer;
mod xserver;

use std::{
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, OnceLock, PoisonError},
    time::{Duration, Instant},
};

use firstlight::synth::{self, Scene, SynthOptions};

use display::Display;
use viewer::Viewer;

/// Long enough for a busy machine with two cores; nothing waits that long if all is well.
const PATIENCE: Duration = Duration::from_secs(120);
/// Pixels that show points, at least, once anything does. The line of text in an empty window has
/// fewer.
const SOME: usize = 6_000;

/// Windows are opened one after the other: with fewer cores than windows, "promptly" means nothing.
fn one_at_a_time() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A town that one thread needs a few seconds to decode.
fn scan() -> PathBuf {
    static SCAN: OnceLock<PathBuf> = OnceLock::new();
    SCAN.get_or_init(|| {
        let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("window-town.laz");
        let options = SynthOptions { points: 3_000_000, ..SynthOptions::new(Scene::Town) };
        synth::write(&options, &path, &mut |_| {}).expect("scan");
        path
    })
    .clone()
}

#[test]
fn a_scan_appears_while_it_loads_and_the_mouse_moves_the_camera() {
    let _turn = one_at_a_time();
    let Some(display) = Display::start() else { return };
    let scan = scan();
    let mut viewer = Viewer::start(&display, &["--threads", "1", scan.to_str().unwrap()]);

    let early = viewer.wait_for("points", PATIENCE, |v| Some(v.shot()).filter(|shot| shot.points() > SOME));
    assert!(!viewer.said("read 3000000 points"), "all was loaded before the first screenshot: the scan is too small");
    early.save("1-loading");

    viewer.wait_for_line("read 3000000 points", PATIENCE);
    viewer.wait_for_line("at rest", PATIENCE);
    let complete = viewer.shot_at_rest();
    complete.save("2-complete");
    let (before, after) = (early.points(), complete.points());
    assert!(after > before + before / 20, "{before} pixels show points while loading, {after} afterwards");

    // Nothing else goes on once the method is chosen.
    viewer.wait_for_line("measured for 1280x800", PATIENCE);
    std::thread::sleep(Duration::from_millis(200));
    let rests = viewer.count("at rest");
    let busy = viewer.cpu_time();
    std::thread::sleep(Duration::from_secs(2));
    let busy = viewer.cpu_time() - busy;
    assert!(busy < Duration::from_millis(200), "{busy:?} of processor time in 2 s although nothing changes");
    assert_eq!(viewer.count("at rest"), rests, "something was drawn although nothing changed");

    viewer.xdotool("mousemove 640 300 mousedown 1");
    for step in 1..=8 {
        viewer.xdotool(&format!("mousemove {} {}", 640 + 30 * step, 300 + 8 * step));
    }
    viewer.xdotool("mouseup 1");
    viewer.wait_for_more("at rest", rests, PATIENCE);
    let orbited = viewer.shot_at_rest();
    orbited.save("3-orbited");
    assert!(orbited.points() > SOME, "the scene is still in the picture");
    let moved = orbited.difference(&complete);
    assert!(moved > after / 4, "only {moved} pixels changed after a drag of the mouse");

    let rests = viewer.count("at rest");
    viewer.xdotool("mousemove 400 400 click 4 click 4 click 4 click 4");
    viewer.wait_for_more("at rest", rests, PATIENCE);
    let zoomed = viewer.shot_at_rest();
    zoomed.save("4-zoomed");
    assert!(zoomed.difference(&orbited) > SOME);

    // Whatever was on screen before: the same camera gives the same picture, to the last bit. Off the picture, the
    // mouse shows no coordinates.
    viewer.xdotool("mousemove 300 790");
    viewer.key("h");
    viewer.wait_for("the first picture again", PATIENCE, |v| (v.shot().difference(&complete) == 0).then_some(()));

    // High quality: other colours, the same after the camera was elsewhere; without it, those from before.
    let rests = viewer.count("at rest");
    viewer.key("b");
    viewer.wait_for_more("at rest", rests, PATIENCE);
    let averaged = viewer.shot_at_rest();
    averaged.save("8-high-quality");
    assert!(averaged.difference(&complete) > SOME, "averages look like front points");
    let rests = viewer.count("at rest");
    viewer.xdotool("mousemove 400 400 click 4 click 4");
    viewer.wait_for_more("at rest", rests, PATIENCE);
    viewer.shot_at_rest().save("9-high-quality-zoomed");
    viewer.xdotool("mousemove 300 790");
    viewer.key("h");
    viewer.wait_for("the averages again", PATIENCE, |v| (v.shot().difference(&averaged) == 0).then_some(()));
    viewer.key("b");
    viewer.wait_for("the front points again", PATIENCE, |v| (v.shot().difference(&complete) == 0).then_some(()));

    // A picture of another size is measured for as well, once it stays.
    viewer.xdotool("search --onlyvisible --name firstlight windowsize --sync 1000 700");
    viewer.wait_for_line("measured for 1000x700", PATIENCE);

    // Too small for any words, or for anything at all; then back.
    for size in ["60 30", "1 1", "1280 800"] {
        viewer.xdotool(&format!("search --onlyvisible --name firstlight windowsize --sync {size}"));
    }
    viewer.wait_for("the picture in its old size", PATIENCE, |v| (v.shot().difference(&complete) == 0).then_some(()));

    assert!(viewer.close(PATIENCE).success());
}

#[test]
fn a_dropped_file_replaces_the_scene_even_while_it_loads() {
    let _turn = one_at_a_time();
    let Some(display) = Display::start() else { return };
    let (first, second) = (scan(), Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_data/planes.las"));
    let mut viewer = Viewer::start(&display, &["--threads", "1", first.to_str().unwrap()]);
    viewer.wait_for("points", PATIENCE, |v| Some(()).filter(|()| v.shot().points() > SOME));
    viewer.drop_file(&second);
    viewer.wait_for_line("at rest", PATIENCE);
    assert!(!viewer.said("read 3000000 points"), "the first scan went on loading");
    let dropped = viewer.shot_at_rest();
    dropped.save("7-dropped");
    assert!(viewer.close(PATIENCE).success());

    let mut viewer = Viewer::start(&display, &[second.to_str().unwrap()]);
    viewer.wait_for("the same picture", PATIENCE, |v| (v.shot().difference(&dropped) == 0).then_some(()));
    assert!(dropped.points() > SOME);
    assert!(viewer.close(PATIENCE).success());
}

#[test]
fn closing_ends_at_once_even_while_loading() {
    let _turn = one_at_a_time();
    let Some(display) = Display::start() else { return };
    let scan = scan();
    for by_signal in [false, true] {
        let mut viewer = Viewer::start(&display, &["--threads", "1", scan.to_str().unwrap()]);
        viewer.wait_for("points", PATIENCE, |v| Some(()).filter(|()| v.shot().points() > SOME));
        assert!(!viewer.said("read 3000000 points"), "the scan is too small");
        let began = Instant::now();
        if by_signal {
            viewer.terminate(PATIENCE);
        } else {
            assert!(viewer.close(PATIENCE).success());
        }
        let took = began.elapsed();
        eprintln!("closed in {took:.3?} (signal: {by_signal})");
        assert!(took < Duration::from_secs(3), "{took:?} to close the window");
    }
}

#[test]
fn an_empty_window_waits_and_bad_input_is_told_in_it() {
    let _turn = one_at_a_time();
    let Some(display) = Display::start() else { return };
    let mut viewer = Viewer::start(&display, &[]);
    let invitation = viewer.wait_for("a window", PATIENCE, |v| Some(v.shot()).filter(|shot| shot.points() > 100));
    invitation.save("5-empty");
    assert!(invitation.points() < SOME);
    assert!(viewer.close(PATIENCE).success());

    let broken = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("window-broken.laz");
    std::fs::write(&broken, "this is no scan").unwrap();
    let mut viewer = Viewer::start(&display, &[broken.to_str().unwrap()]);
    viewer.wait_for_line("window-broken.laz", PATIENCE);
    let red = |p: &[u8; 3]| p[0] > 80 && p[1] < 40 && p[2] < 40;
    let told = viewer.wait_for("a red message", PATIENCE, |v| Some(v.shot()).filter(|shot| shot.count(red) > 1000));
    told.save("6-broken");
    assert!(viewer.close(PATIENCE).success(), "the window stays usable");
}
