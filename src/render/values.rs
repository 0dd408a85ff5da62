//! The attributes' values of a scene: which are in columns, which are on their way, and how they are spread.

use std::sync::Arc;

use super::{
    Backend,
    coloring::Coloring,
    column::{ColumnId, Keys},
    histogram::{AttributeStats, Histogram},
    keys::KeyBuffer,
};
use crate::{
    device::RenderError,
    scene::{Attribute, ColorStats, INTENSITY_BINS, PointBatch, SceneFacts, intensity_of_bin},
};

/// Elevations of so many points are counted all; of larger scenes, one in [`SAMPLED`].
const COUNTED_POINTS: u64 = 1 << 20;
const SAMPLED: u32 = 16;

/// Values of one attribute by record.
struct ValueColumn {
    attribute: Attribute,
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
    /// Intensities that were read besides.
    intensities: Vec<u64>,
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

    /// Begins to read attributes besides; what was being read so far, and is not complete, is dropped.
    pub fn begin_reading(&mut self, attributes: Vec<Attribute>, backend: &mut impl Backend) {
        self.stop_reading(backend);
        attributes.iter().for_each(|attribute| self.begin(attribute.clone()));
        if attributes.contains(&Attribute::Intensity) {
            self.intensities.clear();
        }
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
        let column = ValueColumn { attribute, stats, state: State::Arriving, version: 0 };
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
            if attribute == Attribute::Intensity {
                self.intensities.resize(INTENSITY_BINS, 0);
                let counts = self.intensities.iter_mut().zip(batch.stats.intensity.iter());
                counts.for_each(|(sum, &n)| *sum += u64::from(n));
            }
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
        if let Some(keys) = buffer.fill(attribute, batch, file, &scene.grid) {
            match keys {
                Keys::Small(keys) => self.columns[id].stats.add_small(keys),
                Keys::Wide(keys) => self.columns[id].stats.add_wide(keys),
            }
            self.columns[id].version += 1;
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
        let every = if scene.points_in_header() > COUNTED_POINTS { SAMPLED } else { 1 };
        let samples = || {
            let mut i = 0;
            std::iter::from_fn(move || {
                while let Some(&record) = batch.records.get(i) {
                    let at = i;
                    let to_next = every - record % every;
                    let jumped = i + to_next as usize;
                    let is_run = batch.records.get(jumped).is_some_and(|&next| next == record.wrapping_add(to_next));
                    i = if is_run { jumped } else { i + 1 };
                    if record % every == 0 {
                        return Some(f64::from(batch.positions[at][2]));
                    }
                }
                None
            })
        };
        self.elevations.add(samples);
    }

    /// How an attribute's values are spread, as far as they are known; `stats` are those of the files' points. Of
    /// elevation and intensity a sample is counted, of intensity by some 16 bins per power of two.
    pub fn stats(&self, attribute: &Attribute, stats: &[ColorStats]) -> Option<AttributeStats> {
        let scene = self.scene.as_ref()?;
        match attribute {
            Attribute::Elevation => Some(AttributeStats::Binned(self.elevations.clone())),
            Attribute::Intensity => {
                let mut counts = vec![0; 1 << 16].into_boxed_slice();
                let own = stats.iter().flat_map(|stats| stats.intensity.iter().map(|&n| u64::from(n)).enumerate());
                for (bin, n) in own.chain(self.intensities.iter().copied().enumerate()) {
                    counts[usize::from(intensity_of_bin(bin))] += n;
                }
                Some(AttributeStats::Counted(counts))
            }
            Attribute::File => {
                let mut counts = vec![0; 1 << 16].into_boxed_slice();
                for (count, file) in counts.iter_mut().zip(&scene.files) {
                    *count = file.points_in_header;
                }
                Some(AttributeStats::Counted(counts))
            }
            _ => self.column(attribute).map(|column| column.stats.clone()),
        }
    }

    /// As [`AttributeStats::counts`].
    pub fn counts(&self, attribute: &Attribute, stats: &[ColorStats]) -> Vec<(u16, u64)> {
        match attribute {
            Attribute::Elevation | Attribute::Intensity | Attribute::File => {
                self.stats(attribute, stats).map_or_else(Vec::new, |stats| stats.counts())
            }
            _ => self.column(attribute).map_or_else(Vec::new, |column| column.stats.counts()),
        }
    }

    /// The values that all but this share of the points lie between, in the attribute's unit.
    pub fn clipped(&self, attribute: &Attribute, clip_percent: f64, stats: &[ColorStats]) -> Option<[f64; 2]> {
        match attribute {
            Attribute::Elevation => {
                let grid = self.scene.as_ref()?.grid;
                let steps = self.elevations.clipped(clip_percent)?;
                Some(steps.map(|z| grid.origin[2] + grid.scale[2] * z))
            }
            Attribute::Intensity | Attribute::File => self.stats(attribute, stats)?.clipped(clip_percent),
            _ => self.column(attribute)?.stats.clipped(clip_percent),
        }
    }
}
