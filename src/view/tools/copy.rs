//! To the clipboard.

use eframe::egui::Context;

/// Puts text on the clipboard.
pub fn copy(ctx: &Context, text: String) {
    log::debug!("copied:\n{text}");
    ctx.copy_text(text);
}
