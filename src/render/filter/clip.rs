//! Parts of space that are shown: a box and a slab, in world coordinates.

use std::{
    fmt::{self, Display, Formatter},
    str::FromStr,
};

use serde::{Deserialize, Serialize};

/// What is shown of space: the points inside of all that is set.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Clip {
    pub bounds: Option<ClipBox>,
    pub slab: Option<Slab>,
}

/// A box that stands upright. As text, which `--clip` takes: `x0,y0,z0,x1,y1,z1`, or with the degrees behind.
///
/// Its faces belong to it: what lies on one by the digits of the file is inside.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ClipBox {
    /// Smallest coordinates of the box before it is turned, in the file's unit.
    pub min: [f64; 3],
    /// Largest coordinates.
    pub max: [f64; 3],
    /// Turned by so many degrees around the vertical through its middle, counter-clockwise seen from above.
    #[serde(default)]
    pub degrees: f64,
}

/// What lies between two parallel planes, which belong to it: a section. As text, which `--slab` takes:
/// `x,y,z,nx,ny,nz,thickness`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Slab {
    /// A point halfway between the planes.
    pub point: [f64; 3],
    /// The direction across; of any length above 0.
    pub normal: [f64; 3],
    /// Distance of the planes, in the file's unit.
    pub thickness: f64,
}

/// Why a text is no box or slab.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ClipError {
    #[error("expected {expected}, found {found:?}")]
    NoNumbers { expected: &'static str, found: String },
    #[error("the box has no inside: {axis} goes from {low} to {high}")]
    InsideOut { axis: char, low: String, high: String },
    #[error("the direction of the slab (the fourth to the sixth number) has no length")]
    NoDirection,
    #[error("the thickness of the slab must be above 0, found {0}")]
    NoThickness(String),
}

const BOX: &str =
    "x0,y0,z0,x1,y1,z1 in the file's coordinates (up to 1e15), or these and the degrees that the box is turned by";
const SLAB: &str =
    "x,y,z,nx,ny,nz,thickness: a point of the file's coordinates (up to 1e15), the direction across, and how thick";

impl ClipBox {
    pub fn center(&self) -> [f64; 3] {
        std::array::from_fn(|a| 0.5 * (self.min[a] + self.max[a]))
    }
}

impl Slab {
    /// The direction across, of length 1.
    pub fn across(&self) -> [f64; 3] {
        // Squares of what is very small are 0.
        let largest = self.normal.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let normal = self.normal.map(|x| x / largest);
        let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        normal.map(|x| x / length)
    }
}

/// No number is larger: beyond, an f64 has no more digits for a millimetre, and sums of squares overflow at last.
const MOST: f64 = 1e15;

/// Numbers with commas between.
fn numbers(text: &str, expected: &'static str) -> Result<Vec<f64>, ClipError> {
    let number = |part: &str| part.trim().parse().ok().filter(|number: &f64| number.abs() <= MOST);
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    numbers.ok_or_else(|| ClipError::NoNumbers { expected, found: text.into() })
}

impl FromStr for ClipBox {
    type Err = ClipError;

    fn from_str(text: &str) -> Result<ClipBox, ClipError> {
        let (min, max, degrees) = match numbers(text, BOX)?[..] {
            [x0, y0, z0, x1, y1, z1] => ([x0, y0, z0], [x1, y1, z1], 0.0),
            [x0, y0, z0, x1, y1, z1, degrees] => ([x0, y0, z0], [x1, y1, z1], degrees),
            _ => return Err(ClipError::NoNumbers { expected: BOX, found: text.into() }),
        };
        match (0..3).find(|&a| min[a] > max[a]) {
            Some(a) => Err(ClipError::InsideOut {
                axis: ['x', 'y', 'z'][a],
                low: min[a].to_string(),
                high: max[a].to_string(),
            }),
            None => Ok(ClipBox { min, max, degrees }),
        }
    }
}

impl FromStr for Slab {
    type Err = ClipError;

    fn from_str(text: &str) -> Result<Slab, ClipError> {
        let [x, y, z, nx, ny, nz, thickness] = numbers(text, SLAB)?[..] else {
            return Err(ClipError::NoNumbers { expected: SLAB, found: text.into() });
        };
        if [nx, ny, nz] == [0.0; 3] {
            return Err(ClipError::NoDirection);
        }
        if thickness <= 0.0 {
            return Err(ClipError::NoThickness(thickness.to_string()));
        }
        Ok(Slab { point: [x, y, z], normal: [nx, ny, nz], thickness })
    }
}

impl Display for ClipBox {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let ([x0, y0, z0], [x1, y1, z1]) = (self.min, self.max);
        write!(f, "{x0},{y0},{z0},{x1},{y1},{z1}")?;
        if self.degrees == 0.0 { Ok(()) } else { write!(f, ",{}", self.degrees) }
    }
}

impl Display for Slab {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Slab { point: [x, y, z], normal: [nx, ny, nz], thickness } = self;
        write!(f, "{x},{y},{z},{nx},{ny},{nz},{thickness}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_of_any_length_are_the_same() {
        for length in ["1e-300", "1e-8", "1", "1e15"] {
            let slab: Slab = format!("1,2,3,0,{length},-{length},1").parse().unwrap();
            let [x, y, z] = slab.across();
            assert_eq!((x, y), (0.0, -z), "{length}");
            assert!((y - 0.5f64.sqrt()).abs() < 1e-15, "{length}: {y}");
        }
        assert!("1,2,3,0,0,1e16,1".parse::<Slab>().is_err() && "0,0,0,1e308,1e308,1".parse::<ClipBox>().is_err());
    }

    #[test]
    fn boxes_and_slabs_are_read_as_they_are_written() {
        for text in ["0,1,2,3,4,5.5", "456000.25,5412000,-3,456100.75,5412050,40,30.5", "0,0,0,0,0,0"] {
            assert_eq!(text.parse::<ClipBox>().unwrap().to_string(), text);
        }
        assert_eq!("0,0,0, 1,1,1,0".parse::<ClipBox>().unwrap().to_string(), "0,0,0,1,1,1");
        let slab = "456000.25,5412000,0,0.5,-0.25,0,0.001";
        assert_eq!(slab.parse::<Slab>().unwrap().to_string(), slab);
    }

    #[test]
    fn what_is_wrong_is_told_in_one_line() {
        for (text, hint) in [
            ("1,2,3", "expected x0,y0,z0,x1,y1,z1"),
            ("a,0,0,1,1,1", "expected x0,y0,z0,x1,y1,z1"),
            ("0,9,0,1,1,1", "y goes from 9 to 1"),
            ("0,0,0,1,1,inf", "expected x0"),
        ] {
            let message = text.parse::<ClipBox>().unwrap_err().to_string();
            assert!(message.contains(hint) && !message.contains('\n'), "{message}");
        }
        for (text, hint) in [
            ("1,2,3,4,5,6", "expected x,y,z,nx,ny,nz,thickness"),
            ("0,0,0,0,0,0,1", "no length"),
            ("0,0,0,1,0,0,-2", "above 0, found -2"),
        ] {
            let message = text.parse::<Slab>().unwrap_err().to_string();
            assert!(message.contains(hint) && !message.contains('\n'), "{message}");
        }
    }
}
