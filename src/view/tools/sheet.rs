//! Drawing over the picture: points of the scene to positions in the window, lines and words that can be read on
//! any background.

use eframe::egui::{Align2, Color32, CornerRadius, FontId, Painter, Pos2, Rect, Shape, Stroke, pos2, vec2};
use glam::{DVec2, DVec3};

use crate::view::navigation::{Navigation, clipped};

pub const WHITE: Color32 = Color32::from_rgb(245, 247, 250);
pub const ACCENT: Color32 = Color32::from_rgb(106, 182, 255);
pub const WARM: Color32 = Color32::from_rgb(255, 196, 84);
const SHADE: Color32 = Color32::from_rgba_premultiplied(8, 10, 13, 200);
const FONT_SIZE: f32 = 13.0;

/// The picture as a sheet to draw on.
pub struct Sheet<'a> {
    pub painter: Painter,
    pub rect: Rect,
    /// The part of it that no lines at the edge cover.
    pub free: Rect,
    pub navigation: &'a Navigation,
    pub pixels_per_point: f64,
}

impl Sheet<'_> {
    /// Where a point of the scene is in the window; `None` behind the eye.
    pub fn place(&self, point: DVec3) -> Option<Pos2> {
        self.navigation.locate(point).map(|(pixel, _)| self.position(pixel))
    }

    pub fn position(&self, pixel: DVec2) -> Pos2 {
        let at = pixel / self.pixels_per_point;
        self.rect.min + vec2(at.x as f32, at.y as f32)
    }

    pub fn pixel(&self, position: Pos2) -> DVec2 {
        let at = position - self.rect.min;
        DVec2::new(at.x.into(), at.y.into()) * self.pixels_per_point
    }

    /// The part of a segment that lies before the eye and around the picture.
    pub fn segment(&self, a: DVec3, b: DVec3) -> Option<[Pos2; 2]> {
        let [a, b] = self.navigation.locate_segment(a, b)?;
        Some([self.position(a), self.position(b)])
    }

    /// A line with a dark rim. Returns the part that is drawn.
    pub fn line(&self, a: DVec3, b: DVec3, color: Color32) -> Option<[Pos2; 2]> {
        let ends = self.segment(a, b)?;
        self.painter.line_segment(ends, Stroke::new(4.0, SHADE));
        self.painter.line_segment(ends, Stroke::new(1.8, color));
        Some(ends)
    }

    /// A line that leaves what is under it to be seen.
    pub fn thin_line(&self, a: DVec3, b: DVec3, color: Color32) {
        if let Some(ends) = self.segment(a, b) {
            self.painter.line_segment(ends, Stroke::new(2.0, SHADE.gamma_multiply(0.6)));
            self.painter.line_segment(ends, Stroke::new(1.0, color.gamma_multiply(0.8)));
        }
    }

    /// The last place of a segment, from `a` on, that is so many points within the free part of the picture.
    pub fn last_seen(&self, a: DVec3, b: DVec3, within: f32) -> Option<Pos2> {
        let [a, b] = self.segment(a, b)?;
        let room = self.free.shrink(within);
        room.is_positive().then(|| last_within(a, b, room)).flatten()
    }

    /// A closed outline.
    pub fn outline(&self, corners: &[DVec3], color: Color32) {
        for (at, &corner) in corners.iter().enumerate() {
            self.line(corner, corners[(at + 1) % corners.len()], color);
        }
    }

    /// Fills a convex part of a plane that lies before the eye.
    pub fn fill(&self, corners: &[DVec3], color: Color32) {
        let places: Option<Vec<Pos2>> = corners.iter().map(|&corner| self.place(corner)).collect();
        if let Some(places) = places.filter(|places| places.len() > 2) {
            self.painter.add(Shape::convex_polygon(places, color, Stroke::NONE));
        }
    }

    /// A ring around a point.
    pub fn ring(&self, at: Pos2, color: Color32) {
        self.painter.circle_stroke(at, 5.0, Stroke::new(4.0, SHADE));
        self.painter.circle_stroke(at, 5.0, Stroke::new(1.8, color));
    }

    /// A knob that the mouse can take.
    pub fn knob(&self, at: Pos2, color: Color32, is_hot: bool) {
        self.painter.circle_filled(at, if is_hot { 9.0 } else { 7.0 }, SHADE);
        self.painter.circle_filled(at, if is_hot { 7.0 } else { 5.0 }, color);
    }

    /// Words on a dark ground, beside or above a place and never outside of the picture.
    pub fn words(&self, at: Pos2, anchor: Align2, text: &str, color: Color32) {
        let galley = self.painter.layout_no_wrap(text.to_owned(), FontId::proportional(FONT_SIZE), color);
        let ground = anchor.anchor_size(at, galley.size() + vec2(12.0, 6.0));
        let ground = inside(ground, self.free);
        self.painter.rect_filled(ground, CornerRadius::same(4), SHADE);
        self.painter.galley(ground.min + vec2(6.0, 3.0), galley, color);
    }
}

/// The last place of the segment that is in the rectangle.
fn last_within(a: Pos2, b: Pos2, rect: Rect) -> Option<Pos2> {
    let exact = |at: Pos2| DVec2::new(at.x.into(), at.y.into());
    let [_, last] = clipped([a, b].map(exact), exact(rect.min), exact(rect.max))?;
    Some(pos2(last.x as f32, last.y as f32))
}

/// A rectangle moved into another one, as far as it fits.
fn inside(rect: Rect, around: Rect) -> Rect {
    let x = rect.min.x.min(around.max.x - rect.width()).max(around.min.x);
    let y = rect.min.y.min(around.max.y - rect.height()).max(around.min.y);
    Rect::from_min_size(pos2(x, y), rect.size())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::style::contrast;

    #[test]
    fn words_can_be_read_on_a_white_picture() {
        for color in [WHITE, ACCENT, WARM] {
            let ground = Color32::WHITE.blend(SHADE);
            assert!(contrast(color, ground) >= 4.5, "{color:?}: {}", contrast(color, ground));
        }
    }

    #[test]
    fn words_stay_in_the_picture() {
        let around = Rect::from_min_max(pos2(100.0, 50.0), pos2(500.0, 400.0));
        let rect = |x, y| Rect::from_min_size(pos2(x, y), vec2(80.0, 20.0));
        assert_eq!(inside(rect(200.0, 100.0), around), rect(200.0, 100.0));
        assert_eq!(inside(rect(490.0, 395.0), around), rect(420.0, 380.0));
        assert_eq!(inside(rect(-90.0, 0.0), around), rect(100.0, 50.0));
    }

    #[test]
    fn a_knob_beyond_the_picture_is_where_its_line_leaves_it() {
        let room = Rect::from_min_max(pos2(0.0, 0.0), pos2(200.0, 100.0));
        let from = pos2(100.0, 50.0);
        assert_eq!(last_within(from, pos2(150.0, 60.0), room), Some(pos2(150.0, 60.0)));
        assert_eq!(last_within(from, pos2(300.0, 50.0), room), Some(pos2(200.0, 50.0)));
        assert_eq!(last_within(from, pos2(100.0, -150.0), room), Some(pos2(100.0, 0.0)));
        assert_eq!(last_within(pos2(-100.0, 50.0), pos2(-50.0, 50.0), room), None, "it has not come in yet");
        assert_eq!(last_within(pos2(-100.0, 120.0), pos2(300.0, 120.0), room), None);
    }
}
