//! What points are coloured by, and with which colours: what the user sets.

mod by;
mod classes;
mod map;
mod tone;

use std::collections::BTreeMap;

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
    /// Colours of files, by their number from 0, that are not the usual ones.
    pub files: BTreeMap<usize, [u8; 3]>,
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
            files: BTreeMap::new(),
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

    /// The colour of the points of a file, where files are told apart.
    pub fn file_color(&self, number: usize) -> [u8; 3] {
        self.files.get(&number).copied().unwrap_or_else(|| palette(number))
    }

    /// Settings that change nothing, one line each: what they were made for is not what points are coloured by.
    pub fn without_effect(&self) -> Vec<String> {
        let (usual, by) = (Coloring::default(), &self.by);
        let is_measured = by.attribute().is_some_and(|attribute| !attribute.is_categorical());
        let has_map = is_measured || *by == ColorBy::Auto;
        let is_by = |attribute| by.attribute() == Some(&attribute);
        let measured = "what is measured, such as elevation";
        let idle = [
            (self.range.is_some() && !is_measured, "--color-range", measured),
            (self.clip_percent != usual.clip_percent && !is_measured, "--color-clip", measured),
            (self.map.is_some() && !has_map, "--color-map", measured),
            (self.classes != usual.classes && !is_by(Attribute::Classification), "--class-color", "classification"),
            (self.files != usual.files && !is_by(Attribute::File), "--file-color", "file"),
        ];
        let idle = idle.into_iter().filter(|(is_idle, ..)| *is_idle);
        idle.map(|(_, option, of)| format!("{option} changes nothing in colours by {by}: it is for {of}")).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_that_change_nothing_are_told() {
        let mut all = Coloring { map: Some(ColorMap::Turbo), range: Some([0.0, 1.0]), ..Default::default() };
        all.clip_percent = 5.0;
        all.classes.set_color(6, [1, 2, 3]);
        all.files.insert(0, [1, 2, 3]);
        for (by, expected) in [
            ("auto", &["--color-range", "--color-clip", "--class-color", "--file-color"][..]),
            ("rgb", &["--color-range", "--color-clip", "--color-map", "--class-color", "--file-color"]),
            ("classification", &["--color-range", "--color-clip", "--color-map", "--file-color"]),
            ("file", &["--color-range", "--color-clip", "--color-map", "--class-color"]),
            ("elevation", &["--class-color", "--file-color"]),
            ("extra:height", &["--class-color", "--file-color"]),
        ] {
            let by: ColorBy = by.parse().unwrap();
            let told = Coloring { by: by.clone(), ..all.clone() }.without_effect();
            let options: Vec<&str> = told.iter().filter_map(|line| line.split(' ').next()).collect();
            assert_eq!(options, expected, "{by}");
            assert!(told.iter().all(|line| line.contains(&format!(" by {by}: "))), "{told:?}");
            assert!(Coloring { by, ..Default::default() }.without_effect().is_empty());
        }
    }
}
