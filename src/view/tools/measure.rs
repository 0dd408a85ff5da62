//! Lines along points that were picked, and what is said of their lengths.

use glam::DVec3;

use crate::{
    inspect::{Decimal, Distance, Ruler, scaled},
    scene::{Grid, SceneFacts, Unit},
    source::file_of_record,
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

impl Place {
    /// The same point once its scene is read anew with more files, or fewer; `None` if its file is no longer among
    /// them.
    pub fn in_scene(&self, before: &SceneFacts, now: &SceneFacts) -> Option<Place> {
        let (file, record) = file_of_record(before, self.record)?;
        let file = now.files.iter().find(|file_now| file_now.path == before.files[file].path)?;
        let record = u32::try_from(u64::from(file.first_record) + record).ok()?;
        // A grid that another file makes coarser has the nearest position.
        let steps = now.grid.steps(self.world.into()).map(f64::round);
        let is_on_grid = steps.iter().all(|step| step.abs() <= f64::from(i32::MAX));
        is_on_grid.then(|| Place { record, position: steps.map(|step| step as i32), world: self.world })
    }
}

/// Points in a row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Line {
    pub points: Vec<Place>,
}

impl Line {
    /// The same line in a scene of more files, or fewer; `None` if one of its points is gone.
    pub fn in_scene(&self, before: &SceneFacts, now: &SceneFacts) -> Option<Line> {
        let points: Option<Vec<Place>> = self.points.iter().map(|point| point.in_scene(before, now)).collect();
        points.map(|points| Line { points })
    }

    pub fn segments(&self, ruler: &Ruler) -> Vec<Distance> {
        self.points.windows(2).map(|pair| ruler.distance(pair[0].position, pair[1].position)).collect()
    }

    fn positions(&self) -> Vec<[i32; 3]> {
        self.points.iter().map(|point| point.position).collect()
    }

    /// What is written at a segment.
    pub fn segment_words(segment: &Distance, ruler: &Ruler) -> String {
        let [dx, dy, dz] = &segment.differences;
        match ruler.unit() {
            Unit::Degree => format!("Δ {dx}°, {dy}°, {dz}"),
            _ => ruler.length_text(segment.length),
        }
    }

    /// What is written at the end of it: of one segment its horizontal and vertical parts, of more the sums.
    pub fn total_words(&self, ruler: &Ruler) -> Option<String> {
        if self.points.len() < 2 || ruler.unit() == Unit::Degree {
            return None;
        }
        let line = ruler.polyline(&self.positions());
        let [length, horizontal, vertical] =
            [line.length, line.horizontal, line.vertical].map(|length| ruler.length_text(length));
        Some(match self.points.len() {
            2 => format!("horizontal {horizontal} · vertical {vertical}"),
            _ => format!("total {length} · horizontal {horizontal}"),
        })
    }

    /// All of it as lines of text.
    pub fn text(&self, facts: &SceneFacts) -> String {
        let ruler = Ruler::new(facts);
        let mut text = String::new();
        for (number, point) in (1..).zip(&self.points) {
            let place = coordinates(point.position, &facts.grid).join(" ");
            text += &format!("Point {number}: {place} (record {})\n", point.record);
        }
        let rows = |rows: Vec<(String, String)>| {
            rows.iter().map(|(name, what)| format!("  {name}: {what}\n")).collect::<String>()
        };
        for (number, segment) in (1..).zip(self.segments(&ruler)) {
            text += &format!("From {number} to {}\n{}", number + 1, rows(ruler.distance_rows(&segment)));
        }
        if self.points.len() > 2 {
            text += &format!("Together\n{}", rows(ruler.polyline_rows(&self.positions())));
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

/// Digits behind the point that tell the finest step of the grid.
pub fn places(grid: &Grid) -> usize {
    let places = |scale: &f64| Decimal::from_f64(*scale).map(|scale| scale.places());
    grid.scale.iter().filter_map(places).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Bounds, FileFacts};

    fn facts(scale: f64, metres_per_unit: Option<f64>, is_geographic: bool) -> SceneFacts {
        let file = FileFacts { metres_per_unit, is_geographic, ..Default::default() };
        let grid = Grid { scale: [scale; 3], origin: [500_000.0, 5_000_000.0, 0.0] };
        SceneFacts { grid, bounds: Bounds::default(), files: vec![file], warnings: vec![] }
    }

    fn line<const N: usize>(positions: [[i32; 3]; N], grid: &Grid) -> Line {
        let place = |position| Place { record: 7, position, world: grid.world(position).into() };
        Line { points: positions.map(place).to_vec() }
    }

    #[test]
    fn one_segment_says_its_parts_and_more_their_sum() {
        let facts = facts(0.001, Some(1.0), false);
        let ruler = Ruler::new(&facts);
        let one = line([[-2_000_000_000, 0, 0], [-1_999_997_000, 4_000, -12_000]], &facts.grid);
        assert_eq!(Line::segment_words(&one.segments(&ruler)[0], &ruler), "13.000 m");
        assert_eq!(one.total_words(&ruler).unwrap(), "horizontal 5.000 m · vertical -12.000 m");
        let more = line([[0, 0, 0], [3_000, 4_000, 0], [3_000, 4_000, 12_000]], &facts.grid);
        assert_eq!(more.total_words(&ruler).unwrap(), "total 17.000 m · horizontal 5.000 m");
        assert_eq!(line([[0; 3]], &facts.grid).total_words(&ruler), None);
    }

    #[test]
    fn the_text_has_every_point_and_every_segment() {
        let facts = facts(0.01, Some(1.0), false);
        let text = line([[0, 0, 0], [300, 400, 0], [300, 400, 1200]], &facts.grid).text(&facts);
        assert!(text.contains("Point 2: 500003.00 5000004.00 0.00 (record 7)\n"), "{text}");
        assert!(text.contains("From 1 to 2\n  Distance: 5.00 m\n"), "{text}");
        assert!(text.contains("From 2 to 3\n  Distance: 12.00 m\n  Horizontal: 0.00 m\n"), "{text}");
        assert!(text.contains("Together\n  Length: 17.00 m\n"), "{text}");
    }

    #[test]
    fn degrees_are_not_called_lengths() {
        let facts = facts(1e-7, None, true);
        let ruler = Ruler::new(&facts);
        let line = line([[0, 0, 0], [10, 0, 5]], &facts.grid);
        assert_eq!(line.total_words(&ruler), None);
        assert!(!line.text(&facts).contains(" m"));
    }
}
