//! The cheat sheet: all keys and what the mouse does.

use eframe::egui::{Align2, Area, Context, Frame, Grid, Id, Key, Label, Order, RichText, ScrollArea, Ui, vec2};

use super::{
    keys::{self, Section},
    settings::Settings,
};

/// Two columns take 1,050 points, and some of the window is left around them.
const COLUMNS_FROM: f32 = 1100.0;
/// The longest line of keys and the longest of what they do take 590 points; in narrower columns one is below the
/// other.
const ROWS_FROM: f32 = 600.0;

/// Shows the sheet in the middle of the window until Escape, a click on its button, or its key again.
pub fn show(ctx: &Context, settings: &mut Settings) {
    let screen = ctx.content_rect();
    let margin: i8 = if screen.width().min(screen.height()) < 400.0 { 6 } else { 14 };
    // Of the window's edge, around the sheet, some points stay free.
    let around = 2.0 * f32::from(margin) + 12.0;
    let area = Area::new(Id::unique("help")).order(Order::Foreground).anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0));
    area.show(ctx, |ui| {
        Frame::window(ui.style()).inner_margin(margin).show(ui, |ui| {
            let room = (screen.width() - around).max(1.0);
            let has_columns = screen.width() >= COLUMNS_FROM;
            ui.set_max_width(if has_columns { room } else { room.min(ROWS_FROM) });
            let head = ui.horizontal(|ui| {
                if ui.button("Close").on_hover_text("Close this help (Esc)").clicked() {
                    settings.help = false;
                }
                ui.add(Label::new(RichText::new("Keys and mouse").heading()).truncate());
            });
            let height = screen.height() - around - head.response.rect.height() - ui.spacing().item_spacing.y;
            ScrollArea::vertical()
                .max_height(height.max(1.0))
                .min_scrolled_height(1.0)
                .show(ui, |ui| if has_columns { columns(ui) } else { column(ui, &Section::ALL) });
        });
    });
    if ctx.input(|i| i.key_pressed(Key::Escape)) {
        settings.help = false;
    }
}

/// How to move, and beside it all others.
fn columns(ui: &mut Ui) {
    let [first, others @ ..] = &Section::ALL;
    ui.horizontal_top(|ui| {
        ui.vertical(|ui| column(ui, std::slice::from_ref(first)));
        ui.add_space(16.0);
        ui.vertical(|ui| column(ui, others));
    });
}

fn column(ui: &mut Ui, sections: &[Section]) {
    let has_rows = ui.available_width() >= ROWS_FROM - 20.0;
    for section in sections {
        ui.add_space(4.0);
        ui.strong(section.title());
        let rows = keys::ROWS.iter().filter(|row| row.section == *section);
        if has_rows {
            Grid::new(section.title()).num_columns(2).spacing(vec2(12.0, 3.0)).show(ui, |ui| {
                for row in rows {
                    ui.label(RichText::new(row.keys).monospace());
                    ui.label(row.what);
                    ui.end_row();
                }
            });
        } else {
            for row in rows {
                ui.add(Label::new(RichText::new(row.keys).monospace().strong()).wrap());
                ui.add(Label::new(row.what).wrap());
                ui.add_space(3.0);
            }
        }
    }
}
