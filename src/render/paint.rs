//! From what the user set, and what is known of the points, to the colours of a frame.

use super::{
    color::{FileColor, NO_DATA, PointColors, elevation_ramp},
    coloring::{ColorBy, Coloring, palette},
    column::{ColumnColors, Lookup},
    scale::{Scale, Transfer},
    values::Values,
};
use crate::scene::{Attribute, ColorRule, ColorStats, SceneFacts};

/// The colours of a frame. `stats` are those of each file so far.
pub fn point_colors(coloring: &Coloring, scene: &SceneFacts, stats: &[ColorStats], values: &Values) -> PointColors {
    let files = |rule: &dyn Fn(usize, u32) -> FileColor| -> Vec<FileColor> {
        scene.files.iter().enumerate().map(|(number, file)| rule(number, file.first_record)).collect()
    };
    let tone = &coloring.tone;
    let toned = |rule: FileColor| if tone.is_neutral() { rule } else { rule.toned() };
    let rgb_thresholds = || if tone.is_neutral() { [u32::MAX; 256] } else { tone.thresholds() };
    // Thousands of powers, which a neutral tone does not need.
    let levels = (!tone.is_neutral()).then(|| tone.levels());
    let tint = |color: [u8; 3]| levels.as_ref().map_or(color, |levels| color.map(|c| levels[usize::from(c)]));
    let tinted = |colors: [[u8; 4]; 256]| {
        colors.map(|[r, g, b, a]| {
            let [r, g, b] = tint([r, g, b]);
            [r, g, b, a]
        })
    };
    let grey = || files(&|_, first| FileColor::constant(first, NO_DATA));
    let no_column = |files, thresholds, ramp| PointColors { files, thresholds, ramp, column: None };
    let map = || tinted(coloring.map_in_use().colors());
    match &coloring.by {
        ColorBy::Auto => {
            let rule = |number: usize, first| toned(FileColor::new(first, stats[number].rule()));
            let ramp = coloring.map.map_or_else(elevation_ramp, |map| map.colors());
            no_column(files(&rule), rgb_thresholds(), tinted(ramp))
        }
        ColorBy::Rgb => {
            let rule = |number: usize, first| match stats[number].rgb_max {
                0 => FileColor::constant(first, NO_DATA),
                1..=255 => toned(FileColor::new(first, ColorRule::Rgb8)),
                256.. => toned(FileColor::new(first, ColorRule::Rgb16)),
            };
            no_column(files(&rule), rgb_thresholds(), elevation_ramp())
        }
        ColorBy::Attribute(Attribute::File) => {
            let rule = |number, first| FileColor::constant(first, tint(coloring.file_color(number)));
            no_column(files(&rule), [u32::MAX; 256], elevation_ramp())
        }
        ColorBy::Attribute(Attribute::Elevation) => {
            let thresholds = scale(coloring, &Attribute::Elevation, stats, values).grid_thresholds(&scene.grid);
            no_column(files(&|_, first| FileColor::elevation(first)), thresholds, map())
        }
        ColorBy::Attribute(Attribute::Intensity) if values.is_in_slots(&Attribute::Intensity) => {
            let thresholds = scale(coloring, &Attribute::Intensity, stats, values).small_thresholds();
            no_column(files(&|_, first| FileColor::intensity(first)), thresholds, map())
        }
        ColorBy::Attribute(attribute) => {
            let column = values.column_of(attribute).map(|(column, version)| {
                let scale = || scale(coloring, attribute, stats, values);
                let (lookup, thresholds, colors) = if attribute.is_categorical() {
                    (Lookup::Table, [0; 256], tinted(table(coloring, attribute)))
                } else if attribute.is_small() {
                    (Lookup::Small, scale().small_thresholds().map(u64::from), map())
                } else {
                    (Lookup::Wide, values.wide_thresholds(attribute, coloring.range, &scale()), map())
                };
                ColumnColors { column, lookup, thresholds, colors, version }
            });
            PointColors { files: grey(), thresholds: [u32::MAX; 256], ramp: elevation_ramp(), column }
        }
    }
}

/// The colours of an attribute that is told apart, by [`table_index`](super::column::table_index).
fn table(coloring: &Coloring, attribute: &Attribute) -> [[u8; 4]; 256] {
    std::array::from_fn(|value| {
        let [r, g, b] = match attribute {
            Attribute::Classification => coloring.classes.color(value as u8),
            _ => palette(value),
        };
        [r, g, b, 255]
    })
}

/// The scale in use: the range that the user set, else that of the points so far.
pub fn scale(coloring: &Coloring, attribute: &Attribute, stats: &[ColorStats], values: &Values) -> Scale {
    let automatic = || values.clipped(attribute, coloring.clip_percent, stats).unwrap_or([0.0, 1.0]);
    let [low, high] = coloring.range.unwrap_or_else(automatic);
    let transfer = if *attribute == Attribute::Intensity { Transfer::Root } else { Transfer::Linear };
    Scale { low, high, transfer }
}
