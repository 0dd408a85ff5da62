//! The cheat sheet: all keys and what the mouse does.

use eframe::egui::{Align2, Area, Context, Frame, Grid, Id, Key, Order, RichText, ScrollArea, Ui, vec2};

use super::{
    keys::{self, Section},
    settings::Settings,
};

/// Shows the sheet in the middle of the window until Escape, a click on its button, or its key again.
pub fn show(ctx: &Context, settings: &mut Settings) {
    let screen = ctx.content_rect();
    let area = Area::new(Id::unique("help")).order(Order::Foreground).anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0));
    let area = area.default_size(vec2(640.0, screen.height() - 40.0));
    area.show(ctx, |ui| {
        Frame::window(ui.style()).inner_margin(14).show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.heading("Keys and mouse");
                if ui.button("Close").on_hover_text("Close this help (Esc)").clicked() {
                    settings.help = false;
                }
            });
            ScrollArea::vertical().max_height((screen.height() - 110.0).max(40.0)).show(ui, contents);
        });
    });
    if ctx.input(|i| i.key_pressed(Key::Escape)) {
        settings.help = false;
    }
}

/// Two columns: how to move, and all others.
fn contents(ui: &mut Ui) {
    ui.horizontal_top(|ui| {
        ui.vertical(|ui| section(ui, Section::Move));
        ui.add_space(16.0);
        ui.vertical(|ui| {
            for other in Section::ALL.into_iter().filter(|section| *section != Section::Move) {
                section(ui, other);
            }
        });
    });
}

fn section(ui: &mut Ui, section: Section) {
    ui.add_space(4.0);
    ui.strong(section.title());
    Grid::new(section.title()).num_columns(2).spacing(vec2(16.0, 3.0)).show(ui, |ui| {
        for row in keys::ROWS.iter().filter(|row| row.section == section) {
            ui.label(RichText::new(row.keys).monospace());
            ui.label(row.what);
            ui.end_row();
        }
    });
}
