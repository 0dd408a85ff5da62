//! What points are coloured by, and with which colours.

use eframe::egui::{
    Color32, ColorImage, ComboBox, DragValue, Grid, ProgressBar, Rect, Role, Sense, Slider, TextEdit, TextureHandle,
    TextureOptions, Ui, WidgetInfo, pos2, vec2,
};

use super::{super::format::count, ticks};
use crate::{
    render::{Class, ColorBy, ColorMap, Coloring, Filter, Tone},
    scene::Attribute,
};

/// Height of the histogram, points.
const HISTOGRAM: f32 = 64.0;
/// Bars of the histogram.
pub const BARS: usize = 120;
/// Values that are listed one by one.
const LISTED: usize = 64;

/// What is known of the colours.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Colors {
    /// What the files on screen can be coloured by.
    pub choices: Vec<ColorBy>,
    /// Of the attribute in use: its values lie between these.
    pub extent: Option<[f64; 2]>,
    /// Points in equal parts of the extent.
    pub bars: Vec<u64>,
    /// The values with the first and the last colour.
    pub range: Option<[f64; 2]>,
    /// Values that are told apart: number, name, colour, points.
    pub values: Vec<Value>,
    /// What is being read again, and how far that is.
    pub reading: Option<(String, f32)>,
    /// High-quality shading is asked for and cannot average these colours.
    pub cannot_average: bool,
}

impl Colors {
    /// The next of the choices, or the one before; after the last comes the first, and after what is none of them too.
    pub fn step(&self, coloring: &mut Coloring, forward: bool) {
        let count = self.choices.len();
        let at = self.choices.iter().position(|choice| *choice == coloring.by);
        let next = at.map_or(0, |at| (at + if forward { 1 } else { count - 1 }) % count);
        let Some(next) = self.choices.get(next) else { return };
        coloring.by = next.clone();
        coloring.range = None;
    }
}

/// One of the values that are told apart.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Value {
    pub number: u32,
    pub name: String,
    pub color: [u8; 3],
    pub points: u64,
}

/// Shows the section.
pub fn show(ui: &mut Ui, colors: &Colors, coloring: &mut Coloring, filter: &mut Filter, legend: &mut bool) {
    let by = coloring.by.clone();
    ComboBox::from_label("Colour by").selected_text(title(&by)).width(150.0).show_ui(ui, |ui| {
        for choice in &colors.choices {
            ui.selectable_value(&mut coloring.by, choice.clone(), title(choice));
        }
    });
    if coloring.by != by {
        // It was one of the other attribute's values.
        coloring.range = None;
    }
    if let Some((what, done)) = &colors.reading {
        ui.label(format!("Reading {what} …"));
        ui.add(ProgressBar::new(*done).desired_height(6.0))
            .on_hover_text("The points stay; only these values are read");
    }
    if colors.cannot_average {
        ui.small("High quality shows front points only with this attribute.");
    }
    match by.attribute().cloned() {
        Some(attribute) if attribute.is_categorical() => values(ui, &attribute, colors, coloring, filter),
        Some(_) => scale(ui, colors, coloring),
        None => {}
    }
    if by.attribute().is_some() {
        ui.checkbox(legend, "Legend").on_hover_text("What the colours mean, over the picture");
    }
    tone(ui, &mut coloring.tone);
}

/// As people say it.
pub fn title(by: &ColorBy) -> String {
    match by {
        ColorBy::Auto => "Automatic".into(),
        ColorBy::Rgb => "RGB".into(),
        ColorBy::Attribute(attribute) => attribute_title(attribute),
    }
}

/// As people say it.
pub fn attribute_title(attribute: &Attribute) -> String {
    match attribute {
        Attribute::GpsTime => "GPS time".into(),
        Attribute::Extra(name) => name.clone(),
        other => {
            let text = other.to_string().replace('-', " ");
            super::super::scene_state::sentence(&text)
        }
    }
}

fn scale(ui: &mut Ui, colors: &Colors, coloring: &mut Coloring) {
    let in_use = coloring.map_in_use();
    ComboBox::from_label("Colour map").selected_text(in_use.name()).width(150.0).show_ui(ui, |ui| {
        ui.selectable_value(&mut coloring.map, None, "usual");
        for map in ColorMap::ALL {
            ui.horizontal(|ui| {
                ui.selectable_value(&mut coloring.map, Some(map), map.name());
                let (rect, _) = ui.allocate_exact_size(vec2(80.0, 12.0), Sense::hover());
                ramp(ui, rect, map);
            });
        }
    });
    let (Some(extent), Some(range)) = (colors.extent, colors.range) else { return };
    if let Some(chosen) = histogram(ui, colors, extent, range, in_use) {
        coloring.range = Some(chosen);
    }
    let mut range = range;
    let speed = ((extent[1] - extent[0]) / 300.0).max(f64::MIN_POSITIVE);
    let mut changed = false;
    ui.horizontal(|ui| {
        for (at, name) in ["From", "to"].into_iter().enumerate() {
            let label = ui.label(name);
            let value = ui.add(DragValue::new(&mut range[at]).speed(speed).max_decimals(6)).labelled_by(label.id);
            changed |= value.on_hover_text("Drag, or click to type").changed();
        }
    });
    if changed && range[0] <= range[1] {
        coloring.range = Some(range);
    }
    let mut automatic = coloring.range.is_none();
    ui.horizontal(|ui| {
        if ui
            .checkbox(&mut automatic, "Automatic range")
            .on_hover_text("From the points, without the outliers")
            .changed()
        {
            coloring.range = (!automatic).then_some(range);
        }
        let clip =
            DragValue::new(&mut coloring.clip_percent).range(0.0..=49.0).speed(0.05).max_decimals(2).suffix(" %");
        let clip = ui.add_enabled(automatic, clip).on_hover_text("Of the points, left out at either end");
        clip.widget_info(|| WidgetInfo::labeled(Role::SpinButton, automatic, "Percent left out at either end"));
    });
}

/// Bars, the ramp below them, and two handles that are dragged; gives the new range.
fn histogram(ui: &mut Ui, colors: &Colors, extent: [f64; 2], range: [f64; 2], map: ColorMap) -> Option<[f64; 2]> {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width().max(60.0), HISTOGRAM + 10.0), Sense::hover());
    let bars = Rect::from_min_max(rect.min, pos2(rect.right(), rect.bottom() - 10.0));
    let visuals = ui.visuals().clone();
    ui.painter().rect_filled(bars, 2, visuals.extreme_bg_color);
    let most = colors.bars.iter().copied().max().unwrap_or(0).max(1) as f32;
    let width = bars.width() / colors.bars.len().max(1) as f32;
    for (at, &n) in colors.bars.iter().enumerate().filter(|(_, n)| **n > 0) {
        // Roots: one peak must not flatten all others.
        let height = (n as f32 / most).sqrt() * bars.height();
        let left = bars.left() + at as f32 * width;
        let bar = Rect::from_min_max(pos2(left, bars.bottom() - height), pos2(left + width, bars.bottom()));
        ui.painter().rect_filled(bar, 0, visuals.weak_text_color());
    }
    let span = (extent[1] - extent[0]).max(f64::MIN_POSITIVE);
    let x_of = |value: f64| bars.left() + ((value - extent[0]) / span).clamp(0.0, 1.0) as f32 * bars.width();
    let (left, right) = (x_of(range[0]), x_of(range[1]));
    ramp(ui, Rect::from_min_max(pos2(left, bars.bottom() + 2.0), pos2(right.max(left + 1.0), rect.bottom())), map);
    let mut chosen = None;
    for (at, x) in [left, right].into_iter().enumerate() {
        let grip = Rect::from_center_size(pos2(x, bars.center().y), vec2(10.0, bars.height()));
        let response = ui.interact(grip, ui.scope_id().with(("range", at)), Sense::drag());
        let name = if at == 0 { "Value of the first colour" } else { "Value of the last colour" };
        response.widget_info(|| WidgetInfo::slider(true, range[at], name));
        let color =
            if response.hovered() || response.dragged() { visuals.selection.bg_fill } else { visuals.text_color() };
        ui.painter().vline(x, bars.y_range(), (2.0, color));
        if response.dragged()
            && let Some(pointer) = response.interact_pointer_pos()
        {
            let value = extent[0] + f64::from((pointer.x - bars.left()) / bars.width()).clamp(0.0, 1.0) * span;
            let mut range = range;
            range[at] = value;
            // One handle pushes the other.
            range[1 - at] = if at == 0 { range[1].max(value) } else { range[0].min(value) };
            chosen = Some(range);
        }
        response.on_hover_text(name);
    }
    chosen
}

/// A colour map from left to right.
pub fn ramp(ui: &Ui, rect: Rect, map: ColorMap) {
    ramp_along(ui.painter(), &texture(ui, map), rect);
}

fn ramp_along(painter: &eframe::egui::Painter, texture: &TextureHandle, rect: Rect) {
    painter.image(texture.id(), rect, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
}

/// Made once for each map.
fn texture(ui: &Ui, map: ColorMap) -> TextureHandle {
    let id = eframe::egui::Id::unique("colour map").with(map.name());
    if let Some(texture) = ui.data(|data| data.get_temp::<TextureHandle>(id)) {
        return texture;
    }
    let pixels = map.colors().map(|[r, g, b, _]| Color32::from_rgb(r, g, b)).to_vec();
    let texture = ui.ctx().load_texture(map.name(), ColorImage::new([256, 1], pixels), TextureOptions::LINEAR);
    ui.data_mut(|data| data.insert_temp(id, texture.clone()));
    texture
}

/// Names and colours of values that are told apart, with a tick for those that are shown.
fn values(ui: &mut Ui, attribute: &Attribute, colors: &Colors, coloring: &mut Coloring, filter: &mut Filter) {
    let are_classes = *attribute == Attribute::Classification;
    Grid::new("values").num_columns(4).min_col_width(16.0).striped(true).show(ui, |ui| {
        for value in colors.values.iter().take(LISTED) {
            tick(ui, attribute, value, filter);
            if are_classes {
                class(ui, value, coloring);
            } else {
                let (rect, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
                let [r, g, b] = value.color;
                ui.painter().rect_filled(rect, 2, Color32::from_rgb(r, g, b));
                ui.label(&value.name);
            }
            ui.label(count(value.points)).on_hover_text(format!("{} points", value.points));
            ui.end_row();
        }
    });
    if colors.values.len() > LISTED {
        ui.label(format!("and {} more", colors.values.len() - LISTED));
    }
    if are_classes && coloring.classes.changed().next().is_some() {
        let reset = ui.button("Usual classes").on_hover_text("Names and colours as ASPRS has them");
        if reset.clicked() {
            coloring.classes.reset();
        }
    }
}

/// A tick box that shows or hides a value.
pub fn tick(ui: &mut Ui, attribute: &Attribute, value: &Value, filter: &mut Filter) {
    let mut shown = ticks::is_shown(filter, attribute, value.number);
    let tick = ui.checkbox(&mut shown, "").on_hover_text("Show these points");
    tick.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, shown, format!("Show {}", value.name)));
    if tick.changed() {
        ticks::set_shown(filter, attribute, value.number, shown);
    }
}

fn class(ui: &mut Ui, value: &Value, coloring: &mut Coloring) {
    let number = value.number as u8;
    let Class { name, mut color } = coloring.classes.get(number);
    let button = ui.color_edit_button_srgb(&mut color).on_hover_text("Its colour");
    button.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Colour of class {number}")));
    let mut text = name.to_string();
    let size = vec2(130.0, ui.spacing().interact_size.y);
    let field = ui.add_sized(size, TextEdit::singleline(&mut text)).on_hover_text(format!("Class {number}: {name}"));
    field.widget_info(|| {
        let mut info = WidgetInfo::text_edit(true, "", text.as_str(), "");
        info.label = Some(format!("Name of class {number}"));
        info
    });
    if button.changed() || field.changed() {
        coloring.classes.set(number, Class { name: text.into(), color });
    }
}

fn tone(ui: &mut Ui, tone: &mut Tone) {
    ui.add_space(4.0);
    ui.add(Slider::new(&mut tone.brightness, -1.0..=1.0).max_decimals(2).text("Brightness"));
    ui.add(Slider::new(&mut tone.contrast, 0.0..=10.0).logarithmic(true).max_decimals(2).text("Contrast"));
    ui.add(Slider::new(&mut tone.gamma, 0.1..=10.0).logarithmic(true).max_decimals(2).text("Gamma"));
    if !tone.is_neutral()
        && ui.button("Usual tone").on_hover_text("Brightness, contrast and gamma as they were").clicked()
    {
        *tone = Tone::default();
    }
}
