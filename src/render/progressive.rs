//! Progressive rendering, the same for every backend: batches in, frames out.

use std::{collections::VecDeque, sync::Arc, time::Instant};

use super::{
    averages::Averages,
    backend::{Averaging, Backend, FramePlan, Picture, Shading},
    budget::{BudgetController, FillBudget},
    color::PointColors,
    coloring::Coloring,
    frame::{FrameReport, FrameRequest, MAX_POINTS, Reprojection, StoreOptions},
    pick::{MAX_REACH, Pick, PickAt, PickTicket},
    selection::Selection,
    values::Values,
    view::View,
};
use crate::{
    device::{PassTimes, Passes, Raster, RenderError},
    scene::{ColorStats, PointBatch, SceneFacts},
    store::{Coverage, Insertion, MAX_INSERTION_POINTS, Packing},
};

/// A scene that grows while it is drawn.
pub struct Progressive<B> {
    pub(super) backend: B,
    options: StoreOptions,
    reprojection: Reprojection,
    pub(super) scene: Option<Arc<SceneFacts>>,
    pub(super) stats: Vec<ColorStats>,
    pub(super) coloring: Coloring,
    pub(super) values: Values,
    /// What comes of `coloring`, `stats` and `values`, unless these have changed since.
    pub(super) colors: Arc<PointColors>,
    pub(super) colors_are_stale: bool,
    pub(super) selection: Selection,
    /// Batches not yet (wholly) staged; of the first, `taken` points are.
    queue: VecDeque<PointBatch>,
    taken: usize,
    spent: Vec<PointBatch>,
    staged: PointBatch,
    input_ended: bool,
    insertions: u64,
    pub(super) stored: u32,
    coverage: Coverage,
    /// Points moved to other slots after the points tried had been compared by them. Among points of
    /// equal depth in a pixel (duplicates, level ground from above) the lowest slot wins; if the
    /// winner moves behind one that lost, only trying the loser again puts the picture right.
    unsettled: bool,
    averages: Averages,
    /// Insertions that no frame has drawn as fresh yet.
    undrawn: usize,
    memory_full: bool,
    budget: BudgetController,
    last_times: Option<PassTimes>,
    last_passes: Passes,
    /// Time on the host that the last frame's insertions took.
    insert_secs: f64,
    last_view: Option<View>,
    last_method: Option<Raster>,
    last_shading: Option<Shading>,
    last_colors: Option<Arc<PointColors>>,
    /// The words of the last frame are those of a picture aside.
    words_are_gone: bool,
    /// The words of the last frame, whose points are still in the slots that they name.
    words_stand: bool,
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
            coloring: Coloring::default(),
            values: Values::default(),
            colors: Arc::new(Vec::new().into()),
            colors_are_stale: false,
            selection: Selection::default(),
            queue: VecDeque::new(),
            taken: 0,
            spent: Vec::new(),
            staged: PointBatch::default(),
            input_ended: false,
            insertions: 0,
            stored: 0,
            coverage: Coverage::default(),
            unsettled: false,
            averages: Averages::default(),
            undrawn: 0,
            memory_full: false,
            budget: BudgetController::default(),
            last_times: None,
            last_passes: Passes::default(),
            insert_secs: 0.0,
            last_view: None,
            last_method: None,
            last_shading: None,
            last_colors: None,
            words_are_gone: false,
            words_stand: false,
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
        let packing = Packing::of_scene(&scene.grid, &scene.bounds).ok();
        self.backend.reset(scene.points_in_header().min(self.options.max_points), packing);
        self.stats = vec![ColorStats::default(); scene.files.len()];
        self.values = Values::new(scene.clone());
        self.colors_are_stale = true;
        self.scene = Some(scene);
        self.spent.extend(self.queue.drain(..));
        self.taken = 0;
        self.staged.clear();
        self.input_ended = false;
        self.insertions = 0;
        self.stored = 0;
        self.coverage = Coverage::default();
        self.unsettled = false;
        self.averages = Averages::default();
        self.undrawn = 0;
        self.memory_full = false;
        self.last_view = None;
        self.selection.is_stale = true;
        self.words_stand = false;
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

    /// Points that a frame of the last one's kind may try.
    pub fn fill_points(&self, budget: FillBudget) -> u32 {
        self.budget.points(budget, self.last_passes)
    }

    /// False while high-quality shading waits until nothing changes, since otherwise frames would take longer
    /// than the target.
    pub fn averages_in_motion(&self, budget: FillBudget) -> bool {
        self.budget.averages_in_motion(budget)
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
        // Methods may round differently: a picture is of one.
        let method_changed = self.last_method.replace(self.backend.info().method) != Some(self.backend.info().method);
        if view_changed || method_changed {
            self.restart();
        }
        if let Some(times) = self.backend.pass_times() {
            if let FillBudget::Target(secs) = request.fill {
                self.budget.learn(&times, self.insert_secs, secs);
            }
            self.last_times = Some(times);
        }
        // Before points fill the memory.
        self.words_stand &= self.last_view.is_some_and(|view| view.has_size_of(&request.view));
        self.backend.resize([request.view.width, request.view.height])?;
        let start = Instant::now();
        let limit = self.backend.insertions_per_frame() - self.undrawn;
        // The first picture does not wait for more.
        let limit = if self.insertions == 0 { limit.min(1) } else { limit };
        self.insert_waiting(self.budget.insertions(request.fill, limit))?;
        self.insert_secs = start.elapsed().as_secs_f64();
        if let Some(refusal) = self.values.take_refusal() {
            self.selection.is_stale = true;
            return Err(refusal);
        }
        if self.is_loaded() {
            self.values.end_carrying();
        }
        self.refresh_colors();
        self.refresh_mask();
        if self.unsettled && self.is_loaded() {
            self.restart();
        }
        if self.reprojection == Reprojection::Never && self.stored > 0 && self.coverage.is_complete(self.stored) {
            self.restart();
        }
        let has_all_depths = !view_changed && self.undrawn == 0 && self.coverage.is_complete(self.stored);
        let is_high = request.shading.high_quality && self.can_average();
        let has_all = has_all_depths && (!is_high || self.averages.are_complete(self.stored, &self.colors));
        let is_last = self.last_shading == Some(request.shading) && self.last_colors.as_ref() == Some(&self.colors);
        if has_all && is_last {
            return Ok(self.report(request, false, 0));
        }
        let plan = if has_all_depths && is_high { self.plan_averages(request) } else { self.plan_depths(request) };
        self.draw(&plan)?;
        Ok(self.report(request, true, plan.fill_points()))
    }

    /// Draws all points stored, without regard to what was visible before.
    pub fn brute_force(&mut self, request: &FrameRequest) -> Result<FrameReport, RenderError> {
        self.insert_waiting(self.backend.insertions_per_frame() - self.undrawn)?;
        self.refresh_colors();
        self.refresh_mask();
        self.coverage = Coverage::default();
        self.unsettled = false;
        self.averages = Averages::default();
        let fill = self.coverage.advance(self.stored, self.stored);
        let sums = request.shading.high_quality && self.can_average();
        let averaging = sums.then(|| self.averages.go_on(self.stored, self.stored, &self.colors));
        let plan = FramePlan { fill, averaging, reproject: false, fresh: false, ..self.empty_plan(request) };
        self.draw(&plan)?;
        Ok(self.report(request, true, self.stored))
    }

    /// The picture of all points stored without high-quality shading, brought back; frames go on afterwards as if
    /// it had not been drawn. What the last frame shows has to be [read](Progressive::read) before.
    ///
    /// # Errors
    /// If it cannot be drawn or read.
    pub fn truth(&mut self, request: &FrameRequest) -> Result<Picture, RenderError> {
        self.backend.resize([request.view.width, request.view.height])?;
        let fill = [0..self.stored, 0..0];
        let plan = FramePlan { aside: true, reproject: false, fresh: false, fill, ..self.empty_plan(request) };
        self.words_are_gone = true;
        self.words_stand = false;
        self.backend.draw(&plan)?;
        let picture = self.backend.read()?;
        // Its times are none of a frame's: the budget must not learn from them.
        let _ = self.backend.pass_times();
        Ok(picture)
    }

    /// The depths are final: what is left of high-quality shading.
    fn plan_averages(&mut self, request: &FrameRequest) -> FramePlan {
        let budget = self.budget.points(request.fill, Passes::Sums);
        let averaging = self.averages.go_on(self.stored, budget, &self.colors);
        // What was visible gives the same words again.
        FramePlan { keeps_depths: !self.words_are_gone, averaging: Some(averaging), ..self.empty_plan(request) }
    }

    /// Depths of what was visible, is new, or was not tried yet; with high-quality shading, if there is
    /// time for it, also the averages of these points.
    fn plan_depths(&mut self, request: &FrameRequest) -> FramePlan {
        let high = request.shading.high_quality && self.can_average();
        let averages = high && self.budget.averages_in_motion(request.fill);
        let passes = if averages { Passes::DepthsAndSums } else { Passes::Depths };
        let budget = self.budget.points(request.fill, passes);
        let fill = self.coverage.advance(self.stored, budget);
        self.averages.invalidate();
        let averaging = averages.then(|| match self.coverage.is_complete(self.stored) {
            false => Averaging { begins: true, lists: true, slots: fill.clone() },
            // The depths are final after this frame's first pass, unless points keep arriving; then the
            // fill has nothing to try, and the averages go round on their own.
            true if self.undrawn == 0 => self.averages.go_on(self.stored, budget, &self.colors),
            true => self.averages.sample(self.stored, budget),
        });
        FramePlan { fill, averaging, ..self.empty_plan(request) }
    }

    fn empty_plan(&self, request: &FrameRequest) -> FramePlan {
        FramePlan {
            view: request.view,
            keeps_depths: false,
            reproject: match self.reprojection {
                Reprojection::Always => true,
                Reprojection::WhileStill => self.last_view == Some(request.view),
                Reprojection::Never => false,
            },
            fresh: true,
            fill: Default::default(),
            shading: request.shading,
            colors: self.colors.clone(),
            averaging: None,
            mask: self.selection.mask.clone(),
            aside: false,
        }
    }

    /// Asks which point the last frame shows at a pixel or near it. `None` if there is no such pixel, no frame whose
    /// points are still where it has seen them, or a kernel for it still to be compiled: ask again after the next frame.
    pub fn pick(&mut self, at: PickAt) -> Option<PickTicket> {
        let at = PickAt { reach: at.reach.min(MAX_REACH), ..at };
        if self.words_stand { self.backend.pick(at) } else { None }
    }

    /// The answer to a question, once it is there: on a GPU some milliseconds later, but never waited for. None of a
    /// point where only background is near, or where eight younger questions were asked.
    pub fn picked(&mut self, ticket: PickTicket) -> Option<Option<Pick>> {
        self.backend.picked(ticket)
    }

    /// Brings the last frame back.
    pub fn read(&mut self) -> Result<Picture, RenderError> {
        self.backend.read()
    }

    fn draw(&mut self, plan: &FramePlan) -> Result<(), RenderError> {
        // If the frame fails, nothing of it counts as tried or shown.
        self.last_view = None;
        self.words_stand = false;
        self.backend.draw(plan)?;
        self.words_stand = true;
        self.undrawn = 0;
        self.last_view = Some(plan.view);
        self.last_shading = Some(plan.shading);
        self.last_colors = Some(plan.colors.clone());
        self.last_passes = plan.passes();
        self.words_are_gone = false;
        Ok(())
    }

    fn report(&self, request: &FrameRequest, drawn: bool, fill: u32) -> FrameReport {
        FrameReport {
            drawn,
            points_stored: self.stored.into(),
            points_tried: self.coverage.tried().into(),
            settled: !self.unsettled,
            fill,
            high_quality: request.shading.high_quality && self.can_average(),
            points_averaged: self.averages.points(),
        }
    }

    /// Tries all points again, whatever was tried before.
    pub(super) fn restart(&mut self) {
        self.coverage.restart();
        self.unsettled = false;
        self.averages.invalidate();
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
            let mut inserted = self.backend.insert(&insertion, &self.staged);
            if matches!(inserted, Err(RenderError::OutOfMemory { .. }))
                && self.values.give_way(&mut self.backend, &self.coloring)
            {
                inserted = self.backend.insert(&insertion, &self.staged);
            }
            if let Err(error) = inserted {
                self.memory_full |= matches!(error, RenderError::OutOfMemory { .. });
                return Err(error);
            }
            self.staged.clear();
            self.words_stand = false;
            self.undrawn += 1;
            self.unsettled |= self.stored > 0;
            self.coverage.note_inserted(self.stored, count);
            self.averages.invalidate();
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
                self.stats[batch.file as usize].merge(&batch.stats);
                self.values.take_points(batch, &mut self.backend, &self.coloring);
                self.colors_are_stale = true;
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
