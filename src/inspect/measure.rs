//! Distances between points, in the unit of their coordinates: differences of whole grid steps, so that nothing is lost
//! to large coordinates.

use super::{Decimal, scaled};
use crate::scene::{Grid, SceneFacts, Unit};

/// Measures on a scene's grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Ruler {
    grid: Grid,
    unit: Unit,
}

/// From one point to another, in the file's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Distance {
    /// Straight through space.
    pub length: f64,
    /// In the plane of x and y.
    pub horizontal: f64,
    /// Along z; negative downwards.
    pub vertical: f64,
    /// Differences of x, y and z in all their digits.
    pub differences: [Decimal; 3],
    /// Above the horizontal, degrees; 90 straight up.
    pub slope_deg: f64,
    /// Clockwise from the direction of y (grid north), degrees from 0 to 360; none straight up or down.
    pub bearing_deg: Option<f64>,
}

/// Along several points, in the file's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Polyline {
    pub length: f64,
    pub horizontal: f64,
    /// From the first point to the last, along z.
    pub vertical: f64,
    /// Of the polygon that the line closes to, seen from above; in square units. Of a line that crosses itself, parts
    /// count against each other.
    pub area: f64,
}

impl Ruler {
    pub fn new(scene: &SceneFacts) -> Ruler {
        Ruler { grid: scene.grid, unit: Unit::of(scene) }
    }

    pub fn unit(&self) -> Unit {
        self.unit
    }

    /// Coordinates of a grid position in all their digits: of a scene of one file, those of the record.
    pub fn coordinates(&self, position: [i32; 3]) -> [String; 3] {
        [0, 1, 2].map(|a| {
            let exact = scaled(position[a].into(), self.grid.scale[a], self.grid.origin[a]);
            // The reader lets no scale or offset through that is not finite.
            exact.map_or_else(String::new, |decimal| decimal.to_string())
        })
    }

    /// From one grid position to another.
    pub fn distance(&self, from: [i32; 3], to: [i32; 3]) -> Distance {
        let steps = [0, 1, 2].map(|a| i64::from(to[a]) - i64::from(from[a]));
        let [dx, dy, dz] = [0, 1, 2].map(|a| steps[a] as f64 * self.grid.scale[a]);
        let horizontal = dx.hypot(dy);
        let exact = |a: usize| scaled(steps[a].into(), self.grid.scale[a], 0.0);
        Distance {
            length: horizontal.hypot(dz),
            horizontal,
            vertical: dz,
            differences: [0, 1, 2].map(|a| exact(a).unwrap_or(Decimal::from_integer(steps[a].into()))),
            slope_deg: if horizontal.hypot(dz) > 0.0 { dz.atan2(horizontal).to_degrees() } else { 0.0 },
            bearing_deg: (horizontal > 0.0).then(|| dx.atan2(dy).to_degrees().rem_euclid(360.0)),
        }
    }

    pub fn polyline(&self, points: &[[i32; 3]]) -> Polyline {
        let parts = points.windows(2).map(|pair| self.distance(pair[0], pair[1]));
        let (length, horizontal) = parts.fold((0.0, 0.0), |sum, part| (sum.0 + part.length, sum.1 + part.horizontal));
        let ends = points.first().zip(points.last());
        let vertical = ends.map_or(0.0, |(first, last)| self.distance(*first, *last).vertical);
        Polyline { length, horizontal, vertical, area: self.area(points) }
    }

    /// Twice the area is a whole number of squares of the grid: exact until it is scaled.
    fn area(&self, points: &[[i32; 3]]) -> f64 {
        let Some(first) = points.first() else { return 0.0 };
        let from = |p: &[i32; 3]| [0, 1].map(|a| i128::from(p[a]) - i128::from(first[a]));
        let corners: Vec<[i128; 2]> = points.iter().map(from).collect();
        let twice: i128 = corners.windows(2).map(|pair| pair[0][0] * pair[1][1] - pair[1][0] * pair[0][1]).sum();
        0.5 * twice.unsigned_abs() as f64 * (self.grid.scale[0] * self.grid.scale[1]).abs()
    }

    /// A length in the digits of the grid, with its unit, and in metres if that is another one.
    pub fn length_text(&self, length: f64) -> String {
        let places = self.places();
        let metres = self.other_than_metres().map(|metres| format!(" ({:.places$} m)", length * metres));
        self.unit.text(format_args!("{length:.places$}")) + &metres.unwrap_or_default()
    }

    fn area_text(&self, area: f64) -> String {
        let places = self.places();
        let metres = self.other_than_metres().map(|metres| format!(" ({:.places$} m²)", area * metres * metres));
        self.unit.text(format_args!("{area:.places$}")) + "²" + &metres.unwrap_or_default()
    }

    /// Metres in the unit, where it is another one.
    fn other_than_metres(&self) -> Option<f64> {
        self.unit.metres().filter(|_| self.unit != Unit::Metre)
    }

    /// Digits behind the point that a step of the grid needs.
    fn places(&self) -> usize {
        let places = self.grid.scale.iter().filter_map(|scale| Decimal::from_f64(*scale)).map(|scale| scale.places());
        places.max().unwrap_or(0)
    }

    /// Lines of a name and a text.
    pub fn distance_rows(&self, distance: &Distance) -> Vec<(String, String)> {
        let mut rows: Vec<(String, String)> = Vec::new();
        let mut add = |name: &str, text: String| rows.push((name.into(), text));
        let [dx, dy, dz] = &distance.differences;
        if self.unit == Unit::Degree {
            add("ΔX, ΔY", format!("{dx}°, {dy}°"));
            add("ΔZ", dz.to_string());
            add("Distance", "not from longitudes and latitudes".into());
            return rows;
        }
        add("Distance", self.length_text(distance.length));
        add("Horizontal", self.length_text(distance.horizontal));
        add("Vertical", self.length_text(distance.vertical));
        add("ΔX, ΔY, ΔZ", format!("{dx}, {dy}, {dz}"));
        let percent = 100.0 * distance.vertical / distance.horizontal;
        let percent = if percent.is_finite() { format!(" ({percent:.1} %)") } else { String::new() };
        add("Slope", format!("{:.2}°{percent}", distance.slope_deg));
        if let Some(bearing) = distance.bearing_deg {
            add("Bearing", format!("{bearing:.2}°"));
        }
        rows
    }

    /// Lines of a name and a text; the area from three points on.
    pub fn polyline_rows(&self, points: &[[i32; 3]]) -> Vec<(String, String)> {
        if let [from, .., to] = points
            && (points.len() == 2 || self.unit == Unit::Degree)
        {
            return self.distance_rows(&self.distance(*from, *to));
        }
        let line = self.polyline(points);
        let mut rows = vec![
            ("Length".into(), self.length_text(line.length)),
            ("Horizontal".into(), self.length_text(line.horizontal)),
            ("Vertical".into(), self.length_text(line.vertical)),
        ];
        if points.len() > 2 {
            rows.push(("Area from above".into(), self.area_text(line.area)));
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Bounds, FileFacts};

    fn ruler(scale: [f64; 3], units: &[(Option<f64>, bool)]) -> Ruler {
        let file =
            |&(metres_per_unit, is_geographic): &_| FileFacts { metres_per_unit, is_geographic, ..Default::default() };
        Ruler::new(&SceneFacts {
            grid: Grid { scale, origin: [500_000.0, 5_000_000.0, 0.0] },
            bounds: Bounds::default(),
            files: units.iter().map(file).collect(),
            warnings: vec![],
        })
    }

    const METRE: (Option<f64>, bool) = (Some(1.0), false);

    fn rows(rows: &[(String, String)]) -> String {
        rows.iter().map(|(name, text)| format!("{name}: {text}")).collect::<Vec<_>>().join("; ")
    }

    #[test]
    fn a_known_triangle() {
        // 3 m east, 4 m north, 12 m up: 5 and 13; in steps of a millimetre, far from the origin.
        let ruler = ruler([0.001; 3], &[METRE]);
        let from = [2_000_000_000, -2_000_000_000, 7];
        let distance = ruler.distance(from, [2_000_003_000, -1_999_996_000, 12_007]);
        assert_eq!((distance.length, distance.horizontal, distance.vertical), (13.0, 5.0, 12.0));
        assert!(
            (distance.slope_deg - 67.380_135).abs() < 1e-6 && (distance.bearing_deg.unwrap() - 36.869_898).abs() < 1e-6
        );
        assert_eq!(
            rows(&ruler.distance_rows(&distance)),
            "Distance: 13.000 m; Horizontal: 5.000 m; Vertical: 12.000 m; ΔX, ΔY, ΔZ: 3.000, 4.000, 12.000; \
             Slope: 67.38° (240.0 %); Bearing: 36.87°"
        );
        assert_eq!(ruler.coordinates(from), ["2500000.000", "3000000.000", "0.007"]);
        let back = ruler.distance([2_000_003_000, -1_999_996_000, 12_007], from);
        assert_eq!((back.length, back.vertical, back.differences[2].to_string()), (13.0, -12.0, "-12.000".into()));
        assert!((back.bearing_deg.unwrap() - 216.869_898).abs() < 1e-6);
        let up = ruler.distance(from, [from[0], from[1], 1_007]);
        assert_eq!((up.slope_deg, up.bearing_deg, up.length), (90.0, None, 1.0));
        assert_eq!(rows(&ruler.distance_rows(&up)).split("; ").last(), Some("Slope: 90.00°"));
        assert_eq!(ruler.distance(from, from).slope_deg, 0.0);
        // The widest that a grid can be.
        let widest = ruler.distance([i32::MIN; 3], [i32::MAX; 3]);
        assert_eq!(widest.differences[0].to_string(), "4294967.295");
    }

    #[test]
    fn axes_have_their_own_steps() {
        let distance = ruler([0.5, 0.25, 2.0], &[METRE]).distance([0; 3], [6, 16, 6]);
        assert_eq!((distance.horizontal, distance.length), (5.0, 13.0));
        assert_eq!(distance.differences.map(|d| d.to_string()), ["3.0", "4.00", "12"]);
    }

    #[test]
    fn lengths_and_areas_of_lines() {
        let ruler = ruler([0.01; 3], &[METRE]);
        // A rectangle of 4 m by 3 m, its corners at other heights.
        let corners = [[100, 100, 0], [500, 100, 0], [500, 400, 0], [100, 400, 1200]];
        let line = ruler.polyline(&corners);
        assert_eq!((line.horizontal, line.area, line.vertical), (11.0, 12.0, 12.0));
        assert!((line.length - (7.0 + 4f64.hypot(12.0))).abs() < 1e-12);
        assert!(rows(&ruler.polyline_rows(&corners)).ends_with("Vertical: 12.00 m; Area from above: 12.00 m²"));
        assert_eq!(ruler.polyline(&corners[..2]).area, 0.0);
        assert_eq!(
            rows(&ruler.polyline_rows(&corners[..2])),
            rows(&ruler.distance_rows(&ruler.distance(corners[0], corners[1])))
        );
        assert_eq!((ruler.polyline(&[]).length, ruler.polyline(&corners[..1]).length), (0.0, 0.0));
        // Twice 2^64 squares of the grid and more.
        let all = [[i32::MIN, i32::MIN, 0], [i32::MAX, i32::MIN, 0], [i32::MAX, i32::MAX, 0], [i32::MIN, i32::MAX, 0]];
        assert_eq!(ruler.polyline(&all).area, 4_294_967_295f64.powi(2) * 1e-4);
    }

    #[test]
    fn units_are_those_of_the_coordinate_system() {
        let text = |units: &[(Option<f64>, bool)]| ruler([0.01; 3], units).length_text(10.0);
        assert_eq!(text(&[METRE, METRE]), "10.00 m");
        assert_eq!(text(&[(Some(0.3048), false)]), "10.00 ft (3.05 m)");
        assert_eq!(text(&[(Some(0.304_800_609_601_219), false)]), "10.00 ftUS (3.05 m)");
        assert_eq!(text(&[(Some(1000.0), false)]), "10.00 units (10000.00 m)");
        assert_eq!(text(&[METRE, (None, false)]), "10.00 units");
        assert_eq!(text(&[]), "10.00 units");
        let degrees = ruler([1e-7; 3], &[(None, true)]);
        let expected = "ΔX, ΔY: 0.0000010°, 0.0000020°; ΔZ: 0.0000030; Distance: not from longitudes and latitudes";
        assert_eq!(rows(&degrees.distance_rows(&degrees.distance([0; 3], [10, 20, 30]))), expected);
    }
}
