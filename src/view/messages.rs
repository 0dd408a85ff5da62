//! What went wrong, in plain words. It appears over the picture until the user puts it away, and stays in a list until
//! that is cleared.

use std::collections::VecDeque;

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

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    Note,
    Error,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Entry {
    severity: Severity,
    text: String,
    /// Over the picture as well.
    shown: bool,
}

#[derive(Debug, Default)]
pub struct Messages {
    entries: VecDeque<Entry>,
}

impl Messages {
    pub fn clear(&mut self) {
        self.entries.clear();
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

    /// Errors go before notes. What is in the list already is not repeated.
    pub fn add(&mut self, severity: Severity, text: impl Into<String>) {
        let entry = Entry { severity, text: text.into(), shown: true };
        match severity {
            Severity::Error => log::error!("{}", entry.text),
            Severity::Note => log::warn!("{}", entry.text),
        }
        if self.entries.iter().any(|known| (known.severity, &known.text) == (severity, &entry.text)) {
            return;
        }
        match severity {
            Severity::Error => self.entries.push_front(entry),
            Severity::Note => self.entries.push_back(entry),
        }
        self.entries.truncate(KEPT);
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
}

impl Severity {
    fn name(self) -> &'static str {
        match self {
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
}
