//! Cards pinned to points: every attribute of the record, read back from the file on a thread of its own.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
    mpsc::{Receiver, TryRecvError, channel},
};

use eframe::egui::{self, Context, Id, Label, Rect, RichText, ScrollArea, Ui, Window, pos2, vec2};

use super::{
    copy::copy,
    measure::{Place, coordinates},
    sheet::{Sheet, WARM},
};
use crate::{inspect::PointRecord, scene::SceneFacts};

/// Cards at a time; of more, the oldest is put away.
const MOST: usize = 16;
/// Of a new card, points: its rows and the margins around them.
const WIDTH: f32 = 350.0;
/// From a point to its card, and from a card to where the next one of the same point would be, points.
const ASIDE: f32 = 40.0;
const STEP: f32 = 26.0;
/// Height of a card's rows where there is room for it; a window's title, two lines of buttons and its margins take as
/// much as [`AROUND_ROWS`].
const ROWS: f32 = 360.0;
const AROUND_ROWS: f32 = 118.0;

/// A point with its card.
pub struct Pin {
    number: u32,
    pub place: Place,
    card: Card,
    cancel: Arc<AtomicBool>,
}

enum Card {
    Reading(Receiver<Result<PointRecord, String>>),
    Read(Box<PointRecord>),
    Failed(String),
}

impl Pin {
    fn new(ctx: &Context, facts: &Arc<SceneFacts>, place: Place, number: u32) -> Pin {
        let (ctx, facts) = (ctx.clone(), facts.clone());
        let cancel = Arc::new(AtomicBool::new(false));
        let (answer, card) = channel();
        let stop = cancel.clone();
        let read = move || {
            let read = PointRecord::read_of_scene(&facts, place.record, &stop);
            let record = match read {
                Some(read) => read.map_err(|error| error.to_string()),
                None => Err(format!("no file has record {}", place.record)),
            };
            // Nobody listens once the card is put away.
            let _ = answer.send(record);
            ctx.request_repaint();
        };
        let thread = std::thread::Builder::new().name("card".into()).spawn(read);
        let card = match thread {
            Ok(_) => Card::Reading(card),
            Err(error) => Card::Failed(format!("cannot start a thread: {error}")),
        };
        Pin { number, place, card, cancel }
    }

    fn take_answer(&mut self) {
        let Card::Reading(answer) = &self.card else { return };
        self.card = match answer.try_recv() {
            Ok(Ok(record)) => {
                log::debug!("card of record {}:\n{}", self.place.record, record.text());
                Card::Read(Box::new(record))
            }
            Ok(Err(error)) => {
                log::error!("{error}");
                Card::Failed(error)
            }
            Err(TryRecvError::Empty) => return,
            Err(TryRecvError::Disconnected) => Card::Failed("the reader stopped".into()),
        };
    }

    fn text(&self, facts: &SceneFacts) -> String {
        match &self.card {
            Card::Read(record) => record.text(),
            Card::Reading(_) | Card::Failed(_) => coordinates(self.place.position, &facts.grid).join(" "),
        }
    }
}

impl Drop for Pin {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

/// All pins, in the order that they were set.
#[derive(Default)]
pub struct Pins {
    pins: Vec<Pin>,
    set: u32,
    /// What the last click has pinned.
    added: Option<Added>,
}

/// A card, and the oldest one that had to make room for it.
struct Added {
    number: u32,
    displaced: Option<Pin>,
}

impl Pins {
    /// Pins a card to a point; one that has a card already keeps it.
    pub fn set(&mut self, ctx: &Context, facts: &Arc<SceneFacts>, place: Place) {
        if self.pins.iter().any(|pin| pin.place.record == place.record) {
            return;
        }
        let displaced = (self.pins.len() == MOST).then(|| self.pins.remove(0));
        self.set += 1;
        self.pins.push(Pin::new(ctx, facts, place, self.set));
        self.added = Some(Added { number: self.set, displaced });
    }

    /// A click begins, which may pin a card.
    pub fn begin_click(&mut self) {
        self.added = None;
    }

    /// As if the last click had pinned nothing.
    pub fn undo_click(&mut self) {
        let Some(Added { number, displaced }) = self.added.take() else { return };
        self.pins.retain(|pin| pin.number != number);
        self.pins.splice(0..0, displaced);
    }

    /// Those whose files are still in the scene, with the records' numbers in it.
    pub fn in_scene(self, before: &SceneFacts, now: &SceneFacts) -> Pins {
        let renumbered = |mut pin: Pin| {
            pin.place = pin.place.in_scene(before, now)?;
            Some(pin)
        };
        Pins { pins: self.pins.into_iter().filter_map(renumbered).collect(), added: None, ..self }
    }

    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.pins.len()
    }

    #[cfg(test)]
    pub fn records(&self) -> Vec<u32> {
        self.pins.iter().map(|pin| pin.place.record).collect()
    }

    /// Puts the last card away; false if there was none.
    pub fn remove_last(&mut self) -> bool {
        self.pins.pop().is_some()
    }

    /// Text of the last card.
    pub fn last_text(&self, facts: &SceneFacts) -> Option<String> {
        self.pins.last().map(|pin| pin.text(facts))
    }

    /// Marks the points, and shows the cards.
    pub fn show(&mut self, sheet: &Sheet<'_>, ctx: &Context, facts: &SceneFacts) {
        let mut away = None;
        for (at, pin) in self.pins.iter_mut().enumerate() {
            pin.take_answer();
            let place = sheet.place(pin.place.world);
            let card = card(ctx, sheet, pin, facts, at);
            if let Some(place) = place.filter(|&place| sheet.rect.expand(20.0).contains(place)) {
                if let Some(card) = card.rect {
                    let nearest = card.clamp(place);
                    sheet.painter.line_segment([place, nearest], egui::Stroke::new(1.2, WARM));
                }
                sheet.ring(place, WARM);
                sheet.words(place + vec2(8.0, -8.0), egui::Align2::LEFT_BOTTOM, &pin.number.to_string(), WARM);
            }
            if card.is_closed {
                away = Some(at);
            }
        }
        if let Some(at) = away {
            self.pins.remove(at);
        }
    }
}

struct Shown {
    rect: Option<Rect>,
    is_closed: bool,
}

fn card(ctx: &Context, sheet: &Sheet<'_>, pin: &Pin, facts: &SceneFacts, at: usize) -> Shown {
    let mut open = true;
    let mut close = false;
    // The next ones a step lower.
    let step = STEP * (at % 8) as f32;
    let place = sheet.place(pin.place.world).unwrap_or(sheet.free.left_top());
    let corner = pos2(left_edge(place.x, step, sheet.free), place.y - ASIDE + step);
    let corner = sheet.free.shrink(8.0).clamp(corner);
    let height = (sheet.free.height() - AROUND_ROWS).clamp(20.0, ROWS);
    let window = Window::new(format!("Point {}", pin.number))
        .id(Id::unique(("card", pin.number)))
        .open(&mut open)
        .default_pos(corner)
        .default_width(330.0)
        .constrain_to(sheet.free)
        .resizable(true);
    let shown = window.show(ctx, |ui| {
        match &pin.card {
            Card::Reading(_) => {
                rows(ui, pin.number, height, &place_rows(pin, facts), Some("Reading the record …".into()));
            }
            Card::Failed(error) => {
                let error = RichText::new(error).color(ui.visuals().error_fg_color);
                rows(ui, pin.number, height, &place_rows(pin, facts), Some(error));
            }
            Card::Read(record) => rows(ui, pin.number, height, &record.card(), None),
        }
        ui.horizontal_wrapped(|ui| {
            if ui.button("Copy").on_hover_text("As lines of text (Ctrl + C copies the last card)").clicked() {
                copy(ui.ctx(), pin.text(facts));
            }
            if let Card::Read(record) = &pin.card {
                if ui.button("JSON").on_hover_text("Copy as JSON").clicked() {
                    copy(ui.ctx(), record.json());
                }
                if ui.button("CSV").on_hover_text("Copy as a row of CSV").clicked() {
                    copy(ui.ctx(), record.csv_row());
                }
                if ui.button("CSV with names").on_hover_text("Copy as CSV, with the columns' names above").clicked() {
                    copy(ui.ctx(), format!("{}\n{}", record.csv_header(), record.csv_row()));
                }
            }
            close = ui.button("Close").on_hover_text("Put the card away (Backspace: the last one)").clicked();
        });
    });
    Shown { rect: shown.map(|shown| shown.response.rect), is_closed: close || !open }
}

/// Where a card beside a point begins: right of it, or left of it where only there is room, so that it does not hide
/// the point.
fn left_edge(point: f32, step: f32, free: Rect) -> f32 {
    let (right, left) = (point + ASIDE + step, point - ASIDE - step - WIDTH);
    if right + WIDTH > free.right() && left >= free.left() { left } else { right }
}

fn place_rows(pin: &Pin, facts: &SceneFacts) -> [(String, String); 3] {
    let [x, y, z] = coordinates(pin.place.position, &facts.grid);
    [("X".into(), x), ("Y".into(), y), ("Z".into(), z)]
}

/// What is known, and how it stands with the rest of it.
fn rows(ui: &mut Ui, number: u32, height: f32, rows: &[(String, String)], note: Option<RichText>) {
    ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
        egui::Grid::new(("card rows", number)).num_columns(2).striped(true).show(ui, |ui| {
            for (name, text) in rows {
                ui.label(name);
                ui.add(Label::new(RichText::new(text).monospace()).wrap());
                ui.end_row();
            }
        });
        if let Some(note) = note {
            ui.add(Label::new(note).wrap());
        }
    });
}

#[cfg(test)]
mod tests {
    use std::{
        path::Path,
        time::{Duration, Instant},
    };

    use eframe::egui::{OutputCommand, Rect, Vec2, pos2};
    use egui_kittest::{Harness, kittest::Queryable as _};

    use super::*;
    use crate::{
        scene::{FileFacts, Grid},
        view::navigation::Navigation,
    };

    struct World {
        pins: Pins,
        navigation: Navigation,
        facts: Arc<SceneFacts>,
    }

    /// A scene of one file that may not be there, and what its record says.
    fn world(path: &Path) -> World {
        let grid = Grid { scale: [0.001; 3], origin: [0.0; 3] };
        let bounds = crate::scene::Bounds { min: [0.0; 3], max: [10.0; 3] };
        let file = FileFacts { path: path.to_owned(), points_in_header: 1_000, ..Default::default() };
        let facts = SceneFacts { grid, bounds, files: vec![file], warnings: vec![] };
        World { pins: Pins::default(), navigation: Navigation::new(grid, &bounds, [900, 700]), facts: Arc::new(facts) }
    }

    fn place(record: u32) -> Place {
        Place { record, position: [5_000, 4_250, 1], world: [5.0, 4.25, 0.001].into() }
    }

    fn show(world: World) -> Harness<'static, World> {
        show_in(vec2(900.0, 700.0), world)
    }

    fn show_in(size: Vec2, world: World) -> Harness<'static, World> {
        let contents = move |ui: &mut Ui, world: &mut World| {
            let rect = Rect::from_min_size(pos2(0.0, 0.0), size);
            let ctx = ui.ctx().clone();
            let painter = ui.painter_at(rect);
            let sheet = Sheet { painter, rect, free: rect, navigation: &world.navigation, pixels_per_point: 1.0 };
            world.pins.show(&sheet, &ctx, &world.facts);
        };
        Harness::builder().with_size(size).build_ui_state(contents, world)
    }

    /// Until the card says this, as a thread reads what it is about.
    fn wait_for(harness: &mut Harness<'static, World>, label: &str) {
        let began = Instant::now();
        while harness.query_by_label_contains(label).is_none() {
            assert!(began.elapsed() < Duration::from_secs(30), "the card never says {label}");
            std::thread::sleep(Duration::from_millis(5));
            harness.step();
        }
    }

    fn copied(harness: &Harness<'static, World>) -> Option<String> {
        let commands = &harness.output().platform_output.commands;
        commands.iter().find_map(|command| match command {
            OutputCommand::CopyText(text) => Some(text.clone()),
            _ => None,
        })
    }

    #[test]
    fn a_card_says_what_the_file_says_and_copies_it() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_data/planes.las");
        let record = PointRecord::read(&path, 7, &AtomicBool::new(false)).unwrap();
        let mut world = world(&path);
        world.pins.set(&Context::default(), &world.facts.clone(), place(7));
        let mut harness = show(world);
        wait_for(&mut harness, "Intensity");
        // The card grows with the record.
        harness.run();
        for (_, text) in record.card() {
            assert!(harness.query_all_by_label(&text).next().is_some(), "{text} is not on the card");
        }
        let copies = [("Copy", record.text()), ("JSON", record.json()), ("CSV", record.csv_row())];
        for (button, expected) in copies {
            harness.get_by_label(button).click();
            harness.step();
            assert_eq!(copied(&harness).as_deref(), Some(&*expected), "{button}");
        }
        harness.get_by_label("Close").click();
        harness.step();
        harness.step();
        assert_eq!(harness.state().pins.len(), 0);
    }

    #[test]
    fn a_file_that_is_gone_is_told_on_the_card_and_the_place_stays() {
        let mut world = world(Path::new("/nowhere/at-all.las"));
        world.pins.set(&Context::default(), &world.facts.clone(), place(7));
        let mut harness = show(world);
        wait_for(&mut harness, "at-all.las");
        assert!(harness.query_by_label("4.250").is_some(), "the coordinates are known without the file");
        harness.get_by_label("Copy").click();
        harness.step();
        assert_eq!(copied(&harness).as_deref(), Some("5.000 4.250 0.001"));
    }

    /// A card of 20 rows, whose buttons a status bar would hide: `show_in` has the picture end where that begins.
    #[test]
    fn buttons_of_a_card_are_in_the_picture_whatever_its_size() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_data/planes.las");
        for size in [vec2(640.0, 347.0), vec2(330.0, 207.0), vec2(900.0, 700.0)] {
            let mut world = world(&path);
            world.pins.set(&Context::default(), &world.facts.clone(), place(7));
            let mut harness = show_in(size, world);
            wait_for(&mut harness, "Intensity");
            harness.run();
            let picture = Rect::from_min_size(pos2(0.0, 0.0), size);
            for button in ["Copy", "JSON", "CSV", "CSV with names", "Close"] {
                let rect = harness.get_by_label(button).rect();
                assert!(picture.contains_rect(rect), "{button} at {rect:?} in {size}");
            }
        }
    }

    #[test]
    fn a_card_leaves_its_point_to_be_seen() {
        let free = Rect::from_min_max(pos2(0.0, 0.0), pos2(1000.0, 700.0));
        for (point, step) in [(10.0, 0.0), (500.0, 0.0), (600.0, 26.0), (700.0, 0.0), (990.0, 182.0)] {
            let left = left_edge(point, step, free);
            assert!(left >= 0.0 && left + WIDTH <= 1000.0, "{point}: {left}");
            assert!(point < left || point > left + WIDTH, "{point} is behind {left} to {}", left + WIDTH);
        }
    }
}
