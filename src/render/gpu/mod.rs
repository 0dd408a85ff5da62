//! The GPU backend: wgpu on Vulkan, Metal or DX12. [`GpuBackend::record`] is a frame, pass by pass.

mod average;
mod choose;
mod color;
mod columns;
mod compute;
mod hardware;
mod index;
mod mask;
mod measure;
mod pick;
mod probe;
mod resolve;
mod sources;
mod targets;

use self::{
    average::Average,
    columns::Columns,
    compute::{ComputeRaster, Kernels},
    hardware::HardwareRaster,
    index::IndexBuild,
    mask::Mask,
    measure::Chooser,
    pick::Picker,
    resolve::{ColorSource, Resolve},
    sources::{Source, SourceBinder, Sources},
    targets::{TargetLayouts, Targets},
};
pub use self::{color::ColorTablesUniform, columns::ColumnScaleUniform, pick::PickWords, resolve::ShadingUniform};
use super::{
    Averaging, Backend, BackendInfo, Candidate, ColumnId, FramePlan, Keys, Measured, PassTimes, Pick, PickAt,
    PickTicket, Picture, RasterChoice, RenderError, Sums, View,
};
use crate::{
    gpu::{
        device, kernel, shaders,
        timing::{FrameTimer, Stage, Work},
    },
    scene::PointBatch,
    store::{
        Encoding, Insertion, Packing,
        gpu::{GpuStore, INSERTIONS_PER_FRAME},
    },
};

enum Rasterizer {
    Compute(ComputeRaster),
    Hardware(HardwareRaster),
}

/// Stores points and draws frames on a GPU.
pub struct GpuBackend {
    info: BackendInfo,
    device: wgpu::Device,
    queue: wgpu::Queue,
    store: GpuStore,
    /// Of scenes to come, where it fits.
    encoding: Encoding,
    view: wgpu::Buffer,
    layouts: TargetLayouts,
    targets: Option<Targets>,
    clear: wgpu::ComputePipeline,
    binder: SourceBinder,
    rasterizer: Rasterizer,
    /// The rasterizer draws only what a filter shows.
    masked: bool,
    /// Once a filter was set.
    mask: Option<Mask>,
    stored: u32,
    chooser: Chooser,
    index: IndexBuild,
    resolve: Resolve,
    /// For high-quality shading, once it was asked for.
    average: Option<Average>,
    picker: Picker,
    columns: Columns,
    timer: FrameTimer,
    lost: std::sync::Arc<std::sync::Mutex<Option<String>>>,
}

impl GpuBackend {
    /// Features and limits to ask of an adapter.
    pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
        device::descriptor(adapter)
    }

    /// A backend on the best adapter at hand, without a window.
    pub fn headless(choice: RasterChoice) -> Result<GpuBackend, RenderError> {
        let (adapter, device, queue) = device::headless()?;
        GpuBackend::on_device(&adapter, device, queue, choice)
    }

    /// A backend on a device made with [`GpuBackend::device_descriptor`].
    pub fn on_device(
        adapter: &wgpu::Adapter,
        device: wgpu::Device,
        queue: wgpu::Queue,
        choice: RasterChoice,
    ) -> Result<GpuBackend, RenderError> {
        choose::backend(adapter, device, queue, choice)
    }

    /// A backend that begins with a candidate that the device can run.
    fn with_candidate(
        adapter: &wgpu::AdapterInfo,
        device: wgpu::Device,
        queue: wgpu::Queue,
        candidate: Candidate,
        choice: RasterChoice,
        candidates: (Vec<Candidate>, Vec<Measured>),
    ) -> GpuBackend {
        let store = GpuStore::new(&device, &queue);
        let layouts = TargetLayouts::new(&device);
        let binder = SourceBinder::new(&device);
        let kernels = Kernels::new(&layouts, &store, &binder);
        let mut chooser = Chooser::new(kernels, adapter.device_type, choice, candidates);
        let rasterizer = chooser.rasterizer(&device, &store, candidate, false);
        let resolve = Resolve::new(&device, &layouts, &store.pages);
        let lost = std::sync::Arc::<std::sync::Mutex<Option<String>>>::default();
        let loss = lost.clone();
        device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed
                && let Ok(mut loss) = loss.lock()
            {
                *loss = Some(message);
            }
        });
        GpuBackend {
            info: BackendInfo {
                adapter: adapter.name.clone(),
                api: adapter.backend.to_str().to_owned(),
                driver: format!("{} {}", adapter.driver, adapter.driver_info).trim().to_owned(),
                method: candidate.method,
                encoding: Encoding::default(),
                choice: Some(chooser.first_choice(candidate)),
            },
            view: kernel::uniform(&device, "view", size_of::<View>() as u64),
            targets: None,
            clear: kernel::compute(&device, &shaders::CLEAR.module(&device), "clear", &[&layouts.write]),
            binder,
            rasterizer,
            masked: false,
            mask: None,
            stored: 0,
            chooser,
            index: IndexBuild::new(&device, &layouts),
            columns: Columns::new(&device, &queue, &layouts, &resolve.layout_colors),
            resolve,
            average: None,
            picker: Picker::new(&device),
            timer: FrameTimer::new(&device, &queue, adapter.device_type),
            store,
            encoding: Encoding::default(),
            layouts,
            device,
            queue,
            lost,
        }
    }

    /// The picture of the last frame: one u32 per pixel (red in the lowest byte, then green, blue,
    /// alpha), row by row from the top; and its width and height. The buffer is another one after
    /// the size of the picture changed.
    pub fn picture_buffer(&self) -> Option<(&wgpu::Buffer, [u32; 2])> {
        self.targets.as_ref().map(|targets| (&targets.picture, targets.size))
    }

    /// Makes anew what reads positions, if the store holds them in another encoding than at the last frame.
    fn follow_encoding(&mut self) -> Result<(), RenderError> {
        let encoding = self.store.pages.encoding();
        if self.info.encoding == encoding {
            return Ok(());
        }
        self.chooser.set_encoding(encoding);
        self.resolve.set_encoding(&self.device, &self.layouts, &self.store.pages);
        // Its sums are those of a scene that is gone, or that has grown since.
        self.average = None;
        // It is made anew for the next frame with a filter.
        self.mask = None;
        self.take_rasterizer(self.masked)?;
        // Last: if memory has no room for the rasterizer's targets, the next frame tries again.
        self.info.encoding = encoding;
        Ok(())
    }

    /// Makes the rasterizer of the candidate chosen, for the store's encoding. `masked`: it looks at a filter's bits.
    fn take_rasterizer(&mut self, masked: bool) -> Result<(), RenderError> {
        let candidate = self.current();
        let mut rasterizer = self.chooser.rasterizer(&self.device, &self.store, candidate, masked);
        if let (Rasterizer::Hardware(raster), Some(targets)) = (&mut rasterizer, &self.targets) {
            let [width, height] = targets.size;
            raster
                .resize(&self.device, &self.view, &targets.words, targets.size)
                .map_err(|detail| RenderError::NoMemoryForPicture { width, height, detail })?;
        }
        self.rasterizer = rasterizer;
        self.masked = masked;
        Ok(())
    }

    /// The store, for measuring with other settings than a viewer's.
    pub fn store_mut(&mut self) -> &mut GpuStore {
        &mut self.store
    }

    /// The columns of values, for tests with other settings than a viewer's.
    pub fn columns_mut(&mut self) -> &mut Columns {
        &mut self.columns
    }

    /// One frame. Every pass in order; all state that flows from one to the next is in the arguments.
    fn record(&mut self, encoder: &mut wgpu::CommandEncoder, targets: &Targets, sources: &Sources, plan: &FramePlan) {
        self.columns.record_fill(encoder);
        if self.store.pending_insertions() > 0 {
            self.store.record(&mut self.timer.compute_pass(encoder, Stage::Insert));
        }
        if let (Some(mask), Some(rules)) = (&mut self.mask, &plan.mask) {
            let mut pass = self.timer.compute_pass(encoder, Stage::Insert);
            mask.record(&self.device, &self.queue, &mut pass, &self.store, &self.columns, rules, self.stored);
        }
        if !plan.keeps_depths {
            self.record_clear(encoder, targets);
            match &self.rasterizer {
                Rasterizer::Compute(raster) => {
                    raster.record(encoder, &mut self.timer, &targets.binds_write, &self.store, sources);
                }
                Rasterizer::Hardware(raster) => {
                    let instances = plan.view.point_size.pow(2);
                    raster.record(encoder, &mut self.timer, targets.size, &self.store, sources, instances);
                }
            }
        }
        // Before the index build, which replaces the list of what was visible.
        let bind_sums = self.record_average(encoder, targets, plan);
        if !plan.keeps_depths && !plan.aside {
            self.index.record(&self.device, encoder, &mut self.timer, targets, &self.store.lists);
        }
        let by = match (&plan.colors.column, &self.average, &bind_sums) {
            (Some(colors), ..) => ColorSource::Column(&self.columns, colors),
            (None, Some(average), Some(sums)) => ColorSource::Averages(average.resolve(), sums),
            _ => ColorSource::Files,
        };
        self.resolve.record(&self.device, encoder, &mut self.timer, targets, &self.store.pages, by);
    }

    /// The second pass of high-quality shading, if the frame has one; the bind group of its sums.
    fn record_average(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &Targets,
        plan: &FramePlan,
    ) -> Option<wgpu::BindGroup> {
        let (average, averaging) = (self.average.as_mut()?, plan.averaging.as_ref()?);
        let lists = [(Source::Reproject, plan.reproject), (Source::Fresh, plan.fresh)];
        let lists = lists.into_iter().filter_map(|(source, drawn)| drawn.then_some(source)).collect();
        let read = (targets, &self.view, &self.resolve.tables);
        average.record(&self.device, &self.queue, encoder, &mut self.timer, read, &self.store, lists, averaging)
    }

    /// Makes what high-quality shading needs, and drops it when it is switched off.
    fn prepare_average(&mut self, plan: &FramePlan) -> Result<(), RenderError> {
        if let Some(average) = self.average.as_mut().filter(|_| !plan.shading.high_quality && !plan.aside) {
            average.free();
        }
        if plan.averaging.is_none() {
            return Ok(());
        }
        let size = [plan.view.width, plan.view.height];
        let sums = average::sums_for(&self.device, u64::from(size[0]) * u64::from(size[1]));
        let average = match self.average.take() {
            Some(average) if average.sums == sums && average.masked == self.masked => average,
            _ => {
                let layout_colors = &self.resolve.layout_colors;
                Average::new(&self.device, sums, self.masked, &self.store.pages, &self.resolve.tables, layout_colors)
            }
        };
        self.average.insert(average).resize(&self.device, size)
    }

    /// Gives the pages bits for a filter, or takes them away, and takes the rasterizer that looks at them, or not.
    fn prepare_mask(&mut self, plan: &FramePlan) -> Result<(), RenderError> {
        let on = plan.mask.is_some();
        if on != self.store.pages.is_masked() {
            let points = self.stored.into();
            let full = |detail| RenderError::NoMemoryForFilter { points, detail };
            self.store.pages.set_masked(&self.device, on).map_err(full)?;
            self.mask.as_mut().map(Mask::forget);
        }
        if on && self.mask.is_none() {
            self.mask = Some(Mask::new(&self.device, &self.store, &self.columns));
        }
        if on != self.masked {
            self.take_rasterizer(on)?;
        }
        Ok(())
    }

    /// Which slots a filter hides, in order; empty without a filter. For tests; waits for the device.
    pub fn read_hidden(&self) -> Result<Vec<bool>, RenderError> {
        let mut hidden = Vec::new();
        for page in self.store.pages.iter().filter(|_| self.masked) {
            let words = kernel::read_words(&self.device, &self.queue, &page.hidden)?;
            hidden.extend((0..page.len).map(|slot| words[slot as usize / 32] >> (slot % 32) & 1 == 1));
        }
        hidden.truncate(self.stored as usize);
        Ok(hidden)
    }

    /// The sums of high-quality shading in the last frame that had any: red, green, blue and fragments of
    /// each pixel, without its front point. For tests; waits for the device.
    pub fn read_sums(&self) -> Result<Vec<[u64; 4]>, RenderError> {
        self.average.as_ref().map_or(Ok(Vec::new()), |average| average.read(&self.device, &self.queue))
    }

    /// Counts as a part of reprojecting, as on the CPU backend.
    fn record_clear(&mut self, encoder: &mut wgpu::CommandEncoder, targets: &Targets) {
        let mut pass = self.timer.compute_pass(encoder, Stage::Reproject);
        pass.set_pipeline(&self.clear);
        pass.set_bind_group(0, &targets.binds_write.plain, &[]);
        kernel::dispatch(&mut pass, targets.pixels());
    }

    fn check_device(&self) -> Result<(), RenderError> {
        match self.lost.lock().ok().and_then(|lost| lost.clone()) {
            Some(message) => Err(RenderError::DeviceLost(message)),
            None => Ok(()),
        }
    }
}

impl Backend for GpuBackend {
    fn info(&self) -> &BackendInfo {
        &self.info
    }

    fn sums(&self) -> Sums {
        let pixels = self.targets.as_ref().map_or(0, Targets::pixels);
        average::sums_for(&self.device, pixels.into())
    }

    fn set_encoding(&mut self, encoding: Option<Encoding>) {
        self.encoding = encoding.unwrap_or_default();
    }

    fn reset(&mut self, points: u64, packing: Option<Packing>) {
        self.store.reset(points, packing.filter(|_| self.encoding == Encoding::Packed));
        self.stored = 0;
        self.mask.as_mut().map(Mask::forget);
        self.chooser.reset(points);
        self.columns.reset(points);
    }

    fn insertions_per_frame(&self) -> usize {
        INSERTIONS_PER_FRAME
    }

    fn insert(&mut self, insertion: &Insertion, points: &PointBatch) -> Result<(), RenderError> {
        self.check_device()?;
        self.store.upload(insertion, points)?;
        self.stored = insertion.old + insertion.new;
        self.chooser.stored = self.stored;
        Ok(())
    }

    fn resize(&mut self, size: [u32; 2]) -> Result<(), RenderError> {
        if self.targets.as_ref().is_some_and(|targets| targets.size == size) {
            return Ok(());
        }
        self.check_device()?;
        let targets = Targets::new(&self.device, &self.layouts, &self.view, size)?;
        let [width, height] = size;
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let lists = &mut self.store.lists;
        lists
            .resize_visible(&self.device, &mut encoder, targets.pixels())
            .map_err(|detail| RenderError::NoMemoryForPicture { width, height, detail })?;
        self.queue.submit([encoder.finish()]);
        if let Rasterizer::Hardware(raster) = &mut self.rasterizer {
            raster
                .resize(&self.device, &self.view, &targets.words, size)
                .map_err(|detail| RenderError::NoMemoryForPicture { width, height, detail })?;
        }
        self.targets = Some(targets);
        Ok(())
    }

    fn fill_column(&mut self, column: ColumnId, records: &[u32], keys: Keys<'_>) -> Result<(), RenderError> {
        self.check_device()?;
        self.columns.stage(column, records, keys)
    }

    fn drop_column(&mut self, column: ColumnId) {
        self.columns.drop_column(column);
    }

    fn set_relocation(&mut self, on: bool) {
        self.store.set_relocation(on);
    }

    fn draw(&mut self, plan: &FramePlan) -> Result<(), RenderError> {
        self.check_device()?;
        self.resize([plan.view.width, plan.view.height])?;
        self.follow_encoding()?;
        self.prepare_mask(plan)?;
        self.prepare_average(plan)?;
        let Some(targets) = self.targets.take() else { unreachable!("just made") };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        self.store.lists.drop_forgotten(&mut encoder);
        self.timer.begin();
        self.queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&plan.view));
        // The second argument of the indirect draw: the pixels of a point.
        let instances = plan.view.point_size.pow(2);
        self.queue.write_buffer(&self.store.lists.visible_arguments, 4, bytemuck::bytes_of(&instances));
        if self.resolve.prepare(&self.device, &self.queue, plan)
            && let Some(colors) = &plan.colors.column
        {
            self.columns.prepare(colors);
        }
        let list = [(Source::Reproject, plan.reproject), (Source::Fresh, plan.fresh), (Source::Fill, true)];
        let list = list.into_iter().filter_map(|(source, drawn)| drawn.then_some(source)).collect();
        let sources = self.binder.bind(&self.device, &self.queue, &self.store, list, &plan.fill);
        let work = Work {
            fill_points: plan.fill_points(),
            insertions: self.store.pending_insertions(),
            average_points: plan.averaging.as_ref().map_or(0, Averaging::points),
            passes: plan.passes(),
        };
        self.record(&mut encoder, &targets, &sources, plan);
        self.timer.end(&mut encoder, work);
        self.queue.submit([encoder.finish()]);
        self.timer.submitted(&self.device, &self.queue, work);
        if !plan.aside {
            self.store.forget_fresh();
        }
        self.targets = Some(targets);
        self.check_device()?;
        if plan.aside { Ok(()) } else { self.measure_between_frames(plan.view) }
    }

    fn pass_times(&mut self) -> Option<PassTimes> {
        // An error here is a lost device, which the next frame reports.
        let _ = self.device.poll(wgpu::PollType::Poll);
        self.timer.take()
    }

    fn points_shown(&mut self) -> Option<u64> {
        let mask = self.mask.as_mut().filter(|_| self.masked)?;
        mask.points_shown(&self.device, &self.queue)
    }

    fn choose(&mut self) -> Result<(), RenderError> {
        self.measure_all()
    }

    fn pick(&mut self, at: PickAt) -> Option<PickTicket> {
        let targets = self.targets.as_ref().filter(|targets| (0..2).all(|a| at.pixel[a] < targets.size[a]))?;
        self.picker.ask(&self.device, &self.queue, targets, &self.store.pages, at)
    }

    fn picked(&mut self, ticket: PickTicket) -> Option<Option<Pick>> {
        // An error here is a lost device, which the next frame reports.
        let _ = self.device.poll(wgpu::PollType::Poll);
        self.picker.answer(ticket)
    }

    fn wait(&mut self) -> Result<(), RenderError> {
        self.picker.wait();
        device::wait(&self.device)?;
        self.check_device()
    }

    fn read(&mut self) -> Result<Picture, RenderError> {
        self.follow_encoding()?;
        let Some(targets) = &self.targets else {
            return Ok(Picture { width: 0, height: 0, rgba: vec![], records: vec![], depth: vec![] });
        };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        self.resolve.record_identify(&self.device, &mut encoder, targets, &self.store.pages);
        targets.read(&self.device, &self.queue, encoder)
    }
}
