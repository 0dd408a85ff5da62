//! Draws and times methods on a cloud that is on the device.

use super::{
    Arranged, Cloud, Drawn, Encoding, FrameTime, Gpu, Launch, Method, MethodError, NO_POINT, depth40,
    hardware::Textures,
    modules::{self, Kernel},
    pages::Pages,
    pipelines::Pipelines,
    plan::{Identify, Plan, Resolve, Rule, Step},
    targets::Targets,
    timing::{self, Queries},
};
use crate::{gpu::kernel, render::View};

/// A cloud on a device, and a picture's worth of targets.
pub struct Runner {
    pub(crate) gpu: Gpu,
    encoding: Encoding,
    pub(super) pages: Pages,
    pub(super) targets: Targets,
    pub(super) pipelines: Pipelines,
}

impl Runner {
    /// Uploads the cloud, for pictures of `size` pixels.
    ///
    /// # Errors
    /// A cloud that does not fit the encoding, or 32-bit numbers, or the device's memory; a picture
    /// without pixels or with too many.
    pub fn new<'a>(
        gpu: &Gpu,
        cloud: impl Into<Arranged<'a>>,
        encoding: Encoding,
        size: [u32; 2],
    ) -> Result<Runner, MethodError> {
        Runner::with_pages(gpu, cloud, encoding, size, None)
    }

    /// As [`Runner::new`], with at most `page_points` points in a page.
    ///
    /// # Errors
    /// As [`Runner::new`].
    pub fn with_pages<'a>(
        gpu: &Gpu,
        cloud: impl Into<Arranged<'a>>,
        encoding: Encoding,
        size: [u32; 2],
        page_points: Option<u32>,
    ) -> Result<Runner, MethodError> {
        let pages = Pages::new(&gpu.device, &gpu.queue, cloud.into(), encoding, page_points)?;
        Ok(Runner {
            targets: Targets::new(&gpu.device, size)?,
            pipelines: Pipelines::new(pages.packing, gpu.is_software()),
            pages,
            gpu: gpu.clone(),
            encoding,
        })
    }

    /// Another cloud, or the same in another order, with the pipelines and targets that are there. The old cloud's
    /// memory is free before the new one's is taken.
    ///
    /// # Errors
    /// As [`Runner::new`]; there is no cloud then.
    pub fn load<'a>(&mut self, cloud: impl Into<Arranged<'a>>) -> Result<(), MethodError> {
        self.unload()?;
        self.pages = Pages::new(&self.gpu.device, &self.gpu.queue, cloud.into(), self.encoding, None)?;
        if self.pipelines.set_packing(self.pages.packing) {
            self.targets.textures = None;
        }
        Ok(())
    }

    /// Frees the cloud's memory; what is drawn then is empty.
    ///
    /// # Errors
    /// A lost device.
    pub fn unload(&mut self) -> Result<(), MethodError> {
        let nothing = Cloud::default();
        self.pages = Pages::new(&self.gpu.device, &self.gpu.queue, (&nothing).into(), self.encoding, None)?;
        Ok(())
    }

    /// Points of the cloud.
    pub fn points(&self) -> u64 {
        self.pages.points.into()
    }

    /// Bytes that a pass over all points must read of each.
    pub fn bytes_per_point(&self) -> u64 {
        self.encoding.bytes()
    }

    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Turns of the busy loop before a point gives up; 4,096 unless told, 2²⁰ on a software rasterizer, where
    /// a thread that holds a lock may be off its core.
    pub fn set_spins(&mut self, spins: u32) {
        self.pipelines.set_spins(spins);
    }

    /// How the kernels that draw points are launched; [`Launch::tuned`] unless told.
    pub fn set_launch(&mut self, launch: Launch) {
        self.pipelines.set_launch(launch);
        // They have the hardware's pipeline, and its module the launch.
        self.targets.textures = None;
    }

    /// Whether the device can run a method.
    ///
    /// # Errors
    /// A sentence that names the device and what is missing.
    pub fn supports(&self, method: &Method) -> Result<(), String> {
        self.gpu.supports(method)
    }

    /// Draws a frame and reads it back.
    ///
    /// # Errors
    /// A method that the device cannot run, a view of another size, a lost device.
    pub fn draw(&mut self, method: &Method, view: &View) -> Result<Drawn, MethodError> {
        self.prepare(method, view)?;
        self.gpu.queue.write_buffer(&self.targets.counters, 0, &[0; 8]);
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.record(&mut encoder, method.plan, None);
        self.read_back(encoder, method)
    }

    /// Runs the encoder's commands, finds out which points are shown, and reads the picture back.
    pub(super) fn read_back(&self, mut encoder: wgpu::CommandEncoder, method: &Method) -> Result<Drawn, MethodError> {
        self.record_identify(&mut encoder, method.plan);
        let targets = &self.targets;
        let buffers = [&targets.words, &targets.accumulators, &targets.rgba, &targets.counters];
        let [words, shown, rgba, counters] = kernel::read_all(&self.gpu.device, &self.gpu.queue, encoder, buffers)?;
        let words: &[[u32; 2]] = bytemuck::cast_slice(&words);
        let pixel = |(index, &[low, high]): (usize, &[u32; 2])| match method.plan.rule {
            Rule::Depth40 { .. } if [low, high] == [u32::MAX; 2] => (NO_POINT, f32::INFINITY),
            Rule::Depth40 { is_ranged } => {
                let code = u64::from(high) << 8 | u64::from(low >> 24);
                (shown[2 * index], depth40::depth(code, is_ranged))
            }
            _ if low == NO_POINT => (NO_POINT, f32::INFINITY),
            _ => (low, f32::from_bits(high)),
        };
        let (point, depth) = words.iter().enumerate().map(pixel).unzip();
        Ok(Drawn {
            size: targets.size,
            point,
            depth,
            rgba: rgba.iter().map(|color| color.to_le_bytes()).collect(),
            give_ups: counters[0].into(),
        })
    }

    /// Times frames of a method, one after the other; the first are not left out.
    ///
    /// # Errors
    /// As [`Runner::draw`].
    pub fn time(&mut self, method: &Method, view: &View, frames: u32) -> Result<Vec<FrameTime>, MethodError> {
        self.prepare(method, view)?;
        let passes = 2 + method.plan.geometry.len() as u32;
        Ok(timing::time(&self.gpu, frames, passes, |encoder, queries| self.record(encoder, method.plan, queries))?)
    }

    /// Makes the pipelines of a method and uploads the view.
    pub(super) fn prepare(&mut self, method: &Method, view: &View) -> Result<(), MethodError> {
        self.supports(method).map_err(MethodError::Unsupported)?;
        self.targets.set_view(&self.gpu.queue, view)?;
        let [low, high] = self.pages.extent;
        self.pipelines.is_near = view.is_near(low, high);
        let plan = method.plan;
        if matches!(plan.resolve, Resolve::Textures) && self.targets.textures.is_none() {
            let textures = Textures::new(&self.gpu.device, &self.targets, &self.pages, &self.pipelines);
            self.targets.textures = Some(textures);
        }
        let mut kernels: Vec<&'static Kernel> = vec![&modules::CLEAR_WORDS, &modules::CLEAR_SUMS];
        kernels.extend(method.kernels());
        kernels.push(match plan.resolve {
            Resolve::Targets(kernel) => kernel,
            Resolve::Points | Resolve::Textures => &modules::POINT_COLOR,
        });
        kernels.extend(identify_kernels(plan));
        let (targets, pages) = (&self.targets, &self.pages);
        for kernel in kernels {
            self.pipelines.make(&self.gpu.device, kernel, &[&targets.layout, &pages.layout]);
        }
        if let (Resolve::Textures, Some(textures)) = (&plan.resolve, &targets.textures) {
            let groups = [&targets.layout, &pages.layout, &textures.layout];
            self.pipelines.make(&self.gpu.device, &modules::COLLECT, &groups);
        }
        Ok(())
    }

    /// One frame: clear, geometry, resolve, a pass each.
    fn record(&self, encoder: &mut wgpu::CommandEncoder, plan: &Plan, mut queries: Option<&mut Queries>) {
        self.record_clear(encoder, plan, queries.as_deref_mut());
        for step in plan.geometry {
            let pages = self.pages.pages.iter().map(|page| (&page.bind, page.len));
            self.record_step(encoder, step, pages, true, queries.as_deref_mut());
        }
        self.record_resolve(encoder, plan, queries);
    }

    pub(super) fn record_clear(&self, encoder: &mut wgpu::CommandEncoder, plan: &Plan, queries: Option<&mut Queries>) {
        let mut pass = self.pass(encoder, queries);
        self.over_pixels(&mut pass, &modules::CLEAR_WORDS);
        if plan.has_sums {
            self.over_pixels(&mut pass, &modules::CLEAR_SUMS);
        }
    }

    /// A geometry pass over these pages, or parts of pages; `is_first` if no part came before.
    pub(super) fn record_step<'p>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        step: &Step,
        parts: impl Iterator<Item = (&'p wgpu::BindGroup, u32)>,
        is_first: bool,
        queries: Option<&mut Queries>,
    ) {
        match step {
            Step::Points(kernel) => {
                let mut pass = self.pass(encoder, queries);
                self.over_parts(&mut pass, kernel, parts);
            }
            Step::Draw => {
                if let Some(textures) = &self.targets.textures {
                    textures.draw(encoder, &self.targets, parts, is_first, queries.map(Queries::render));
                }
            }
        }
    }

    pub(super) fn record_resolve(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        plan: &Plan,
        queries: Option<&mut Queries>,
    ) {
        let mut pass = self.pass(encoder, queries);
        match (&plan.resolve, &self.targets.textures) {
            (Resolve::Targets(kernel), _) => self.over_pixels(&mut pass, kernel),
            (Resolve::Textures, Some(textures)) => {
                pass.set_bind_group(2, &textures.bind, &[]);
                self.over_pixels(&mut pass, &modules::COLLECT);
                self.per_page(&mut pass, &modules::POINT_COLOR);
            }
            (Resolve::Points | Resolve::Textures, _) => self.per_page(&mut pass, &modules::POINT_COLOR),
        }
    }

    fn record_identify(&self, encoder: &mut wgpu::CommandEncoder, plan: &Plan) {
        let mut pass = self.pass(encoder, None);
        for kernel in identify_kernels(plan) {
            match plan.identify {
                Identify::Depth => self.per_page(&mut pass, kernel),
                _ if kernel.name == modules::CLEAR_SHOWN.name => self.over_pixels(&mut pass, kernel),
                _ => self.over_points(&mut pass, kernel),
            }
        }
    }

    pub(super) fn pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        queries: Option<&mut Queries>,
    ) -> wgpu::ComputePass<'e> {
        let timestamp_writes = queries.map(Queries::compute);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
        pass.set_bind_group(0, &self.targets.bind, &[]);
        if let Some(page) = self.pages.pages.first() {
            pass.set_bind_group(1, &page.bind, &[]);
        }
        pass
    }

    /// A thread for each pixel, once.
    fn over_pixels(&self, pass: &mut wgpu::ComputePass<'_>, kernel: &Kernel) {
        let Some(pipeline) = self.pipelines.get(kernel) else { return };
        pass.set_pipeline(pipeline);
        kernel::dispatch(pass, self.targets.pixels());
    }

    /// A thread for each pixel, for each page.
    fn per_page(&self, pass: &mut wgpu::ComputePass<'_>, kernel: &Kernel) {
        for page in &self.pages.pages {
            pass.set_bind_group(1, &page.bind, &[]);
            self.over_pixels(pass, kernel);
        }
    }

    /// A thread for each point.
    pub(super) fn over_points(&self, pass: &mut wgpu::ComputePass<'_>, kernel: &Kernel) {
        self.over_parts(pass, kernel, self.pages.pages.iter().map(|page| (&page.bind, page.len)));
    }

    fn over_parts<'p>(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        kernel: &Kernel,
        parts: impl Iterator<Item = (&'p wgpu::BindGroup, u32)>,
    ) {
        let Some(pipeline) = self.pipelines.get(kernel) else { return };
        pass.set_pipeline(pipeline);
        for (bind, len) in parts {
            pass.set_bind_group(1, bind, &[]);
            kernel::dispatch_groups(pass, kernel.groups(len, self.pipelines.launch));
        }
    }
}

/// Kernels that find the point and the depth of each pixel after a frame.
fn identify_kernels(plan: &Plan) -> Vec<&'static Kernel> {
    match plan.identify {
        Identify::Word => vec![],
        Identify::Depth => vec![&modules::DEPTH_OF_POINT],
        Identify::FrontPoint => vec![&modules::SLOT_32],
        Identify::WordPoint(kernel) => vec![&modules::CLEAR_SHOWN, kernel],
    }
}
