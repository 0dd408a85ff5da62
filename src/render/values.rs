//! The attributes' values of a scene: which are in columns, which are on their way, and how they are spread.

use std::sync::Arc;

use super::{
    Backend,
    coloring::Coloring,
    column::{ColumnId, Keys},
    histogram::{AttributeStats, Histogram, SampledIntensities},
    keys::KeyBuffer,
    scale::Scale,
    wide::WideKeys,
};
use crate::{
    device::RenderError,
    scene::{Attribute, ColorStats, PointBatch, SAMPLED, SceneFacts, sample_of},
};

/// Elevations of so many points are counted all; of larger scenes, one in [`SAMPLED`].
const COUNTED_POINTS: u64 = 1 << 20;

/// Values of one attribute by record.
struct ValueColumn {
    attribute: Attribute,
    /// What its keys mean, where they are wide.
    wide: WideKeys,
    /// Smallest and largest of these keys, where [`WideKeys::needs_extent`].
    extent: Option<[u64; 2]>,
    stats: AttributeStats,
    state: State,
    /// Batches that have come.
    version: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// There is none, or no more.
    Dropped,
    Arriving,
    Complete,
    /// Memory had no room for it.
    Refused,
}

/// All values of a scene.
#[derive(Default)]
pub struct Values {
    scene: Option<Arc<SceneFacts>>,
    /// A column's index is its [`ColumnId`].
    columns: Vec<ValueColumn>,
    /// What the batches of points have.
    carried: Vec<Attribute>,
    /// What must stay, whatever the colours: a filter needs it.
    protected: Vec<Attribute>,
    /// What is read besides, at the moment.
    reading: Vec<Attribute>,
    /// The grid's third coordinate, sampled by record number.
    elevations: Histogram,
    buffer: KeyBuffer,
    refusal: Option<RenderError>,
}

impl Values {
    pub fn new(scene: Arc<SceneFacts>) -> Values {
        Values { scene: Some(scene), ..Default::default() }
    }

    /// Says what the batches of points carry from the first on.
    pub fn carry(&mut self, attributes: impl IntoIterator<Item = Attribute>) {
        self.carried.extend(attributes);
        for attribute in self.carried.clone() {
            if !self.is_in_slots(&attribute) {
                self.begin(attribute);
            }
        }
    }

    /// Whether the store has it in its slots: no column is needed.
    pub fn is_in_slots(&self, attribute: &Attribute) -> bool {
        match attribute {
            Attribute::Elevation | Attribute::File => true,
            Attribute::Intensity => {
                let all_read = |scene: &Arc<SceneFacts>| scene.files.iter().all(|file| file.record.has_intensities);
                self.carried.contains(attribute) || self.scene.as_ref().is_some_and(all_read)
            }
            _ => false,
        }
    }

    /// Whether it has to be read besides: some file has it, and it is neither there nor on its way.
    pub fn lacks(&self, attribute: &Attribute) -> bool {
        let Some(scene) = &self.scene else { return false };
        let is_known = self.column(attribute).is_some_and(|column| column.state != State::Dropped);
        !self.is_in_slots(attribute) && !is_known && scene.files.iter().any(|file| attribute.is_in(file))
    }

    /// Begins to read attributes besides. What was being read so far, and is not complete, is dropped, unless it goes on:
    /// then what has come stays, for the same will come again, and only the statistics begin anew.
    pub fn begin_reading(&mut self, attributes: Vec<Attribute>, backend: &mut impl Backend) {
        self.reading.retain(|attribute| !attributes.contains(attribute));
        self.stop_reading(backend);
        attributes.iter().for_each(|attribute| self.begin(attribute.clone()));
        self.reading = attributes;
    }

    /// Drops what is being read besides, as far as it is not complete.
    pub fn stop_reading(&mut self, backend: &mut impl Backend) {
        for attribute in std::mem::take(&mut self.reading) {
            if let Some(id) = self.id(&attribute).filter(|&id| self.columns[id].state == State::Arriving) {
                self.drop_column(id, backend);
            }
        }
    }

    /// All that was read besides is there.
    pub fn end_reading(&mut self) {
        let reading = std::mem::take(&mut self.reading);
        self.complete(&reading);
    }

    /// All batches of points have come.
    pub fn end_carrying(&mut self) {
        let carried = self.carried.clone();
        self.complete(&carried);
    }

    fn complete(&mut self, attributes: &[Attribute]) {
        for column in self.columns.iter_mut().filter(|column| attributes.contains(&column.attribute)) {
            if column.state == State::Arriving {
                column.state = State::Complete;
            }
        }
    }

    /// These are needed whatever the colours are.
    pub fn protect(&mut self, attributes: Vec<Attribute>) {
        self.protected = attributes;
    }

    /// Whether its values are on their way, and come otherwise than with the points.
    pub fn is_being_read(&self, attribute: &Attribute) -> bool {
        self.reading.contains(attribute)
    }

    pub fn is_reading(&self) -> bool {
        !self.reading.is_empty()
    }

    fn begin(&mut self, attribute: Attribute) {
        let stats = AttributeStats::new(attribute.is_small());
        let wide = self.scene.as_ref().map_or(WideKeys::Doubles, |scene| WideKeys::new(&attribute, scene));
        // Batches count on: by its version it is seen that a column has changed.
        let version = self.column(&attribute).map_or(0, |column| column.version);
        let column = ValueColumn { attribute, wide, extent: None, stats, state: State::Arriving, version };
        match self.id(&column.attribute) {
            Some(id) => self.columns[id] = column,
            None => self.columns.push(column),
        }
    }

    fn id(&self, attribute: &Attribute) -> Option<ColumnId> {
        self.columns.iter().position(|column| column.attribute == *attribute)
    }

    fn column(&self, attribute: &Attribute) -> Option<&ValueColumn> {
        self.columns.iter().find(|column| column.attribute == *attribute)
    }

    /// The column of an attribute and how much has come into it, if there is one.
    pub fn column_of(&self, attribute: &Attribute) -> Option<(ColumnId, u64)> {
        let id = self.id(attribute)?;
        let column = &self.columns[id];
        matches!(column.state, State::Arriving | State::Complete).then_some((id, column.version))
    }

    /// True if all values that there are of it are there.
    pub fn is_complete(&self, attribute: &Attribute) -> bool {
        self.column(attribute).is_some_and(|column| column.state == State::Complete)
    }

    /// Takes what a batch of points carries.
    pub fn take_points(&mut self, batch: &PointBatch, backend: &mut impl Backend, coloring: &Coloring) {
        self.sample_elevations(batch);
        for attribute in self.carried.clone() {
            if !self.is_in_slots(&attribute) {
                self.take(&attribute, batch, backend, coloring);
            }
        }
    }

    /// Takes what a batch of values has.
    pub fn take_values(&mut self, batch: &PointBatch, backend: &mut impl Backend, coloring: &Coloring) {
        for attribute in self.reading.clone() {
            self.take(&attribute, batch, backend, coloring);
        }
    }

    fn take(&mut self, attribute: &Attribute, batch: &PointBatch, backend: &mut impl Backend, coloring: &Coloring) {
        let (Some(scene), Some(id)) = (self.scene.clone(), self.id(attribute)) else { return };
        let Some(file) = scene.files.get(batch.file as usize) else { return };
        if self.columns[id].state != State::Arriving {
            return;
        }
        let mut buffer = std::mem::take(&mut self.buffer);
        let column = &mut self.columns[id];
        if let Some(keys) = buffer.fill(attribute, batch, file, &scene.grid, &column.wide) {
            match keys {
                Keys::Small(keys) => column.stats.add_small(keys),
                Keys::Wide(keys) => {
                    column.stats.add_wide(keys, |key| column.wide.value(key));
                    if column.wide.needs_extent() {
                        let with = |all: Option<[u64; 2]>, &key: &u64| match all {
                            _ if key == 0 => all,
                            Some([low, high]) => Some([low.min(key), high.max(key)]),
                            None => Some([key; 2]),
                        };
                        column.extent = keys.iter().fold(column.extent, with);
                    }
                }
            }
            column.version += 1;
            let filled = backend.fill_column(id, &batch.records, keys).or_else(|_| {
                // What nothing is coloured by makes room.
                let shown = coloring.by.attribute().and_then(|attribute| self.id(attribute));
                self.make_room([Some(id), shown], backend);
                backend.fill_column(id, &batch.records, keys)
            });
            if let Err(error) = filled {
                self.drop_column(id, backend);
                self.columns[id].state = State::Refused;
                self.refusal = Some(error);
            }
        }
        self.buffer = buffer;
    }

    /// Drops all columns but these; false if there were none.
    fn make_room(&mut self, keep: [Option<ColumnId>; 2], backend: &mut impl Backend) -> bool {
        let others = |(id, column): &(ColumnId, &ValueColumn)| {
            let is_needed = keep.contains(&Some(*id)) || self.protected.contains(&column.attribute);
            column.state == State::Complete && !is_needed
        };
        let others: Vec<ColumnId> = self.columns.iter().enumerate().filter(others).map(|(id, _)| id).collect();
        others.iter().for_each(|&id| self.drop_column(id, backend));
        !others.is_empty()
    }

    /// Makes room for points: columns that nothing is coloured by go. False if there are none.
    pub fn give_way(&mut self, backend: &mut impl Backend, coloring: &Coloring) -> bool {
        let shown = coloring.by.attribute().and_then(|attribute| self.id(attribute));
        self.make_room([shown, None], backend)
    }

    fn drop_column(&mut self, id: ColumnId, backend: &mut impl Backend) {
        backend.drop_column(id);
        self.columns[id].state = State::Dropped;
    }

    /// Why values could not be kept, once.
    pub fn take_refusal(&mut self) -> Option<RenderError> {
        self.refusal.take()
    }

    /// Another coloring may be tried again.
    pub fn forget_refusals(&mut self) {
        for column in self.columns.iter_mut().filter(|column| column.state == State::Refused) {
            column.state = State::Dropped;
        }
    }

    /// By record number, so that the samples do not depend on where batches begin. A run's next sample is found
    /// without looking at the records in between.
    fn sample_elevations(&mut self, batch: &PointBatch) {
        let Some(scene) = &self.scene else { return };
        if scene.points_in_header() <= COUNTED_POINTS {
            return self.elevations.add(|| batch.positions.iter().map(|position| f64::from(position[2])));
        }
        let samples = || {
            let mut i = 0;
            std::iter::from_fn(move || {
                while let Some(&record) = batch.records.get(i) {
                    let row = record / SAMPLED;
                    let sample = [row, row + 1].map(sample_of).into_iter().find(|&sample| sample >= record)?;
                    let at = i + (sample - record) as usize;
                    let is_run = batch.records.get(at) == Some(&sample);
                    i = if is_run { at + 1 } else { i + 1 };
                    if is_run {
                        return Some(f64::from(batch.positions[at][2]));
                    }
                }
                None
            })
        };
        self.elevations.add(samples);
    }

    /// How an attribute's values are spread, as far as they are known; `stats` are those of the files' points. Of
    /// elevations of large scenes and of intensities that came with the points, a sample is counted.
    pub fn stats(&self, attribute: &Attribute, stats: &[ColorStats]) -> Option<AttributeStats> {
        match attribute {
            Attribute::Elevation => {
                let [low, high] = z_extent(stats)?;
                Some(AttributeStats::Binned(self.elevations.clone().between(low, high)))
            }
            Attribute::Intensity if self.column_of(attribute).is_none() => {
                SampledIntensities::new(stats).map(AttributeStats::Intensities)
            }
            Attribute::File => {
                let files = &self.scene.as_ref()?.files;
                Some(AttributeStats::Counted(files.iter().map(|file| file.points_in_header).collect()))
            }
            _ => self.column(attribute).map(|column| column.stats.clone()),
        }
    }

    /// The smallest wide key of each of 256 colours; `range` is what the user set.
    pub fn wide_thresholds(&self, attribute: &Attribute, range: Option<[f64; 2]>, scale: &Scale) -> [u64; 256] {
        let Some(ValueColumn { wide, extent, .. }) = self.column(attribute) else { return scale.wide_thresholds() };
        let between = extent.filter(|_| range.is_none()).and_then(|extent| wide.thresholds_between(extent));
        between.unwrap_or_else(|| wide.thresholds(scale))
    }

    /// As [`AttributeStats::counts`].
    pub fn counts(&self, attribute: &Attribute, stats: &[ColorStats]) -> Vec<(u16, u64)> {
        match attribute {
            Attribute::File => self.stats(attribute, stats).map_or_else(Vec::new, |stats| stats.counts()),
            _ => self.column(attribute).map_or_else(Vec::new, |column| column.stats.counts()),
        }
    }

    /// The values that all but this share of the points lie between, in the attribute's unit.
    pub fn clipped(&self, attribute: &Attribute, clip_percent: f64, stats: &[ColorStats]) -> Option<[f64; 2]> {
        match attribute {
            Attribute::Elevation => {
                let grid = self.scene.as_ref()?.grid;
                let all = z_extent(stats).filter(|_| clip_percent == 0.0);
                let steps = all.or_else(|| self.elevations.clipped(clip_percent))?;
                Some(steps.map(|z| grid.origin[2] + grid.scale[2] * z))
            }
            Attribute::Intensity | Attribute::File if self.column_of(attribute).is_none() => {
                self.stats(attribute, stats)?.clipped(clip_percent)
            }
            _ => self.column(attribute)?.stats.clipped(clip_percent),
        }
    }
}

/// Least and largest third coordinate of all points.
fn z_extent(stats: &[ColorStats]) -> Option<[f64; 2]> {
    let low = stats.iter().map(|stats| stats.z_min).min()?;
    let high = stats.iter().map(|stats| stats.z_max).max()?;
    (low <= high).then_some([low.into(), high.into()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        render::CpuBackend,
        scene::{FileFacts, Grid},
    };

    /// Lines of 64 points; every 16th record has the lowest z, and the highest is that of one point.
    fn lines() -> PointBatch {
        let z = |k: u32| if k == 12_345 { 99_999 } else { 10 * (k % 64) as i32 };
        let mut batch = PointBatch { records: (0..40_000).collect(), ..Default::default() };
        batch.positions = batch.records.iter().map(|&k| [0, 0, if k % 16 == 0 { 0 } else { z(k) }]).collect();
        batch.colors = vec![[0, 0, 0, 500]; 40_000];
        (batch.stats.z_min, batch.stats.z_max) = (0, 99_999);
        (batch.stats.intensity_min, batch.stats.intensity_max) = (500, 500);
        batch.stats.intensity[40] = 2500;
        batch
    }

    fn values(points_in_header: u64) -> Values {
        let file = FileFacts { points_in_header, ..Default::default() };
        let grid = Grid { scale: [0.5; 3], origin: [0.0; 3] };
        let scene = SceneFacts { grid, bounds: Default::default(), files: vec![file], warnings: Vec::new() };
        Values::new(Arc::new(scene))
    }

    #[test]
    fn the_range_of_all_elevations_is_that_of_the_points() {
        let batch = lines();
        for points in [40_000, 1 << 21] {
            let mut values = values(points);
            values.take_points(&batch, &mut CpuBackend::new(Some(1)), &Coloring::default());
            let stats = std::slice::from_ref(&batch.stats);
            assert_eq!(values.clipped(&Attribute::Elevation, 0.0, stats), Some([0.0, 49_999.5]));
            assert_eq!(values.stats(&Attribute::Elevation, stats).unwrap().extent(), Some([0.0, 99_999.0]));
            let [low, high] = values.clipped(&Attribute::Elevation, 1.0, stats).unwrap();
            assert!(low == 0.0 && (315.0..320.0).contains(&high), "every place of a line: {low} {high}");
            let total = values.stats(&Attribute::Elevation, stats).unwrap().total();
            assert_eq!(total, if points > COUNTED_POINTS { 2500 } else { 40_000 });
        }
    }

    #[test]
    fn intensities_that_are_read_again_are_counted_once() {
        let (batch, mut backend, coloring) = (lines(), CpuBackend::new(Some(1)), Coloring::default());
        let stats = std::slice::from_ref(&batch.stats);
        let mut values = values(40_000);
        assert_eq!(values.stats(&Attribute::Intensity, stats).unwrap().total(), 2500, "the reader's sample");
        for _ in 0..2 {
            values.begin_reading(vec![Attribute::Intensity], &mut backend);
            values.take_values(&batch, &mut backend, &coloring);
            values.end_reading();
            assert_eq!(
                values.stats(&Attribute::Intensity, stats).unwrap().total(),
                40_000,
                "each point, by the column"
            );
            assert_eq!(values.clipped(&Attribute::Intensity, 0.0, stats), Some([500.0; 2]));
        }
    }
}
