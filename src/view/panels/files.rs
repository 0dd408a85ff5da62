//! The files on screen: what each is, how far it is read, whether it is shown; and how to open others.

use std::path::PathBuf;

use eframe::egui::{Align, Button, Frame, Label, Layout, ProgressBar, RichText, TextEdit, Ui};

use super::{
    super::{
        format::{count, duration, percent},
        requests::{Choose, Request},
        scene_state::name,
        settings::Settings,
    },
    Typed, ticks,
};
use crate::{
    render::{Filter, Look},
    scene::Attribute,
};

/// Files that are listed one by one; a folder may hold thousands.
const LISTED: usize = 100;

/// What is known of all files.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Files {
    pub rows: Vec<Row>,
    /// What is about to be opened.
    pub opening: Option<String>,
    /// Inputs that could not be opened, and why.
    pub failed: Vec<(PathBuf, String)>,
    pub recent: Vec<PathBuf>,
    /// Points read per second, while anything is read.
    pub points_per_sec: f64,
    /// Until all is read, as far as that can be told.
    pub secs_to_go: Option<f64>,
    pub is_reading: bool,
    /// Files dropped on a window may not arrive here.
    pub on_wayland: bool,
}

/// What is known of one file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Row {
    pub path: PathBuf,
    /// e.g. "LAZ 1.4, format 7".
    pub kind: String,
    pub crs: Option<String>,
    pub points: u64,
    pub points_read: u64,
    pub state: State,
    pub warnings: Vec<String>,
    pub error: Option<String>,
    /// What its points have, where points are coloured by file.
    pub color: Option<[u8; 3]>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum State {
    #[default]
    Reading,
    /// The user has stopped it.
    Stopped,
    Done,
}

impl Files {
    fn points(&self) -> u64 {
        self.rows.iter().map(|row| row.points).sum()
    }

    fn points_read(&self) -> u64 {
        self.rows.iter().map(|row| row.points_read).sum()
    }

    /// As text, one line per file.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for row in &self.rows {
            let crs = row.crs.as_deref().unwrap_or("no coordinate system");
            text +=
                &format!("{}\t{}\t{} of {} points\t{crs}\n", row.path.display(), row.kind, row.points_read, row.points);
            for line in row.warnings.iter().chain(&row.error) {
                text += &format!("\t{line}\n");
            }
        }
        for (path, error) in &self.failed {
            text += &format!("{}\t{error}\n", path.display());
        }
        text
    }
}

/// Shows the section.
pub fn show(ui: &mut Ui, files: &Files, settings: &mut Settings, typed: &mut Typed, requests: &mut Vec<Request>) {
    open_line(ui, files, typed, requests);
    if let Some(opening) = &files.opening {
        ui.horizontal(|ui| {
            ui.label(format!("Opening {opening} …"));
            if ui.small_button("Cancel").on_hover_text("What is shown stays").clicked() {
                requests.push(Request::StopReading);
            }
        });
    }
    if !files.rows.is_empty() {
        summary(ui, files, requests);
    }
    let several = files.rows.len() > 1;
    for (number, row) in files.rows.iter().take(LISTED).enumerate() {
        Frame::group(ui.style()).inner_margin(6).show(ui, |ui| {
            ui.push_id(number, |ui| file(ui, number, row, several, &mut settings.look, requests));
        });
    }
    if files.rows.len() > LISTED {
        ui.label(format!("and {} more files", files.rows.len() - LISTED));
    }
    for (path, error) in &files.failed {
        ui.label(RichText::new(name(path)).strong());
        ui.add(Label::new(RichText::new(error).color(ui.visuals().error_fg_color)).wrap());
    }
    if several {
        show_all_or_none(ui, files.rows.len(), &mut settings.look.filter);
    }
    recent(ui, files, typed, requests);
}

fn open_line(ui: &mut Ui, files: &Files, typed: &mut Typed, requests: &mut Vec<Request>) {
    ui.horizontal_wrapped(|ui| {
        if ui.button("Open files…").on_hover_text("LAS and LAZ files (Ctrl+O)").clicked() {
            requests.push(Request::Choose { what: Choose::Files, add: typed.add });
        }
        if ui.button("Open folder…").on_hover_text("All scans in it and its folders (Ctrl+Shift+O)").clicked() {
            requests.push(Request::Choose { what: Choose::Folder, add: typed.add });
        }
        ui.checkbox(&mut typed.add, "Add").on_hover_text(
            "What is opened or dropped next comes besides what is shown; all is read again, the view stays",
        );
    });
    let field = TextEdit::singleline(&mut typed.path).hint_text("or type a path").desired_width(f32::INFINITY);
    let field = ui.add(field).on_hover_text("Path of a file or folder to open; Enter opens it");
    field.widget_info(|| {
        let mut info = eframe::egui::WidgetInfo::text_edit(true, "", typed.path.as_str(), "or type a path");
        info.label = Some("Path to open".into());
        info
    });
    let entered = field.lost_focus() && ui.input(|i| i.key_pressed(eframe::egui::Key::Enter));
    let path = typed.path.trim();
    if entered && !path.is_empty() {
        // It stays until it is open: one typed wrong is mended, not typed anew.
        requests.push(Request::Open { inputs: vec![path.into()], add: typed.add });
    }
    if files.on_wayland {
        ui.small("On Wayland, files dropped on the window may not arrive: open them here, or name them when you start firstlight.");
    }
}

fn summary(ui: &mut Ui, files: &Files, requests: &mut Vec<Request>) {
    ui.horizontal_wrapped(|ui| {
        let (read, points) = (files.points_read(), files.points());
        let mut text = match files.rows.len() {
            1 => format!("{} points", count(points)),
            n => format!("{n} files, {} points", count(points)),
        };
        if files.is_reading {
            text += &format!(" · {} read · {} points/s", percent(read, points), count(files.points_per_sec as u64));
            if let Some(secs) = files.secs_to_go {
                text += &format!(" · {} to go", duration(secs));
            }
        }
        ui.label(text);
        if files.is_reading && ui.small_button("Stop reading").on_hover_text("What is read stays").clicked() {
            requests.push(Request::StopReading);
        }
        super::copy_button(ui, "Copy list", "The files and what is known of them, as text", || files.to_text());
    });
}

fn file(ui: &mut Ui, number: usize, row: &Row, several: bool, look: &mut Look, requests: &mut Vec<Request>) {
    let Look { filter, coloring, .. } = look;
    let file_name = name(&row.path);
    ui.horizontal(|ui| {
        if let Some(mut color) = row.color {
            ui.spacing_mut().interact_size = eframe::egui::vec2(18.0, 14.0);
            let button = ui.color_edit_button_srgb(&mut color).on_hover_text("Its colour");
            button.widget_info(|| button_info(&format!("Colour of {file_name}")));
            if button.changed() {
                coloring.files.insert(number, color);
            }
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if several {
                let close =
                    ui.add(Button::new("×").small()).on_hover_text("Close this file; the others are read again");
                close.widget_info(|| button_info(&format!("Close {file_name}")));
                if close.clicked() {
                    requests.push(Request::CloseFile(number));
                }
            }
            if row.state == State::Reading && several {
                let stop = ui.small_button("Stop").on_hover_text("Stop reading this file; what is read of it stays");
                stop.widget_info(|| button_info(&format!("Stop reading {file_name}")));
                if stop.clicked() {
                    requests.push(Request::StopFile(number));
                }
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let text = RichText::new(&file_name).strong();
                if several {
                    let mut shown = ticks::is_shown(filter, &Attribute::File, number as u32);
                    let check = ui.add(eframe::egui::Checkbox::new(&mut shown, "")).on_hover_text("Show this file");
                    check.widget_info(|| {
                        eframe::egui::WidgetInfo::selected(
                            eframe::egui::Role::CheckBox,
                            true,
                            shown,
                            format!("Show {file_name}"),
                        )
                    });
                    if check.changed() {
                        ticks::set_shown(filter, &Attribute::File, number as u32, shown);
                    }
                }
                ui.add(Label::new(text).truncate()).on_hover_text(row.path.display().to_string());
            });
        });
    });
    ui.small(format!("{} · {} points", row.kind, count(row.points)));
    ui.add(Label::new(RichText::new(row.crs.as_deref().unwrap_or("no coordinate system")).small()).truncate())
        .on_hover_text("Coordinate system, from its WKT or GeoTIFF keys");
    match row.state {
        State::Reading => {
            let share = row.points_read as f32 / row.points.max(1) as f32;
            ui.add(ProgressBar::new(share).desired_height(6.0))
                .on_hover_text(format!("{} of {} points read", row.points_read, row.points));
        }
        State::Stopped => {
            ui.small(format!("stopped after {} of its points", percent(row.points_read, row.points)));
        }
        State::Done => {}
    }
    for warning in &row.warnings {
        ui.add(Label::new(RichText::new(warning).small().color(ui.visuals().warn_fg_color)).wrap());
    }
    if let Some(error) = &row.error {
        ui.add(Label::new(RichText::new(error).small().color(ui.visuals().error_fg_color)).wrap());
    }
}

fn button_info(label: &str) -> eframe::egui::WidgetInfo {
    eframe::egui::WidgetInfo::labeled(eframe::egui::Role::Button, true, label)
}

fn show_all_or_none(ui: &mut Ui, files: usize, filter: &mut Filter) {
    ui.horizontal(|ui| {
        if ui.small_button("Show all files").clicked() {
            filter.set(&Attribute::File, None);
        }
        if ui.small_button("Hide all files").clicked() {
            ticks::hide(filter, &Attribute::File, 0..files as u32);
        }
    });
}

fn recent(ui: &mut Ui, files: &Files, typed: &Typed, requests: &mut Vec<Request>) {
    if files.recent.is_empty() {
        return;
    }
    ui.menu_button("Recent", |ui| {
        for path in &files.recent {
            let button = ui.button(name(path)).on_hover_text(path.display().to_string());
            if button.clicked() {
                requests.push(Request::Open { inputs: vec![path.clone()], add: typed.add });
                ui.close();
            }
        }
        ui.separator();
        if ui.button("Forget all").clicked() {
            requests.push(Request::ForgetRecent);
            ui.close();
        }
    })
    .response
    .on_hover_text("What was opened before");
}

/// Of so many files those that were hidden stay so, by the numbers that they have now; some may be gone.
pub fn renumber(filter: &mut Filter, files: usize, number_now: impl Fn(usize) -> Option<usize>) {
    let hidden = (0..files).filter(|&file| !ticks::is_shown(filter, &Attribute::File, file as u32));
    let hidden: Vec<u32> = hidden.filter_map(&number_now).map(|number| number as u32).collect();
    ticks::hide(filter, &Attribute::File, hidden);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_files_stay_hidden_when_others_come_and_go() {
        let mut filter = Filter::default();
        ticks::hide(&mut filter, &Attribute::File, [1, 3]);
        let shown = |filter: &Filter| (0..4).map(|i| ticks::is_shown(filter, &Attribute::File, i)).collect::<Vec<_>>();
        // The first one goes, and another comes before the last.
        renumber(&mut filter, 4, |file| [None, Some(0), Some(1), Some(3)][file]);
        assert_eq!(shown(&filter), [false, true, true, false]);
        renumber(&mut filter, 4, |file| file.checked_sub(1).filter(|&file| file < 2));
        assert!(filter.clauses.is_empty());
    }
}
