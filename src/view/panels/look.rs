//! How the scene is shown.

use eframe::egui::{Slider, SliderClamping, Ui};

use super::super::settings::Settings;
use crate::render::{MAX_PX, PointSize, Projection, Shading};

/// Strengths of eye-dome lighting that the control offers; more can be asked for on the command line.
const EDL: std::ops::RangeInclusive<f32> = 0.05..=4.0;

/// What the command line gave beyond the ends of a slider stays until the slider is moved.
fn beyond(slider: Slider<'_>) -> Slider<'_> {
    slider.clamping(SliderClamping::Edits)
}

/// Width of a point, in pixels or in space.
fn point_size(ui: &mut Ui, size: &mut PointSize) {
    let mut in_pixels = size.pixels().is_some();
    match size {
        PointSize::Pixels(pixels) => {
            ui.add(Slider::new(pixels, 1..=MAX_PX).text("Point size, px")).on_hover_text("Width of a point ([ and ])");
        }
        PointSize::World(length) => length_slider(ui, length, "units"),
        PointSize::Metres(length) => length_slider(ui, length, "m"),
        PointSize::Feet(length) => length_slider(ui, length, "ft"),
    }
    if ui
        .checkbox(&mut in_pixels, "In pixels")
        .on_hover_text("Or in metres (the file's unit where it does not say how long that is), larger from near")
        .changed()
    {
        *size = if in_pixels { PointSize::Pixels(2) } else { PointSize::Metres(0.05) };
    }
}

fn length_slider(ui: &mut Ui, length: &mut f64, unit: &str) {
    ui.add(beyond(Slider::new(length, 0.001..=10.0)).logarithmic(true).text(format!("Point size, {unit}")))
        .on_hover_text("Width of a point in space ([ and ])");
}

/// Shows the section.
pub fn show(ui: &mut Ui, settings: &mut Settings) {
    let shading = &mut settings.look.shading;
    point_size(ui, &mut settings.look.point_size);
    ui.checkbox(&mut settings.edl, "Eye-dome lighting").on_hover_text("Darkens what lies behind its neighbours (L)");
    let strength = beyond(Slider::new(&mut shading.edl_strength, EDL)).logarithmic(true).text("Strength");
    ui.add_enabled(settings.edl, strength).on_hover_text("Strength of eye-dome lighting");
    ui.checkbox(&mut shading.high_quality, "High quality")
        .on_hover_text("Mean colour of all points within 1 % of the nearest; twice the work (B)");
    ui.checkbox(&mut shading.fill_holes, "Fill holes")
        .on_hover_text("Small holes in surfaces get the colour of a point beside them");
    let mut orthographic = settings.look.projection == Projection::Orthographic;
    if ui.checkbox(&mut orthographic, "Orthographic").on_hover_text("Parallel lines stay parallel").changed() {
        settings.look.projection = if orthographic { Projection::Orthographic } else { Projection::Perspective };
    }
    ui.horizontal(|ui| {
        ui.checkbox(&mut settings.look.decor.bounding_box, "Box").on_hover_text("The scene's bounding box");
        ui.checkbox(&mut settings.look.decor.scale_bar, "Scale").on_hover_text("A scale bar");
        ui.checkbox(&mut settings.look.decor.north_arrow, "North").on_hover_text("A north arrow");
    });
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
