//! Which points are shown: by class, return, source, file, and ranges of numbers.

use eframe::egui::{CollapsingHeader, DragValue, Grid, Label, RichText, TextEdit, Ui, WidgetInfo};

use super::{
    super::{format::count, requests::Request},
    Typed,
    color::{Value, attribute_title, tick},
    ticks,
};
use crate::{
    render::{Clause, Clip, Filter},
    scene::Attribute,
};

/// Values that are listed one by one.
const LISTED: usize = 100;

/// What can be filtered by, and what is known of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Filters {
    /// Attributes whose values are ticked one by one.
    pub tables: Vec<Table>,
    /// Attributes that are cut to a range: between these their values lie, where that is known.
    pub ranges: Vec<(Attribute, Option<[f64; 2]>)>,
    /// Points that are shown, and all that are stored.
    pub shown: Option<[u64; 2]>,
}

/// The values of an attribute.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub attribute: Attribute,
    /// Empty before they are read.
    pub values: Vec<Value>,
    /// Not all values have come yet.
    pub is_partial: bool,
}

/// Shows the section.
pub fn show(
    ui: &mut Ui,
    filters: &Filters,
    filter: &mut Filter,
    clip: &mut Clip,
    typed: &mut Typed,
    requests: &mut Vec<Request>,
) {
    ui.horizontal_wrapped(|ui| {
        match filters.shown {
            Some([shown, all]) if shown < all => ui.label(format!("{} of {} points shown", count(shown), count(all))),
            _ => ui.label("All points are shown."),
        };
        let is_on = !filter.clauses.is_empty() || *clip != Clip::default();
        if ui
            .add_enabled(is_on, eframe::egui::Button::new("Show all").small())
            .on_hover_text("No filter, no clipping")
            .clicked()
        {
            filter.clauses.clear();
            *clip = Clip::default();
        }
    });
    clauses(ui, filter, clip);
    for table in &filters.tables {
        let title = attribute_title(&table.attribute);
        let header = CollapsingHeader::new(&title).id_salt(("filter", &title));
        header.default_open(table.attribute == Attribute::Classification).show(ui, |ui| {
            values(ui, table, filter, requests);
        });
    }
    CollapsingHeader::new("Ranges").show(ui, |ui| {
        for (attribute, extent) in &filters.ranges {
            range(ui, attribute, *extent, filter);
        }
    });
    text(ui, filter, typed);
}

/// What holds now, each with a button that takes it away.
fn clauses(ui: &mut Ui, filter: &mut Filter, clip: &mut Clip) {
    let mut gone = None;
    for (number, clause) in filter.clauses.iter().enumerate() {
        let text = clause.to_string();
        if line(ui, &text) {
            gone = Some(number);
        }
    }
    if let Some(gone) = gone {
        filter.clauses.remove(gone);
    }
    if clip.bounds.is_some() && line(ui, "clipping box") {
        clip.bounds = None;
    }
    if clip.slab.is_some() && line(ui, "section") {
        clip.slab = None;
    }
}

/// True if it is to go.
fn line(ui: &mut Ui, text: &str) -> bool {
    ui.horizontal(|ui| {
        let button = ui.small_button("×").on_hover_text("Take this away");
        button.widget_info(|| WidgetInfo::labeled(eframe::egui::Role::Button, true, format!("Take away {text}")));
        ui.add(Label::new(RichText::new(text).monospace()).truncate()).on_hover_text(text);
        button.clicked()
    })
    .inner
}

fn values(ui: &mut Ui, table: &Table, filter: &mut Filter, requests: &mut Vec<Request>) {
    let attribute = &table.attribute;
    if table.values.is_empty() {
        let read =
            ui.button("Read the values").on_hover_text("Reads this attribute of all points; the picture goes on");
        read.widget_info(|| {
            let name = format!("Read the values: {}", attribute_title(attribute));
            WidgetInfo::labeled(eframe::egui::Role::Button, true, name)
        });
        if read.clicked() {
            requests.push(Request::Read(attribute.clone()));
        }
        return;
    }
    ui.horizontal(|ui| {
        if ui.small_button("All").clicked() {
            filter.set(attribute, None);
        }
        if ui.small_button("None").clicked() {
            ticks::hide(filter, attribute, table.values.iter().map(|value| value.number));
        }
        if table.is_partial {
            ui.small("as far as it is read");
        }
    });
    Grid::new(("values", attribute.to_string())).num_columns(3).min_col_width(16.0).striped(true).show(ui, |ui| {
        for value in table.values.iter().take(LISTED) {
            tick(ui, attribute, value, filter);
            ui.label(&value.name);
            ui.label(count(value.points)).on_hover_text(format!("{} points", value.points));
            ui.end_row();
        }
    });
    if table.values.len() > LISTED {
        ui.label(format!("and {} more", table.values.len() - LISTED));
    }
}

/// Cuts an attribute to what lies between two numbers.
fn range(ui: &mut Ui, attribute: &Attribute, extent: Option<[f64; 2]>, filter: &mut Filter) {
    let clause = filter.of(attribute).cloned();
    let found = clause.as_ref().filter(|clause| !clause.is_excluding).and_then(|clause| clause.values.ranges().first());
    let mut range = found.copied().or(extent).unwrap_or([0.0, 1.0]);
    let mut is_on = clause.is_some();
    let title = attribute_title(attribute);
    let mut changed = ui.checkbox(&mut is_on, &title).on_hover_text("Show only values in a range").changed();
    if is_on {
        let [low, high] = extent.unwrap_or(range);
        let speed = ((high - low) / 300.0).max(1e-6);
        ui.horizontal(|ui| {
            for (at, name) in ["from", "to"].into_iter().enumerate() {
                let mut field = DragValue::new(&mut range[at]).speed(speed).prefix(format!("{name} "));
                field = field.max_decimals(if *attribute == Attribute::Intensity { 0 } else { 6 });
                if let Some([least, most]) = attribute.limits() {
                    field = field.range(least..=most);
                }
                let field = ui.add(field);
                field.widget_info(|| {
                    WidgetInfo::labeled(eframe::egui::Role::SpinButton, true, format!("{title} {name}"))
                });
                changed |= field.changed();
            }
        });
    }
    if changed && range[0] <= range[1] {
        filter.set(attribute, is_on.then(|| Clause::between(attribute.clone(), range[0], range[1])));
    }
}

/// A clause as `--filter` takes it.
fn text(ui: &mut Ui, filter: &mut Filter, typed: &mut Typed) {
    let field = TextEdit::singleline(&mut typed.clause).hint_text("or type class!=7, z=10..55.5, …");
    let field = ui.add(field.desired_width(f32::INFINITY)).on_hover_text("As --filter takes it; Enter adds it");
    field.widget_info(|| {
        let mut info = WidgetInfo::text_edit(true, "", typed.clause.as_str(), "class!=7");
        info.label = Some("Clause to add".into());
        info
    });
    let entered = field.lost_focus() && ui.input(|i| i.key_pressed(eframe::egui::Key::Enter));
    if field.changed() {
        typed.clause_error = None;
    }
    if entered && !typed.clause.trim().is_empty() {
        match typed.clause.trim().parse::<Clause>() {
            Ok(clause) => {
                let attribute = clause.attribute.clone();
                filter.set(&attribute, Some(clause));
                typed.clause.clear();
            }
            Err(error) => typed.clause_error = Some(error.to_string()),
        }
    }
    if let Some(error) = &typed.clause_error {
        ui.add(Label::new(RichText::new(error).small().color(ui.visuals().error_fg_color)).wrap());
    }
}
