//! The box, the scale bar, the north arrow and the legend, over the picture.

use eframe::egui::{Align2, Color32, FontId, Rect, Shape, Stroke, Ui, epaint::PathStroke, vec2};
use glam::DVec2;

use super::{overlay::BAR_HEIGHT, settings::Settings};
use crate::{
    render::{Align, Camera, Legend, Sheet, overlay},
    scene::SceneFacts,
};

/// Height of the texts, in points.
const TEXT: f64 = 15.0;
const LIGHT: Color32 = Color32::from_rgb(236, 238, 242);
const DARK: Color32 = Color32::from_rgb(20, 22, 26);
/// Least opacity of what is under texts: through the 0.7 of pictures for files a white picture shines as a grey of 91,
/// of 255, and takes its contrast from every thin letter.
const OPACITY: f64 = 0.9;
const GROUND: Color32 = Color32::from_rgba_premultiplied(18, 20, 23, 230);
/// Edges of the box; points before them shine through.
const EDGE: Color32 = Color32::from_rgba_premultiplied(150, 115, 50, 150);

/// Paints what the look asks for over the picture, which takes `screen` of the window. Unlike in pictures for files,
/// the box is not hidden behind points: their depths are on the GPU.
pub fn paint(ui: &Ui, screen: Rect, settings: &Settings, camera: &Camera, facts: &SceneFacts, legend: Option<&Legend>) {
    let decor = settings.look.decor;
    let covered_below = if settings.bar { f64::from(BAR_HEIGHT) } else { 0.0 };
    if decor.is_empty() || screen.width() < 1.0 || f64::from(screen.height()) < covered_below + 1.0 {
        return;
    }
    let size = [screen.width().round() as u32, screen.height().round() as u32];
    // A camera that makes no picture is told about by the frame.
    let sheet = Sheet { size, text_px: TEXT, covered_below };
    let Ok(overlay) = overlay(decor, camera, facts, legend, &sheet) else { return };
    // Just over the picture: whatever else there is lies above.
    let painter = ui.painter_at(screen);
    let at = |point: DVec2| screen.min + vec2(point.x as f32, point.y as f32);
    for line in overlay.lines.iter().filter(|line| line.depths.is_some()) {
        painter.line_segment(line.ends.map(at), (1.5, EDGE));
    }
    for plate in &overlay.plates {
        let [r, g, b] = plate.color;
        let color = Color32::from_rgba_unmultiplied(r, g, b, (plate.opacity.max(OPACITY) * 255.0).round() as u8);
        painter.rect_filled(Rect::from_min_max(at(plate.min), at(plate.max)), 0, color);
    }
    for line in overlay.lines.iter().filter(|line| line.depths.is_none()) {
        painter.line_segment(line.ends.map(at), (3.5, DARK));
    }
    for (triangle, color) in overlay.triangles.iter().zip([LIGHT, DARK].into_iter().cycle()) {
        painter.add(Shape::convex_polygon(triangle.map(at).to_vec(), color, PathStroke::NONE));
    }
    for line in overlay.lines.iter().filter(|line| line.depths.is_none()) {
        painter.line_segment(line.ends.map(at), Stroke::new(1.5, LIGHT));
    }
    for label in &overlay.labels {
        let place = at(label.at);
        let font = FontId::proportional(TEXT as f32);
        let align = match label.align {
            Align::Left => Align2::LEFT_CENTER,
            Align::Middle => Align2::CENTER_CENTER,
        };
        let galley = painter.layout_no_wrap(label.text.clone(), font, LIGHT);
        let ground = align.anchor_size(place, galley.size());
        // The legend's are on its plate.
        if !overlay
            .plates
            .iter()
            .any(|plate| Rect::from_min_max(at(plate.min), at(plate.max)).contains(ground.center()))
        {
            painter.rect_filled(ground.expand2(vec2(4.0, 1.0)), 3, GROUND);
        }
        painter.galley(ground.min, galley, LIGHT);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::style::contrast;

    #[test]
    fn labels_can_be_read_on_a_white_picture() {
        for ground in [GROUND, DARK.gamma_multiply(OPACITY as f32)] {
            let ground = Color32::WHITE.blend(ground);
            assert!(contrast(LIGHT, ground) >= 7.0, "{ground:?}: {}", contrast(LIGHT, ground));
        }
    }
}
