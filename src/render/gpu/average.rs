//! High-quality shading (Schütz and Wimmer 2019, 2021): a second pass over the points sums up, for each
//! pixel, the colours of all fragments within 1 % behind its front; the resolve pass divides.

use wgpu::BufferUsages;

use super::{
    color::ColorTables,
    sources::{Source, SourceBinder},
    targets::Targets,
};
use crate::{
    gpu::{
        kernel::{self, Binding},
        shaders,
        timing::{FrameTimer, Stage},
    },
    render::{Averaging, RenderError, Sums},
    store::gpu::{DISPATCH_ARGUMENTS, GpuStore, Pages},
};

/// The averaging passes. Made when first asked for.
pub struct Average {
    pub sums: Sums,
    /// Adds only what a filter shows.
    pub masked: bool,
    from_list: wgpu::ComputePipeline,
    from_span: wgpu::ComputePipeline,
    color: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    binder: SourceBinder,
    /// The ranges of slots that a frame adds.
    slots: wgpu::Buffer,
    buffer: Option<Buffer>,
}

/// The sums of a picture's pixels.
struct Buffer {
    size: [u32; 2],
    words: wgpu::Buffer,
}

/// Bytes of a pixel's sums.
fn bytes(sums: Sums) -> u64 {
    match sums {
        Sums::Hqs1r => 24,
        Sums::Hqs => 16,
    }
}

/// The sums that a device can hold for so many pixels: in 64-bit words where it has all their atomics
/// and room for them.
pub fn sums_for(device: &wgpu::Device, pixels: u64) -> Sums {
    let has_atomics = device.features().contains(shaders::INT64_ATOMICS);
    if has_atomics && pixels * bytes(Sums::Hqs1r) <= binding_limit(device) { Sums::Hqs1r } else { Sums::Hqs }
}

fn binding_limit(device: &wgpu::Device) -> u64 {
    let limits = device.limits();
    limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
}

impl Average {
    /// `layout_colors` is that of the resolve pass's outputs.
    pub fn new(
        device: &wgpu::Device,
        sums: Sums,
        masked: bool,
        pages: &Pages,
        tables: &ColorTables,
        layout_colors: &wgpu::BindGroupLayout,
    ) -> Average {
        use Binding::{Read, ReadWrite, Uniform};
        let (average, resolve) = match sums {
            Sums::Hqs1r => (shaders::AVERAGE_64, shaders::RESOLVE_64),
            Sums::Hqs => (shaders::AVERAGE_32, shaders::RESOLVE_32),
        };
        let encoding = pages.encoding();
        let (average, resolve) = (average.module_in(device, encoding), resolve.module_in(device, encoding));
        let layout = kernel::layout(device, "sums", wgpu::ShaderStages::COMPUTE, &[Uniform, Read, ReadWrite, Uniform]);
        let binder = SourceBinder::new(device);
        let adding = |entry| {
            let groups = [&layout, &pages.layout_average, &binder.layout, &tables.layout];
            kernel::compute_with(device, &average, entry, &groups, &[("HAS_MASK", f64::from(u8::from(masked)))])
        };
        let groups = [&layout, &pages.layout_resolve, layout_colors, &tables.layout];
        Average {
            sums,
            masked,
            from_list: adding("from_list"),
            from_span: adding("from_span"),
            color: kernel::compute(device, &resolve, "color_average", &groups),
            slots: kernel::uniform(device, "averaged slots", 16),
            buffer: None,
            binder,
            layout,
        }
    }

    /// Makes room for the sums of a picture; those of another size are dropped.
    ///
    /// # Errors
    /// If the device or its memory has no room for so many.
    pub fn resize(&mut self, device: &wgpu::Device, size: [u32; 2]) -> Result<(), RenderError> {
        if self.buffer.as_ref().is_some_and(|buffer| buffer.size == size) {
            return Ok(());
        }
        self.buffer = None;
        let [width, height] = size;
        let needed = u64::from(width) * u64::from(height) * bytes(self.sums);
        if needed > binding_limit(device) {
            let detail = "more than it can bind".into();
            return Err(RenderError::NoMemoryForSums { width, height, detail });
        }
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let words = kernel::in_memory(device, || kernel::buffer(device, "sums", needed, usage))
            .map_err(|detail| RenderError::NoMemoryForSums { width, height, detail })?;
        self.buffer = Some(Buffer { size, words });
        Ok(())
    }

    /// Frees the sums; the pipelines stay, for a GPU takes 100 ms to compile one.
    pub fn free(&mut self) {
        self.buffer = None;
    }

    /// Adds what `averaging` says to the sums; returns their bind group for [`Average::resolve`].
    /// `lists` are drawn where `averaging` takes them.
    #[allow(clippy::too_many_arguments, reason = "a pass names all that it reads and writes")]
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut FrameTimer,
        (targets, view, tables): (&Targets, &wgpu::Buffer, &ColorTables),
        store: &GpuStore,
        lists: Vec<Source>,
        averaging: &Averaging,
    ) -> Option<wgpu::BindGroup> {
        let words = &self.buffer.as_ref()?.words;
        let [a, b] = &averaging.slots;
        queue.write_buffer(&self.slots, 0, bytemuck::cast_slice(&[a.start, a.end, b.start, b.end]));
        let sources = self.binder.bind(device, queue, store, lists, &averaging.slots);
        let bind = kernel::bind_buffers(device, "sums", &self.layout, &[view, &targets.words, words, &self.slots]);
        if averaging.begins {
            encoder.clear_buffer(words, 0, None);
        }
        for &source in sources.list.iter().filter(|_| averaging.lists) {
            let mut pass = timer.compute_pass(encoder, Stage::Average);
            pass.set_pipeline(&self.from_list);
            pass.set_bind_group(0, &bind, &[]);
            pass.set_bind_group(3, &tables.bind, &[]);
            for page in store.pages.iter() {
                pass.set_bind_group(1, &page.bind_average, &[]);
                if source == Source::Reproject {
                    pass.set_bind_group(2, &sources.bind_visible, &[0]);
                    pass.dispatch_workgroups_indirect(&store.lists.visible_arguments, DISPATCH_ARGUMENTS);
                } else {
                    pass.set_bind_group(2, &sources.bind_fresh, &[0]);
                    kernel::dispatch(&mut pass, sources.fresh_points);
                }
            }
        }
        let mut pass = timer.compute_pass(encoder, Stage::AverageFill);
        pass.set_pipeline(&self.from_span);
        pass.set_bind_group(0, &bind, &[]);
        pass.set_bind_group(3, &tables.bind, &[]);
        for (piece, offset) in sources.pieces.iter().zip((0..).step_by(kernel::SPAN_STRIDE as usize)) {
            pass.set_bind_group(1, &store.pages.at(piece.page).bind_average, &[]);
            pass.set_bind_group(2, &sources.bind_fresh, &[offset]);
            kernel::dispatch(&mut pass, piece.slots.end - piece.slots.start);
        }
        drop(pass);
        Some(bind)
    }

    /// The pipeline that colours pixels by their averages, in the place of resolve's `color`.
    pub fn resolve(&self) -> &wgpu::ComputePipeline {
        &self.color
    }

    /// Red, green, blue and fragments of each pixel, without the front point; waits for the device.
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<[u64; 4]>, RenderError> {
        let Some(buffer) = &self.buffer else { return Ok(Vec::new()) };
        let words = kernel::read_words(device, queue, &buffer.words)?;
        Ok(match self.sums {
            Sums::Hqs => words.chunks_exact(4).map(|sum| [0, 1, 2, 3].map(|at| u64::from(sum[at]))).collect(),
            Sums::Hqs1r => words.chunks_exact(6).map(unpacked).collect(),
        })
    }
}

/// As `sums_of` in `shaders/sums_64.wgsl`.
fn unpacked(words: &[u32]) -> [u64; 4] {
    let first = u64::from(words[1]) << 32 | u64::from(words[0]);
    let count = first & 0x3f_ffff;
    if count < 64 {
        [first >> 50, first >> 36 & 0x3fff, first >> 22 & 0x3fff, count]
    } else {
        [2, 3, 4, 5].map(|at| u64::from(words[at]))
    }
}
