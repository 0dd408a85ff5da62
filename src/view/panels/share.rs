//! A picture of the scene, at any size; and the command that makes the same one.

use std::path::PathBuf;

use eframe::egui::{ComboBox, DragValue, ProgressBar, TextEdit, Ui};

use super::super::{
    requests::{Choose, Request},
    screenshot::ShotOptions,
};

/// Sizes by name; the first is that of the picture in the window.
const SIZES: [(&str, Option<[u32; 2]>); 6] = [
    ("As in the window", None),
    ("1920 × 1080", Some([1920, 1080])),
    ("2560 × 1440", Some([2560, 1440])),
    ("3840 × 2160", Some([3840, 2160])),
    ("7680 × 4320", Some([7680, 4320])),
    ("A4 at 300 dpi", Some([3508, 2480])),
];
/// Pixels along a side; the device may allow fewer in all.
const SIDES: std::ops::RangeInclusive<u32> = 1..=16_384;

/// What the section shows, and what is typed in it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Share {
    pub window_size: [u32; 2],
    /// None: that of the window.
    pub size: Option<[u32; 2]>,
    /// Not before all is read and the picture is final.
    pub wait: bool,
    pub path: String,
    /// The path was chosen in a dialog, which asks before a file is replaced.
    pub may_replace: bool,
    /// How far a picture is that is being taken, from 0 to 1.
    pub taking: Option<f32>,
    /// There is a scene.
    pub has_scene: bool,
    /// What makes the same picture in a shell.
    pub command: Option<String>,
}

impl Share {
    pub fn options(&self) -> ShotOptions {
        ShotOptions {
            size: self.size.unwrap_or(self.window_size),
            wait: self.wait,
            path: PathBuf::from(self.path.trim()),
            may_replace: self.may_replace,
        }
    }
}

/// Shows the section.
pub fn show(ui: &mut Ui, share: &mut Share, requests: &mut Vec<Request>) {
    if !share.has_scene {
        ui.label("Nothing to show yet.");
        return;
    }
    let named = SIZES.iter().find(|(_, size)| *size == share.size).map_or("Another size", |(name, _)| *name);
    ComboBox::from_label("Size of the picture").selected_text(named).show_ui(ui, |ui| {
        for (name, size) in SIZES {
            ui.selectable_value(&mut share.size, size, name);
        }
        let another = share.size.unwrap_or(share.window_size);
        if ui.selectable_label(named == "Another size", "Another size").clicked() {
            // One pixel beside a named one, so that it is another.
            share.size = Some([another[0], another[1].saturating_sub(1).max(1)]);
        }
    });
    if let Some(size) = &mut share.size {
        ui.horizontal(|ui| {
            let [width, height] = size;
            let label = ui.label("Width");
            ui.add(DragValue::new(width).range(SIDES)).labelled_by(label.id);
            let label = ui.label("Height");
            ui.add(DragValue::new(height).range(SIDES)).labelled_by(label.id);
        });
    }
    ui.checkbox(&mut share.wait, "Wait until it is complete")
        .on_hover_text("Until all files are read and the picture is final; otherwise it shows what is read so far");
    let field =
        ui.add(TextEdit::singleline(&mut share.path).desired_width(f32::INFINITY)).on_hover_text("Path of the PNG");
    field.widget_info(|| {
        let mut info = eframe::egui::WidgetInfo::text_edit(true, "", share.path.as_str(), "");
        info.label = Some("Path of the PNG".into());
        info
    });
    if field.changed() {
        share.may_replace = false;
    }
    match share.taking {
        Some(done) => {
            ui.horizontal(|ui| {
                if ui.button("Stop the picture").clicked() {
                    requests.push(Request::StopScreenshot);
                }
                ui.add(ProgressBar::new(done).show_percentage());
            });
        }
        None => {
            ui.horizontal(|ui| {
                if ui.button("Save picture").on_hover_text("Ctrl+S").clicked() {
                    requests.push(Request::Screenshot(share.options()));
                }
                if ui.button("Choose path…").clicked() {
                    requests.push(Request::Choose { what: Choose::Picture, add: false });
                }
            });
        }
    }
    if let Some(command) = &share.command {
        super::copy_button(
            ui,
            "Copy command",
            "The command that makes this picture without a window (Ctrl+Shift+C)",
            || command.clone(),
        );
    }
}
