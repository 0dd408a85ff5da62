//! [`Progressive`] in colours of the user's choice: which attributes it needs, and how their values come.

use std::sync::Arc;

use super::{
    Backend, Progressive,
    color::{FileColor, NO_DATA},
    coloring::{ColorBy, Coloring},
    column::{ColumnId, table_index},
    histogram::AttributeStats,
    legend::{self, Legend, LegendKey},
    paint,
    scale::Scale,
};
use crate::{
    device::RenderError,
    scene::{Attribute, ColorStats, FileFacts, PointBatch},
};

impl<B: Backend> Progressive<B> {
    /// Says which attributes all batches of the scene just opened carry, besides what every batch has: they were asked
    /// of the reader. To be called before the first batch.
    pub fn carry(&mut self, attributes: impl IntoIterator<Item = Attribute>) {
        self.values.carry(attributes);
        self.selection.is_stale = true;
    }

    /// Colours points otherwise from the next frame on. That frame costs no more than any; where values are lacking,
    /// see [`Progressive::lacking`].
    pub fn set_coloring(&mut self, coloring: &Coloring) {
        if self.coloring != *coloring {
            self.coloring.clone_from(coloring);
            self.values.forget_refusals();
            self.colors_are_stale = true;
        }
    }

    pub fn coloring(&self) -> &Coloring {
        &self.coloring
    }

    /// Those of these attributes that some file has and that have neither come nor are on their way: a second reader
    /// has to fetch them, see [`Progressive::begin_values`].
    pub fn lacking<'a>(&self, attributes: impl IntoIterator<Item = &'a Attribute>) -> Vec<Attribute> {
        attributes.into_iter().filter(|attribute| self.values.lacks(attribute)).cloned().collect()
    }

    /// Announces values of these attributes, of all records of the scene, in any order. Values that were announced
    /// before and have not all come are dropped.
    pub fn begin_values(&mut self, attributes: Vec<Attribute>) {
        self.values.begin_reading(attributes, &mut self.backend);
        self.colors_are_stale = true;
        self.selection.is_stale = true;
    }

    /// Takes the announced values of a batch, whose points are not stored: they are, or will be, by the way of
    /// [`Progressive::offer`]. To be given back to its reader.
    ///
    /// # Errors
    /// If memory has no room for them; the others are then not needed either.
    pub fn offer_values(&mut self, batch: &PointBatch) -> Result<(), RenderError> {
        self.values.take_values(batch, &mut self.backend, &self.coloring);
        self.colors_are_stale = true;
        self.selection.is_stale = true;
        self.values.take_refusal().map_or(Ok(()), Err)
    }

    /// All announced values have come.
    pub fn end_values(&mut self) {
        self.values.end_reading();
        self.colors_are_stale = true;
        self.selection.is_stale = true;
    }

    /// Nobody will fetch the announced values: those that have not all come are dropped.
    pub fn drop_values(&mut self) {
        self.values.stop_reading(&mut self.backend);
        self.colors_are_stale = true;
        self.selection.is_stale = true;
    }

    /// True while announced values are on their way.
    pub fn awaits_values(&self) -> bool {
        self.values.is_reading()
    }

    /// Whether high-quality shading averages the colours: those of a column it does not, there is no room for one more
    /// binding. Each pixel then shows its front point.
    pub fn can_average(&self) -> bool {
        match &self.coloring.by {
            ColorBy::Auto | ColorBy::Rgb => true,
            ColorBy::Attribute(attribute) => self.values.is_in_slots(attribute),
        }
    }

    /// How an attribute's values are spread so far, if it is known: what a histogram and an automatic range are made
    /// of. Elevations are in steps of the scene's grid. Of elevations of large scenes, and of intensities that came with
    /// the points, a sample is counted; the least and the largest are those of all points.
    pub fn stats(&self, attribute: &Attribute) -> Option<AttributeStats> {
        self.values.stats(attribute, &self.stats)
    }

    /// The numbers of points, or of a sample of them, in `bins` equal parts of a range in the attribute's unit.
    pub fn histogram(&self, attribute: &Attribute, range: [f64; 2], bins: usize) -> Option<Vec<u64>> {
        let grid = &self.scene.as_ref()?.grid;
        let of_stats = |z: f64| match attribute {
            Attribute::Elevation => (z - grid.origin[2]) / grid.scale[2],
            _ => z,
        };
        Some(self.stats(attribute)?.bins(range.map(of_stats), bins))
    }

    /// Smallest and largest value so far, in the attribute's unit.
    pub fn extent(&self, attribute: &Attribute) -> Option<[f64; 2]> {
        self.values.clipped(attribute, 0.0, &self.stats)
    }

    /// How many points have each of the values that there are so far, by value: of classes, returns, sources, user
    /// data, and files. Of other attributes, and of what was not read, none.
    pub fn counts(&self, attribute: &Attribute) -> Vec<(u16, u64)> {
        match attribute {
            Attribute::Intensity => Vec::new(),
            _ => self.values.counts(attribute, &self.stats),
        }
    }

    /// The files that are coloured by RGB, which they have, and of which all points so far have none but zeros; one
    /// line each.
    pub fn colorless_files(&self) -> Vec<String> {
        let files = self.scene.iter().flat_map(|scene| scene.files.iter().zip(&self.stats));
        let has_points = |stats: &ColorStats| stats.z_min <= stats.z_max;
        let is_colorless = |(file, stats): &(&FileFacts, &ColorStats)| {
            self.coloring.by == ColorBy::Rgb && ColorBy::Rgb.is_in(file) && stats.rgb_max == 0 && has_points(stats)
        };
        let line = |(file, _): (&FileFacts, _)| {
            format!("{}: red, green and blue of all points are 0: they are grey", file.path.display())
        };
        files.filter(is_colorless).map(line).collect()
    }

    /// What the colours mean; `None` for RGB, for automatic colours, which differ from file to file, and as long as
    /// there are no values.
    pub fn legend(&self) -> Option<Legend> {
        let (scene, attribute) = (self.scene.as_ref()?, legend::subject(&self.coloring)?);
        let title = legend::title(attribute, scene);
        let rgb = |[r, g, b, _]: [u8; 4]| [r, g, b];
        let colors = paint::point_colors(&self.coloring, scene, &self.stats, &self.values);
        let key = if attribute.is_categorical() {
            let table = colors.column.as_ref().map(|column| column.colors);
            let color = |value: u16| match (attribute, &table) {
                (Attribute::File, _) => colors.files.get(usize::from(value)).map_or(NO_DATA, FileColor::constant_color),
                (_, Some(table)) => rgb(table[table_index(value)]),
                _ => NO_DATA,
            };
            LegendKey::Classes(legend::classes(&self.coloring, attribute, &self.counts(attribute), color, scene))
        } else {
            self.extent(attribute)?;
            let scale = self.scale(attribute);
            let ramp = colors.column.as_ref().map_or(&colors.ramp, |column| &column.colors);
            LegendKey::Scale {
                colors: ramp.iter().copied().map(rgb).collect(),
                ticks: legend::ticks(attribute, &scale, scene),
                scale,
            }
        };
        Some(Legend { title, key })
    }

    /// True if all values of an attribute that is not in the store's slots have come.
    pub fn has_all_values(&self, attribute: &Attribute) -> bool {
        self.values.is_complete(attribute)
    }

    /// The column that holds an attribute, and how often it has changed.
    pub fn column_of(&self, attribute: &Attribute) -> Option<(ColumnId, u64)> {
        self.values.column_of(attribute)
    }

    /// Whether the store's slots have it, so that there is no column.
    pub fn is_in_slots(&self, attribute: &Attribute) -> bool {
        self.values.is_in_slots(attribute)
    }

    /// The scale that an attribute is shown by: the range that the user set, else that of the points so far.
    pub fn scale(&self, attribute: &Attribute) -> Scale {
        paint::scale(&self.coloring, attribute, &self.stats, &self.values)
    }

    pub(super) fn refresh_colors(&mut self) {
        if !std::mem::take(&mut self.colors_are_stale) {
            return;
        }
        if let Some(scene) = &self.scene {
            let colors = paint::point_colors(&self.coloring, scene, &self.stats, &self.values);
            if colors != *self.colors {
                self.colors = Arc::new(colors);
            }
        }
    }
}
