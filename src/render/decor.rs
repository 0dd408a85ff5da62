//! What is drawn over a picture to read it by: the scene's box, a scale bar, a north arrow, a legend. As lines, shapes
//! and texts in pixels, which the window and `render` draw alike.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::{
    camera::{Camera, CameraError, Projection},
    legend::Legend,
    legend_layout,
    lens::Lens,
};
use crate::scene::{Bounds, SceneFacts, Unit};

/// What to draw over a picture.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Decor {
    /// The edges of the box that the headers promise, behind the points that are before them.
    pub bounding_box: bool,
    /// A length at the depth of the camera's target.
    pub scale_bar: bool,
    /// The direction of the file's y axis, on level ground.
    pub north_arrow: bool,
    /// What the colours mean, where they mean one attribute.
    pub legend: bool,
}

/// The parts as the command line names them.
const NAMES: [&str; 4] = ["box", "scale", "north", "legend"];
/// And no part at all.
const NONE: &str = "none";

impl Decor {
    fn parts(&mut self) -> [&mut bool; 4] {
        [&mut self.bounding_box, &mut self.scale_bar, &mut self.north_arrow, &mut self.legend]
    }

    /// What [`Decor::from_str`](std::str::FromStr) takes.
    pub fn names() -> Vec<&'static str> {
        NAMES.into_iter().chain([NONE]).collect()
    }

    /// Whether there is anything to draw.
    pub fn is_empty(self) -> bool {
        self == Decor::default()
    }
}

impl std::str::FromStr for Decor {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut decor = Decor::default();
        if text == NONE {
            return Ok(decor);
        }
        for name in text.split(',').map(str::trim) {
            let known = decor.parts().into_iter().zip(NAMES).find(|(_, known)| *known == name);
            let (part, _) =
                known.ok_or_else(|| format!("expected {NONE} or some of {}, found `{name}`", NAMES.join(", ")))?;
            *part = true;
        }
        Ok(decor)
    }
}

/// As [`Decor::from_str`](std::str::FromStr) takes it.
impl std::fmt::Display for Decor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut decor = *self;
        let set: Vec<&str> = decor.parts().into_iter().zip(NAMES).filter(|(set, _)| **set).map(|(_, n)| n).collect();
        let joined = set.join(",");
        f.write_str(if set.is_empty() { NONE } else { &joined })
    }
}

/// A line in pixels from the upper left corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    pub ends: [DVec2; 2],
    /// Depths of the ends, for a line in the scene: hidden behind nearer points.
    pub depths: Option<[f64; 2]>,
}

/// An upright rectangle, filled; in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plate {
    pub min: DVec2,
    pub max: DVec2,
    pub color: [u8; 3],
    /// 1 hides what is behind it.
    pub opacity: f64,
}

/// What a label's place is: the middle of its left edge, or its middle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    Left,
    Middle,
}

/// A text in one line.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    pub at: DVec2,
    pub align: Align,
    pub text: String,
}

/// All that is to be drawn, in pixels. Plates lie below the other shapes, but for lines in the scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overlay {
    pub lines: Vec<Line>,
    pub plates: Vec<Plate>,
    /// Triangles, filled; light ones and dark ones in turn.
    pub triangles: Vec<[DVec2; 3]>,
    pub labels: Vec<Label>,
}

/// What an overlay is laid out on.
#[derive(Debug, Clone, Copy)]
pub struct Sheet {
    /// Of the picture, pixels.
    pub size: [u32; 2],
    /// Height of the texts, pixels.
    pub text_px: f64,
    /// Pixels at the picture's lower edge that something else covers.
    pub covered_below: f64,
}

/// The largest of 1, 2 and 5 times a power of ten that is at most this; 0 for what is no length.
fn round_length(most: f64) -> f64 {
    if !(most.is_finite() && most > 0.0) {
        return 0.0;
    }
    let ten = 10f64.powf(most.log10().floor());
    // The logarithm may be off by a rounding, to either side.
    [0.5, 1.0, 2.0, 5.0, 10.0].map(|n| n * ten).into_iter().filter(|&n| n <= most * (1.0 + 1e-9)).fold(0.0, f64::max)
}

/// What `decor` asks for, over a picture. Colours without a legend have none.
///
/// # Errors
/// If the camera's numbers make no picture.
pub fn overlay(
    decor: Decor,
    camera: &Camera,
    facts: &SceneFacts,
    legend: Option<&Legend>,
    sheet: &Sheet,
) -> Result<Overlay, CameraError> {
    let (size, text_px) = (sheet.size, sheet.text_px);
    let lens = Lens::of(camera, size)?;
    let mut overlay = Overlay::default();
    if decor.bounding_box && facts.bounds.is_sane() {
        overlay.lines.extend(box_lines(&lens, &facts.bounds));
    }
    let free = f64::from(size[1]) - sheet.covered_below;
    let corner = DVec2::new(f64::from(size[0]), free) - DVec2::splat(1.5 * text_px);
    if decor.scale_bar {
        let depth = lens.depth(DVec3::from_array(camera.target));
        let pixels_per_unit = lens.pixels_per_unit(depth);
        let length = round_length(0.25 * f64::from(size[0]) / pixels_per_unit);
        let left = DVec2::new(1.5 * text_px, corner.y);
        let right = left + DVec2::X * (length * pixels_per_unit);
        let tick = DVec2::Y * (0.35 * text_px);
        for ends in [[left, right], [left - tick, left], [right - tick, right]] {
            overlay.lines.push(Line { ends, depths: None });
        }
        let where_to = if camera.projection == Projection::Perspective { " in the middle" } else { "" };
        let middle = (left + right) * 0.5 - DVec2::Y * (0.9 * text_px);
        // Of a short bar the text is wider.
        let text = Unit::of(facts).text(length) + where_to;
        let half = 0.28 * text_px * text.chars().count() as f64;
        let at = DVec2::new(middle.x.max(left.x + half), middle.y);
        overlay.labels.push(Label { at, align: Align::Middle, text });
    }
    if decor.north_arrow {
        north_arrow(&mut overlay, &lens, corner, text_px);
    }
    if let Some(legend) = legend.filter(|_| decor.legend) {
        legend_layout::lay_out(&mut overlay, legend, sheet);
    }
    Ok(overlay)
}

/// The edges of a box, as far as they are before the eye.
fn box_lines(lens: &Lens, bounds: &Bounds) -> Vec<Line> {
    let corner = |k: usize| {
        let side = |a: usize| if k >> a & 1 == 0 { bounds.min[a] } else { bounds.max[a] };
        DVec3::new(side(0), side(1), side(2))
    };
    let deepest = (0..8).map(|k| lens.depth(corner(k))).fold(0.0, f64::max);
    // Nearer than this, an edge is cut off.
    let near = 1e-6 * deepest;
    let edges = (0..8).flat_map(|k| (0..3).filter(move |a| k >> a & 1 == 0).map(move |a| (k, k | 1 << a)));
    let line = |(a, b): (usize, usize)| {
        let cut = |from: DVec3, to: DVec3| {
            let [start, end] = [from, to].map(|p| lens.depth(p));
            if start >= near { from } else { from.lerp(to, (near - start) / (end - start)) }
        };
        let [a, b] = [corner(a), corner(b)];
        if lens.depth(a).max(lens.depth(b)) <= near {
            return None;
        }
        let [(from, from_depth), (to, to_depth)] = [lens.place(cut(a, b))?, lens.place(cut(b, a))?];
        Some(Line { ends: [from, to], depths: Some([from_depth, to_depth]) })
    };
    edges.filter_map(line).collect()
}

/// An arrow that lies on level ground, as the camera sees it from far away.
fn north_arrow(overlay: &mut Overlay, lens: &Lens, corner: DVec2, text_px: f64) {
    let radius = 2.2 * text_px;
    let middle = corner - DVec2::splat(radius);
    let at = |x: f64, y: f64| {
        let world = DVec3::new(x, y, 0.0);
        middle + DVec2::new(world.dot(lens.right), world.dot(lens.down)) * radius
    };
    let (tip, notch) = (at(0.0, 0.8), at(0.0, -0.35));
    let [left, right] = [at(-0.5, -0.7), at(0.5, -0.7)];
    overlay.triangles.push([tip, left, notch]);
    overlay.triangles.push([tip, notch, right]);
    for ends in [[tip, left], [left, notch], [notch, right], [right, tip]] {
        overlay.lines.push(Line { ends, depths: None });
    }
    // Beyond the tip, or above where that points at the eye.
    let ahead = (tip - middle).try_normalize().unwrap_or(-DVec2::Y);
    let at = tip + ahead * (0.7 * text_px);
    overlay.labels.push(Label { at, align: Align::Middle, text: "N".to_owned() });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{FileFacts, Grid};

    fn facts() -> SceneFacts {
        let bounds = Bounds { min: [500_000.0, 5_000_000.0, 300.0], max: [500_100.0, 5_000_060.0, 320.0] };
        let file = FileFacts { metres_per_unit: Some(1.0), ..Default::default() };
        SceneFacts {
            grid: Grid { scale: [0.01; 3], origin: [500_000.0, 5_000_000.0, 0.0] },
            bounds,
            files: vec![file],
            warnings: vec![],
        }
    }

    const SHEET: Sheet = Sheet { size: [640, 400], text_px: 12.0, covered_below: 0.0 };

    #[test]
    fn names_are_read_back() {
        for text in ["none", "legend", "box", "scale", "north", "box,scale", "box,scale,north,legend"] {
            assert_eq!(text.parse::<Decor>().expect(text).to_string(), text);
        }
        assert_eq!("box, scale".parse::<Decor>().expect("blanks").to_string(), "box,scale");
        assert!("box,ruler".parse::<Decor>().is_err_and(|why| why.contains("north") && why.contains("`ruler`")));
        assert!("".parse::<Decor>().is_err());
    }

    #[test]
    fn lengths_are_round() {
        for (most, length) in [(1.0, 1.0), (1.99, 1.0), (2.0, 2.0), (4.9, 2.0), (7.0, 5.0), (0.03, 0.02), (1234.0, 1e3)]
        {
            assert!((round_length(most) / length - 1.0).abs() < 1e-12, "{most}: {}", round_length(most));
        }
        assert_eq!([0.0, -1.0, f64::NAN, f64::INFINITY].map(round_length), [0.0; 4]);
    }

    /// Every corner of the box is an end of three lines, where the kernels would draw a point.
    #[test]
    fn the_box_has_twelve_edges_where_its_points_are_drawn() {
        let facts = facts();
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let from = DVec3::new(0.35, -1.0, 0.75);
            let camera = Camera::fit_as(&facts.bounds, &facts.grid, 1.6, from, projection);
            let decor = Decor { bounding_box: true, ..Default::default() };
            let overlay = overlay(decor, &camera, &facts, None, &SHEET).expect("a camera");
            assert_eq!(overlay.lines.len(), 12);
            let view = camera.view(&facts.grid, [640, 400], 1).expect("a camera");
            for k in 0..8 {
                let side = |a: usize| if k >> a & 1 == 0 { facts.bounds.min[a] } else { facts.bounds.max[a] };
                let steps = facts.grid.steps([side(0), side(1), side(2)]).map(|s| s.round() as i32);
                let drawn = view.project(steps).expect("in the picture");
                let at = DVec2::new(f64::from(drawn.corner[0]) + 0.5, f64::from(drawn.corner[1]) + 0.5);
                let ends = overlay.lines.iter().flat_map(|line| line.ends).filter(|end| end.distance(at) < 1.0);
                assert_eq!(ends.count(), 3, "{projection:?}, corner {k} at {at}");
            }
        }
    }

    #[test]
    fn a_box_around_the_eye_is_cut_off() {
        let facts = facts();
        let center = facts.bounds.center();
        let camera = Camera { eye: center, target: [center[0], center[1] + 1.0, center[2]], ..Default::default() };
        let lens = Lens::of(&camera, [640, 400]).expect("a camera");
        let lines = box_lines(&lens, &facts.bounds);
        // The four edges of the wall ahead, and the four that lead there.
        assert_eq!(lines.len(), 8);
        assert!(lines.iter().all(|line| line.depths.is_some_and(|depths| depths.iter().all(|&d| d > 0.0))));
    }

    #[test]
    fn the_scale_bar_is_as_long_as_it_says() {
        let facts = facts();
        let target = facts.bounds.center();
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let eye = [target[0], target[1], target[2] + 150.0];
            let camera = Camera { eye, target, up: [0.0, 1.0, 0.0], projection, ..Default::default() };
            let decor = Decor { scale_bar: true, north_arrow: true, ..Default::default() };
            let overlay = overlay(decor, &camera, &facts, None, &SHEET).expect("a camera");
            let [left, right] = overlay.lines[0].ends;
            let text = &overlay.labels[0].text;
            let length: f64 = text.split(' ').next().and_then(|n| n.parse().ok()).expect("a number");
            assert!(text.contains(" m"), "{text}");
            let view = camera.view(&facts.grid, [640, 400], 1).expect("a camera");
            let at = |x: f64| {
                let steps = facts.grid.steps([target[0] + x, target[1], target[2]]).map(|s| s.round() as i32);
                f64::from(view.project(steps).expect("in the picture").corner[0])
            };
            assert!((at(0.5 * length) - at(-0.5 * length) - (right.x - left.x)).abs() <= 1.0, "{text}");
            // From above, north is up.
            let tip = overlay.triangles[0][0];
            assert!(overlay.triangles[0][1].y > tip.y + 10.0 && overlay.labels[1].at.y < tip.y, "{overlay:?}");
        }
    }
}
