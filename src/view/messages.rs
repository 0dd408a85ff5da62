//! What went wrong, in plain words, until the user puts it away.

use std::collections::VecDeque;

use eframe::egui::{
    self, Area, Color32, FontId, Frame, Id, Margin, Order, TextFormat,
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

#[derive(Debug, Default)]
pub struct Messages {
    entries: VecDeque<(Severity, String)>,
}

impl Messages {
    pub fn clear(&mut self) {
        self.entries.clear();
    }

    /// Errors go before notes. What is shown already is not repeated.
    pub fn add(&mut self, severity: Severity, text: impl Into<String>) {
        let entry = (severity, text.into());
        match severity {
            Severity::Error => log::error!("{}", entry.1),
            Severity::Note => log::warn!("{}", entry.1),
        }
        if self.entries.contains(&entry) {
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

    /// In the upper left corner, each with a button that puts it away.
    pub fn show(&mut self, ctx: &egui::Context) {
        if self.entries.is_empty() {
            return;
        }
        let screen = ctx.content_rect();
        let width = (screen.width() - 80.0).clamp(60.0, 640.0);
        // At most half of the window, if all of them are long.
        let shown = ((screen.height() * 0.5 / HEIGHT) as usize).clamp(1, SHOWN);
        let corner = screen.min + vec2(10.0, 10.0);
        let area = Area::new(Id::unique("messages")).order(Order::Foreground).fixed_pos(corner).constrain(false);
        area.show(ctx, |ui| {
            let mut dismissed = None;
            for (at, (severity, text)) in self.entries.iter().take(shown).enumerate() {
                if message(ui, *severity, text, width) {
                    dismissed = Some(at);
                }
            }
            let more = self.entries.len().saturating_sub(shown);
            if more > 0 && message(ui, Severity::Note, &format!("and {more} more; put all of them away"), width) {
                self.entries.clear();
            } else if let Some(at) = dismissed {
                self.entries.remove(at);
            }
        });
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
        let dismissed = ui.small_button("×").on_hover_text("Put away").clicked();
        let format = TextFormat::simple(FontId::proportional(13.0), Color32::WHITE);
        let mut job = LayoutJob::single_section(text.to_owned(), format);
        job.wrap = TextWrapping { max_width: width, max_rows: ROWS, ..Default::default() };
        let galley = ui.painter().layout_job(job);
        let elided = galley.elided;
        let label = ui.label(galley);
        if elided {
            label.on_hover_text(text);
        }
        dismissed
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
        let texts: Vec<&str> = messages.entries.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(texts, ["broken", "odd"]);
        for i in 0..2 * KEPT {
            messages.add(Severity::Error, i.to_string());
        }
        assert_eq!(messages.entries.len(), KEPT);
    }
}
