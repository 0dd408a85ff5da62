//! What points are coloured by, and with which colours: what the user sets.

mod by;
mod classes;
mod map;
mod tone;

pub use by::{ColorBy, UnknownColor};
pub use classes::{Class, ClassTable};
pub use map::{ColorMap, UnknownMap, palette};
use serde::{Deserialize, Serialize};
pub use tone::Tone;

use crate::scene::{Attribute, FileFacts, SceneFacts};

/// Share of the points, percent, that the automatic range leaves out at either end: one retro-reflector, or one bird,
/// must not turn the rest into one colour.
pub const CLIP_PERCENT: f64 = 1.0;

/// How points get their colours.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Coloring {
    pub by: ColorBy,
    /// `None`: grey for intensity, viridis for everything else.
    pub map: Option<ColorMap>,
    /// Values with the first and the last colour, in the attribute's unit; `None`: from the points, see
    /// [`Coloring::clip_percent`].
    pub range: Option<[f64; 2]>,
    /// Percent of the points that the automatic range leaves out at either end, 0 to below 50.
    pub clip_percent: f64,
    pub classes: ClassTable,
    pub tone: Tone,
}

impl Default for Coloring {
    fn default() -> Self {
        Coloring {
            by: ColorBy::Auto,
            map: None,
            range: None,
            clip_percent: CLIP_PERCENT,
            classes: ClassTable::default(),
            tone: Tone::default(),
        }
    }
}

impl Coloring {
    /// The colour map in use.
    pub fn map_in_use(&self) -> ColorMap {
        let usual = if self.by.attribute() == Some(&Attribute::Intensity) { ColorMap::Grey } else { ColorMap::Viridis };
        self.map.unwrap_or(usual)
    }

    /// What the points have instead, one line for each file that lacks what they are to be coloured by.
    pub fn absences(&self, scene: &SceneFacts) -> Vec<String> {
        let lacking = scene.files.iter().filter(|file| !self.by.is_in(file));
        lacking.map(|file| absence(&self.by, file)).collect()
    }
}

fn absence(by: &ColorBy, file: &FileFacts) -> String {
    let extra = file.record.extra_names().map(|name| ColorBy::Attribute(Attribute::Extra(name)));
    let all = std::iter::once(ColorBy::Rgb).chain(Attribute::NAMED.map(|(_, a)| ColorBy::Attribute(a))).chain(extra);
    let has: Vec<String> = all.filter(|by| by.is_in(file)).map(|by| by.to_string()).collect();
    format!("{} has no {by}: its points are grey; --color-by takes {}", file.path.display(), has.join(", "))
}
