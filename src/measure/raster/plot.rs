//! Plots whose lines and dots carry their names: with sixteen methods, a legend of colours is a riddle.
//!
//! Hand-written SVG: what is needed are logarithmic axes and names that do not lie on one another, and
//! the library behind [`crate::measure::Chart`] has the first and not the second.

use std::fmt::Write;

use crate::measure::html::escape;

/// Width and height in SVG units; pages scale them.
const SIZE: [f64; 2] = [720.0, 420.0];
/// Left, right, top and bottom of the plane; the names stand to the right of it.
const PLANE: [f64; 4] = [66.0, 600.0, 10.0, 370.0];
/// Where the title of a file begins, and its height.
const LEFT: f64 = 8.0;
const TITLE: f64 = 30.0;
/// Least distance of two names.
const LINE: f64 = 15.0;
/// Told apart on white and on black, also by readers who see no red or no green (after Okabe and Ito).
const COLORS: [&str; 7] = ["#007ec4", "#de7000", "#009970", "#c75c98", "#8e6edc", "#9a8814", "#d63e3e"];

/// How an axis counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    Linear,
    /// Powers of ten; values that are not above zero are left out.
    Log,
}

/// One axis.
#[derive(Debug, Clone)]
pub struct Axis {
    /// With the unit.
    pub name: String,
    pub scale: Scale,
}

/// A named line; a single point is a dot.
#[derive(Debug, Clone)]
pub struct Curve {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// A plot.
#[derive(Debug, Clone)]
pub struct Plot {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub curves: Vec<Curve>,
    /// A line without a name behind the others: a front, a ceiling.
    pub behind: Vec<(f64, f64)>,
}

/// An axis laid out: values → SVG units.
struct Laid {
    scale: Scale,
    low: f64,
    high: f64,
    from: f64,
    to: f64,
    ticks: Vec<f64>,
}

impl Laid {
    fn new(scale: Scale, values: impl Iterator<Item = f64>, from: f64, to: f64) -> Laid {
        let usable = values.filter(|v| v.is_finite() && (scale == Scale::Linear || *v > 0.0));
        let (low, high) = usable.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (1.0, 1.0) };
        if scale == Scale::Log {
            // Whole decades where there is one between, else 1, 2 and 5 times them.
            let (low, high) = (low * 0.9, high * 1.1);
            let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
            let steps: &[f64] = if high / low > 300.0 { &[1.0] } else { &[1.0, 2.0, 5.0] };
            let all = decades.flat_map(|d| steps.iter().map(move |s| s * 10f64.powi(d)));
            let ticks = all.filter(|t| (low..=high).contains(t)).collect();
            return Laid { scale, low, high, from, to, ticks };
        }
        let span = if high > low { high - low } else { high.abs().max(1.0) };
        let (low, high) = (low - 0.04 * span, high + 0.04 * span);
        let rough = (high - low) / 6.0;
        let decade = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|s| s * decade).find(|s| *s >= rough).unwrap_or(rough);
        let first = (low / step).ceil() as i64;
        let ticks = (first..first + 12).map(|i| i as f64 * step).take_while(|t| *t <= high).collect();
        Laid { scale, low, high, from, to, ticks }
    }

    /// `None` for what has no place.
    fn at(&self, value: f64) -> Option<f64> {
        if !value.is_finite() || (self.scale == Scale::Log && value <= 0.0) {
            return None;
        }
        let share = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        Some(self.from + share * (self.to - self.from))
    }
}

impl Plot {
    /// The drawing with its title, as an HTML figure.
    pub fn figure(&self) -> String {
        format!("<figure><figcaption>{}</figcaption>\n{}</figure>\n", escape(&self.title), self.svg())
    }

    /// The drawing with its title as a file of its own, for a page that shows it as an image: there nothing is
    /// inherited, so it has colours of its own for light and dark.
    pub fn file(&self) -> String {
        let [width, height] = SIZE;
        let svg = self.svg();
        let Some((_, inside)) = svg.split_once('>') else { return svg };
        let title = escape(&self.title);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"{title}\" width=\"{width}\" \
             height=\"{0}\" viewBox=\"0 -{TITLE} {width} {0}\" font-family=\"system-ui, sans-serif\" font-size=\"12\" \
             fill=\"currentColor\">\n<style>:root {{ color: #1f2328 }} @media (prefers-color-scheme: dark) {{ :root {{ \
             color: #e6edf3 }} }}</style>\n<text x=\"{1}\" y=\"-10\" font-size=\"13\" font-weight=\"600\">{title}</text>{inside}",
            height + TITLE,
            LEFT
        )
    }

    /// The drawing alone.
    pub fn svg(&self) -> String {
        let [left, right, top, bottom] = PLANE;
        let all = || self.curves.iter().flat_map(|curve| &curve.points).chain(&self.behind);
        let x = Laid::new(self.x.scale, all().map(|p| p.0), left, right);
        let y = Laid::new(self.y.scale, all().map(|p| p.1), bottom, top);
        let mut out = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"{}\" viewBox=\"0 0 {} {}\" \
             font-family=\"system-ui, sans-serif\" font-size=\"12\" fill=\"currentColor\">",
            escape(&self.title),
            SIZE[0],
            SIZE[1]
        );
        for &tick in &x.ticks {
            if let Some(at) = x.at(tick) {
                let _ =
                    write!(out, "<path d=\"M{at:.1} {top}V{bottom}\" stroke=\"currentColor\" stroke-opacity=\".15\"/>");
                let _ = writeln!(
                    out,
                    "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                    bottom + 16.0,
                    short(tick)
                );
            }
        }
        for &tick in &y.ticks {
            if let Some(at) = y.at(tick) {
                let _ =
                    write!(out, "<path d=\"M{left} {at:.1}H{right}\" stroke=\"currentColor\" stroke-opacity=\".15\"/>");
                let _ = writeln!(
                    out,
                    "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                    left - 6.0,
                    at + 4.0,
                    short(tick)
                );
            }
        }
        let (middle, level) = (0.5 * (left + right), 0.5 * (top + bottom));
        let _ = writeln!(
            out,
            "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            bottom + 38.0,
            escape(&self.x.name)
        );
        let _ = writeln!(
            out,
            "<text transform=\"translate(14 {level}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            escape(&self.y.name)
        );
        let place = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
            points.iter().filter_map(|p| Some((x.at(p.0)?, y.at(p.1)?))).collect()
        };
        if let behind @ [_, ..] = &place(&self.behind)[..] {
            let _ = writeln!(
                out,
                "<path d=\"{}\" fill=\"none\" stroke=\"currentColor\" stroke-opacity=\".5\" stroke-dasharray=\"5 4\"/>",
                path(behind)
            );
        }
        let placed: Vec<Vec<(f64, f64)>> = self.curves.iter().map(|curve| place(&curve.points)).collect();
        let ends: Vec<Option<f64>> = placed.iter().map(|points| Some(points.last()?.1)).collect();
        let heights = apart(&ends, top + 4.0, bottom);
        for (i, (curve, points)) in self.curves.iter().zip(&placed).enumerate() {
            let (Some(&(end_x, end_y)), Some(height)) = (points.last(), heights[i]) else { continue };
            let color = COLORS[i % COLORS.len()];
            if points.len() > 1 {
                let _ = writeln!(
                    out,
                    "<path d=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.8\"/>",
                    path(points)
                );
            }
            for (x, y) in points {
                let _ = write!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{color}\"/>");
            }
            let _ = writeln!(
                out,
                "<path d=\"M{:.1} {end_y:.1}L{} {height:.1}\" fill=\"none\" stroke=\"{color}\" stroke-opacity=\".5\"/>\
                 <text x=\"{}\" y=\"{:.1}\" fill=\"{color}\">{}</text>",
                end_x + 4.0,
                right + 8.0,
                right + 11.0,
                height + 4.0,
                escape(&curve.name)
            );
        }
        out.push_str("</svg>\n");
        out
    }
}

fn path(points: &[(f64, f64)]) -> String {
    let steps = points.iter().enumerate().map(|(i, (x, y))| format!("{}{x:.1} {y:.1}", if i == 0 { 'M' } else { 'L' }));
    steps.collect()
}

/// The heights of names, near where they belong, at least a line apart, in the same order.
fn apart(ends: &[Option<f64>], top: f64, bottom: f64) -> Vec<Option<f64>> {
    let mut order: Vec<(usize, f64)> = ends.iter().enumerate().filter_map(|(i, end)| Some((i, (*end)?))).collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut at = top;
    for (_, height) in &mut order {
        *height = height.max(at);
        at = *height + LINE;
    }
    // What was pushed over the end goes back up.
    let mut limit = bottom;
    for (_, height) in order.iter_mut().rev() {
        *height = height.min(limit);
        limit = *height - LINE;
    }
    let mut heights = vec![None; ends.len()];
    order.iter().for_each(|&(i, height)| heights[i] = Some(height));
    heights
}

/// A number at an axis: 20M, 0.5, 3k.
fn short(value: f64) -> String {
    let (scaled, unit) = match value.abs() {
        v if v >= 1e9 => (value * 1e-9, "G"),
        v if v >= 1e6 => (value * 1e-6, "M"),
        v if v >= 1e4 => (value * 1e-3, "k"),
        _ => (value, ""),
    };
    let text = format!("{scaled:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { format!("{text}{unit}") }
}

/// The points that no other beats in both coordinates (larger is better), from left to right: the Pareto front.
pub fn front(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut sorted: Vec<(f64, f64)> = points.iter().copied().filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
    sorted.sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1)));
    let mut front: Vec<(f64, f64)> = Vec::new();
    for point in sorted {
        if front.last().is_none_or(|last| point.1 > last.1) {
            front.push(point);
        }
    }
    front.reverse();
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [(1.0, 5.0), (0.5, 9.0), (0.5, 7.0), (0.9, 5.0), (0.2, 8.0), (1.0, 4.0), (f64::NAN, 99.0)];
        assert_eq!(front(&points), [(0.5, 9.0), (1.0, 5.0)]);
        assert!(front(&[]).is_empty());
    }

    #[test]
    fn names_do_not_lie_on_one_another() {
        let ends = [Some(100.0), None, Some(101.0), Some(99.0), Some(370.0), Some(370.0)];
        let heights = apart(&ends, 14.0, 370.0);
        assert_eq!(heights[1], None);
        let mut placed: Vec<f64> = heights.iter().flatten().copied().collect();
        assert!(heights[3] < heights[0] && heights[0] < heights[2], "in order");
        placed.sort_by(f64::total_cmp);
        assert!(placed.windows(2).all(|w| w[1] - w[0] >= LINE - 1e-9), "{placed:?}");
        assert!(placed.iter().all(|h| (0.0..=370.0).contains(h)));
    }

    #[test]
    fn a_tenfold_is_the_same_distance_everywhere() {
        let axis = Laid::new(Scale::Log, [1.0, 1e6, 0.0, f64::NAN].into_iter(), 0.0, 100.0);
        let at = |v| axis.at(v).unwrap();
        assert!((at(10.0) - at(1.0) - (at(1e5) - at(1e4))).abs() < 1e-9);
        assert_eq!((axis.at(0.0), axis.at(f64::NAN)), (None, None));
        assert_eq!(axis.ticks.len(), 7, "{:?}", axis.ticks);
        let linear = Laid::new(Scale::Linear, [0.0, 1.0].into_iter(), 100.0, 0.0);
        assert!(linear.at(1.0).unwrap() < linear.at(0.0).unwrap());
        assert!(!Laid::new(Scale::Linear, [5.0].into_iter(), 0.0, 1.0).ticks.is_empty());
    }

    #[test]
    fn a_plot_has_its_names_and_needs_nothing_else() {
        let curve = |name: &str, points: &[(f64, f64)]| Curve { name: name.into(), points: points.to_vec() };
        let axis = |name: &str, scale| Axis { name: name.into(), scale };
        let plot = Plot {
            title: "a < b".into(),
            x: axis("points", Scale::Log),
            y: axis("ms & more", Scale::Log),
            curves: vec![
                curve("one", &[(1.0, 1.0), (10.0, 3.0)]),
                curve("dot", &[(3.0, 2.0)]),
                curve("none", &[(0.0, 1.0)]),
            ],
            behind: vec![],
        };
        let figure = plot.figure();
        assert!(figure.contains("a &lt; b") && figure.contains("ms &amp; more") && figure.contains(">one<"));
        assert_eq!((figure.matches("<circle").count(), figure.contains(">none<")), (3, false));
        assert_eq!(figure.matches("http").count(), 1, "only the name of SVG itself");
        assert_eq!([0.5, 20_000.0, 3e6, 0.0, 1e9].map(short), ["0.5", "20k", "3M", "0", "1G"]);
    }
}
