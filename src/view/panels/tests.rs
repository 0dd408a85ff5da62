//! Panels as a user sees and works them: found by their accessible names, clicked, and held to snapshots of the
//! accessibility tree in `tests/panels`.

use std::{fmt::Write as _, path::PathBuf, time::Instant};

use eframe::egui::{
    Key, Modifiers, OutputCommand,
    accesskit::{Role as AccessRole, Toggled},
    vec2,
};
use egui_kittest::{
    Harness,
    kittest::{NodeT as _, Queryable as _},
};

use super::{
    color::{Colors, Value},
    files::{Files, Row, State},
    filter::{Filters, Table},
    performance::{GpuMemory, Performance},
    *,
};
use crate::{
    device::PassTimes,
    render::{ColorBy, ColorMap},
    scene::Attribute,
    source::ThreadTimes,
    view::{Options, messages::Severity, remembered::Remembered},
};

/// Everything that the panel shows, and what it asks for.
struct World {
    settings: Settings,
    files: Files,
    colors: Colors,
    filters: Filters,
    performance: Performance,
    share: share::Share,
    messages: Messages,
    typed: Typed,
    requests: Vec<Request>,
}

impl World {
    fn new(sections: &[Section]) -> World {
        let mut settings = Settings::new(&Options::default(), &Remembered::default());
        settings.sections = sections.iter().copied().collect();
        World {
            settings,
            files: Files::default(),
            colors: Colors::default(),
            filters: Filters::default(),
            performance: Performance::default(),
            share: share::Share::default(),
            messages: Messages::default(),
            typed: Typed::default(),
            requests: Vec::new(),
        }
    }

    fn with_files(mut self) -> World {
        let row = |name: &str, state, points_read| Row {
            path: PathBuf::from("/scans").join(name),
            kind: "LAZ 1.4, format 7".into(),
            crs: Some("projected EPSG:25832".into()),
            points: 2_000_000,
            points_read,
            state,
            ..Default::default()
        };
        let mut broken = row("c.laz", State::Stopped, 500_000);
        broken.warnings = vec!["12 points lie outside of the header's box; they are shown".into()];
        broken.error = Some("1500000 of 2000000 points are missing".into());
        broken.crs = None;
        self.files = Files {
            rows: vec![row("a.laz", State::Done, 2_000_000), row("b.laz", State::Reading, 1_000_000), broken],
            failed: vec![("/scans/no.las".into(), "not found: /scans/no.las".into())],
            recent: vec!["/scans".into(), "/other/tower.laz".into()],
            points_per_sec: 1_500_000.0,
            secs_to_go: Some(42.0),
            is_reading: true,
            ..Default::default()
        };
        self
    }

    fn show(self) -> Harness<'static, World> {
        let contents = |ui: &mut Ui, world: &mut World| {
            let mut model = Model {
                files: &world.files,
                colors: &world.colors,
                filters: &world.filters,
                performance: &world.performance,
                share: &mut world.share,
                messages: &world.messages,
                typed: &mut world.typed,
            };
            contents(ui, &mut world.settings, &mut model, &mut world.requests);
        };
        let mut harness = Harness::builder().with_size(vec2(320.0, 1400.0)).build_ui_state(contents, self);
        harness.run();
        harness
    }
}

fn copied(harness: &Harness<'_, World>) -> Option<String> {
    harness.output().platform_output.commands.iter().find_map(|command| match command {
        OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    })
}

/// Roles, names, values and states of all nodes, one line each.
fn tree(harness: &Harness<'_, World>) -> String {
    fn write(text: &mut String, depth: usize, node: &egui_kittest::Node<'_>) {
        let access = node.accesskit_node();
        let name = access.label().unwrap_or_default();
        let value = access.value().unwrap_or_default();
        let number = access.numeric_value().map_or(String::new(), |n| format!(" = {n}"));
        let state = match access.toggled() {
            Some(Toggled::True) => " [on]",
            Some(_) => " [off]",
            None if access.is_disabled() => " [disabled]",
            None => "",
        };
        let shown = !(name.is_empty() && value.is_empty() && number.is_empty());
        if shown {
            let value = if value.is_empty() || value == name { String::new() } else { format!(" \"{value}\"") };
            let _ = writeln!(text, "{}{:?} {name}{value}{number}{state}", "  ".repeat(depth), access.role());
        }
        if access.role() == AccessRole::Label {
            return;
        }
        for child in node.children() {
            write(text, depth + usize::from(shown), &child);
        }
    }
    let mut text = String::new();
    write(&mut text, 0, &harness.root());
    text
}

/// Compares with the snapshot of this name; UPDATE_SNAPSHOTS writes it anew.
fn check_tree(harness: &Harness<'_, World>, name: &str) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/panels").join(format!("{name}.txt"));
    let found = tree(harness);
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, &found).unwrap();
    }
    let expected = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
    assert!(found == expected, "{} says\n{expected}\nbut the panel is\n{found}", path.display());
}

#[test]
fn sections_open_and_close_and_remember_it() {
    let mut harness = World::new(&[Section::Look]).show();
    assert!(harness.query_by_label("High quality").is_some());
    assert!(harness.query_by_label("Save picture").is_none());
    harness.get_by_label("Look").click();
    harness.get_by_label("Files").click();
    harness.run();
    assert_eq!(harness.state().settings.sections, [Section::Files].into());
    assert!(harness.query_by_label("High quality").is_none());
    assert!(harness.query_by_label("Open files…").is_some());
    harness.get_by_label("Hide").click();
    harness.run();
    assert!(!harness.state().settings.panel);
}

#[test]
fn the_keyboard_reaches_the_panel_and_works_it() {
    let mut world = World::new(&[]);
    world.typed.focus = true;
    let mut harness = world.show();
    assert!(harness.get_by_label("Hide").is_focused());
    harness.key_press(Key::Tab);
    harness.run();
    assert!(harness.get_by_label("Keys").is_focused());
    harness.key_press(Key::Space);
    harness.run();
    assert!(harness.state().settings.help);
}

#[test]
fn files_are_shown_hidden_stopped_and_closed() {
    let mut harness = World::new(&[Section::Files]).with_files().show();
    check_tree(&harness, "files");
    harness.get_by_label("Show b.laz").click();
    harness.run();
    let shown = |harness: &Harness<'_, World>| {
        (0..3).map(|i| ticks::is_shown(&harness.state().settings.look.filter, &Attribute::File, i)).collect::<Vec<_>>()
    };
    assert_eq!(shown(&harness), [true, false, true]);
    assert_eq!(harness.get_by_label("Show b.laz").accesskit_node().toggled(), Some(Toggled::False));
    harness.get_by_label("Hide all files").click();
    harness.run();
    assert_eq!(shown(&harness), [false; 3]);
    harness.get_by_label("Show all files").click();
    harness.run();
    assert_eq!(shown(&harness), [true; 3]);

    harness.get_by_label("Stop reading b.laz").click();
    harness.run();
    assert!(harness.query_by_label("Stop reading a.laz").is_none(), "it is read already");
    harness.get_by_label("Close c.laz").click();
    harness.run();
    harness.get_by_label("Stop reading").click();
    harness.run();
    assert_eq!(harness.state().requests, [Request::StopFile(1), Request::CloseFile(2), Request::StopReading]);
    harness.get_by_label("Copy list").click();
    harness.step();
    let text = copied(&harness).unwrap();
    assert!(
        text.contains("/scans/b.laz\tLAZ 1.4, format 7\t1000000 of 2000000 points\tprojected EPSG:25832"),
        "{text}"
    );
    assert!(text.contains("not found: /scans/no.las"), "{text}");
}

#[test]
fn files_are_opened_in_every_way() {
    let mut world = World::new(&[Section::Files]).with_files();
    world.files.on_wayland = true;
    let mut harness = world.show();
    assert!(harness.query_by_label_contains("On Wayland").is_some(), "the window says how else");
    harness.get_by_label("Open files…").click();
    harness.run();
    harness.get_by_label("Add").click();
    harness.run();
    harness.get_by_label("Open folder…").click();
    harness.run();
    harness.get_by_label("Path to open").focus();
    harness.run();
    harness.get_by_label("Path to open").type_text("/tmp/a scan.las");
    harness.run();
    harness.key_press(Key::Enter);
    harness.run();
    assert_eq!(harness.state().typed.path, "/tmp/a scan.las", "it may not be there");
    harness.get_by_label("Recent").click();
    harness.run();
    harness.get_by_label("tower.laz").click();
    harness.run();
    let choose = |what, add| Request::Choose { what, add };
    let open = |path: &str| Request::Open { inputs: vec![path.into()], add: true };
    use crate::view::requests::Choose;
    assert_eq!(
        harness.state().requests,
        [choose(Choose::Files, false), choose(Choose::Folder, true), open("/tmp/a scan.las"), open("/other/tower.laz")]
    );
}

#[test]
fn looks_are_set() {
    let mut harness = World::new(&[Section::Look]).show();
    check_tree(&harness, "look");
    harness.get_by_label("High quality").click();
    harness.get_by_label("Eye-dome lighting").click();
    harness.run();
    harness.get_by_label("White").click();
    harness.run();
    let settings = &harness.state().settings;
    assert!(settings.look.shading.high_quality && !settings.edl);
    assert_eq!(settings.shading().edl_strength, 0.0);
    assert_eq!(settings.look.shading.background, [255; 3]);
}

#[test]
fn looks_beyond_the_sliders_stay_as_the_command_line_gave_them() {
    let mut world = World::new(&[Section::Look]);
    world.settings.look.shading.edl_strength = 6.0;
    world.settings.look.point_size = crate::render::PointSize::World(20.0);
    let look = world.settings.look.clone();
    let harness = world.show();
    assert_eq!(harness.state().settings.look, look);
}

#[test]
fn a_path_stays_in_its_field_until_it_is_open() {
    let mut typed = Typed { path: " /scans/tower.las".into(), ..Default::default() };
    typed.note_opened(&["/scans/other.las".into()]);
    assert_eq!(typed.path, " /scans/tower.las");
    typed.note_opened(&["/scans/other.las".into(), "/scans/tower.las".into()]);
    assert_eq!(typed.path, "");
}

fn classes() -> Vec<Value> {
    let value = |number, name: &str, points| Value { number, name: name.into(), color: [number as u8; 3], points };
    vec![value(2, "2 ground", 1_500_000), value(6, "6 building", 400_000), value(9, "9 water", 42)]
}

fn shown_by(harness: &Harness<'_, World>) -> String {
    let clauses = harness.state().settings.look.filter.clauses.iter();
    clauses.map(|clause| clause.to_string()).collect::<Vec<_>>().join(" ")
}

#[test]
fn colours_are_chosen_and_their_range_is_dragged() {
    let mut world = World::new(&[Section::Color]);
    world.colors = Colors {
        choices: vec![ColorBy::Auto, ColorBy::Rgb, Attribute::Elevation.into(), Attribute::Classification.into()],
        extent: Some([100.0, 200.0]),
        bars: (0..50).collect(),
        range: Some([110.0, 190.0]),
        reading: Some(("GPS time".into(), 0.25)),
        ..Default::default()
    };
    let mut harness = world.show();
    assert!(harness.query_by_label("Legend").is_none(), "automatic colours have none");
    harness.get_by_label("Colour by").click();
    harness.run();
    harness.get_by_label("Elevation").click();
    harness.run();
    check_tree(&harness, "color");
    let coloring = |harness: &Harness<'_, World>| harness.state().settings.look.coloring.clone();
    assert_eq!(coloring(&harness).by, Attribute::Elevation.into());
    assert_eq!(coloring(&harness).range, None);

    // The handle of the first colour, to where the second one is and beyond: it pushes it.
    let handle = harness.get_by_label("Value of the first colour").rect().center();
    harness.drag_at(handle);
    harness.run();
    harness.hover_at(handle + vec2(40.0, 0.0));
    harness.run();
    harness.drop_at(handle + vec2(40.0, 0.0));
    harness.run();
    let [low, high] = coloring(&harness).range.expect("a range of the user's own");
    assert!(low > 112.0 && low < 150.0 && high == 190.0, "{low} to {high}");
    harness.get_by_label("Automatic range").click();
    harness.run();
    assert_eq!(coloring(&harness).range, None);

    harness.get_by_label("Colour map").click();
    harness.run();
    harness.get_by_label("turbo").click();
    harness.run();
    assert_eq!(coloring(&harness).map, Some(ColorMap::Turbo));
    harness.get_by_label("Legend").click();
    harness.run();
    assert!(!harness.state().settings.look.decor.legend);
}

#[test]
fn classes_have_names_colours_counts_and_ticks() {
    let mut world = World::new(&[Section::Color]);
    world.settings.look.coloring.by = Attribute::Classification.into();
    world.colors.values = classes();
    let mut harness = world.show();
    check_tree(&harness, "classes");
    harness.get_by_label("Show 6 building").click();
    harness.run();
    assert_eq!(shown_by(&harness), "classification!=6");
    assert!(harness.query_by_label("Usual classes").is_none());
    harness.get_by_label("Name of class 9").focus();
    harness.run();
    harness.get_by_label("Name of class 9").type_text("!");
    harness.run();
    let name = |harness: &Harness<'_, World>| harness.state().settings.look.coloring.classes.get(9).name.to_string();
    assert!(name(&harness).contains('!'), "{}", name(&harness));
    harness.get_by_label("Usual classes").click();
    harness.run();
    assert_eq!(name(&harness), "water");
}

#[test]
fn points_are_filtered_by_ticks_ranges_and_text() {
    let mut world = World::new(&[Section::Filter]);
    let table = |attribute, values, is_partial| Table { attribute, values, is_partial };
    world.filters = Filters {
        tables: vec![
            table(Attribute::Classification, classes(), true),
            table(Attribute::ReturnNumber, Vec::new(), true),
        ],
        ranges: vec![(Attribute::Elevation, Some([100.0, 200.0]))],
        shown: Some([750_000, 1_500_000]),
    };
    let mut harness = world.show();
    harness.get_by_label("Ranges").click();
    harness.get_by_label("Return number").click();
    harness.run();
    check_tree(&harness, "filter");
    harness.get_by_label("Show 2 ground").click();
    harness.run();
    harness.get_by_label("Elevation").click();
    harness.run();
    assert_eq!(shown_by(&harness), "classification!=2 elevation=100..200");
    harness.get_by_label("Read the values: Return number").click();
    harness.run();
    assert_eq!(harness.state().requests, [Request::Read(Attribute::ReturnNumber)]);

    let type_clause = |harness: &mut Harness<'_, World>, text: &str| {
        harness.get_by_label("Clause to add").focus();
        harness.run();
        harness.get_by_label("Clause to add").type_text(text);
        harness.run();
        harness.key_press(Key::Enter);
        harness.run();
    };
    type_clause(&mut harness, "colour=5");
    assert!(harness.query_by_label_contains("expected intensity").is_some(), "what is wrong is told");
    harness.state_mut().typed.clause.clear();
    type_clause(&mut harness, "class=6,9");
    assert_eq!(shown_by(&harness), "classification=6,9 elevation=100..200");
    harness.get_by_label("Take away elevation=100..200").click();
    harness.run();
    assert_eq!(shown_by(&harness), "classification=6,9");
    harness.get_by_label("Show all").click();
    harness.run();
    assert_eq!(shown_by(&harness), "");
}

#[test]
fn messages_are_listed_copied_and_cleared() {
    let mut world = World::new(&[Section::Messages]);
    world.messages.add(Severity::Note, "a.laz: odd");
    world.messages.add(Severity::Error, "b.laz: broken");
    let mut harness = world.show();
    check_tree(&harness, "messages");
    harness.get_by_label("Copy message 2").click();
    harness.step();
    assert_eq!(copied(&harness).as_deref(), Some("a.laz: odd"));
    harness.get_by_label("Copy all").click();
    harness.step();
    assert_eq!(copied(&harness).as_deref(), Some("error: b.laz: broken\nnote: a.laz: odd\n"));
    harness.get_by_label("Clear").click();
    harness.run();
    assert_eq!(harness.state().requests, [Request::ClearMessages]);
}

#[test]
fn performance_is_shown_and_copied() {
    let mut world = World::new(&[Section::Performance]);
    let performance = &mut world.performance;
    (performance.adapter, performance.method) = ("llvmpipe".into(), "early-z".into());
    for i in 0..10 {
        let ms = 1e-3 * f64::from(i);
        performance.note_frame(PassTimes { reproject: ms, fill: 2.0 * ms, resolve: 1e-3, ..Default::default() }, 0.017);
    }
    let times =
        ThreadTimes { name: "laz-0".into(), points: 3_000_000, decode_secs: 1.0, wait_secs: 1.0, ..Default::default() };
    performance.note_threads(Instant::now(), vec![times], Some(2.0));
    performance.gpu_memory = Some(GpuMemory { used: 300 << 20, reserved: 512 << 20 });
    let mut harness = world.show();
    check_tree(&harness, "performance");
    harness.get_by_label("Copy as text").click();
    harness.step();
    let text = copied(&harness).unwrap();
    assert!(text.contains("laz-0\t1.50 M") && text.contains("reproject"), "{text}");
}

#[test]
fn a_picture_is_asked_for_at_any_size() {
    let mut world = World::new(&[Section::Share]);
    world.share = share::Share {
        has_scene: true,
        window_size: [800, 600],
        wait: true,
        path: "/tmp/scan.png".into(),
        command: Some("firstlight render scan.laz".into()),
        ..Default::default()
    };
    let mut harness = world.show();
    check_tree(&harness, "share");
    harness.get_by_label("Save picture").click();
    harness.run();
    harness.get_by_label("Size of the picture").click();
    harness.run();
    harness.get_by_label("3840 × 2160").click();
    harness.run();
    harness.get_by_label("Wait until it is complete").click();
    harness.run();
    harness.get_by_label("Save picture").click();
    harness.run();
    let shot = |size, wait| {
        Request::Screenshot(crate::view::screenshot::ShotOptions {
            size,
            wait,
            path: "/tmp/scan.png".into(),
            may_replace: false,
        })
    };
    assert_eq!(harness.state().requests, [shot([800, 600], true), shot([3840, 2160], false)]);
    harness.get_by_label("Copy command").click();
    harness.step();
    assert_eq!(copied(&harness).as_deref(), Some("firstlight render scan.laz"));
    harness.state_mut().share.taking = Some(0.25);
    harness.run();
    harness.get_by_label("Stop the picture").click();
    harness.run();
    assert_eq!(harness.state().requests.last(), Some(&Request::StopScreenshot));
}

#[test]
fn the_cheat_sheet_lists_keys_and_closes() {
    let mut settings = Settings::new(&Options::default(), &Remembered::default());
    settings.help = true;
    let sheet = |ui: &mut Ui, settings: &mut Settings| {
        if settings.help {
            crate::view::help::show(ui.ctx(), settings);
        }
    };
    let mut harness = Harness::builder().with_size(vec2(900.0, 900.0)).build_ui_state(sheet, settings);
    harness.run();
    for key in ["Tab", "F6", "Ctrl+O", "Ctrl+S", "Home, H"] {
        assert!(harness.query_by_label(key).is_some(), "{key} is not listed");
    }
    harness.key_press_modifiers(Modifiers::NONE, Key::Escape);
    harness.run();
    assert!(!harness.state().help);
}

/// One column where two have no room, keys above what they do where they have none beside it, all of it within the
/// window.
#[test]
fn the_cheat_sheet_fits_into_any_window() {
    let sheet = |ui: &mut Ui, settings: &mut Settings| crate::view::help::show(ui.ctx(), settings);
    for size in [vec2(1280.0, 800.0), vec2(1090.0, 700.0), vec2(640.0, 400.0), vec2(330.0, 260.0), vec2(200.0, 150.0)] {
        let mut settings = Settings::new(&Options::default(), &Remembered::default());
        settings.help = true;
        let mut harness = Harness::builder().with_size(size).build_ui_state(sheet, settings);
        harness.run();
        let window = eframe::egui::Rect::from_min_size(eframe::egui::Pos2::ZERO, size);
        let close = harness.get_by_label("Close").rect();
        assert!(window.contains_rect(close), "{close:?} in {size}");
        for row in crate::view::keys::ROWS {
            let labels: Vec<_> =
                harness.query_all_by_label(row.what).chain(harness.query_all_by_label(row.keys)).collect();
            assert!(labels.len() > 1 || size.x < 1280.0, "{} is missing", row.keys);
            for label in labels {
                let rect = label.rect();
                assert!(rect.left() >= 0.0 && rect.right() <= size.x, "{} at {rect:?} in {size}", row.keys);
            }
        }
        harness.get_by_label("Close").click();
        harness.run();
        assert!(!harness.state().help, "{size}");
    }
}

/// Whatever the size of the window, nothing panics, and the picture keeps some room.
#[test]
fn any_size_of_window_will_do() {
    for size in [vec2(1.0, 1.0), vec2(60.0, 30.0), vec2(300.0, 200.0), vec2(500.0, 170.0), vec2(1280.0, 800.0)] {
        let world = World::new(&[Section::Files, Section::Look, Section::Performance]).with_files();
        let show = |ui: &mut Ui, world: &mut World| {
            let mut model = Model {
                files: &world.files,
                colors: &world.colors,
                filters: &world.filters,
                performance: &world.performance,
                share: &mut world.share,
                messages: &world.messages,
                typed: &mut world.typed,
            };
            side(ui, &mut world.settings, &mut model, &mut world.requests);
            // The harness keeps a margin of 8 points at either side.
            let left = ui.available_rect_before_wrap();
            assert!(left.width() >= ui.ctx().content_rect().width().min(PICTURE_WIDTH) - 17.0, "{left:?}");
        };
        let mut harness = Harness::builder().with_size(size).build_ui_state(show, world);
        harness.run();
        let has_panel = harness.query_by_label("Hide").is_some();
        assert_eq!(has_panel, size.x >= NARROWEST + PICTURE_WIDTH && size.y >= 160.0, "{size}");
    }
}
