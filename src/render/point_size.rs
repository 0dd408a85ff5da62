//! How large a point is drawn.

use serde::{Deserialize, Serialize};

/// Largest number of pixels that a point can be given.
pub const MAX_PX: u32 = 8;

/// A point of a size in the file's unit is drawn at most so many pixels wide. One costs the square of that: 1,024
/// pixels here, and whoever stands closer looks between the points in any case. 5 cm in a picture of 1080 lines
/// are 32 pixels at 1.5 m.
pub const MAX_WORLD_PX: u32 = 32;

/// In the file's unit; far beyond, numbers of 32 bits end.
const MIN_WORLD: f64 = 1e-9;
const MAX_WORLD: f64 = 1e9;

/// Width of the square that a point is drawn as.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PointSize {
    /// Pixels, 1 to [`MAX_PX`].
    Pixels(u32),
    /// In the file's unit: as many pixels as that takes where the point is, 1 to [`MAX_WORLD_PX`].
    World(f64),
}

impl PointSize {
    /// The width in pixels, if it is given so.
    pub fn pixels(self) -> Option<u32> {
        match self {
            PointSize::Pixels(pixels) => Some(pixels),
            PointSize::World(_) => None,
        }
    }

    /// The width in the file's unit, if it is given so.
    pub fn world(self) -> Option<f64> {
        match self {
            PointSize::Pixels(_) => None,
            PointSize::World(size) => Some(size),
        }
    }

    /// So many steps larger: a pixel, or a quarter.
    pub fn stepped(self, by: i32) -> PointSize {
        match self {
            PointSize::Pixels(pixels) => PointSize::Pixels(pixels.saturating_add_signed(by).clamp(1, MAX_PX)),
            PointSize::World(size) => PointSize::World((size * 1.25_f64.powi(by)).clamp(MIN_WORLD, MAX_WORLD)),
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

/// As on the command line: `2`, `0.05m`.
impl std::fmt::Display for PointSize {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            PointSize::Pixels(pixels) => write!(f, "{pixels}"),
            PointSize::World(size) => write!(f, "{size}m"),
        }
    }
}

impl std::str::FromStr for PointSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!("expected pixels from 1 to {MAX_PX}, or a size in the file's unit such as 0.05m, found `{text}`")
        };
        let size = match text.strip_suffix('m') {
            Some(size) => size.parse().ok().filter(|size| (MIN_WORLD..=MAX_WORLD).contains(size)).map(PointSize::World),
            None => text.parse().ok().filter(|pixels| (1..=MAX_PX).contains(pixels)).map(PointSize::Pixels),
        };
        size.ok_or_else(wrong)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_as_they_are_typed() {
        for (text, size) in
            [("1", PointSize::Pixels(1)), ("8", PointSize::Pixels(8)), ("0.05m", PointSize::World(0.05))]
        {
            assert_eq!(text.parse(), Ok(size));
            assert_eq!(size.to_string(), text);
        }
        for text in ["", "0", "9", "-1", "1.5", "m", "0m", "-1m", "nanm", "infm", "1e12m", "1px", "1 m", "0.05"] {
            assert!(text.parse::<PointSize>().is_err_and(|why| why.contains("0.05m")), "{text}");
        }
    }
}
