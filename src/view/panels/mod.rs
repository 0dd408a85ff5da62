//! The side panel: sections that open and close. Each shows a model that it is given, changes settings, and asks for
//! the rest with requests; so it needs no GPU, and tests can click through it.

pub mod color;
pub mod files;
pub mod filter;
pub mod look;
pub mod messages;
pub mod performance;
pub mod share;
mod ticks;

use std::path::{Path, PathBuf};

use eframe::egui::{CollapsingHeader, Context, Panel, RichText, ScrollArea, Ui, scroll_area::ScrollSource};

use super::{
    messages::Messages,
    requests::Request,
    settings::{Section, Settings, Theme},
};

/// So much of the window is left to the picture.
const PICTURE_WIDTH: f32 = 240.0;
const NARROWEST: f32 = 220.0;

/// All that the panel shows.
pub struct Model<'a> {
    pub files: &'a files::Files,
    pub colors: &'a color::Colors,
    pub filters: &'a filter::Filters,
    pub performance: &'a performance::Performance,
    pub share: &'a mut share::Share,
    pub messages: &'a Messages,
    /// What the user has typed, and is no setting.
    pub typed: &'a mut Typed,
}

/// Texts in fields.
#[derive(Debug, Default)]
pub struct Typed {
    pub path: String,
    /// What is opened next comes besides what is shown.
    pub add: bool,
    /// A clause of the filter, and what is wrong with it.
    pub clause: String,
    pub clause_error: Option<String>,
    /// The keyboard is asked for by the panel's first control.
    pub focus: bool,
}

impl Typed {
    /// These are open now: a path among them has done its work.
    pub fn note_opened(&mut self, inputs: &[PathBuf]) {
        if inputs.iter().any(|input| input.as_path() == Path::new(self.path.trim())) {
            self.path.clear();
        }
    }
}

/// Whether a window of this width has room for the panel beside the picture.
pub fn fits(ctx: &Context) -> bool {
    let size = ctx.content_rect().size();
    size.x >= NARROWEST + PICTURE_WIDTH && size.y >= 160.0
}

/// Shows the panel, if it is asked for and there is room.
pub fn side(ui: &mut Ui, settings: &mut Settings, model: &mut Model<'_>, requests: &mut Vec<Request>) {
    if !settings.panel || !fits(ui.ctx()) {
        return;
    }
    let widest = ui.ctx().content_rect().width() - PICTURE_WIDTH;
    let panel = Panel::right("panel")
        .default_size(settings.panel_width.clamp(NARROWEST, widest))
        .size_range(NARROWEST..=widest);
    let shown = panel.show(ui, |ui| {
        ui.take_available_width();
        let area = ScrollArea::vertical()
            .auto_shrink(false)
            .scroll_source(ScrollSource::SCROLL_BAR | ScrollSource::MOUSE_WHEEL);
        area.show(ui, |ui| contents(ui, settings, model, requests));
    });
    settings.panel_width = shown.response.rect.width().round();
}

/// The sections, one below the other.
pub fn contents(ui: &mut Ui, settings: &mut Settings, model: &mut Model<'_>, requests: &mut Vec<Request>) {
    ui.add_space(4.0);
    top(ui, settings, model.typed);
    section(ui, settings, Section::Files, "Files", |ui, settings| {
        files::show(ui, model.files, settings, model.typed, requests);
    });
    section(ui, settings, Section::Color, "Colour", |ui, settings| {
        let look = &mut settings.look;
        color::show(ui, model.colors, &mut look.coloring, &mut look.filter, &mut look.decor.legend);
    });
    section(ui, settings, Section::Filter, "Filter", |ui, settings| {
        let look = &mut settings.look;
        filter::show(ui, model.filters, &mut look.filter, &mut look.clip, model.typed, requests);
    });
    section(ui, settings, Section::Look, "Look", look::show);
    section(ui, settings, Section::Share, "Share", |ui, _| share::show(ui, model.share, requests));
    section(ui, settings, Section::Performance, "Performance", |ui, _| performance::show(ui, model.performance));
    let messages = match model.messages.len() {
        0 => "Messages".to_owned(),
        n => format!("Messages ({n})"),
    };
    section(ui, settings, Section::Messages, &messages, |ui, _| messages::show(ui, model.messages, requests));
}

fn top(ui: &mut Ui, settings: &mut Settings, typed: &mut Typed) {
    ui.horizontal(|ui| {
        let hide = ui.button("Hide").on_hover_text("Hide this panel (Tab)");
        if std::mem::take(&mut typed.focus) {
            hide.request_focus();
        }
        if hide.clicked() {
            settings.panel = false;
        }
        if ui.button("Keys").on_hover_text("All keys and mouse buttons (F1 or ?)").clicked() {
            settings.help = !settings.help;
        }
        ui.menu_button("Theme", |ui| {
            for (theme, name) in Theme::ALL {
                if ui.radio_value(&mut settings.theme, theme, name).clicked() {
                    ui.close();
                }
            }
        })
        .response
        .on_hover_text("Dark or light controls");
    });
    ui.add_space(2.0);
}

/// A section that remembers whether it is open.
fn section(
    ui: &mut Ui,
    settings: &mut Settings,
    section: Section,
    title: &str,
    contents: impl FnOnce(&mut Ui, &mut Settings),
) {
    ui.separator();
    let is_open = settings.sections.contains(&section);
    let header = CollapsingHeader::new(RichText::new(title).strong()).id_salt(section as u32).open(Some(is_open));
    let shown = header.show_unindented(ui, |ui| {
        ui.add_space(2.0);
        contents(ui, settings);
        ui.add_space(4.0);
    });
    if shown.header_response.clicked() {
        if is_open {
            settings.sections.remove(&section);
        } else {
            settings.sections.insert(section);
        }
    }
}

/// A button that copies a text.
pub fn copy_button(ui: &mut Ui, label: &str, hint: &str, text: impl FnOnce() -> String) {
    if ui.button(label).on_hover_text(hint).clicked() {
        ui.ctx().copy_text(text());
    }
}

#[cfg(test)]
mod tests;
