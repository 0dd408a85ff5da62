//! The compute rasterizers: `atomicMin` decides each pixel. With 64-bit atomics one pass writes depth
//! and slot at once; without, a pass for the depth and one for the slot. They differ in what a fill
//! does before the atomic operation; lists are short, and drawn alike by all.

use std::{collections::HashMap, sync::mpsc, thread};

use super::{
    sources::{Source, SourceBinder, Sources},
    targets::{TargetLayouts, WriteBinds},
};
use crate::{
    gpu::{
        kernel,
        shaders::{self, Shader},
        timing::FrameTimer,
    },
    render::{Candidate, Raster},
    store::{
        Encoding,
        gpu::{DISPATCH_ARGUMENTS, GpuStore},
    },
};

/// Points that a thread of `from_span` draws, as in `shaders/span.wgsl`.
const SPAN_POINTS: u32 = 4;

/// The modules of a method, in the order of their passes; none if it has no compute shaders.
pub fn modules(method: Raster) -> &'static [&'static Shader] {
    match method {
        Raster::EarlyZ => &[&shaders::EARLY_Z],
        Raster::AtomicMin => &[&shaders::ATOMIC_MIN],
        Raster::Reduce => &[&shaders::REDUCE],
        Raster::ReduceEarlyZ => &[&shaders::REDUCE_EARLY_Z],
        Raster::Dedup => &[&shaders::DEDUP],
        Raster::TwoPass32 => &[&shaders::DEPTH_32, &shaders::SLOT_32],
        Raster::Points | Raster::Cpu => &[],
    }
}

/// Whether a module looks at words before it writes them, `shaders/early.wgsl`.
fn is_early(module: &Shader) -> bool {
    ["EARLY_Z", "REDUCE_EARLY_Z"].contains(&module.name)
}

/// The module whose `from_list` serves a module: the one without subgroups that has the same `plot`.
fn of_lists(module: &'static Shader) -> &'static Shader {
    match module.name {
        "REDUCE" | "DEDUP" => &shaders::ATOMIC_MIN,
        "REDUCE_EARLY_Z" => &shaders::EARLY_Z,
        _ => module,
    }
}

/// How kernels read points: in which encoding, and whether a filter's bits are looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Reading {
    pub encoding: Encoding,
    pub masked: bool,
}

/// A module's name; of spans, the group size; how it reads points.
type Key = (&'static str, Option<u32>, Reading);

/// Pipelines, each made once: when it is first needed, or before on a thread of their own.
pub struct Kernels {
    /// Of words, of words for the early test, of positions, of slots.
    layouts: [wgpu::BindGroupLayout; 4],
    made: HashMap<Key, wgpu::ComputePipeline>,
    arriving: Option<mpsc::Receiver<(Key, wgpu::ComputePipeline)>>,
    maker: Option<thread::JoinHandle<()>>,
}

impl Drop for Kernels {
    /// The program must not end amid a driver's compiling.
    fn drop(&mut self) {
        self.stop_making();
    }
}

impl Kernels {
    pub fn new(layouts: &TargetLayouts, store: &GpuStore, binder: &SourceBinder) -> Kernels {
        let layouts = [
            layouts.write.clone(),
            layouts.write_early.clone(),
            store.pages.layout_positions.clone(),
            binder.layout.clone(),
        ];
        Kernels { layouts, made: HashMap::new(), arriving: None, maker: None }
    }

    /// Starts to make what these candidates need, in this order. A GPU's driver takes some 100 ms for each kernel
    /// (H200), which no frame should wait for.
    pub fn make_aside(&mut self, device: &wgpu::Device, candidates: Vec<Candidate>, reading: Reading) {
        self.stop_making();
        let (sender, receiver) = mpsc::channel();
        let mut own = Kernels { layouts: self.layouts.clone(), made: self.made.clone(), arriving: None, maker: None };
        let device = device.clone();
        let make = move || {
            for (shader, span_group) in candidates.into_iter().flat_map(needs) {
                let key = (shader.name, span_group, reading);
                let is_made = own.made.contains_key(&key);
                if !is_made && sender.send((key, own.make(&device, shader, span_group, reading))).is_err() {
                    return;
                }
            }
        };
        // Without a thread, they are made when they are needed.
        if let Ok(maker) = thread::Builder::new().name("kernels".into()).spawn(make) {
            self.arriving = Some(receiver);
            self.maker = Some(maker);
        }
    }

    /// Keeps what was made so far; waits for the kernel that is being compiled.
    fn stop_making(&mut self) {
        if let Some(arriving) = self.arriving.take() {
            self.made.extend(arriving.try_iter());
        }
        if let Some(maker) = self.maker.take() {
            // A panic of the compiler was told where it happened.
            let _ = maker.join();
        }
    }

    /// Whether a candidate's pipelines are there, or will never come from elsewhere.
    pub fn is_ready(&mut self, candidate: Candidate, reading: Reading) -> bool {
        loop {
            let is_made =
                |(shader, group): (&'static Shader, _)| self.made.contains_key(&(shader.name, group, reading));
            if needs(candidate).all(is_made) {
                return true;
            }
            let Some(arriving) = &self.arriving else { return true };
            match arriving.try_recv() {
                Ok((key, pipeline)) => {
                    self.made.insert(key, pipeline);
                }
                Err(mpsc::TryRecvError::Empty) => return false,
                Err(mpsc::TryRecvError::Disconnected) => self.arriving = None,
            }
        }
    }

    /// `span_group` is the group size of `from_span`; without, it is `from_list`.
    fn make(
        &mut self,
        device: &wgpu::Device,
        shader: &'static Shader,
        span_group: Option<u32>,
        reading: Reading,
    ) -> wgpu::ComputePipeline {
        if let Some(arriving) = &self.arriving {
            self.made.extend(arriving.try_iter());
        }
        let make = || {
            let [plain, early, positions, slots] = &self.layouts;
            let groups = [if is_early(shader) { early } else { plain }, positions, slots];
            let module = shader.module_in(device, reading.encoding);
            let has_mask = ("HAS_MASK", f64::from(u8::from(reading.masked)));
            match span_group {
                None => kernel::compute_with(device, &module, "from_list", &groups, &[has_mask]),
                Some(group) => {
                    let constants = [("SPAN_GROUP", f64::from(group)), has_mask];
                    kernel::compute_with(device, &module, "from_span", &groups, &constants)
                }
            }
        };
        self.made.entry((shader.name, span_group, reading)).or_insert_with(make).clone()
    }
}

fn group_size(candidate: Candidate) -> u32 {
    candidate.group_size.unwrap_or(kernel::GROUP)
}

/// The pipelines of a candidate.
fn needs(candidate: Candidate) -> impl Iterator<Item = (&'static Shader, Option<u32>)> {
    let of = move |&shader: &&'static Shader| [(of_lists(shader), None), (shader, Some(group_size(candidate)))];
    modules(candidate.method).iter().flat_map(of)
}

struct Plot {
    from_list: wgpu::ComputePipeline,
    from_span: wgpu::ComputePipeline,
}

/// Rasterizes with compute shaders.
pub struct ComputeRaster {
    /// One, or first depths and then slots.
    plots: Vec<Plot>,
    group_size: u32,
    is_early: bool,
}

impl ComputeRaster {
    /// The device must have what the method's modules need.
    pub fn new(device: &wgpu::Device, candidate: Candidate, kernels: &mut Kernels, reading: Reading) -> ComputeRaster {
        let group_size = group_size(candidate);
        let plot = |shader: &&'static Shader| Plot {
            from_list: kernels.make(device, of_lists(shader), None, reading),
            from_span: kernels.make(device, shader, Some(group_size), reading),
        };
        let modules = modules(candidate.method);
        let is_early = modules.iter().any(|module| is_early(module));
        ComputeRaster { plots: modules.iter().map(plot).collect(), group_size, is_early }
    }

    /// `binds_write` are of the words to draw to.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut FrameTimer,
        binds_write: &WriteBinds,
        store: &GpuStore,
        sources: &Sources,
    ) {
        for plot in &self.plots {
            for &source in &sources.list {
                let mut pass = timer.compute_pass(encoder, source.stage());
                pass.set_bind_group(0, if self.is_early { &binds_write.early } else { &binds_write.plain }, &[]);
                match source {
                    Source::Reproject | Source::Fresh => {
                        pass.set_pipeline(&plot.from_list);
                        for page in store.pages.iter() {
                            pass.set_bind_group(1, &page.bind_positions, &[]);
                            if source == Source::Reproject {
                                pass.set_bind_group(2, &sources.bind_visible, &[0]);
                                pass.dispatch_workgroups_indirect(&store.lists.visible_arguments, DISPATCH_ARGUMENTS);
                            } else {
                                pass.set_bind_group(2, &sources.bind_fresh, &[0]);
                                kernel::dispatch(&mut pass, sources.fresh_points);
                            }
                        }
                    }
                    Source::Fill => {
                        pass.set_pipeline(&plot.from_span);
                        for (piece, offset) in sources.pieces.iter().zip((0..).step_by(kernel::SPAN_STRIDE as usize)) {
                            pass.set_bind_group(1, &store.pages.at(piece.page).bind_positions, &[]);
                            pass.set_bind_group(2, &sources.bind_fresh, &[offset]);
                            let points = piece.slots.end - piece.slots.start;
                            kernel::dispatch_groups(&mut pass, points.div_ceil(SPAN_POINTS * self.group_size));
                        }
                    }
                }
            }
        }
    }
}
