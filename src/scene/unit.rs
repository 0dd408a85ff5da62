//! The unit of coordinates.

use std::fmt::Display;

use super::{FileFacts, SceneFacts};

/// What a length in a file's coordinates is a length of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unit {
    Metre,
    Foot,
    SurveyFoot,
    /// So many metres.
    Other(f64),
    /// No file says, or they disagree.
    Unknown,
    /// Longitudes and latitudes, of which lengths do not follow like this.
    Degree,
}

impl Unit {
    /// The unit of a scene's files, if all have the same.
    pub fn of(scene: &SceneFacts) -> Unit {
        let mut units = scene.files.iter().map(Unit::of_file);
        let first = units.next().unwrap_or(Unit::Unknown);
        if units.all(|unit| unit == first) { first } else { Unit::Unknown }
    }

    fn of_file(file: &FileFacts) -> Unit {
        let is = |m: f64, other: f64| (m / other - 1.0).abs() < 1e-9;
        match file.metres_per_unit {
            _ if file.is_geographic => Unit::Degree,
            Some(m) if is(m, 1.0) => Unit::Metre,
            Some(m) if is(m, 0.3048) => Unit::Foot,
            // Twice a millionth longer; some files round it.
            Some(m) if (m / (1200.0 / 3937.0) - 1.0).abs() < 5e-7 => Unit::SurveyFoot,
            Some(m) => Unit::Other(m),
            None => Unit::Unknown,
        }
    }

    /// Its sign, if it has one.
    pub fn symbol(self) -> Option<&'static str> {
        match self {
            Unit::Metre => Some("m"),
            Unit::Foot => Some("ft"),
            Unit::SurveyFoot => Some("ftUS"),
            Unit::Degree => Some("°"),
            Unit::Other(_) | Unit::Unknown => None,
        }
    }

    /// So many of it: `5 m`, `0.5°`, `5 units`.
    pub fn text(self, number: impl Display) -> String {
        match self {
            Unit::Degree => format!("{number}°"),
            _ => format!("{number} {}", self.symbol().unwrap_or("units")),
        }
    }

    /// Its length in metres, if it has one.
    pub fn metres(self) -> Option<f64> {
        match self {
            Unit::Metre => Some(1.0),
            Unit::Foot => Some(0.3048),
            Unit::SurveyFoot => Some(1200.0 / 3937.0),
            Unit::Other(metres) => Some(metres),
            Unit::Unknown | Unit::Degree => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Bounds, Grid};

    #[test]
    fn a_unit_is_named_where_files_agree() {
        let of = |units: &[(Option<f64>, bool)]| {
            let file =
                |&(metres_per_unit, is_geographic)| FileFacts { metres_per_unit, is_geographic, ..Default::default() };
            Unit::of(&SceneFacts {
                grid: Grid { scale: [0.01; 3], origin: [0.0; 3] },
                bounds: Bounds::default(),
                files: units.iter().map(file).collect(),
                warnings: vec![],
            })
        };
        let flat = |metres: f64| (Some(metres), false);
        for (units, text) in [
            (&[flat(1.0), flat(1.0)][..], "5 m"),
            (&[flat(0.3048)], "5 ft"),
            (&[flat(1200.0 / 3937.0)], "5 ftUS"),
            (&[flat(0.304_800_6)], "5 ftUS"),
            (&[flat(1000.0)], "5 units"),
            (&[(None, true)], "5°"),
            // Whatever a file says of lengths beside.
            (&[(Some(1.0), true)], "5°"),
            (&[(None, false)], "5 units"),
            (&[flat(1.0), (None, false)], "5 units"),
            (&[flat(0.3048), flat(1200.0 / 3937.0)], "5 units"),
            (&[], "5 units"),
        ] {
            assert_eq!(of(units).text(5), text, "{units:?}");
        }
        assert_eq!(
            [&[flat(0.3048)], &[flat(1000.0)], &[(None, true)]].map(|u| of(u).metres()),
            [Some(0.3048), Some(1000.0), None]
        );
    }
}
