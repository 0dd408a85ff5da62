//! The panel, pictures for files, and what is remembered from one run to the next.

use std::{
    fs::{self, File},
    io::BufReader,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use super::{PATIENCE, SOME, display::Display, one_at_a_time, scan, viewer::Viewer};

fn temporary(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn planes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_data/planes.las")
}

fn size_of_png(path: &Path) -> (u32, u32) {
    let reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
    (reader.info().width, reader.info().height)
}

/// The first window of a user: its panel is open, Tab hides it, Ctrl+S saves a picture beside the scan, and the next
/// window is as this one was left.
#[test]
fn settings_are_remembered_and_pictures_saved() {
    let _turn = one_at_a_time();
    let Some(display) = Display::start() else { return };
    let (settings, folder) = (temporary("window-remembered.json"), temporary("window-pictures"));
    let _ = fs::remove_file(&settings);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let scan = folder.join("planes.las");
    fs::copy(planes(), &scan).unwrap();
    let arguments = ["--point-size", "3", scan.to_str().unwrap()];

    let began = Instant::now();
    let mut viewer = Viewer::start_with(&display, &settings, &arguments);
    viewer.wait_for("points", PATIENCE, |v| Some(()).filter(|()| v.shot().points() > SOME));
    eprintln!("points on screen {:.3?} after the start", began.elapsed());
    viewer.wait_for_line("at rest", PATIENCE);
    let with_panel = viewer.shot_at_rest();
    with_panel.save("10-panel");
    // Where the picture would be without the panel, there is another colour than its background.
    let background = with_panel.at(5, 400);
    assert_ne!(with_panel.at(1270, 700), background);

    // The picture that is saved is not that of the window: the panel is no part of it.
    viewer.key("ctrl+s");
    viewer.wait_for_line("picture written to", PATIENCE);
    let picture = folder.join("planes.png");
    let (width, height) = size_of_png(&picture);
    assert!(width < 1280 - 200 && height == 800, "{width}x{height}");

    let rests = viewer.count("at rest");
    viewer.key("Tab");
    viewer.wait_for_more("at rest", rests, PATIENCE);
    let without = viewer.shot_at_rest();
    without.save("11-no-panel");
    assert_eq!(without.at(1270, 700), background);
    viewer.key("ctrl+s");
    viewer.wait_for("a second picture", PATIENCE, |_| folder.join("planes-1.png").is_file().then_some(()));
    assert_eq!(size_of_png(&folder.join("planes-1.png")), (1280, 800));

    // Nothing goes on while the panel rests, either.
    viewer.key("Tab");
    viewer.wait_for_line("measured for 1280x800", PATIENCE);
    viewer.shot_at_rest();
    // Until the window has said for long enough where the pictures are.
    std::thread::sleep(Duration::from_secs(7));
    let (rests, busy) = (viewer.count("at rest"), viewer.cpu_time());
    std::thread::sleep(Duration::from_secs(2));
    let busy = viewer.cpu_time() - busy;
    assert!(busy < Duration::from_millis(200), "{busy:?} of processor time in 2 s with an idle panel");
    assert_eq!(viewer.count("at rest"), rests);
    viewer.key("Tab");
    viewer.shot_at_rest();
    assert!(viewer.close(PATIENCE).success());

    let text = fs::read_to_string(&settings).unwrap();
    assert!(text.contains("\"panel\": false") && text.contains("planes.las"), "{text}");
    // The panel stays hidden, and the points as large as they were, without the option.
    let mut viewer = Viewer::start_with(&display, &settings, &[scan.to_str().unwrap()]);
    viewer.wait_for_line("at rest", PATIENCE);
    let again = viewer.shot_at_rest();
    again.save("14-remembered");
    assert!(viewer.close(PATIENCE).success());
    let mut viewer = Viewer::start(&display, &arguments);
    viewer.wait_for("the same picture", PATIENCE, |v| (v.shot().difference(&again) == 0).then_some(()));
    assert!(viewer.close(PATIENCE).success());

    // What is damaged is as if it were not there, and --fresh does not even look.
    fs::write(&settings, &text[..text.len() / 2]).unwrap();
    let mut viewer = Viewer::start_with(&display, &settings, &arguments);
    viewer.wait_for("the first picture", PATIENCE, |v| (v.shot().difference(&with_panel) == 0).then_some(()));
    assert!(viewer.close(PATIENCE).success());
    fs::write(&settings, &text).unwrap();
    let mut viewer = Viewer::start_with(&display, &settings, &["--fresh", arguments[0], arguments[1], arguments[2]]);
    viewer.wait_for("the first picture", PATIENCE, |v| (v.shot().difference(&with_panel) == 0).then_some(()));
    viewer.key("Tab");
    assert!(viewer.close(PATIENCE).success());
    assert_eq!(fs::read_to_string(&settings).unwrap(), text, "nothing was remembered");
}

/// Other colours in the middle of loading: what the first reader has not read comes from a second one, and in the end
/// the picture is that of a window which was asked for them from the start.
#[test]
fn colours_change_in_mid_load() {
    let _turn = one_at_a_time();
    let Some(display) = Display::start() else { return };
    let scan = scan();
    let scan = scan.to_str().unwrap();
    let mut viewer = Viewer::start(&display, &["--threads", "1", scan]);
    viewer.wait_for("points", PATIENCE, |v| Some(()).filter(|()| v.shot().points() > SOME));
    while !viewer.said("colours by classification") {
        // The last one may not have been seen yet: two keys would be one too many.
        let modes = viewer.count("colours by");
        viewer.key("v");
        viewer.wait_for_more("colours by", modes, PATIENCE);
    }
    assert!(!viewer.said("read 3000000 points"), "the scan is too small: all was loaded before the key");
    let early = viewer.shot();
    early.save("12-classes-early");
    viewer.wait_for_line("read 3000000 points", PATIENCE);
    viewer.wait_for_rest_after("read the values of 3000000 points", PATIENCE);
    let switched = viewer.shot_at_rest();
    switched.save("13-classes");
    assert!(viewer.close(PATIENCE).success());

    let mut viewer = Viewer::start(&display, &["--color-by", "classification", scan]);
    viewer.wait_for_line("read 3000000 points", PATIENCE);
    viewer.wait_for("the same picture", PATIENCE, |v| (v.shot().difference(&switched) == 0).then_some(()));
    // Back again: nothing has to be read.
    let rests = viewer.count("at rest");
    viewer.xdotool("search --onlyvisible --name firstlight windowfocus --sync key shift+v");
    viewer.wait_for_more("at rest", rests, PATIENCE);
    assert!(viewer.shot_at_rest().difference(&switched) > SOME);
    // And forth: nothing comes from the file that could bring the legend up to date later.
    let rests = viewer.count("at rest");
    viewer.key("v");
    viewer.wait_for_more("at rest", rests, PATIENCE);
    let again = viewer.shot_at_rest();
    again.save("17-classes-again");
    assert_eq!(again.difference(&switched), 0);
    assert!(viewer.close(PATIENCE).success());
}

/// A picture that waits for its points is of the view in which it was asked for, wherever the user goes meanwhile.
#[test]
fn a_picture_is_of_the_view_that_it_was_asked_for() {
    let _turn = one_at_a_time();
    let Some(display) = Display::start() else { return };
    let folder = temporary("window-asked-for");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let copy = folder.join("town.laz");
    fs::copy(scan(), &copy).unwrap();
    let mut viewer = Viewer::start(&display, &["--threads", "1", copy.to_str().unwrap()]);
    viewer.wait_for("points", PATIENCE, |v| Some(()).filter(|()| v.shot().points() > SOME));
    viewer.key("ctrl+s");
    viewer.key("7");
    assert!(!viewer.said("read 3000000 points"), "the scan is too small: all was loaded before the keys");
    viewer.wait_for_line("picture written to", PATIENCE);
    assert!(viewer.said("read 3000000 points"));
    let rests = viewer.count("at rest");
    viewer.key("ctrl+s");
    viewer.wait_for("a second picture", PATIENCE, |_| folder.join("town-1.png").is_file().then_some(()));
    // The window is not held up, and goes on where it was.
    viewer.wait_for_more("at rest", rests, PATIENCE);
    viewer.shot_at_rest().save("15-from-above");
    assert!(viewer.close(PATIENCE).success());

    let mut viewer = Viewer::start(&display, &[copy.to_str().unwrap()]);
    viewer.wait_for_rest_after("read 3000000 points", PATIENCE);
    viewer.key("ctrl+s");
    viewer.wait_for("a third picture", PATIENCE, |_| folder.join("town-2.png").is_file().then_some(()));
    assert!(viewer.close(PATIENCE).success());
    let [asked, above, usual] =
        ["town.png", "town-1.png", "town-2.png"].map(|name| fs::read(folder.join(name)).unwrap());
    assert!(asked == usual && above != usual);
}

/// What is typed into a field, and the key that ends it, is for nothing else.
#[test]
fn keys_of_a_field_are_not_for_the_picture() {
    let _turn = one_at_a_time();
    let Some(display) = Display::start() else { return };
    let settings = temporary("window-typed.json");
    let _ = fs::remove_file(&settings);
    let mut viewer = Viewer::start_with(&display, &settings, &[planes().to_str().unwrap()]);
    viewer.wait_for_line("at rest", PATIENCE);
    let before = viewer.shot_at_rest();
    // The field for a path.
    viewer.focus();
    viewer.xdotool("mousemove 1128 98 click 1");
    // With o, the bar at the lower edge would go, with b there would be high quality.
    for key in ["slash", "n", "o", "b", "Return"] {
        viewer.key(key);
    }
    viewer.wait_for_line("/nob", PATIENCE);
    let after = viewer.shot_at_rest();
    after.save("16-typed");
    // The key that opens is also one that picks the point in the middle, with a card beside it.
    let middle = (300..900).flat_map(|x| (250..600).map(move |y| (x, y)));
    assert!(middle.into_iter().all(|(x, y)| before.at(x, y) == after.at(x, y)));
    assert!(viewer.close(PATIENCE).success());
    let text = fs::read_to_string(&settings).unwrap();
    assert!(text.contains("\"bar\": true") && text.contains("\"high_quality\": false"), "{text}");
}
