//! The CPU backend: the kernels' twins, each in a file named as its shader, together a renderer for
//! machines without a GPU. Twins are written from the design and the paper, not from the WGSL, and no
//! result depends on the number of threads.

mod average;
mod columns;
mod index;
mod mask;
mod raster;
mod resolve;
mod store;
mod threads;

use std::{ops::Range, sync::atomic::AtomicU64, thread::available_parallelism, time::Instant};

use self::{
    average::PixelSums, columns::Columns, mask::Mask, resolve::Resolved, store::PointStore, threads::map_parts,
};
use super::{
    Averaging, Backend, BackendInfo, ColumnId, FramePlan, Keys, PassTimes, Picture, Raster, RenderError, Sums, View,
};
use crate::{
    scene::PointBatch,
    store::{Encoding, Insertion, Packing},
};

/// The word of a pixel that no point covers.
const BACKGROUND: u64 = u64::MAX;

/// Largest picture. A pixel takes 20 bytes here, 36 with high-quality shading, and as much again in a [`Picture`].
const MAX_PIXELS: u64 = 1 << 28;

/// Smallest shares of work that are worth a thread (starting one takes some 20 µs).
const POINTS_PER_THREAD: usize = 4096;
const PIXELS_PER_THREAD: usize = 16_384;

/// Stores points in memory and draws frames on the processor.
pub struct CpuBackend {
    info: BackendInfo,
    threads: usize,
    store: PointStore,
    mask: Mask,
    /// Slots that the last frame shows, each once.
    visible: Vec<u32>,
    /// Slots of the points inserted since the last frame.
    fresh: Vec<u32>,
    relocation: bool,
    width: u32,
    height: u32,
    /// Per pixel: depth in the upper, slot in the lower half.
    words: Vec<AtomicU64>,
    /// Of high-quality shading, per pixel; empty until asked for.
    sums: Vec<PixelSums>,
    resolved: Resolved,
    columns: Columns,
    /// Seconds that insertions took since the last frame.
    insert_secs: f64,
    /// Insertions since the last frame.
    insertions: u32,
    times: Option<PassTimes>,
}

impl CpuBackend {
    /// `threads`: by default one per core.
    pub fn new(threads: Option<usize>) -> CpuBackend {
        let threads = threads.unwrap_or_else(|| available_parallelism().map_or(1, usize::from)).max(1);
        let adapter = format!("CPU, {threads} {}", if threads == 1 { "thread" } else { "threads" });
        CpuBackend {
            info: BackendInfo {
                adapter,
                api: "cpu".into(),
                driver: String::new(),
                method: Raster::Cpu,
                encoding: Encoding::Wide,
                choice: None,
            },
            threads,
            store: PointStore::default(),
            mask: Mask::default(),
            visible: Vec::new(),
            fresh: Vec::new(),
            relocation: true,
            width: 0,
            height: 0,
            words: Vec::new(),
            sums: Vec::new(),
            resolved: Resolved::default(),
            columns: Columns::default(),
            insert_secs: 0.0,
            insertions: 0,
            times: None,
        }
    }

    /// The sums of high-quality shading in the last frame that had any: red, green, blue and fragments of
    /// each pixel, without its front point. For tests.
    pub fn read_sums(&self) -> Vec<[u64; 4]> {
        self.sums.iter().map(average::unpacked).collect()
    }

    /// Which slots a filter hides, in order; empty without a filter. For tests.
    pub fn read_hidden(&self) -> Vec<bool> {
        let slots = if self.mask.is_off() { 0 } else { self.store.records.len() as u32 };
        (0..slots).map(|slot| !self.mask.shows(slot)).collect()
    }

    /// Makes room for the sums of all pixels, and empties them if they begin anew.
    fn prepare_sums(&mut self, begins: bool) -> Result<(), RenderError> {
        if self.sums.len() != self.words.len() {
            let (width, height) = (self.width, self.height);
            self.sums = Vec::new();
            let pixels = self.words.len();
            let full = |_| RenderError::TooManyPixels { width, height, limit: MAX_PIXELS };
            self.sums.try_reserve_exact(pixels).map_err(full)?;
            self.sums.resize_with(pixels, PixelSums::default);
        } else if begins {
            self.sums.iter_mut().flatten().for_each(|sum| *sum.get_mut() = 0);
        }
        Ok(())
    }

    /// Adds a point to the sums.
    fn add_slot(&self, plan: &FramePlan, slot: u32) {
        if !self.mask.shows(slot) {
            return;
        }
        let position = self.store.positions[slot as usize];
        let color = || resolve::point_color(&plan.colors, &self.store, slot);
        average::add_point(&self.sums, &self.words, &plan.view, slot, position, color);
    }

    /// Adds the points drawn from lists, but for those that [`CpuBackend::add_span`] adds.
    fn add_lists(&self, plan: &FramePlan, averaging: &Averaging) {
        let lists = [(&self.visible, plan.reproject), (&self.fresh, plan.fresh)];
        for (list, _) in lists.into_iter().filter(|&(_, drawn)| drawn && averaging.lists) {
            map_parts(self.threads, list.len(), POINTS_PER_THREAD, |part| {
                let others = list[part].iter().filter(|slot| !averaging.slots.iter().any(|span| span.contains(slot)));
                others.for_each(|&slot| self.add_slot(plan, slot));
            });
        }
    }

    fn add_span(&self, plan: &FramePlan, averaging: &Averaging) {
        for span in &averaging.slots {
            map_parts(self.threads, span.len(), POINTS_PER_THREAD, |part| {
                (span.start + part.start as u32..span.start + part.end as u32)
                    .for_each(|slot| self.add_slot(plan, slot));
            });
        }
    }

    /// Makes the picture all background.
    fn clear(&mut self) {
        for word in &mut self.words {
            *word.get_mut() = BACKGROUND;
        }
    }

    /// Draws the points in these slots.
    fn draw_slots(&self, plan: &FramePlan, slots: &[u32]) {
        map_parts(self.threads, slots.len(), POINTS_PER_THREAD, |part| {
            for &slot in slots[part].iter().filter(|&&slot| self.mask.shows(slot)) {
                raster::draw_point(&self.words, &plan.view, slot, self.store.positions[slot as usize]);
            }
        });
    }

    /// Draws the points of a run of slots.
    fn draw_span(&self, plan: &FramePlan, span: Range<u32>) {
        let positions = &self.store.positions[span.start as usize..span.end as usize];
        map_parts(self.threads, positions.len(), POINTS_PER_THREAD, |part| {
            let points = (span.start + part.start as u32..).zip(&positions[part]);
            let draw = |(slot, &position)| raster::draw_point(&self.words, &plan.view, slot, position);
            match self.mask.is_off() {
                true => points.for_each(draw),
                false => points.filter(|&(slot, _)| self.mask.shows(slot)).for_each(draw),
            }
        });
    }
}

/// The slots that are listed as visible after these points were drawn under these slot numbers: the rasterizer's and
/// the index's twins alone, for slots beyond what memory holds.
pub fn list_visible(view: &View, points: &[(u32, [i32; 3])]) -> Vec<u32> {
    let pixels = view.width as usize * view.height as usize;
    let words: Vec<AtomicU64> = (0..pixels).map(|_| AtomicU64::new(BACKGROUND)).collect();
    points.iter().for_each(|&(slot, position)| raster::draw_point(&words, view, slot, position));
    let mut visible = Vec::new();
    index::build(&mut visible, &words, view, 1);
    visible
}

impl Backend for CpuBackend {
    fn info(&self) -> &BackendInfo {
        &self.info
    }

    fn sums(&self) -> Sums {
        Sums::Hqs
    }

    fn reset(&mut self, _points: u64, _packing: Option<Packing>) {
        // No memory is set aside for the points announced: a header may promise any number of them.
        self.store = PointStore::default();
        self.mask = Mask::default();
        self.columns = Columns::default();
        self.visible = Vec::new();
        self.fresh = Vec::new();
        self.insert_secs = 0.0;
        self.insertions = 0;
        self.times = None;
    }

    fn insertions_per_frame(&self) -> usize {
        8
    }

    fn resize(&mut self, size: [u32; 2]) -> Result<(), RenderError> {
        let [width, height] = size;
        let pixels = u64::from(width) * u64::from(height);
        let refusal = || RenderError::TooManyPixels { width, height, limit: MAX_PIXELS };
        if pixels > MAX_PIXELS {
            return Err(refusal());
        }
        let pixels = pixels as usize;
        if self.words.len() != pixels {
            self.words = Vec::new();
            self.words.try_reserve_exact(pixels).map_err(|_| refusal())?;
            self.words.resize_with(pixels, || AtomicU64::new(BACKGROUND));
            self.resolved.resize(pixels).map_err(|_| refusal())?;
        }
        (self.width, self.height) = (width, height);
        Ok(())
    }

    fn insert(&mut self, insertion: &Insertion, points: &PointBatch) -> Result<(), RenderError> {
        let start = Instant::now();
        let out_of_memory = |e: std::collections::TryReserveError| RenderError::OutOfMemory {
            stored: insertion.old.into(),
            detail: e.to_string(),
        };
        self.fresh.try_reserve(points.len()).map_err(out_of_memory)?;
        let lists: [&mut [u32]; 2] =
            if self.relocation { [&mut self.visible, &mut self.fresh] } else { Default::default() };
        let targets = self.store.insert(insertion, points, lists, self.threads).map_err(out_of_memory)?;
        self.fresh.extend(targets);
        self.insert_secs += start.elapsed().as_secs_f64();
        self.insertions += 1;
        Ok(())
    }

    fn fill_column(&mut self, column: ColumnId, records: &[u32], keys: Keys<'_>) -> Result<(), RenderError> {
        let refusal =
            |error: std::collections::TryReserveError| RenderError::NoMemoryForValues { detail: error.to_string() };
        self.columns.fill(column, records, keys).map_err(refusal)
    }

    fn drop_column(&mut self, column: ColumnId) {
        self.columns.drop_column(column);
    }

    fn set_relocation(&mut self, on: bool) {
        self.relocation = on;
    }

    fn draw(&mut self, plan: &FramePlan) -> Result<(), RenderError> {
        let mut last = Instant::now();
        let mut lap = || std::mem::replace(&mut last, Instant::now()).elapsed().as_secs_f64();
        let mut times = PassTimes {
            insert: std::mem::take(&mut self.insert_secs),
            insertions: std::mem::take(&mut self.insertions),
            passes: plan.passes(),
            ..Default::default()
        };

        self.resize([plan.view.width, plan.view.height])?;
        self.mask.update(plan.mask.as_ref(), &self.store, &self.columns, &self.fresh, self.threads).map_err(
            |error| {
                let (points, detail) = (self.store.records.len() as u64, error.to_string());
                RenderError::NoMemoryForFilter { points, detail }
            },
        )?;
        times.insert += lap();
        if !plan.keeps_depths {
            self.clear();
            if plan.reproject {
                self.draw_slots(plan, &self.visible);
            }
            times.reproject = lap();
            if plan.fresh {
                self.draw_slots(plan, &self.fresh);
            }
            times.fresh = lap();
            for range in &plan.fill {
                times.fill_points += range.end - range.start;
                self.draw_span(plan, range.clone());
            }
            times.fill = lap();
        }
        if !plan.shading.high_quality && !plan.aside {
            self.sums = Vec::new();
        }
        if let Some(averaging) = &plan.averaging {
            self.prepare_sums(averaging.begins)?;
            self.add_lists(plan, averaging);
            times.average = lap();
            self.add_span(plan, averaging);
            times.average_fill = lap();
            times.average_points = averaging.points();
        }
        if !plan.aside {
            self.fresh.clear();
        }
        if !plan.keeps_depths && !plan.aside {
            index::build(&mut self.visible, &self.words, &plan.view, self.threads);
        }
        times.index = lap();
        let sums = plan.averaging.as_ref().map(|_| self.sums.as_slice());
        self.resolved.resolve(plan, &self.words, sums, &self.store, &self.columns, self.threads);
        times.resolve = lap();
        self.times = Some(times);
        Ok(())
    }

    fn pass_times(&mut self) -> Option<PassTimes> {
        self.times.take()
    }

    fn points_shown(&mut self) -> Option<u64> {
        self.mask.points_shown()
    }

    fn wait(&mut self) -> Result<(), RenderError> {
        Ok(())
    }

    fn read(&mut self) -> Result<Picture, RenderError> {
        let depth_of = |word: &mut AtomicU64| match *word.get_mut() {
            BACKGROUND => f32::INFINITY,
            word => raster::depth(word),
        };
        let depth: Vec<f32> = self.words.iter_mut().map(depth_of).collect();
        let record_of = |(&record, depth): (&u32, &f32)| if depth.is_finite() { i64::from(record) } else { -1 };
        Ok(Picture {
            width: self.width,
            height: self.height,
            rgba: self.resolved.rgba.clone(),
            records: self.resolved.records.iter().zip(&depth).map(record_of).collect(),
            depth,
        })
    }
}
