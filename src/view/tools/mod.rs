//! What the mouse does in the picture besides moving the camera: hover and cards, distances, a clipping box and a slab.
//!
//! ```text
//! sheet     points of the scene to positions in the window, lines and words over the picture
//! pins      cards: a record read back from its file
//! measure   distances along lines of points
//! handles   boxes and slabs: what dragging a handle does
//! clip      the handles drawn, and their numbers in a small window
//! strip     the buttons at the left edge
//! ```

mod clip;
mod copy;
mod handles;
mod measure;
mod pins;
mod sheet;
mod strip;

use std::{sync::Arc, time::Duration};

use eframe::egui::{Align2, Context, Rect, Ui, vec2};
use glam::DVec2;

use super::{keys::Command, navigation::Navigation, probe::REACH};
use crate::{
    inspect::Ruler,
    render::{Clip, GpuBackend, Pick, PickAt, PickTicket, Progressive},
    scene::SceneFacts,
};
use clip::Clipping;
use measure::{Line, Place, coordinates};
use pins::Pins;
use sheet::{ACCENT, Sheet, WHITE};

pub use strip::strip;

/// How soon a window looks again for an answer from the GPU.
pub const ANSWER_INTERVAL: Duration = Duration::from_millis(8);
/// Frames that a click waits for a picture that can be asked.
const PATIENCE_FRAMES: u32 = 100;

/// What a click in the picture does.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Tool {
    /// Pins a card.
    #[default]
    Inspect,
    /// Measures from one point to another.
    Distance,
    /// Measures along a line of points.
    Polyline,
    /// Shows the clipping box's handles.
    Box,
    /// Shows the slab's handles.
    Slab,
}

impl Tool {
    pub const ALL: [Tool; 5] = [Tool::Inspect, Tool::Distance, Tool::Polyline, Tool::Box, Tool::Slab];

    fn measures(self) -> bool {
        matches!(self, Tool::Distance | Tool::Polyline)
    }
}

/// What the tools have in hand, of one scene.
#[derive(Default)]
pub struct Tools {
    pub tool: Tool,
    /// The point under the cursor.
    hovered: Option<Place>,
    pins: Pins,
    lines: Vec<Line>,
    /// The line that is being measured.
    drawn: Line,
    clicks: Vec<Click>,
    clipping: Clipping,
    last: Last,
}

/// A click whose point is being asked for.
struct Click {
    pixel: DVec2,
    ticket: Option<PickTicket>,
    frames: u32,
}

/// What was added last.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
enum Last {
    #[default]
    Card,
    Line,
}

impl Tools {
    /// What stays when the scene is read anew with more files, or fewer: cards and lines of points that are still there.
    pub fn in_scene(self, before: &SceneFacts, now: &SceneFacts) -> Tools {
        Tools {
            hovered: None,
            pins: self.pins.in_scene(before, now),
            lines: self.lines.iter().filter_map(|line| line.in_scene(before, now)).collect(),
            drawn: self.drawn.in_scene(before, now).unwrap_or_default(),
            clicks: Vec::new(),
            ..self
        }
    }

    /// The point under the cursor is this one now, or none.
    pub fn hover(&mut self, pick: Option<Pick>, facts: &SceneFacts) {
        let hovered = pick.map(|pick| place(&pick, facts));
        if let Some(place) = hovered.filter(|_| hovered != self.hovered) {
            log::debug!("at the cursor: {}", coordinates(place.position, &facts.grid).join(" "));
        }
        self.hovered = hovered;
    }

    /// Asks for the point at a pixel, to do with it what the tool does.
    pub fn click(&mut self, pixel: DVec2) {
        if pixel.min_element() >= 0.0 && (self.tool == Tool::Inspect || self.tool.measures()) {
            self.pins.begin_click();
            self.clicks.push(Click { pixel, ticket: None, frames: 0 });
        }
    }

    /// The last click was the first half of a double click, which does something else; true if that is for the camera.
    pub fn double_click(&mut self) -> bool {
        self.clicks.clear();
        if self.tool.measures() {
            self.finish();
            return false;
        }
        if self.tool == Tool::Inspect {
            self.pins.undo_click();
        }
        true
    }

    /// Goes on with the clicks whose points are not known yet.
    pub fn answer(&mut self, ctx: &Context, progressive: &mut Progressive<GpuBackend>, facts: &Arc<SceneFacts>) {
        for mut click in std::mem::take(&mut self.clicks) {
            click.frames += 1;
            let Some(ticket) = click.ticket else {
                let pixel = [click.pixel.x as u32, click.pixel.y as u32];
                click.ticket = progressive.pick(PickAt { pixel, reach: REACH });
                if click.frames < PATIENCE_FRAMES {
                    self.clicks.push(click);
                }
                continue;
            };
            match progressive.picked(ticket) {
                None => self.clicks.push(click),
                Some(None) => log::debug!("no point within {REACH} pixels"),
                Some(Some(pick)) => self.take(ctx, facts, place(&pick, facts)),
            }
        }
        if !self.clicks.is_empty() {
            ctx.request_repaint_after(ANSWER_INTERVAL);
        }
    }

    fn take(&mut self, ctx: &Context, facts: &Arc<SceneFacts>, place: Place) {
        if !self.tool.measures() {
            self.last = Last::Card;
            self.pins.set(ctx, facts, place);
            return;
        }
        // The same point again, as by a double click, is no segment.
        if self.drawn.points.last().is_none_or(|last| last.record != place.record) {
            self.drawn.points.push(place);
        }
        if self.tool == Tool::Distance && self.drawn.points.len() == 2 {
            self.finish();
        }
        if let Some(line) = self.lines.last().filter(|_| self.drawn.points.is_empty()) {
            log::debug!("measured:\n{}", line.text(facts));
        }
    }

    /// The line that is being measured is complete; a single point is none.
    fn finish(&mut self) {
        let line = std::mem::take(&mut self.drawn);
        if line.points.len() > 1 {
            self.lines.push(line);
            self.last = Last::Line;
        }
    }

    fn take_tool(&mut self, tool: Tool) {
        self.finish();
        // The key of a tool puts it away again.
        self.tool = if self.tool == tool { Tool::Inspect } else { tool };
    }

    /// What keys and buttons ask for; `cursor` is the pixel that it is about.
    pub fn obey(&mut self, command: Command, ctx: &Context, facts: &SceneFacts, cursor: DVec2, clip: &mut Clip) {
        match command {
            Command::Take(tool) => self.take_tool(tool),
            Command::Click => self.click(cursor),
            Command::Finish if self.drawn.points.is_empty() => self.click(cursor),
            Command::Finish => self.finish(),
            Command::Copy => {
                if let Some(text) = self.text(facts) {
                    copy::copy(ctx, text);
                }
            }
            Command::Remove => self.remove(clip),
            Command::Close => self.close(),
            _ => {}
        }
    }

    fn text(&self, facts: &SceneFacts) -> Option<String> {
        let line = || Some(self.lines.last()?.text(facts));
        let card = || self.pins.last_text(facts);
        match self.last {
            _ if self.drawn.points.len() > 1 => Some(self.drawn.text(facts)),
            Last::Card => card().or_else(line),
            Last::Line => line().or_else(card),
        }
    }

    fn remove(&mut self, clip: &mut Clip) {
        match self.tool {
            Tool::Box => clip.bounds = None,
            Tool::Slab => clip.slab = None,
            Tool::Distance | Tool::Polyline => {
                if self.drawn.points.pop().is_none() {
                    self.lines.pop();
                }
            }
            Tool::Inspect => {
                if !self.pins.remove_last() {
                    self.lines.pop();
                }
            }
        }
    }

    fn close(&mut self) {
        if !self.drawn.points.is_empty() {
            self.drawn.points.clear();
        } else if self.tool != Tool::Inspect {
            self.tool = Tool::Inspect;
        } else {
            self.pins.remove_last();
        }
    }

    /// Draws what there is over the picture, which takes `rect` of the window, `free` of it without lines at its edge.
    /// `cursor` is the pixel under the cursor, if it is on the picture and no button is held.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        [rect, free]: [Rect; 2],
        navigation: &Navigation,
        facts: &SceneFacts,
        clip: &mut Clip,
        cursor: Option<DVec2>,
    ) {
        let ctx = ui.ctx().clone();
        let sheet = Sheet {
            painter: ui.painter_at(rect),
            rect,
            free,
            navigation,
            pixels_per_point: ctx.pixels_per_point().into(),
        };
        let has_handle = self.clipping.show(ui, &sheet, self.tool, facts, clip);
        for line in &self.lines {
            draw_line(&sheet, line, facts, None);
        }
        let ahead = self.hovered.filter(|_| self.tool.measures() && cursor.is_some());
        draw_line(&sheet, &self.drawn, facts, ahead);
        self.pins.show(&sheet, &ctx, facts);
        if let (Some(cursor), Some(place), false) = (cursor, &self.hovered, has_handle) {
            draw_hovered(&sheet, cursor, place, facts);
        }
    }
}

fn place(pick: &Pick, facts: &SceneFacts) -> Place {
    Place { record: pick.record, position: pick.position, world: facts.grid.world(pick.position).into() }
}

/// Coordinates with the file's digits beside the cursor, and a ring where the point is.
fn draw_hovered(sheet: &Sheet<'_>, cursor: DVec2, place: &Place, facts: &SceneFacts) {
    if let Some(at) = sheet.place(place.world) {
        sheet.ring(at, WHITE);
    }
    let words = coordinates(place.position, &facts.grid).join("  ");
    sheet.words(sheet.position(cursor) + vec2(16.0, 18.0), Align2::LEFT_TOP, &words, WHITE);
}

/// A line with its lengths; `ahead` is where it would go on.
fn draw_line(sheet: &Sheet<'_>, line: &Line, facts: &SceneFacts, ahead: Option<Place>) {
    let ruler = Ruler::new(facts);
    let mut whole = line.clone();
    if !line.points.is_empty() {
        whole.points.extend(ahead);
    }
    for (pair, segment) in whole.points.windows(2).zip(whole.segments(&ruler)) {
        if let Some([a, b]) = sheet.line(pair[0].world, pair[1].world, ACCENT) {
            let middle = a + (b - a) * 0.5;
            sheet.words(middle, Align2::CENTER_BOTTOM, &Line::segment_words(&segment, &ruler), WHITE);
        }
    }
    for point in &line.points {
        if let Some(at) = sheet.place(point.world) {
            sheet.ring(at, ACCENT);
        }
    }
    if let (Some(last), Some(words)) = (whole.points.last(), whole.total_words(&ruler))
        && let Some(at) = sheet.place(last.world)
    {
        sheet.words(at + vec2(12.0, 12.0), Align2::LEFT_TOP, &words, WHITE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Bounds, FileFacts, Grid};

    fn facts() -> Arc<SceneFacts> {
        let grid = Grid { scale: [0.01; 3], origin: [0.0; 3] };
        let bounds = Bounds { min: [0.0; 3], max: [10.0; 3] };
        Arc::new(SceneFacts { grid, bounds, files: vec![FileFacts::default()], warnings: vec![] })
    }

    fn at(record: u32) -> Place {
        Place { record, position: [100 * record as i32, 0, 0], world: DVec2::new(record.into(), 0.0).extend(0.0) }
    }

    #[test]
    fn two_clicks_measure_a_distance_and_further_ones_the_next() {
        let (ctx, facts, mut clip) = (Context::default(), facts(), Clip::default());
        let mut tools = Tools::default();
        let obey = |tools: &mut Tools, command, clip: &mut Clip| {
            tools.obey(command, &ctx, &facts, DVec2::ZERO, clip);
        };
        obey(&mut tools, Command::Take(Tool::Distance), &mut clip);
        for record in [1, 1, 4, 6] {
            tools.take(&ctx, &facts, at(record));
        }
        assert_eq!((tools.lines.len(), tools.drawn.points.len()), (1, 1));
        assert!(tools.text(&facts).unwrap().contains("3.00"), "{:?}", tools.text(&facts));
        obey(&mut tools, Command::Remove, &mut clip);
        assert_eq!((tools.lines.len(), tools.drawn.points.len()), (1, 0));
        obey(&mut tools, Command::Remove, &mut clip);
        assert_eq!((tools.lines.len(), tools.text(&facts)), (0, None));
        obey(&mut tools, Command::Take(Tool::Distance), &mut clip);
        assert_eq!(tools.tool, Tool::Inspect, "its key puts a tool away");
    }

    #[test]
    fn a_line_of_points_ends_when_it_is_told_to() {
        let (ctx, facts, mut clip) = (Context::default(), facts(), Clip::default());
        let mut tools = Tools { tool: Tool::Polyline, ..Default::default() };
        for record in [1, 2, 5] {
            tools.take(&ctx, &facts, at(record));
        }
        assert!(tools.text(&facts).unwrap().contains("Length: 4.00"));
        tools.obey(Command::Finish, &ctx, &facts, DVec2::ZERO, &mut clip);
        assert_eq!((tools.lines.len(), tools.drawn.points.len()), (1, 0));
        tools.take(&ctx, &facts, at(9));
        assert!(!tools.double_click(), "it ends the line and moves no camera");
        assert_eq!((tools.lines.len(), tools.drawn.points.len()), (1, 0), "one point is no line");
        tools.take(&ctx, &facts, at(9));
        tools.close();
        assert_eq!((tools.drawn.points.len(), tools.tool), (0, Tool::Polyline), "Escape: first the line");
        tools.close();
        assert_eq!((tools.lines.len(), tools.tool), (1, Tool::Inspect), "then the tool; what was measured stays");
    }

    /// With as many cards as there may be, the first half of a double click takes the oldest one's place: it comes back.
    #[test]
    fn a_double_click_costs_no_card() {
        let (ctx, facts) = (Context::default(), facts());
        let mut tools = Tools::default();
        for record in 1..=16 {
            tools.click(DVec2::ONE);
            tools.take(&ctx, &facts, at(record));
        }
        let before = tools.pins.records();
        assert_eq!(before.len(), 16);
        tools.click(DVec2::ONE);
        tools.take(&ctx, &facts, at(17));
        assert_ne!(tools.pins.records(), before);
        tools.double_click();
        assert_eq!(tools.pins.records(), before);
    }

    #[test]
    fn cards_and_lines_follow_their_files_to_other_record_numbers() {
        let (ctx, mut before) = (Context::default(), (*facts()).clone());
        let file = |name: &str, first_record| FileFacts {
            path: name.into(),
            first_record,
            points_in_header: 100,
            ..Default::default()
        };
        before.files = vec![file("a.las", 0), file("b.las", 100)];
        let before = Arc::new(before);
        let mut tools = Tools::default();
        for record in [7, 105] {
            tools.take(&ctx, &before, at(record));
        }
        tools.tool = Tool::Polyline;
        for (from, to) in [(101, 103), (3, 103)] {
            tools.take(&ctx, &before, at(from));
            tools.take(&ctx, &before, at(to));
            tools.finish();
        }
        // Without the first file, on a grid of tenths.
        let grid = Grid { scale: [0.1; 3], origin: [100.0, 0.0, 0.0] };
        let now = SceneFacts { grid, files: vec![file("c.las", 0), file("b.las", 40)], ..(*before).clone() };
        let tools = tools.in_scene(&before, &now);
        assert_eq!(tools.pins.records(), [45]);
        let [line] = &tools.lines[..] else { panic!("{:?}", tools.lines) };
        let points = [(41, [10, 0, 0]), (43, [30, 0, 0])];
        assert_eq!(points, [0, 1].map(|i| (line.points[i].record, line.points[i].position)));
        assert!(line.text(&now).contains("2.0"), "{}", line.text(&now));
        assert_eq!(tools.tool, Tool::Polyline);
    }

    #[test]
    fn escape_puts_cards_away_one_by_one() {
        let (ctx, facts) = (Context::default(), facts());
        let mut tools = Tools::default();
        for record in [1, 2, 2] {
            tools.take(&ctx, &facts, at(record));
        }
        assert_eq!(tools.pins.len(), 2, "a point has one card");
        tools.close();
        assert_eq!(tools.pins.len(), 1);
        tools.click(DVec2::ONE);
        tools.take(&ctx, &facts, at(3));
        assert!(tools.double_click(), "the double click is the camera's");
        assert_eq!(tools.pins.len(), 1, "and its first half pins nothing");
        tools.click(DVec2::ONE);
        assert!(tools.double_click(), "beside all points");
        assert_eq!(tools.pins.len(), 1, "there is nothing to take back");
        tools.tool = Tool::Box;
        let mut clip = Clip { bounds: Some(handles::whole_box(&facts.bounds)), slab: None };
        tools.obey(Command::Remove, &ctx, &facts, DVec2::ZERO, &mut clip);
        assert_eq!((clip.bounds, tools.pins.len()), (None, 1), "Delete takes the box, not the card");
    }
}
