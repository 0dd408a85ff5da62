//! How the scene is shown.

use eframe::egui::{Slider, Ui};

use super::super::{overlay::POINT_SIZES, settings::Settings};
use crate::render::Shading;

/// Strengths of eye-dome lighting that the control offers; more can be asked for on the command line.
const EDL: std::ops::RangeInclusive<f32> = 0.05..=4.0;

/// Shows the section.
pub fn show(ui: &mut Ui, settings: &mut Settings) {
    let shading = &mut settings.look.shading;
    ui.add(Slider::new(&mut settings.look.point_size, POINT_SIZES).text("Point size, px"))
        .on_hover_text("Width of a point ([ and ])");
    ui.checkbox(&mut settings.edl, "Eye-dome lighting").on_hover_text("Darkens what lies behind its neighbours (L)");
    ui.add_enabled(settings.edl, Slider::new(&mut shading.edl_strength, EDL).logarithmic(true).text("Strength"))
        .on_hover_text("Strength of eye-dome lighting");
    ui.checkbox(&mut shading.high_quality, "High quality")
        .on_hover_text("Mean colour of all points within 1 % of the nearest; twice the work (B)");
    ui.checkbox(&mut settings.smooth, "Glide to views").on_hover_text(
        "The camera goes to a view that is asked for in a quarter of a second, instead of jumping there",
    );
    let shading = &mut settings.look.shading;
    ui.horizontal(|ui| {
        let label = ui.label("Background");
        ui.color_edit_button_srgb(&mut shading.background).labelled_by(label.id).on_hover_text("Where no point is");
        if ui.small_button("White").clicked() {
            shading.background = [255; 3];
        }
        if ui.small_button("Usual").clicked() {
            shading.background = Shading::default().background;
        }
    });
}
