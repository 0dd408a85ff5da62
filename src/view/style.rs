//! Colours and sizes of the controls where egui's own are hard to read. Texts keep a contrast of 4.5:1 and the edges of
//! controls one of 3:1 (WCAG 2.1, success criteria 1.4.3 and 1.4.11), dark and light, over any picture.

use eframe::egui::{Color32, FontId, Stroke, Style, TextStyle};

/// Sets them in a style of either theme.
pub fn readable(style: &mut Style) {
    // egui's 9 points are hard to read.
    style.text_styles.insert(TextStyle::Small, FontId::proportional(11.0));
    let visuals = &mut style.visuals;
    let gray = Color32::from_gray;
    let (text, weak, edge) = if visuals.dark_mode { (200, 165, 135) } else { (50, 90, 115) };
    visuals.widgets.noninteractive.fg_stroke.color = gray(text);
    visuals.weak_text_color = Some(gray(weak));
    visuals.widgets.inactive.bg_stroke = Stroke::new(1.0, gray(edge));
    if !visuals.dark_mode {
        // The rail of a slider, which has no edge: egui's 230 is the bar's own colour.
        visuals.widgets.inactive.bg_fill = gray(185);
    }
    (visuals.warn_fg_color, visuals.error_fg_color) = if visuals.dark_mode {
        (Color32::from_rgb(255, 160, 40), Color32::from_rgb(255, 125, 115))
    } else {
        (Color32::from_rgb(140, 75, 0), Color32::from_rgb(175, 0, 0))
    };
}

/// (L1 + 0.05) / (L2 + 0.05) with the relative luminances of opaque colours, as WCAG has it.
#[cfg(test)]
pub fn contrast(a: Color32, b: Color32) -> f32 {
    let luminance = |color: Color32| {
        let [r, g, b, _] = eframe::egui::Rgba::from(color).to_array();
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let (a, b) = (luminance(a) + 0.05, luminance(b) + 0.05);
    (a / b).max(b / a)
}

#[cfg(test)]
mod tests {
    use eframe::egui::Visuals;

    use super::*;
    use crate::view::overlay::PANEL_ALPHA;

    /// Panels and cards are opaque; the bar lets a little of a black or white picture through.
    #[test]
    fn texts_and_edges_can_be_seen_on_whatever_is_behind_them() {
        for visuals in [Visuals::dark(), Visuals::light()] {
            let mut style = Style { visuals, ..Default::default() };
            readable(&mut style);
            let visuals = &style.visuals;
            let bar = |picture: Color32| picture.blend(visuals.panel_fill.gamma_multiply_u8(PANEL_ALPHA));
            let grounds = [visuals.panel_fill, visuals.window_fill, bar(Color32::BLACK), bar(Color32::WHITE)];
            let texts = [
                visuals.text_color(),
                visuals.weak_text_color(),
                visuals.strong_text_color(),
                visuals.warn_fg_color,
                visuals.error_fg_color,
            ];
            for ground in grounds {
                for text in texts {
                    assert!(contrast(text, ground) >= 4.5, "{text:?} on {ground:?}: {}", contrast(text, ground));
                }
                let edge = visuals.widgets.inactive.bg_stroke.color;
                assert!(contrast(edge, ground) >= 3.0, "{edge:?} on {ground:?}: {}", contrast(edge, ground));
            }
        }
        let [black, white] = [Color32::BLACK, Color32::WHITE];
        assert!((contrast(black, white) - 21.0).abs() < 0.01, "the formula itself");
    }
}
