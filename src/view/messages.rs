//! What went wrong and what was done, in plain words. It appears over the picture, what went wrong until the user puts
//! it away, and stays in a list until that is cleared.

use std::{collections::VecDeque, time::Duration};

use eframe::egui::{
    self, Area, Color32, FontId, Frame, Id, Margin, Order, Rect, Role, TextFormat, WidgetInfo,
    text::{LayoutJob, TextWrapping},
    vec2,
};

use crate::source::SourceReport;

/// So many are shown at a time.
const SHOWN: usize = 4;
/// Lines of one message; the rest appears under the mouse.
const ROWS: usize = 3;
/// Of a message with that many lines.
const HEIGHT: f32 = 64.0;
/// Older ones are forgotten: a folder of broken files must not fill memory.
const KEPT: usize = 200;
/// Seconds that it is said for that something is done: time to read a path. Then it goes at once, as a window at rest
/// has no frames to fade in.
const DONE_SECS: f64 = 6.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// What was asked for is done; it goes by itself.
    Done,
    Note,
    Error,
}

#[derive(Debug, Clone, PartialEq)]
struct Entry {
    severity: Severity,
    text: String,
    /// Over the picture as well.
    shown: bool,
    /// When that was first, in the window's seconds.
    shown_at: Option<f64>,
    /// Of a scene that is gone.
    is_past: bool,
}

#[derive(Debug, Default)]
pub struct Messages {
    entries: VecDeque<Entry>,
}

impl Messages {
    pub fn clear(&mut self) {
        self.entries.clear();
    }

    /// Another scene is on screen: what was said of the last one stays in the list alone.
    pub fn begin_scene(&mut self) {
        for entry in &mut self.entries {
            (entry.shown, entry.is_past) = (false, true);
        }
    }

    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Errors first.
    pub fn iter(&self) -> impl Iterator<Item = (Severity, &str)> {
        self.entries.iter().map(|entry| (entry.severity, entry.text.as_str()))
    }

    /// One line each.
    pub fn to_text(&self) -> String {
        self.iter().map(|(severity, text)| format!("{}: {text}\n", severity.name())).collect()
    }

    /// Errors go before notes. What is in the list already is not repeated, unless it was done again or said of another
    /// scene.
    pub fn add(&mut self, severity: Severity, text: impl Into<String>) {
        let entry = Entry { severity, text: text.into(), shown: true, shown_at: None, is_past: false };
        match severity {
            Severity::Error => log::error!("{}", entry.text),
            Severity::Note => log::warn!("{}", entry.text),
            Severity::Done => log::info!("{}", entry.text),
        }
        let known = self.entries.iter().position(|known| (known.severity, &known.text) == (severity, &entry.text));
        if let Some(known) = known {
            if severity != Severity::Done && !self.entries[known].is_past {
                return;
            }
            self.entries.remove(known);
        }
        match severity {
            Severity::Error => self.entries.push_front(entry),
            Severity::Note | Severity::Done => self.entries.push_back(entry),
        }
        if self.entries.len() > KEPT {
            // What another scene said, else the oldest note, else the oldest error.
            let past = self.entries.iter().position(|entry| entry.is_past);
            let note = || self.entries.iter().position(|entry| entry.severity != Severity::Error);
            let oldest = past.or_else(note).unwrap_or(KEPT);
            self.entries.remove(oldest);
        }
    }

    /// All that a reader's report has to say.
    pub fn add_report(&mut self, report: &SourceReport) {
        for file in &report.files {
            let name = file.path.file_name().unwrap_or(file.path.as_os_str()).to_string_lossy();
            for warning in &file.warnings {
                self.add(Severity::Note, prefixed(&name, warning));
            }
            if let Some(error) = &file.error {
                self.add(Severity::Error, prefixed(&name, error));
            }
        }
    }

    /// In the upper left corner of the picture, each with a button that puts it away.
    pub fn show(&mut self, ctx: &egui::Context, screen: Rect) {
        let now = ctx.input(|i| i.time);
        self.let_go(ctx, now);
        let waiting = self.entries.iter().filter(|entry| entry.shown).count();
        if waiting == 0 {
            return;
        }
        let width = (screen.width() - 80.0).clamp(60.0, 640.0);
        // At most half of the window, if all of them are long.
        let most = ((screen.height() * 0.5 / HEIGHT) as usize).clamp(1, SHOWN);
        let corner = screen.min + vec2(10.0, 10.0);
        let area = Area::new(Id::unique("messages")).order(Order::Foreground).fixed_pos(corner).constrain(false);
        area.show(ctx, |ui| {
            for entry in self.entries.iter_mut().filter(|entry| entry.shown).take(most) {
                entry.shown = !message(ui, entry.severity, &entry.text, width);
            }
            let more = waiting.saturating_sub(most);
            if more > 0 && message(ui, Severity::Note, &format!("and {more} more; put all of them away"), width) {
                for entry in &mut self.entries {
                    entry.shown = false;
                }
            }
        });
    }

    /// What is done has been said for long enough, or will be: then the window wakes up.
    fn let_go(&mut self, ctx: &egui::Context, now: f64) {
        for entry in self.entries.iter_mut().filter(|entry| entry.shown && entry.severity == Severity::Done) {
            let left = *entry.shown_at.get_or_insert(now) + DONE_SECS - now;
            entry.shown = left > 0.0;
            if entry.shown {
                ctx.request_repaint_after(Duration::from_secs_f64(left));
            }
        }
    }
}

impl Severity {
    fn name(self) -> &'static str {
        match self {
            Severity::Done => "done",
            Severity::Note => "note",
            Severity::Error => "error",
        }
    }
}

/// True if it was put away.
fn message(ui: &mut egui::Ui, severity: Severity, text: &str, width: f32) -> bool {
    let (fill, mark) = match severity {
        Severity::Error => (Color32::from_rgb(92, 26, 26), Color32::from_rgb(255, 138, 128)),
        Severity::Note => (Color32::from_rgb(58, 48, 18), Color32::from_rgb(255, 213, 105)),
        Severity::Done => (Color32::from_rgb(38, 42, 48), Color32::from_rgb(160, 170, 182)),
    };
    let frame = Frame::new().fill(fill).stroke((1.0, mark)).corner_radius(4).inner_margin(Margin::symmetric(8, 5));
    let contents = |ui: &mut egui::Ui| {
        let button = ui.small_button("×").on_hover_text("Put away; it stays under Messages");
        button.widget_info(|| WidgetInfo::labeled(Role::Button, true, "Put away"));
        let format = TextFormat::simple(FontId::proportional(13.0), Color32::WHITE);
        let mut job = LayoutJob::single_section(text.to_owned(), format);
        job.wrap = TextWrapping { max_width: width, max_rows: ROWS, ..Default::default() };
        let galley = ui.painter().layout_job(job);
        let elided = galley.elided;
        let label = ui.label(galley);
        if elided {
            label.on_hover_text(text);
        }
        button.clicked()
    };
    frame.show(ui, |ui| ui.horizontal_top(contents).inner).inner
}

/// Readers name the file themselves where they can.
fn prefixed(name: &str, text: &str) -> String {
    if text.contains(name) { text.to_owned() } else { format!("{name}: {text}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_come_first_and_nothing_twice() {
        let mut messages = Messages::default();
        messages.add(Severity::Note, "odd");
        messages.add(Severity::Error, "broken");
        messages.add(Severity::Note, "odd");
        let texts: Vec<&str> = messages.iter().map(|(_, text)| text).collect();
        assert_eq!(texts, ["broken", "odd"]);
        assert_eq!(messages.to_text(), "error: broken\nnote: odd\n");
        for i in 0..2 * KEPT {
            messages.add(Severity::Error, i.to_string());
        }
        assert_eq!(messages.len(), KEPT);
    }

    /// Texts over the picture, `secs` into the window's life.
    fn shown(messages: &mut Messages, secs: f64) -> Vec<String> {
        let ctx = egui::Context::default();
        let screen = Rect::from_min_size(egui::Pos2::ZERO, vec2(900.0, 700.0));
        let input = egui::RawInput { time: Some(secs), ..Default::default() };
        let mut output = ctx.run_ui(input, |ui| messages.show(ui.ctx(), screen));
        output.textures_delta.clear();
        messages.entries.iter().filter(|entry| entry.shown).map(|entry| entry.text.clone()).collect()
    }

    #[test]
    fn what_is_done_goes_by_itself_and_comes_when_it_is_done_again() {
        let mut messages = Messages::default();
        messages.add(Severity::Note, "odd");
        messages.add(Severity::Done, "written");
        assert_eq!(shown(&mut messages, 10.0), ["odd", "written"]);
        assert_eq!(shown(&mut messages, 15.5), ["odd", "written"]);
        assert_eq!(shown(&mut messages, 16.1), ["odd"], "an oddity waits");
        messages.add(Severity::Done, "written");
        assert_eq!(shown(&mut messages, 20.0), ["odd", "written"]);
        assert_eq!(messages.to_text(), "note: odd\ndone: written\n");
    }

    #[test]
    fn another_scene_leaves_the_list_and_may_say_the_same() {
        let mut messages = Messages::default();
        messages.add(Severity::Error, "broken");
        messages.add(Severity::Note, "odd");
        messages.begin_scene();
        assert_eq!((shown(&mut messages, 1.0).len(), messages.len()), (0, 2));
        messages.add(Severity::Note, "odd");
        assert_eq!(shown(&mut messages, 2.0), ["odd"]);
        assert_eq!(messages.len(), 2);
    }
}
