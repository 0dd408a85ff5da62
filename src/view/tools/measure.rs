//! Distances between points that were picked: along lines of them, in the file's unit.

use glam::DVec3;

use crate::{
    inspect::scaled,
    scene::{Grid, SceneFacts},
};

/// A point of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Record number, counted through all files of the scene.
    pub record: u32,
    /// On the scene's grid.
    pub position: [i32; 3],
    /// In world coordinates.
    pub world: DVec3,
}

/// What the numbers of a scene's coordinates are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unit {
    /// Of unknown length.
    Plain,
    /// Metres per unit.
    Length(f64),
    /// Longitude and latitude: horizontal distances are no lengths.
    Degrees,
}

impl Unit {
    pub fn of(facts: &SceneFacts) -> Unit {
        match facts.files.first() {
            Some(file) if file.is_geographic => Unit::Degrees,
            Some(file) => file.metres_per_unit.map_or(Unit::Plain, Unit::Length),
            None => Unit::Plain,
        }
    }

    /// Behind a number.
    fn suffix(self) -> &'static str {
        let Unit::Length(metres) = self else { return "" };
        let known = [
            (1.0, " m"),
            (0.3048, " ft"),
            (1200.0 / 3937.0, " ft (US)"),
            (0.001, " mm"),
            (0.01, " cm"),
            (1000.0, " km"),
        ];
        known.iter().find(|(unit, _)| (metres / unit - 1.0).abs() < 1e-9).map_or(" units", |(_, suffix)| *suffix)
    }
}

/// How far it is from one point to another, in the file's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Apart {
    pub delta: [f64; 3],
    pub horizontal: f64,
    /// Upwards.
    pub vertical: f64,
    pub direct: f64,
}

impl Apart {
    /// Exact to the last bit of the steps between: no coordinate is rounded first.
    pub fn of(a: &Place, b: &Place, grid: &Grid) -> Apart {
        let steps = |axis: usize| f64::from(b.position[axis]) - f64::from(a.position[axis]);
        let delta: [f64; 3] = std::array::from_fn(|axis| steps(axis) * grid.scale[axis]);
        let horizontal = delta[0].hypot(delta[1]);
        Apart { delta, horizontal, vertical: delta[2], direct: horizontal.hypot(delta[2]) }
    }
}

/// Points in a row, with what lies between them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Line {
    pub points: Vec<Place>,
}

/// A measured length in as many digits as the grid has, and its unit.
pub fn length(value: f64, grid: &Grid, unit: Unit) -> String {
    format!("{value:.digits$}{}", unit.suffix(), digits = places(grid))
}

/// Digits behind the point that tell the finest step of the grid; never more than an f64 has for a scan.
pub fn places(grid: &Grid) -> usize {
    let finest = grid.scale.iter().copied().fold(f64::INFINITY, f64::min);
    // 0.001 is -2.9999… in logarithms; steps like 0.00025 need one digit more than their magnitude.
    let magnitude = (-finest.log10() - 1e-9).ceil();
    if magnitude.is_finite() { magnitude.clamp(0.0, 9.0) as usize } else { 3 }
}

impl Line {
    pub fn segments(&self, grid: &Grid) -> Vec<Apart> {
        self.points.windows(2).map(|pair| Apart::of(&pair[0], &pair[1], grid)).collect()
    }

    /// Sum of its segments: through space, and on the map.
    pub fn totals(&self, grid: &Grid) -> [f64; 2] {
        self.segments(grid)
            .iter()
            .fold([0.0; 2], |[direct, flat], apart| [direct + apart.direct, flat + apart.horizontal])
    }

    /// What is written at a segment.
    pub fn segment_words(apart: &Apart, grid: &Grid, unit: Unit) -> String {
        match unit {
            Unit::Degrees => format!(
                "Δ {:+.digits$}°, {:+.digits$}°, vertical {:+.3}",
                apart.delta[0],
                apart.delta[1],
                apart.vertical,
                digits = places(grid)
            ),
            _ => length(apart.direct, grid, unit),
        }
    }

    /// What is written at the end of it: of one segment its horizontal and vertical parts, of more the sum.
    pub fn total_words(&self, grid: &Grid, unit: Unit) -> Option<String> {
        let segments = self.segments(grid);
        match (unit, &segments[..]) {
            (Unit::Degrees, _) | (_, []) => None,
            (_, [only]) => {
                let [horizontal, vertical] = [only.horizontal, only.vertical].map(|value| length(value, grid, unit));
                Some(format!("horizontal {horizontal} · vertical {vertical}"))
            }
            _ => {
                let [direct, flat] = self.totals(grid).map(|value| length(value, grid, unit));
                Some(format!("total {direct} · horizontal {flat}"))
            }
        }
    }

    /// All of it as lines of text.
    pub fn text(&self, facts: &SceneFacts) -> String {
        let (grid, unit) = (&facts.grid, Unit::of(facts));
        let mut text = String::new();
        for (number, point) in (1..).zip(&self.points) {
            let [x, y, z] = coordinates(point.position, grid);
            text += &format!("point {number}: {x} {y} {z} (record {})\n", point.record);
        }
        for (number, apart) in (1..).zip(self.segments(grid)) {
            let [dx, dy, dz] = apart.delta;
            let [direct, flat] = [apart.direct, apart.horizontal].map(|value| length(value, grid, unit));
            let digits = places(grid);
            text += &format!("from {number} to {}: ", number + 1);
            text += &match unit {
                Unit::Degrees => format!("Δ {dx:.digits$}° {dy:.digits$}°, vertical {dz:.3}\n"),
                _ => format!(
                    "{direct}, horizontal {flat}, vertical {}, Δ {dx:.digits$} {dy:.digits$} {dz:.digits$}\n",
                    length(dz, grid, unit)
                ),
            };
        }
        if self.points.len() > 2 && unit != Unit::Degrees {
            let [direct, flat] = self.totals(grid).map(|value| length(value, grid, unit));
            text += &format!("total: {direct}, horizontal {flat}\n");
        }
        text
    }
}

/// Coordinates with the digits of the grid's scale and origin.
pub fn coordinates(position: [i32; 3], grid: &Grid) -> [String; 3] {
    let world = grid.world(position);
    std::array::from_fn(|a| {
        let exact = scaled(position[a].into(), grid.scale[a], grid.origin[a]);
        exact.map_or_else(|| world[a].to_string(), |exact| exact.to_string())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::FileFacts;

    fn facts(scale: f64, metres_per_unit: Option<f64>, is_geographic: bool) -> SceneFacts {
        let file = FileFacts { metres_per_unit, is_geographic, ..Default::default() };
        let grid = Grid { scale: [scale; 3], origin: [500_000.0, 5_000_000.0, 0.0] };
        SceneFacts { grid, bounds: Default::default(), files: vec![file], warnings: vec![] }
    }

    fn place(position: [i32; 3], grid: &Grid) -> Place {
        Place { record: 7, position, world: grid.world(position).into() }
    }

    #[test]
    fn distances_are_those_of_the_steps_between() {
        let facts = facts(0.001, Some(1.0), false);
        let line = Line {
            points: [[-2_000_000_000, 0, 0], [-1_999_997_000, 4_000, -12_000]].map(|p| place(p, &facts.grid)).to_vec(),
        };
        let apart = line.segments(&facts.grid)[0];
        assert_eq!((apart.horizontal, apart.vertical, apart.direct), (5.0, -12.0, 13.0));
        assert_eq!(Line::segment_words(&apart, &facts.grid, Unit::Length(1.0)), "13.000 m");
        assert_eq!(
            line.total_words(&facts.grid, Unit::Length(1.0)).unwrap(),
            "horizontal 5.000 m · vertical -12.000 m"
        );
        // The whole width of a grid does not overflow.
        let ends = [[i32::MIN; 3], [i32::MAX; 3]].map(|p| place(p, &facts.grid));
        assert_eq!(Apart::of(&ends[0], &ends[1], &facts.grid).delta[0], 4_294_967.295);
    }

    #[test]
    fn lines_add_up_and_say_so() {
        let facts = facts(0.01, Some(0.3048), false);
        let points = [[0, 0, 0], [300, 400, 0], [300, 400, 1200], [0, 0, 1200]].map(|p| place(p, &facts.grid));
        let line = Line { points: points.to_vec() };
        assert_eq!(line.totals(&facts.grid), [22.0, 10.0]);
        let text = line.text(&facts);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "point 2: 500003.00 5000004.00 0.00 (record 7)");
        assert_eq!(lines[4], "from 1 to 2: 5.00 ft, horizontal 5.00 ft, vertical 0.00 ft, Δ 3.00 4.00 0.00");
        assert_eq!(lines[7], "total: 22.00 ft, horizontal 10.00 ft");
        assert_eq!(lines.len(), 8);
        let one = Line { points: points[..1].to_vec() };
        assert_eq!((one.segments(&facts.grid).len(), one.total_words(&facts.grid, Unit::Plain)), (0, None));
    }

    #[test]
    fn degrees_are_not_called_lengths() {
        let facts = facts(1e-7, None, true);
        assert_eq!(Unit::of(&facts), Unit::Degrees);
        let line = Line { points: [[0, 0, 0], [10, 0, 5]].map(|p| place(p, &facts.grid)).to_vec() };
        assert!(!line.text(&facts).contains(" m") && line.total_words(&facts.grid, Unit::Degrees).is_none());
    }

    #[test]
    fn digits_are_those_of_the_finest_step() {
        for (scale, digits) in
            [(0.001, 3), (0.01, 2), (1.0, 0), (0.00025, 4), (1e-7, 7), (100.0, 0), (f64::NAN, 3), (0.0, 3)]
        {
            assert_eq!(places(&Grid { scale: [scale; 3], origin: [0.0; 3] }), digits, "{scale}");
        }
    }
}
