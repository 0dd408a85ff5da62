//! Progressive rendering, the same for every backend: batches in, frames out.

use std::{collections::VecDeque, sync::Arc, time::Instant};

use serde::Serialize;

use super::{
    backend::{Backend, FramePlan, Picture, Shading},
    budget::{BudgetController, FillBudget},
    camera::View,
    color::FileColor,
};
use crate::{
    device::{PassTimes, RenderError},
    scene::{ColorStats, PointBatch, SceneFacts},
    store::{Coverage, Insertion, MAX_INSERTION_POINTS, SlotOrder},
};

/// Points that enter the store at a time. Larger ones cost fewer look-ups per visible point and
/// second, smaller ones show sooner: at 65,536 a LAZ file is seen after its first two chunks.
pub const INSERTION_POINTS: u32 = 65_536;

/// Slots are 32-bit numbers, and the last one means "no point".
const MAX_POINTS: u64 = u32::MAX as u64;

/// How the store is to be filled; fixes the slot of every point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StoreOptions {
    pub seed: u64,
    /// Points per insertion, 1 to [`MAX_INSERTION_POINTS`]. A scene's last one may be smaller, and its first
    /// one is its first batch, so that something shows at once.
    pub insertion_points: u32,
    /// Store no more than this many points.
    pub max_points: u64,
    /// Anything but shuffled is for measuring what the shuffle is worth.
    pub order: SlotOrder,
}

/// When a frame draws what the last one showed. A viewer always does; the others are what that is measured
/// against.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Reprojection {
    #[default]
    Always,
    /// Unless the view changed: the picture begins anew whenever the camera moves.
    WhileStill,
    /// Every frame is a new sample of the points, and stays one: a still picture never converges.
    Never,
}

impl Default for StoreOptions {
    fn default() -> Self {
        StoreOptions {
            seed: 1,
            insertion_points: INSERTION_POINTS,
            max_points: MAX_POINTS,
            order: SlotOrder::default(),
        }
    }
}

/// What a frame is to show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameRequest {
    pub view: View,
    pub fill: FillBudget,
    pub shading: Shading,
}

/// What a frame did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct FrameReport {
    /// False if nothing had changed, so that nothing was drawn.
    pub drawn: bool,
    pub points_stored: u64,
    /// Points that were tried since the view last changed; all of them: the picture has converged.
    pub points_tried: u64,
    /// False while ties between points of equal depth may stand that slots since renumbered decided;
    /// a full cycle after loading settles them.
    pub settled: bool,
    /// Points that the fill tried in this frame.
    pub fill: u32,
}

impl FrameReport {
    /// The picture equals that of all points stored.
    pub fn is_converged(&self) -> bool {
        self.settled && self.points_tried == self.points_stored
    }
}

/// A scene that grows while it is drawn.
pub struct Progressive<B> {
    backend: B,
    options: StoreOptions,
    reprojection: Reprojection,
    scene: Option<Arc<SceneFacts>>,
    stats: Vec<ColorStats>,
    /// What `stats` say of each file.
    file_colors: Vec<FileColor>,
    /// Batches not yet (wholly) staged; of the first, `taken` points are.
    queue: VecDeque<PointBatch>,
    taken: usize,
    spent: Vec<PointBatch>,
    staged: PointBatch,
    input_ended: bool,
    insertions: u64,
    stored: u32,
    coverage: Coverage,
    /// Points moved to other slots after the points tried had been compared by them. Among points of
    /// equal depth in a pixel (duplicates, level ground from above) the lowest slot wins; if the
    /// winner moves behind one that lost, only trying the loser again puts the picture right.
    unsettled: bool,
    /// Insertions that no frame has drawn as fresh yet.
    undrawn: usize,
    memory_full: bool,
    budget: BudgetController,
    last_times: Option<PassTimes>,
    /// Time on the host that the last frame's insertions took.
    insert_secs: f64,
    last_view: Option<View>,
    last_shading: Option<Shading>,
}

impl<B: Backend> Progressive<B> {
    pub fn new(backend: B, options: StoreOptions) -> Self {
        assert!((1..=MAX_INSERTION_POINTS).contains(&options.insertion_points), "{options:?}");
        Progressive {
            backend,
            options,
            reprojection: Reprojection::default(),
            scene: None,
            stats: Vec::new(),
            file_colors: Vec::new(),
            queue: VecDeque::new(),
            taken: 0,
            spent: Vec::new(),
            staged: PointBatch::default(),
            input_ended: false,
            insertions: 0,
            stored: 0,
            coverage: Coverage::default(),
            unsettled: false,
            undrawn: 0,
            memory_full: false,
            budget: BudgetController::default(),
            last_times: None,
            insert_secs: 0.0,
            last_view: None,
            last_shading: None,
        }
    }

    pub fn backend(&self) -> &B {
        &self.backend
    }

    pub fn backend_mut(&mut self) -> &mut B {
        &mut self.backend
    }

    /// For measuring other ways than a viewer's.
    pub fn set_reprojection(&mut self, reprojection: Reprojection) {
        self.reprojection = reprojection;
    }

    pub fn scene(&self) -> Option<&Arc<SceneFacts>> {
        self.scene.as_ref()
    }

    /// Starts a scene; an earlier one is dropped.
    pub fn open(&mut self, scene: Arc<SceneFacts>) {
        self.backend.reset(scene.points_in_header().min(self.options.max_points));
        self.stats = vec![ColorStats::default(); scene.files.len()];
        let unseen = ColorStats::default().rule();
        self.file_colors = scene.files.iter().map(|file| FileColor::new(file.first_record, unseen)).collect();
        self.scene = Some(scene);
        self.spent.extend(self.queue.drain(..));
        self.taken = 0;
        self.staged.clear();
        self.input_ended = false;
        self.insertions = 0;
        self.stored = 0;
        self.coverage = Coverage::default();
        self.unsettled = false;
        self.undrawn = 0;
        self.memory_full = false;
        self.last_view = None;
    }

    /// True if the next frame could insert more points than are waiting.
    pub fn wants_points(&self) -> bool {
        !self.is_full()
            && self.waiting() < u64::from(self.options.insertion_points) * self.backend.insertions_per_frame() as u64
    }

    /// Points offered and not yet inserted.
    pub fn waiting(&self) -> u64 {
        let queued: usize = self.queue.iter().map(PointBatch::len).sum();
        (queued - self.taken + self.staged.len()) as u64
    }

    /// True if the store holds as many points as it may.
    pub fn is_full(&self) -> bool {
        self.memory_full || u64::from(self.stored) >= self.options.max_points.min(MAX_POINTS)
    }

    /// Queues a batch for the next frames.
    pub fn offer(&mut self, batch: PointBatch) {
        self.queue.push_back(batch);
    }

    /// Says that no more batches follow, so that the points left over may enter as a smaller insertion.
    pub fn end_of_input(&mut self) {
        self.input_ended = true;
    }

    /// Batches whose memory may be used again.
    pub fn spent(&mut self) -> impl Iterator<Item = PointBatch> + '_ {
        self.spent.drain(..)
    }

    pub fn points_stored(&self) -> u64 {
        self.stored.into()
    }

    /// Points that the next frame may try.
    pub fn fill_points(&self, budget: FillBudget) -> u32 {
        self.budget.points(budget)
    }

    /// Times of the latest frame that the device has finished, if it can tell.
    pub fn last_pass_times(&self) -> Option<&PassTimes> {
        self.last_times.as_ref()
    }

    pub fn insertions(&self) -> u64 {
        self.insertions
    }

    /// True once all input has entered the store.
    pub fn is_loaded(&self) -> bool {
        (self.input_ended && self.waiting() == 0) || self.is_full()
    }

    /// Draws the next frame, if anything changed since the last.
    pub fn frame(&mut self, request: &FrameRequest) -> Result<FrameReport, RenderError> {
        let view_changed = self.last_view != Some(request.view);
        if view_changed {
            self.restart();
        }
        if let Some(times) = self.backend.pass_times() {
            if let FillBudget::Target(secs) = request.fill {
                self.budget.learn(&times, self.insert_secs, secs);
            }
            self.last_times = Some(times);
        }
        // Before points fill the memory.
        self.backend.resize([request.view.width, request.view.height])?;
        let start = Instant::now();
        let limit = self.backend.insertions_per_frame() - self.undrawn;
        // The first picture does not wait for more.
        let limit = if self.insertions == 0 { limit.min(1) } else { limit };
        self.insert_waiting(self.budget.insertions(request.fill, limit))?;
        self.insert_secs = start.elapsed().as_secs_f64();
        if self.unsettled && self.is_loaded() {
            self.restart();
        }
        let mut complete = self.coverage.is_complete(self.stored);
        if complete && self.reprojection == Reprojection::Never && self.stored > 0 {
            self.restart();
            complete = false;
        }
        if !view_changed && self.undrawn == 0 && complete && self.last_shading == Some(request.shading) {
            return Ok(self.report(false, 0));
        }
        let fill = self.coverage.advance(self.stored, self.budget.points(request.fill));
        let filled = fill.iter().map(|r| r.end - r.start).sum();
        let reproject = match self.reprojection {
            Reprojection::Always => true,
            Reprojection::WhileStill => !view_changed,
            Reprojection::Never => false,
        };
        self.draw(request, reproject, true, fill)?;
        Ok(self.report(true, filled))
    }

    /// The picture of all points stored, brought back; frames go on afterwards as if it had not been drawn.
    /// What the last frame shows has to be [read](Progressive::read) before.
    ///
    /// # Errors
    /// If it cannot be drawn or read.
    pub fn truth(&mut self, request: &FrameRequest) -> Result<Picture, RenderError> {
        self.backend.resize([request.view.width, request.view.height])?;
        let plan = FramePlan {
            view: request.view,
            reproject: false,
            fresh: false,
            fill: [0..self.stored, 0..0],
            shading: request.shading,
            files: self.file_colors.clone(),
            aside: true,
        };
        self.backend.draw(&plan)?;
        let picture = self.backend.read()?;
        // Its times are none of a frame's: the budget must not learn from them.
        let _ = self.backend.pass_times();
        Ok(picture)
    }

    /// Draws all points stored, without regard to what was visible before.
    pub fn brute_force(&mut self, request: &FrameRequest) -> Result<FrameReport, RenderError> {
        self.insert_waiting(self.backend.insertions_per_frame() - self.undrawn)?;
        self.coverage = Coverage::default();
        self.unsettled = false;
        let fill = self.coverage.advance(self.stored, self.stored);
        self.draw(request, false, false, fill)?;
        Ok(self.report(true, self.stored))
    }

    /// Brings the last frame back.
    pub fn read(&mut self) -> Result<Picture, RenderError> {
        self.backend.read()
    }

    fn draw(
        &mut self,
        request: &FrameRequest,
        reproject: bool,
        fresh: bool,
        fill: [std::ops::Range<u32>; 2],
    ) -> Result<(), RenderError> {
        let files = self.file_colors.clone();
        // If the frame fails, nothing of it counts as tried or shown.
        self.last_view = None;
        let plan =
            FramePlan { view: request.view, reproject, fresh, fill, shading: request.shading, files, aside: false };
        self.backend.draw(&plan)?;
        self.undrawn = 0;
        self.last_view = Some(request.view);
        self.last_shading = Some(request.shading);
        Ok(())
    }

    fn report(&self, drawn: bool, fill: u32) -> FrameReport {
        FrameReport {
            drawn,
            points_stored: self.stored.into(),
            points_tried: self.coverage.tried().into(),
            settled: !self.unsettled,
            fill,
        }
    }

    /// Tries all points again, whatever was tried before.
    fn restart(&mut self) {
        self.coverage.restart();
        self.unsettled = false;
    }

    /// Inserts what waits, as far as one frame may. Once memory is full, nothing more is inserted and
    /// the points so far can still be drawn.
    fn insert_waiting(&mut self, limit: usize) -> Result<(), RenderError> {
        for _ in 0..limit {
            let count = self.stage();
            if count == 0 {
                break;
            }
            let StoreOptions { order, seed, .. } = self.options;
            let insertion = Insertion::in_order(order, self.stored, count, seed, self.insertions);
            if let Err(error) = self.backend.insert(&insertion, &self.staged) {
                self.memory_full |= matches!(error, RenderError::OutOfMemory { .. });
                return Err(error);
            }
            self.staged.clear();
            self.undrawn += 1;
            self.unsettled |= self.stored > 0;
            self.coverage.note_inserted(self.stored, count);
            self.stored += count;
            self.insertions += 1;
        }
        Ok(())
    }

    /// Moves points from the queue until they make an insertion; returns its size, 0 if there are not
    /// enough yet.
    fn stage(&mut self) -> u32 {
        if self.is_full() {
            return 0;
        }
        let room = self.options.max_points.min(MAX_POINTS) - u64::from(self.stored);
        let wanted = u64::from(self.options.insertion_points).min(room) as usize;
        while self.staged.len() < wanted
            && (self.insertions > 0 || self.staged.is_empty())
            && let Some(batch) = self.queue.front()
        {
            // Also if the batch will enter only in part: its points need a rule for their colours.
            if self.taken == 0 {
                let file = batch.file as usize;
                self.stats[file].merge(&batch.stats);
                self.file_colors[file] = FileColor::new(self.file_colors[file].first_record, self.stats[file].rule());
            }
            if self.taken == 0 && self.staged.is_empty() && batch.len() <= wanted {
                // A whole batch becomes the start of the insertion without a copy.
                if let Some(mut batch) = self.queue.pop_front() {
                    std::mem::swap(&mut self.staged, &mut batch);
                    self.spent.push(batch);
                }
                continue;
            }
            let end = batch.len().min(self.taken + wanted - self.staged.len());
            self.staged.positions.extend_from_slice(&batch.positions[self.taken..end]);
            self.staged.colors.extend_from_slice(&batch.colors[self.taken..end]);
            self.staged.records.extend_from_slice(&batch.records[self.taken..end]);
            self.taken = end;
            if end == batch.len()
                && let Some(batch) = self.queue.pop_front()
            {
                self.spent.push(batch);
                self.taken = 0;
            }
        }
        let complete =
            self.staged.len() == wanted || (self.input_ended && self.queue.is_empty()) || self.insertions == 0;
        if complete { self.staged.len() as u32 } else { 0 }
    }
}
