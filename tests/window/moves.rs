//! Camera moves by mouse and keys: undone, redone, bookmarked.

use super::{PATIENCE, SOME, display::Display, display::Shot, one_at_a_time, scan, viewer::Viewer};

/// Drags with a button, in steps as a hand does.
fn drag(viewer: &Viewer, button: u32, from: [i32; 2], by: [i32; 2]) {
    viewer.xdotool(&format!("mousemove {} {} mousedown {button}", from[0], from[1]));
    for step in 1..=6 {
        viewer.xdotool(&format!("mousemove {} {}", from[0] + by[0] * step / 6, from[1] + by[1] * step / 6));
    }
    viewer.xdotool(&format!("mouseup {button}"));
}

/// The picture once it rests again after `act`.
fn after(viewer: &mut Viewer, act: impl FnOnce(&Viewer)) -> Shot {
    let rests = viewer.count("at rest");
    act(viewer);
    viewer.wait_for_more("at rest", rests, PATIENCE);
    rest(viewer)
}

/// Off the picture, where the mouse shows no coordinates.
fn rest(viewer: &Viewer) -> Shot {
    viewer.xdotool("mousemove 300 790");
    viewer.shot_at_rest()
}

#[test]
fn moves_are_undone_and_redone_and_views_are_kept() {
    let _turn = one_at_a_time();
    let Some(display) = Display::start() else { return };
    let scan = scan();
    let mut viewer = Viewer::start(&display, &[scan.to_str().unwrap()]);
    viewer.wait_for_line("read 3000000 points", PATIENCE);
    viewer.wait_for_line("at rest", PATIENCE);
    let first = rest(&viewer);
    let same = |viewer: &mut Viewer, what: &str, shot: &Shot| {
        viewer.wait_for(what, PATIENCE, |v| (v.shot().difference(shot) == 0).then_some(()));
    };

    let orbited = after(&mut viewer, |v| drag(v, 1, [500, 420], [120, 30]));
    assert!(orbited.difference(&first) > SOME);
    let panned = after(&mut viewer, |v| drag(v, 3, [600, 400], [-90, 40]));
    assert!(panned.difference(&orbited) > SOME);
    let zoomed = after(&mut viewer, |v| v.xdotool("mousemove 640 400 click 4 click 4 click 4"));
    assert!(zoomed.difference(&panned) > SOME);
    let top = after(&mut viewer, |v| v.key("7"));
    top.save("moves-1-top");

    // Four gestures, four steps: each picture is that of before, to the last bit.
    for (what, shot) in [("zoomed", &zoomed), ("panned", &panned), ("orbited", &orbited), ("first", &first)] {
        viewer.key("ctrl+z");
        same(&mut viewer, &format!("the {what} picture, undone"), shot);
    }
    for (what, shot) in [("orbited", &orbited), ("panned", &panned), ("zoomed", &zoomed), ("top", &top)] {
        viewer.key("ctrl+y");
        same(&mut viewer, &format!("the {what} picture, redone"), shot);
    }

    // A bookmark of the top view, then one that is set anew.
    viewer.key("k");
    let isometric = after(&mut viewer, |v| v.key("5"));
    isometric.save("moves-2-isometric");
    assert!(isometric.difference(&top) > SOME);
    viewer.key("ctrl+1");
    same(&mut viewer, "the bookmark", &top);
    viewer.key("5");
    same(&mut viewer, "the isometric view", &isometric);
    viewer.key("ctrl+shift+1");
    viewer.key("h");
    same(&mut viewer, "the first picture", &first);
    viewer.key("ctrl+1");
    same(&mut viewer, "the bookmark that was set", &isometric);

    // What is under the cursor comes to the middle: the same move by mouse and by key.
    viewer.xdotool("mousemove 500 450");
    std::thread::sleep(std::time::Duration::from_millis(500));
    let centred = after(&mut viewer, |v| v.xdotool("mousemove 501 450 click --repeat 2 --delay 60 1"));
    centred.save("moves-3-centred");
    assert!(centred.difference(&isometric) > SOME);
    viewer.key("ctrl+z");
    same(&mut viewer, "the picture before the double click", &isometric);

    // Flying in, by a key that is held, and looking around.
    let flown = after(&mut viewer, |v| {
        v.xdotool("keydown w");
        v.xdotool("keyup w");
    });
    assert!(flown.difference(&isometric) > SOME);
    let looked = after(&mut viewer, |v| {
        v.key("f");
        drag(v, 1, [640, 400], [60, 20]);
    });
    assert!(looked.difference(&flown) > SOME);
    viewer.key("ctrl+z");
    same(&mut viewer, "the picture before looking around", &flown);
    viewer.key("ctrl+z");
    same(&mut viewer, "the picture before flying", &isometric);

    // At rest, nothing moves.
    let busy = viewer.cpu_time();
    std::thread::sleep(std::time::Duration::from_secs(2));
    let busy = viewer.cpu_time() - busy;
    assert!(busy < std::time::Duration::from_millis(200), "{busy:?} of processor time in 2 s at rest");

    viewer.key("F1");
    viewer.shot_at_rest().save("moves-4-help");
    assert!(viewer.close(PATIENCE).success());
}
