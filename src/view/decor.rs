//! The box, the scale bar and the north arrow, over the picture.

use eframe::egui::{
    Align2, Color32, FontId, Id, LayerId, Order, Rect, Shape, Stroke, Ui, epaint::PathStroke, pos2, vec2,
};
use glam::DVec2;

use super::{overlay::BAR_HEIGHT, settings::Settings};
use crate::{
    render::{Camera, overlay},
    scene::SceneFacts,
};

/// Height of the texts, in points.
const TEXT: f64 = 15.0;
const LIGHT: Color32 = Color32::from_rgb(236, 238, 242);
const DARK: Color32 = Color32::from_rgb(20, 22, 26);
/// Edges of the box; points before them shine through.
const EDGE: Color32 = Color32::from_rgba_premultiplied(150, 115, 50, 150);

/// Paints what the look asks for over the picture, which takes `screen` of the window. Unlike in pictures for files,
/// the box is not hidden behind points: their depths are on the GPU.
pub fn paint(ui: &Ui, screen: Rect, settings: &Settings, camera: &Camera, facts: &SceneFacts) {
    let decor = settings.look.decor;
    // Above the status lines.
    let free = if settings.bar { screen.height() - BAR_HEIGHT } else { screen.height() };
    if decor.is_empty() || screen.width() < 1.0 || free < 1.0 {
        return;
    }
    let size = [screen.width().round() as u32, screen.height().round() as u32];
    // A camera that makes no picture is told about by the frame.
    let Ok(overlay) = overlay(decor, camera, size, facts, TEXT) else { return };
    let painter = ui.ctx().layer_painter(LayerId::new(Order::Middle, Id::unique("decor"))).with_clip_rect(screen);
    let raised = free - screen.height();
    let at = |point: DVec2, in_scene: bool| {
        let up = if in_scene { 0.0 } else { raised };
        screen.min + vec2(point.x as f32, point.y as f32 + up)
    };
    for line in overlay.lines.iter().filter(|line| line.depths.is_some()) {
        painter.line_segment(line.ends.map(|end| at(end, true)), (1.5, EDGE));
    }
    for line in overlay.lines.iter().filter(|line| line.depths.is_none()) {
        painter.line_segment(line.ends.map(|end| at(end, false)), (3.5, DARK));
    }
    for (triangle, color) in overlay.triangles.iter().zip([LIGHT, DARK].into_iter().cycle()) {
        let points = triangle.iter().map(|&point| at(point, false)).collect();
        painter.add(Shape::convex_polygon(points, color, PathStroke::NONE));
    }
    for line in overlay.lines.iter().filter(|line| line.depths.is_none()) {
        painter.line_segment(line.ends.map(|end| at(end, false)), Stroke::new(1.5, LIGHT));
    }
    for (middle, text) in &overlay.texts {
        let middle = at(*middle, false);
        let font = FontId::proportional(TEXT as f32);
        for [x, y] in [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]] {
            let beside = pos2(middle.x + x, middle.y + y);
            painter.text(beside, Align2::CENTER_CENTER, text, font.clone(), DARK);
        }
        painter.text(middle, Align2::CENTER_CENTER, text, font, LIGHT);
    }
}
