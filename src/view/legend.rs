//! What the colours mean, over the picture.

use eframe::egui::{
    Align2, Area, Color32, Frame, Id, Margin, Order, Rect, Sense, TextStyle, TextWrapMode, Ui, pos2, vec2,
};

use crate::render::{Legend, LegendClass, LegendKey, Tick};

/// Values that are named; the panel lists all.
const NAMED: usize = 14;
/// Width and height of the bar of colours.
const BAR: [f32; 2] = [14.0, 150.0];

/// Shows it at the right edge of the picture, which takes `screen` of the window.
pub fn show(ui: &Ui, screen: Rect, legend: &Legend) {
    if screen.width() < 320.0 || screen.height() < 300.0 {
        return;
    }
    let corner = screen.right_top() + vec2(-10.0, 10.0);
    let area = Area::new(Id::unique("legend")).order(Order::Middle).pivot(Align2::RIGHT_TOP).fixed_pos(corner);
    area.interactable(false).show(ui.ctx(), |ui| {
        let [r, g, b, _] = ui.visuals().panel_fill.to_array();
        let fill = Color32::from_rgba_unmultiplied(r, g, b, 200);
        Frame::new().fill(fill).corner_radius(4).inner_margin(Margin::same(8)).show(ui, |ui| {
            // As wide as its title and names want, not as the area was when it showed another legend.
            ui.style_mut().wrap_mode = Some(TextWrapMode::Extend);
            ui.strong(&legend.title);
            match &legend.key {
                LegendKey::Scale { colors, ticks, .. } => scale(ui, colors, ticks),
                LegendKey::Classes(classes) => names(ui, classes),
            }
        });
    });
}

fn names(ui: &mut Ui, classes: &[LegendClass]) {
    for class in classes.iter().take(NAMED) {
        ui.horizontal(|ui| {
            let (rect, _) = ui.allocate_exact_size(vec2(12.0, 12.0), Sense::hover());
            let [r, g, b] = class.color;
            ui.painter().rect_filled(rect, 2, Color32::from_rgb(r, g, b));
            ui.label(&class.name);
        });
    }
    if classes.len() > NAMED {
        ui.small(format!("and {} more", classes.len() - NAMED));
    }
}

fn scale(ui: &mut Ui, colors: &[[u8; 3]], ticks: &[Tick]) {
    let font = TextStyle::Small.resolve(ui.style());
    let width = |tick: &Tick| ui.painter().layout_no_wrap(tick.text.clone(), font.clone(), Color32::WHITE).size().x;
    let widest = ticks.iter().map(width).fold(0.0, f32::max);
    let (rect, _) = ui.allocate_exact_size(vec2(BAR[0] + 8.0 + widest, BAR[1] + 8.0), Sense::hover());
    let bar = Rect::from_min_size(rect.min + vec2(0.0, 4.0), vec2(BAR[0], BAR[1]));
    let step = bar.height() / colors.len().max(1) as f32;
    for (at, &[r, g, b]) in colors.iter().enumerate() {
        let bottom = bar.bottom() - at as f32 * step;
        // A little higher than its share, so that nothing shows between two.
        let slice = Rect::from_min_max(pos2(bar.left(), bottom - step - 0.5), pos2(bar.right(), bottom));
        ui.painter().rect_filled(slice, 0, Color32::from_rgb(r, g, b));
    }
    for tick in ticks {
        let y = bar.bottom() - bar.height() * tick.place as f32;
        let color = ui.visuals().text_color();
        ui.painter().hline(bar.right()..=bar.right() + 3.0, y, (1.0, color));
        ui.painter().text(pos2(bar.right() + 6.0, y), Align2::LEFT_CENTER, &tick.text, font.clone(), color);
    }
}
