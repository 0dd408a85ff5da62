//! The cheat sheet: all keys and what the mouse does.

use eframe::egui::{Align2, Area, Context, Frame, Grid, Id, Key, Order, RichText, ScrollArea, Ui, vec2};

use super::settings::Settings;

/// Groups of keys: a heading, and rows of what to press and what it does.
const GROUPS: [(&str, &[(&str, &str)]); 4] = [
    (
        "Move",
        &[
            ("Left drag", "orbit"),
            ("Right or middle drag, Shift + left", "pan: the grabbed point follows"),
            ("Wheel, pinch", "zoom to the cursor"),
            ("Double click", "orbit around the point there"),
            ("W A S D", "fly forward, left, back, right"),
            ("Q E", "fly down, up"),
            ("Shift with these", "five times as fast"),
            ("Home, H", "fit all"),
            ("7, 1, 3", "from above, from the south, from the east"),
        ],
    ),
    (
        "Look",
        &[
            ("[ ]  or  - =", "point size"),
            ("V, Shift + V", "the next colours, the ones before"),
            ("L", "eye-dome lighting on or off"),
            ("B", "high quality (blends near points) on or off"),
        ],
    ),
    (
        "Files and pictures",
        &[
            ("Ctrl+O", "open files"),
            ("Ctrl+Shift+O", "open a folder"),
            ("Drop files or folders", "open them instead, or besides if Add is ticked"),
            ("Ctrl+S", "save the picture"),
            ("Ctrl+Shift+C", "copy the command that makes this picture"),
        ],
    ),
    (
        "Window",
        &[
            ("Tab", "panel on or off"),
            ("F6", "keyboard to the panel: then Tab, arrows, Space, Enter"),
            ("Esc", "keyboard back to the picture"),
            ("O", "status lines on or off"),
            ("F1, ?", "this help"),
        ],
    ),
];

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

fn contents(ui: &mut Ui) {
    for (heading, rows) in GROUPS {
        ui.add_space(4.0);
        ui.strong(heading);
        Grid::new(heading).num_columns(2).min_col_width(210.0).spacing(vec2(20.0, 3.0)).show(ui, |ui| {
            for (keys, meaning) in rows {
                ui.label(RichText::new(*keys).monospace());
                ui.label(*meaning);
                ui.end_row();
            }
        });
    }
}
