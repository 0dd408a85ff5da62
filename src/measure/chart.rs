//! Line charts as SVG text that a page can hold inline.
//!
//! Axes and letters take the page's own text colour and the ground is transparent, so that one chart
//! serves light and dark pages. Legends are the page's: HTML lays out text better than a library that
//! has to guess its width.

use plotters::{
    backend::SVGBackend,
    chart::{ChartBuilder, ChartContext},
    coord::{Shift, cartesian::Cartesian2d, types::RangedCoordf64},
    drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea},
    element::Circle,
    series::{DashedLineSeries, LineSeries},
    style::{Color, IntoFont, RGBColor, TRANSPARENT},
};

use super::html::escape;

/// Width and height of a chart, in SVG units; pages scale it.
const SIZE: (u32, u32) = (640, 330);

/// Colours that are told apart on white and on black, also by readers who see no red or no green
/// (after Okabe and Ito's palette, at middle brightness).
const PALETTE: [RGBColor; 7] = [
    RGBColor(0, 126, 196),
    RGBColor(222, 112, 0),
    RGBColor(0, 153, 112),
    RGBColor(199, 92, 152),
    RGBColor(142, 110, 220),
    RGBColor(154, 136, 20),
    RGBColor(214, 62, 62),
];

/// Stands for the page's text colour until the SVG is finished; plotters knows no CSS names.
const INK: RGBColor = RGBColor(1, 2, 3);
const INK_IN_SVG: &str = "#010203";

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Draw {
    /// Points joined by straight lines.
    Line,
    /// Points that are few: joined, each with a dot.
    LineAndDots,
    /// Points that are many and scatter.
    Dots,
    /// A dashed line: a limit or a model, not a measurement.
    Dashed,
}

/// One row of points with a name.
#[derive(Debug, Clone)]
pub struct Series {
    pub name: String,
    pub points: Vec<(f64, f64)>,
    pub draw: Draw,
}

/// A chart. Points that are not finite are left out; axes begin at 0 unless points lie below.
#[derive(Debug, Clone)]
pub struct Chart {
    pub title: String,
    /// Names of the axes, with their units.
    pub x: String,
    pub y: String,
    /// Values that the axes reach at least.
    pub x_at_least: f64,
    pub y_at_least: f64,
    /// Between two whole numbers on the x axis there is nothing (threads, files): no ticks there.
    pub x_is_whole: bool,
    pub series: Vec<Series>,
}

impl Chart {
    /// The drawing alone.
    pub fn svg(&self) -> String {
        let mut svg = String::new();
        if self.draw(SVGBackend::with_string(&mut svg, SIZE).into_drawing_area()).is_err() {
            // Writing to a string cannot fail; should a drawing ever be impossible, the page says so.
            return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 9 9\"><title>not drawn</title></svg>"
                .into();
        }
        // The page sets the width; the view box keeps the proportions.
        let fixed = format!("<svg width=\"{}\" height=\"{}\"", SIZE.0, SIZE.1);
        let named = format!("<svg role=\"img\" aria-label=\"{}\"", escape(&self.title));
        svg.replacen(&fixed, &named, 1).replace(INK_IN_SVG, "currentColor")
    }

    /// The drawing with its title and legend, as an HTML figure.
    pub fn figure(&self) -> String {
        let entries: Vec<String> = (self.series.iter().enumerate())
            .map(|(i, series)| {
                let RGBColor(r, g, b) = color(i);
                let kind = if series.draw == Draw::Dashed { "dashed" } else { "solid" };
                let mark = format!("<i style=\"border-top:3px {kind} rgb({r},{g},{b})\"></i>");
                format!("<li>{mark}{}</li>", escape(&series.name))
            })
            .collect();
        let (title, legend) = (escape(&self.title), entries.concat());
        format!("<figure><figcaption>{title}</figcaption>\n{}\n<ul>{legend}</ul></figure>\n", self.svg())
    }

    fn draw(&self, area: DrawingArea<SVGBackend<'_>, Shift>) -> Drawn {
        let all = || self.series.iter().flat_map(finite);
        let range = |value: fn((f64, f64)) -> f64, at_least: f64| {
            let high = all().map(value).fold(at_least, f64::max);
            let low = all().map(value).fold(0.0, f64::min);
            // Something to divide by, and a little air above the highest point.
            low..if high > low { high + 0.03 * (high - low) } else { low + 1.0 }
        };
        let (x, y) = (range(|p| p.0, self.x_at_least), range(|p| p.1, self.y_at_least));
        let x_ticks = if self.x_is_whole { (x.end as usize + 1).min(8) } else { 8 };
        let mut chart = ChartBuilder::on(&area)
            .margin(8)
            .margin_right(16)
            .x_label_area_size(42)
            .y_label_area_size(64)
            .build_cartesian_2d(x, y)?;
        let text = ("sans-serif", 13).into_font().color(&INK);
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(INK.mix(0.15))
            .axis_style(INK)
            .label_style(text.clone())
            .axis_desc_style(text)
            .x_desc(&self.x)
            .y_desc(&self.y)
            .x_labels(x_ticks)
            .y_labels(6)
            .x_label_formatter(&|v| tick(*v))
            .y_label_formatter(&|v| tick(*v))
            .draw()?;
        for (i, series) in self.series.iter().enumerate() {
            draw_series(&mut chart, series, color(i))?;
        }
        area.present()?;
        drop(chart);
        Ok(())
    }
}

type Plane = Cartesian2d<RangedCoordf64, RangedCoordf64>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

fn draw_series<'a>(chart: &mut ChartContext<'a, SVGBackend<'a>, Plane>, series: &Series, color: RGBColor) -> Drawn {
    let points = || finite(series).collect::<Vec<_>>().into_iter();
    match series.draw {
        Draw::Dashed => drop(chart.draw_series(DashedLineSeries::new(points(), 6, 4, color.stroke_width(2)))?),
        Draw::Line | Draw::LineAndDots => drop(chart.draw_series(LineSeries::new(points(), color.stroke_width(2)))?),
        Draw::Dots => {}
    }
    if matches!(series.draw, Draw::Dots | Draw::LineAndDots) {
        let radius = if series.draw == Draw::Dots { 2 } else { 4 };
        chart.draw_series(points().map(|at| Circle::new(at, radius, color.filled())))?;
    }
    Ok(())
}

fn finite(series: &Series) -> impl Iterator<Item = (f64, f64)> + '_ {
    series.points.iter().copied().filter(|(x, y)| x.is_finite() && y.is_finite())
}

fn color(series: usize) -> RGBColor {
    PALETTE[series % PALETTE.len()]
}

/// A number at an axis: short, and without the digits that binary fractions leave.
fn tick(value: f64) -> String {
    let rounded = format!("{value:.4}");
    let short = rounded.trim_end_matches('0').trim_end_matches('.');
    if short.is_empty() || short == "-0" { "0".into() } else { short.into() }
}

/// At most `most` of the points: evenly chosen, with the first and the last. Keeps pages small.
pub fn thin(points: Vec<(f64, f64)>, most: usize) -> Vec<(f64, f64)> {
    if points.len() <= most || most < 2 {
        return points;
    }
    let last = points.len() - 1;
    (0..most).map(|i| points[i * last / (most - 1)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: &[(f64, f64)], draw: Draw) -> Chart {
        Chart {
            title: "points < time".into(),
            x: "seconds".into(),
            y: "M points".into(),
            x_at_least: 0.0,
            y_at_least: 0.0,
            x_is_whole: false,
            series: vec![Series { name: "a & b".into(), points: points.to_vec(), draw }],
        }
    }

    #[test]
    fn a_chart_takes_the_pages_colours_and_needs_nothing_else() {
        let figure = chart(&[(0.0, 1.0), (1.0, 3.0)], Draw::Line).figure();
        assert!(figure.contains("currentColor") && !figure.contains(INK_IN_SVG));
        assert!(figure.contains("points &lt; time") && figure.contains("a &amp; b"));
        assert!(figure.contains("<polyline"));
        assert!(!figure.contains("http") || figure.matches("http").count() == figure.matches("xmlns").count());
    }

    #[test]
    fn a_higher_point_is_drawn_higher() {
        let heights = |points: &[(f64, f64)]| -> Vec<f64> {
            let svg = chart(points, Draw::Dots).svg();
            let circles = svg.split("<circle").skip(1);
            circles.map(|c| c.split("cy=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap()).collect()
        };
        let [low, high] = heights(&[(0.0, 1.0), (1.0, 3.0)])[..] else { panic!("two circles") };
        assert!(high < low, "SVG counts from the top");
        assert_eq!(heights(&[(0.0, f64::NAN), (1.0, 3.0)]).len(), 1, "no place for what is not a number");
        assert!(heights(&[]).is_empty());
    }

    #[test]
    fn ticks_are_short() {
        assert_eq!([0.1 + 0.2, 5.0, 1200.0, 0.0, -1e-9].map(tick), ["0.3", "5", "1200", "0", "0"]);
    }

    #[test]
    fn thinning_keeps_both_ends() {
        let points: Vec<_> = (0..1000).map(|i| (f64::from(i), 0.0)).collect();
        let thinned = thin(points.clone(), 10);
        assert_eq!((thinned.len(), thinned[0].0, thinned[9].0), (10, 0.0, 999.0));
        assert!(thinned.is_sorted());
        assert_eq!(thin(points, 1000).len(), 1000);
    }
}
