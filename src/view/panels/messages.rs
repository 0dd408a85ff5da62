//! What went wrong, what is odd and what was done, to be read, copied and cleared.

use eframe::egui::{Label, RichText, Ui};

use super::super::{
    messages::{Messages, Severity},
    requests::Request,
};

/// Shows the section.
pub fn show(ui: &mut Ui, messages: &Messages, requests: &mut Vec<Request>) {
    if messages.len() == 0 {
        ui.label("Nothing to tell.");
        return;
    }
    ui.horizontal(|ui| {
        super::copy_button(ui, "Copy all", "All messages as text", || messages.to_text());
        if ui.button("Clear").on_hover_text("Forget all messages").clicked() {
            requests.push(Request::ClearMessages);
        }
    });
    for (number, (severity, text)) in messages.iter().enumerate() {
        ui.push_id(number, |ui| {
            ui.horizontal_top(|ui| {
                let copy = ui.small_button("Copy").on_hover_text("This message as text");
                copy.widget_info(|| {
                    eframe::egui::WidgetInfo::labeled(
                        eframe::egui::Role::Button,
                        true,
                        format!("Copy message {}", number + 1),
                    )
                });
                if copy.clicked() {
                    ui.ctx().copy_text(text.to_owned());
                }
                let color = match severity {
                    Severity::Done => ui.visuals().text_color(),
                    Severity::Error => ui.visuals().error_fg_color,
                    Severity::Note => ui.visuals().warn_fg_color,
                };
                ui.add(Label::new(RichText::new(text).color(color)).wrap());
            });
        });
    }
}
