//! Cards pinned to points: every attribute of the record, read back from the file on a thread of its own.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
    mpsc::{Receiver, TryRecvError, channel},
};

use eframe::egui::{self, Context, Id, RichText, ScrollArea, Window, vec2};

use super::{
    copy::copy,
    measure::{Place, coordinates},
    sheet::{Sheet, WARM},
};
use crate::{inspect::PointRecord, scene::SceneFacts};

/// Cards at a time; of more, the oldest is put away.
const MOST: usize = 16;

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
}

impl Pins {
    /// Pins a card to a point; one that has a card already keeps it.
    pub fn set(&mut self, ctx: &Context, facts: &Arc<SceneFacts>, place: Place) {
        if self.pins.iter().any(|pin| pin.place.record == place.record) {
            return;
        }
        if self.pins.len() == MOST {
            self.pins.remove(0);
        }
        self.set += 1;
        self.pins.push(Pin::new(ctx, facts, place, self.set));
    }

    pub fn len(&self) -> usize {
        self.pins.len()
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
    rect: Option<egui::Rect>,
    is_closed: bool,
}

fn card(ctx: &Context, sheet: &Sheet<'_>, pin: &Pin, facts: &SceneFacts, at: usize) -> Shown {
    let mut open = true;
    let mut close = false;
    // Beside its point, the next ones a step lower.
    let step = 26.0 * (at % 8) as f32;
    let beside = sheet.place(pin.place.world).map_or(sheet.free.left_top(), |place| place + vec2(40.0, -40.0));
    let corner = sheet.free.shrink(8.0).clamp(beside + vec2(step, step));
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
                let [x, y, z] = coordinates(pin.place.position, &facts.grid);
                rows(ui, pin.number, &[("X".into(), x), ("Y".into(), y), ("Z".into(), z)]);
                ui.label("Reading the record …");
            }
            Card::Failed(error) => {
                let [x, y, z] = coordinates(pin.place.position, &facts.grid);
                rows(ui, pin.number, &[("X".into(), x), ("Y".into(), y), ("Z".into(), z)]);
                ui.colored_label(ui.visuals().error_fg_color, error);
            }
            Card::Read(record) => rows(ui, pin.number, &record.card()),
        }
        ui.horizontal(|ui| {
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

fn rows(ui: &mut egui::Ui, number: u32, rows: &[(String, String)]) {
    ScrollArea::vertical().max_height(360.0).show(ui, |ui| {
        egui::Grid::new(("card rows", number)).num_columns(2).striped(true).show(ui, |ui| {
            for (name, text) in rows {
                ui.label(RichText::new(name).weak());
                ui.add(egui::Label::new(RichText::new(text).monospace()).wrap());
                ui.end_row();
            }
        });
    });
}

#[cfg(test)]
mod tests {
    use std::{
        path::Path,
        time::{Duration, Instant},
    };

    use eframe::egui::{OutputCommand, Rect, pos2};
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
        let contents = |ui: &mut egui::Ui, world: &mut World| {
            let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(900.0, 700.0));
            let ctx = ui.ctx().clone();
            let painter = ui.painter_at(rect);
            let sheet = Sheet { painter, rect, free: rect, navigation: &world.navigation, pixels_per_point: 1.0 };
            world.pins.show(&sheet, &ctx, &world.facts);
        };
        Harness::builder().with_size(vec2(900.0, 700.0)).build_ui_state(contents, world)
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
}
