//! How large a point is drawn.

use serde::{Deserialize, Serialize};

use crate::scene::{SceneFacts, Unit};

/// Largest number of pixels that a point can be given.
pub const MAX_PX: u32 = 8;

/// A point of a size in the file's unit is drawn at most so many pixels wide. One costs the square of that: 1,024
/// pixels here, and whoever stands closer looks between the points in any case. 5 cm in a picture of 1080 lines
/// are 32 pixels at 1.5 m.
pub const MAX_WORLD_PX: u32 = 32;

/// In any unit; far beyond, numbers of 32 bits end.
const MIN_LENGTH: f64 = 1e-9;
const MAX_LENGTH: f64 = 1e9;

const METRES_PER_FOOT: f64 = 0.3048;

/// Width of the square that a point is drawn as, as users say it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PointSize {
    /// Pixels, 1 to [`MAX_PX`].
    Pixels(u32),
    /// In the file's unit.
    World(f64),
    Metres(f64),
    /// Feet of 0.3048 m. Survey feet are longer by two millionths, which nobody sees.
    Feet(f64),
}

/// Width of the square that a point is drawn as, where the unit of the scene is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PointWidth {
    /// Pixels, 1 to [`MAX_PX`].
    Pixels(u32),
    /// In the file's unit: as many pixels as that takes where the point is, 1 to [`MAX_WORLD_PX`].
    World(f64),
}

impl PointSize {
    /// The width in this scene. Where the length of its unit is not known, metres and feet are the file's unit: see
    /// [`PointSize::doubt`].
    pub fn on(self, scene: &SceneFacts) -> PointWidth {
        let metres_per_unit = Unit::of(scene).metres();
        let of_metres = |length: f64, metres: f64| metres_per_unit.map_or(length, |unit| length * metres / unit);
        match self {
            PointSize::Pixels(pixels) => PointWidth::Pixels(pixels),
            PointSize::World(size) => PointWidth::World(size),
            PointSize::Metres(size) => PointWidth::World(of_metres(size, 1.0)),
            PointSize::Feet(size) => PointWidth::World(of_metres(size, METRES_PER_FOOT)),
        }
    }

    /// Why the width is not what was asked for, if so.
    pub fn doubt(self, scene: &SceneFacts) -> Option<String> {
        let (PointSize::Metres(size) | PointSize::Feet(size)) = self else { return None };
        let why = match Unit::of(scene) {
            Unit::Unknown => "how long that is, the files do not say, or they disagree",
            Unit::Degree => "its coordinates are degrees",
            _ => return None,
        };
        Some(format!("points of {self} are {size} of the file's unit: {why}"))
    }

    /// The width in pixels, if it is given so.
    pub fn pixels(self) -> Option<u32> {
        match self {
            PointSize::Pixels(pixels) => Some(pixels),
            PointSize::World(_) | PointSize::Metres(_) | PointSize::Feet(_) => None,
        }
    }

    /// So many steps larger: a pixel, or a quarter.
    pub fn stepped(self, by: i32) -> PointSize {
        let longer = |size: f64| (size * 1.25_f64.powi(by)).clamp(MIN_LENGTH, MAX_LENGTH);
        match self {
            PointSize::Pixels(pixels) => PointSize::Pixels(pixels.saturating_add_signed(by).clamp(1, MAX_PX)),
            PointSize::World(size) => PointSize::World(longer(size)),
            PointSize::Metres(size) => PointSize::Metres(longer(size)),
            PointSize::Feet(size) => PointSize::Feet(longer(size)),
        }
    }
}

impl PointWidth {
    /// The width in pixels, if it is given so.
    pub fn pixels(self) -> Option<u32> {
        match self {
            PointWidth::Pixels(pixels) => Some(pixels),
            PointWidth::World(_) => None,
        }
    }

    /// The width in the file's unit, if it is given so.
    pub fn world(self) -> Option<f64> {
        match self {
            PointWidth::Pixels(_) => None,
            PointWidth::World(size) => Some(size),
        }
    }
}

impl Default for PointSize {
    fn default() -> Self {
        PointSize::Pixels(1)
    }
}

impl From<u32> for PointSize {
    fn from(pixels: u32) -> Self {
        PointSize::Pixels(pixels)
    }
}

impl From<u32> for PointWidth {
    fn from(pixels: u32) -> Self {
        PointWidth::Pixels(pixels)
    }
}

/// As on the command line: `2`, `0.05m`, `0.2ft`, `0.05u`.
impl std::fmt::Display for PointSize {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            PointSize::Pixels(pixels) => write!(f, "{pixels}"),
            PointSize::World(size) => write!(f, "{size}u"),
            PointSize::Metres(size) => write!(f, "{size}m"),
            PointSize::Feet(size) => write!(f, "{size}ft"),
        }
    }
}

/// What a length of each unit is.
type OfLength = fn(f64) -> PointSize;
const UNITS: [(&str, OfLength); 3] = [("m", PointSize::Metres), ("ft", PointSize::Feet), ("u", PointSize::World)];

impl std::str::FromStr for PointSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let with_unit = UNITS.iter().find_map(|(unit, of)| Some((text.strip_suffix(unit)?, of)));
        let size = match with_unit {
            Some((length, of)) => {
                length.parse().ok().filter(|length| (MIN_LENGTH..=MAX_LENGTH).contains(length)).map(of)
            }
            None => text.parse().ok().filter(|pixels| (1..=MAX_PX).contains(pixels)).map(PointSize::Pixels),
        };
        size.ok_or_else(|| {
            format!(
                "expected pixels from 1 to {MAX_PX}, or a size such as 0.05m, 0.2ft or 0.05u (the file's unit), found \
                 `{text}`"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Bounds, FileFacts, Grid};

    #[test]
    fn sizes_are_read_as_they_are_written() {
        for text in ["1", "8", "0.05m", "0.2ft", "0.05u", "1000000000m"] {
            assert_eq!(text.parse::<PointSize>().unwrap().to_string(), text);
        }
        assert_eq!("0.2ft".parse(), Ok(PointSize::Feet(0.2)));
        for text in ["", "0", "9", "m", "0m", "-1m", "NaNm", "infu", "1 m", "1cm", "1e10ft", "t", "2px"] {
            let message = text.parse::<PointSize>().unwrap_err();
            assert!(message.contains("pixels from 1 to 8") && message.contains("0.2ft"), "{message}");
        }
    }

    #[test]
    fn a_metre_is_a_metre_where_the_file_says_its_unit() {
        let scene = |metres_per_unit, is_geographic| SceneFacts {
            grid: Grid { scale: [0.01; 3], origin: [0.0; 3] },
            bounds: Bounds::default(),
            files: vec![FileFacts { metres_per_unit, is_geographic, ..Default::default() }],
            warnings: vec![],
        };
        let (metre, foot, unknown, degree) =
            (scene(Some(1.0), false), scene(Some(0.3048), false), scene(None, false), scene(None, true));
        let world = |size: PointSize, scene| size.on(scene).world().unwrap();
        assert_eq!(world(PointSize::Metres(0.3048), &metre), 0.3048);
        assert_eq!(world(PointSize::Metres(0.3048), &foot), 1.0);
        assert_eq!((world(PointSize::Feet(2.0), &foot), world(PointSize::Feet(2.0), &metre)), (2.0, 0.6096));
        for size in [PointSize::Metres(0.5), PointSize::Feet(0.5)] {
            assert_eq!((world(size, &unknown), world(size, &degree)), (0.5, 0.5));
            assert!(size.doubt(&unknown).unwrap().starts_with(&format!("points of {size} are 0.5 of the file's unit")));
            assert!(size.doubt(&degree).unwrap().ends_with("degrees"));
            assert_eq!((size.doubt(&metre), size.doubt(&foot)), (None, None));
        }
        for size in [PointSize::World(0.5), PointSize::Pixels(3)] {
            assert_eq!((size.on(&foot), size.doubt(&unknown)), (size.on(&metre), None));
        }
        assert_eq!(PointSize::Pixels(3).on(&foot).pixels(), Some(3));
    }
}
