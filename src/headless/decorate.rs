//! Draws lines, shapes and texts over a picture.

use eframe::egui::{
    Color32, FontDefinitions, FontId,
    epaint::{Fonts, TextOptions},
};
use glam::DVec2;

use crate::render::{Align, Label, Line, Overlay, Picture, Plate, Projection};

const LIGHT: [u8; 3] = [236, 238, 242];
const DARK: [u8; 3] = [20, 22, 26];
/// Edges of the box.
const EDGE: [u8; 3] = [255, 196, 84];

/// Pixels of a text's height in a picture of this size.
pub fn text_px(size: [u32; 2]) -> f64 {
    (f64::from(size[1].min(size[0])) / 48.0).clamp(9.0, 200.0).round()
}

/// Draws over a picture; lines in the scene are hidden behind its points.
pub fn decorate(picture: &mut Picture, overlay: &Overlay, projection: Projection) {
    let text_px = text_px([picture.width, picture.height]);
    let width = (text_px / 10.0).max(1.0);
    let (in_scene, above): (Vec<&Line>, Vec<&Line>) = overlay.lines.iter().partition(|line| line.depths.is_some());
    for line in in_scene {
        draw_line(picture, line, width, EDGE, projection);
    }
    for plate in &overlay.plates {
        fill_plate(picture, plate);
    }
    for line in &above {
        draw_line(picture, line, width + 2.0, DARK, projection);
    }
    for (triangle, color) in overlay.triangles.iter().zip([LIGHT, DARK].into_iter().cycle()) {
        fill_triangle(picture, *triangle, color);
    }
    for line in &above {
        draw_line(picture, line, width, LIGHT, projection);
    }
    let mut fonts = Fonts::new(TextOptions::default(), FontDefinitions::default());
    for label in &overlay.labels {
        draw_text(picture, &mut fonts, label, text_px);
    }
}

/// Mixes a colour into a pixel, if it is in the picture.
fn blend(picture: &mut Picture, [x, y]: [i64; 2], color: [u8; 3], alpha: f64) {
    if x < 0 || y < 0 || x >= i64::from(picture.width) || y >= i64::from(picture.height) {
        return;
    }
    let pixel = &mut picture.rgba[y as usize * picture.width as usize + x as usize];
    for (channel, color) in pixel.iter_mut().zip(color) {
        *channel = (f64::from(*channel) + alpha * (f64::from(color) - f64::from(*channel))).round() as u8;
    }
}

/// Steps along the longer axis, and gives each pixel across as much as the line covers of it.
fn draw_line(picture: &mut Picture, line: &Line, width: f64, color: [u8; 3], projection: Projection) {
    let Some((from, to)) = inside(line.ends, picture, width) else { return };
    let [start, end] = line.ends;
    let along = end - start;
    let length = along.length();
    if length == 0.0 {
        return;
    }
    let is_steep = along.y.abs() > along.x.abs();
    let swap = |p: DVec2| if is_steep { DVec2::new(p.y, p.x) } else { p };
    let [a, b] = [from, to].map(|share| swap(start + along * share));
    let direction = swap(along) / length;
    let reach = (0.5 * width + 1.0) / direction.x.abs().max(0.1);
    let [first, last] = [a.x.min(b.x) - 0.5 * width, a.x.max(b.x) + 0.5 * width];
    for column in first.floor() as i64..=last.ceil() as i64 {
        let center = a.y + (column as f64 + 0.5 - a.x) * direction.y / direction.x;
        for row in (center - reach).floor() as i64..=(center + reach).ceil() as i64 {
            let offset = DVec2::new(column as f64 + 0.5, row as f64 + 0.5) - swap(start);
            let t = offset.dot(direction).clamp(0.0, length);
            let alpha = (0.5 * width + 0.5 - offset.distance(direction * t)).clamp(0.0, 1.0);
            let pixel = if is_steep { [row, column] } else { [column, row] };
            if alpha > 0.0 && !is_hidden(picture, pixel, line, t / length, projection) {
                blend(picture, pixel, color, alpha);
            }
        }
    }
}

/// The part of a line that can be in the picture, as shares of it: a box may reach far beyond.
fn inside(ends: [DVec2; 2], picture: &Picture, margin: f64) -> Option<(f64, f64)> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    let along = ends[1] - ends[0];
    let size = DVec2::new(f64::from(picture.width), f64::from(picture.height));
    for axis in 0..2 {
        let (low, high) = (-margin - ends[0][axis], size[axis] + margin - ends[0][axis]);
        if along[axis].abs() < 1e-12 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
            continue;
        }
        let shares = [low / along[axis], high / along[axis]];
        from = from.max(shares[0].min(shares[1]));
        to = to.min(shares[0].max(shares[1]));
    }
    (from < to).then_some((from, to))
}

/// Whether a point of the picture is before the line there.
fn is_hidden(picture: &Picture, [x, y]: [i64; 2], line: &Line, share: f64, projection: Projection) -> bool {
    let Some([from, to]) = line.depths else { return false };
    let depth = match projection {
        Projection::Perspective => 1.0 / (1.0 / from + share * (1.0 / to - 1.0 / from)),
        Projection::Orthographic => from + share * (to - from),
    };
    let inside = x >= 0 && y >= 0 && x < i64::from(picture.width) && y < i64::from(picture.height);
    // The outermost points lie on the edges.
    inside && f64::from(picture.depth[y as usize * picture.width as usize + x as usize]) < depth * (1.0 - 1e-5)
}

fn fill_triangle(picture: &mut Picture, corners: [DVec2; 3], color: [u8; 3]) {
    let [a, b, c] = corners;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let size = DVec2::new(f64::from(picture.width), f64::from(picture.height));
    let (low, high) = (low.max(DVec2::ZERO), high.min(size));
    for y in low.y.floor() as i64..=high.y.ceil() as i64 {
        for x in low.x.floor() as i64..=high.x.ceil() as i64 {
            let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| (to - from).perp_dot(p - from));
            if sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0) {
                blend(picture, [x, y], color, 1.0);
            }
        }
    }
}

/// Each pixel gets as much of its colour as it is covered.
fn fill_plate(picture: &mut Picture, plate: &Plate) {
    let size = DVec2::new(f64::from(picture.width), f64::from(picture.height));
    let (low, high) = (plate.min.max(DVec2::ZERO), plate.max.min(size));
    let covered = |axis: usize, at: i64| ((at + 1) as f64).min(high[axis]) - (at as f64).max(low[axis]);
    for y in low.y.floor() as i64..high.y.ceil() as i64 {
        for x in low.x.floor() as i64..high.x.ceil() as i64 {
            blend(picture, [x, y], plate.color, plate.opacity * covered(0, x) * covered(1, y));
        }
    }
}

/// With a dark rim, so that it is read on any ground.
fn draw_text(picture: &mut Picture, fonts: &mut Fonts, label: &Label, text_px: f64) {
    let (glyphs, atlas) = {
        let mut view = fonts.with_pixels_per_point(1.0);
        let galley = view.layout_no_wrap(label.text.clone(), FontId::proportional(text_px as f32), Color32::WHITE);
        (galley, view.image())
    };
    let before = match label.align {
        Align::Left => 0.0,
        Align::Middle => 0.5,
    };
    let corner = label.at - DVec2::new(before * f64::from(glyphs.rect.width()), 0.5 * f64::from(glyphs.rect.height()));
    let mut ink: Vec<([i64; 2], f64)> = Vec::new();
    for row in &glyphs.rows {
        let mesh = &row.row.visuals.mesh;
        // Upright rectangles of four corners, as many pixels as texels.
        for quad in mesh.vertices[row.row.visuals.glyph_vertex_range.clone()].chunks_exact(4) {
            let low = |of: fn(&eframe::egui::epaint::Vertex) -> f32| quad.iter().map(of).fold(f32::INFINITY, f32::min);
            let high = |of: fn(&eframe::egui::epaint::Vertex) -> f32| quad.iter().map(of).fold(0.0, f32::max);
            let [u, v] = [low(|q| q.uv.x), low(|q| q.uv.y)].map(|t| t.round() as usize);
            let [right, bottom] = [high(|q| q.uv.x), high(|q| q.uv.y)].map(|t| t.round() as usize);
            let left = corner.x + f64::from(row.pos.x + low(|q| q.pos.x));
            let top = corner.y + f64::from(row.pos.y + low(|q| q.pos.y));
            for y in v..bottom.min(atlas.size[1]) {
                for x in u..right.min(atlas.size[0]) {
                    let alpha = f64::from(atlas.pixels[y * atlas.size[0] + x].a()) / 255.0;
                    let pixel = [left.round() as i64 + (x - u) as i64, top.round() as i64 + (y - v) as i64];
                    if alpha > 0.0 {
                        ink.push((pixel, alpha));
                    }
                }
            }
        }
    }
    for &([x, y], alpha) in &ink {
        for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)] {
            blend(picture, [x + dx, y + dy], DARK, 0.6 * alpha);
        }
    }
    for &(pixel, alpha) in &ink {
        blend(picture, pixel, LIGHT, alpha);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(width: u32, height: u32, depth: f32) -> Picture {
        let pixels = (width * height) as usize;
        Picture {
            width,
            height,
            rgba: vec![[90, 90, 90, 255]; pixels],
            records: vec![0; pixels],
            depth: vec![depth; pixels],
        }
    }

    fn changed(picture: &Picture) -> Vec<[usize; 2]> {
        let width = picture.width as usize;
        let all = picture.rgba.iter().enumerate().filter(|(_, rgba)| **rgba != [90, 90, 90, 255]);
        all.map(|(at, _)| [at % width, at / width]).collect()
    }

    #[test]
    fn lines_are_hidden_where_points_are_before_them() {
        let line = |depths| Overlay {
            lines: vec![Line { ends: [DVec2::new(-1e7, 20.5), DVec2::new(1e7, 20.5)], depths }],
            ..Default::default()
        };
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let drawn = |depths, depth| {
                let mut picture = gray(60, 40, depth);
                decorate(&mut picture, &line(depths), projection);
                changed(&picture).len()
            };
            let all = drawn(Some([5.0, 5.0]), 6.0);
            assert!(all >= 60, "{all}");
            assert_eq!(drawn(Some([5.0, 5.0]), f32::INFINITY), all);
            assert_eq!(drawn(Some([5.0, 5.0]), 4.0), 0);
            // On the edge itself.
            assert_eq!(drawn(Some([5.0, 5.0]), 5.0), all);
            // Without a depth, above all.
            assert!(drawn(None, 1.0) > all);
        }
    }

    #[test]
    fn texts_are_where_they_should_be() {
        let mut picture = gray(200, 60, 1.0);
        let labels = vec![Label { at: DVec2::new(100.0, 30.0), align: Align::Middle, text: "50 m".to_owned() }];
        decorate(&mut picture, &Overlay { labels, ..Default::default() }, Projection::Perspective);
        let ink = changed(&picture);
        assert!(ink.len() > 60, "{} pixels", ink.len());
        let middle = |axis: usize| ink.iter().map(|p| p[axis] as f64).sum::<f64>() / ink.len() as f64;
        assert!((middle(0) - 100.0).abs() < 4.0 && (middle(1) - 30.0).abs() < 4.0, "{} {}", middle(0), middle(1));
        // There are pixels as light as the letters are.
        assert!(picture.rgba.iter().any(|rgba| rgba[0] > 200));
    }

    #[test]
    fn plates_cover_what_they_say() {
        let mut picture = gray(20, 10, 1.0);
        let plate = |min: [f64; 2], max: [f64; 2], opacity| Plate {
            min: min.into(),
            max: max.into(),
            color: [190, 0, 90],
            opacity,
        };
        let plates = vec![plate([2.0, 3.0], [4.5, 5.0], 1.0), plate([18.0, -7.0], [99.0, 1.0], 0.5)];
        decorate(&mut picture, &Overlay { plates, ..Default::default() }, Projection::Perspective);
        let at = |x: usize, y: usize| picture.rgba[y * 20 + x];
        assert_eq!([at(2, 3), at(3, 4)], [[190, 0, 90, 255]; 2]);
        assert_eq!(at(4, 4), [140, 45, 90, 255], "half of it");
        assert_eq!([at(18, 0), at(19, 0)], [[140, 45, 90, 255]; 2]);
        assert_eq!(changed(&picture).len(), 8);
    }
}
