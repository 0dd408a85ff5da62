//! The bits that say which points a filter hides: made anew when the filter changes, in one go, and while points
//! arrive for the slots that insertions touched.
//!
//! A frame with another filter takes longer for that. It is not spread over frames: the picture would show points of
//! the old filter beside those of the new one.

use std::sync::{Arc, Mutex};

use wgpu::BufferUsages;

use super::{
    columns::Columns,
    sources::{Source, SourceBinder, Sources},
};
use crate::{
    gpu::{
        kernel::{self, Binding},
        shaders,
    },
    render::{ColumnId, MaskRules, Test},
    store::gpu::GpuStore,
};

/// The passes of `shaders/mask.wgsl` and `shaders/mask_column.wgsl`. Made when the first filter is set.
pub struct Mask {
    by_slots: Pipelines,
    /// By small keys and by wide ones.
    by_columns: [Pipelines; 2],
    count: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    binder: SourceBinder,
    /// What the pages' bits were made with.
    rules: Option<Arc<MaskRules>>,
    bind_slots: Option<wgpu::BindGroup>,
    /// A column, whether its keys are wide, and its test.
    bind_columns: Vec<(ColumnId, bool, wgpu::BindGroup)>,
    /// Slots whose bits are right, from the first on.
    known: u32,
    hidden: Hidden,
}

struct Pipelines {
    from_span: wgpu::ComputePipeline,
    from_list: wgpu::ComputePipeline,
}

/// How many points are hidden, on its way from the device.
struct Hidden {
    count: wgpu::Buffer,
    readback: wgpu::Buffer,
    /// What the device said of the readback under way, and the points that were stored.
    arriving: Option<(Arc<Mutex<Option<bool>>>, u32)>,
    /// Points that `count` is of, if that was not asked for yet.
    counted: Option<u32>,
    shown: Option<u64>,
}

impl Mask {
    pub fn new(device: &wgpu::Device, store: &GpuStore, columns: &Columns) -> Mask {
        let slots = shaders::MASK.module_in(device, store.pages.encoding());
        let keys = shaders::MASK_COLUMN.module(device);
        let layout = kernel::layout(device, "rules", wgpu::ShaderStages::COMPUTE, &[Binding::Read, Binding::ReadWrite]);
        let binder = SourceBinder::new(device);
        let groups = [&layout, &store.pages.layout_mask, &binder.layout, &columns.layout_read];
        let by_slots = |entry| kernel::compute(device, &slots, entry, &groups[..3]);
        let by_columns = |is_wide: bool| {
            let constants = [("IS_WIDE", f64::from(u8::from(is_wide)))];
            let pipeline = |entry| kernel::compute_with(device, &keys, entry, &groups, &constants);
            Pipelines { from_span: pipeline("from_span"), from_list: pipeline("from_list") }
        };
        Mask {
            by_slots: Pipelines { from_span: by_slots("from_span"), from_list: by_slots("from_list") },
            by_columns: [false, true].map(by_columns),
            count: by_slots("count"),
            rules: None,
            bind_slots: None,
            bind_columns: Vec::new(),
            known: 0,
            hidden: Hidden::new(device),
            layout,
            binder,
        }
    }

    /// Nothing is known of any slot any more.
    pub fn forget(&mut self) {
        self.rules = None;
        self.known = 0;
        self.hidden.counted = None;
        self.hidden.shown = None;
    }

    /// Records what brings the bits of the first `stored` slots up to date, after the frame's insertions.
    #[allow(clippy::too_many_arguments, reason = "a pass names all that it reads and writes")]
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        pass: &mut wgpu::ComputePass<'_>,
        store: &GpuStore,
        columns: &Columns,
        rules: &Arc<MaskRules>,
        stored: u32,
    ) {
        if self.rules.as_ref() != Some(rules) {
            self.set_rules(device, queue, rules.clone());
        }
        // What is known moves with its points: into the tail, or out of the way of new ones.
        let fresh = if self.known > 0 { store.fresh_points() } else { 0 };
        let Some(bind_slots) = self.bind_slots.as_ref().filter(|_| self.known != stored || fresh > 0) else { return };
        let sources = self.binder.bind(device, queue, store, vec![Source::Fresh], &[self.known..stored, 0..0]);
        pass.set_bind_group(0, bind_slots, &[]);
        self.by_slots.record(pass, store, &sources, fresh);
        // Each hides more.
        for (column, is_wide, bind) in &self.bind_columns {
            pass.set_bind_group(0, bind, &[]);
            for keys in columns.whole(*column) {
                pass.set_bind_group(3, &keys, &[]);
                self.by_columns[usize::from(*is_wide)].record(pass, store, &sources, fresh);
            }
        }
        pass.set_pipeline(&self.count);
        queue.write_buffer(&self.hidden.count, 0, &[0; 4]);
        for page in store.pages.iter() {
            pass.set_bind_group(1, page.bind_mask.as_ref(), &[]);
            kernel::dispatch(pass, page.len.div_ceil(32));
        }
        self.known = stored;
        self.hidden.counted = Some(stored);
    }

    fn set_rules(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, rules: Arc<MaskRules>) {
        let bind = |tests: &[&Test]| {
            let words = MaskRules::words(tests);
            let bytes: &[u8] = bytemuck::cast_slice(&words);
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
            let buffer = kernel::buffer(device, "rules", bytes.len() as u64, usage);
            queue.write_buffer(&buffer, 0, bytes);
            kernel::bind_buffers(device, "rules", &self.layout, &[&buffer, &self.hidden.count])
        };
        self.bind_slots = Some(bind(&rules.of_slots()));
        self.bind_columns =
            rules.of_columns().map(|(column, is_wide, test)| (column, is_wide, bind(&[test]))).collect();
        self.rules = Some(rules);
        self.known = 0;
    }

    /// Points that are shown, as far as the device has told.
    pub fn points_shown(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Option<u64> {
        self.hidden.take(device, queue);
        self.hidden.shown
    }
}

impl Pipelines {
    /// The `fresh` slots of the list, then the ranges.
    fn record(&self, pass: &mut wgpu::ComputePass<'_>, store: &GpuStore, sources: &Sources, fresh: u32) {
        pass.set_pipeline(&self.from_list);
        pass.set_bind_group(2, &sources.bind_fresh, &[0]);
        for page in store.pages.iter().filter(|_| fresh > 0) {
            pass.set_bind_group(1, page.bind_mask.as_ref(), &[]);
            kernel::dispatch(pass, fresh);
        }
        pass.set_pipeline(&self.from_span);
        for (piece, offset) in sources.pieces.iter().zip((0..).step_by(kernel::SPAN_STRIDE as usize)) {
            let page = store.pages.at(piece.page);
            pass.set_bind_group(1, page.bind_mask.as_ref(), &[]);
            pass.set_bind_group(2, &sources.bind_fresh, &[offset]);
            // And those before the range in its first word.
            kernel::dispatch(pass, piece.slots.end - piece.slots.start + (piece.slots.start - page.first) % 32);
        }
    }
}

impl Hidden {
    fn new(device: &wgpu::Device) -> Hidden {
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let mapped = BufferUsages::COPY_DST | BufferUsages::MAP_READ;
        Hidden {
            count: kernel::buffer(device, "hidden points", 4, storage),
            readback: kernel::buffer(device, "hidden points readback", 4, mapped),
            arriving: None,
            counted: None,
            shown: None,
        }
    }

    /// Takes in what has arrived, and asks for what was counted since.
    fn take(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) {
        // An error here is a lost device, which the next frame reports.
        let _ = device.poll(wgpu::PollType::Poll);
        let arrived = self.arriving.as_ref().and_then(|(told, _)| told.lock().ok().and_then(|mut told| told.take()));
        if let Some(is_mapped) = arrived
            && let Some((_, stored)) = self.arriving.take()
            && is_mapped
        {
            if let Ok(bytes) = self.readback.get_mapped_range(..) {
                let hidden: &[u32] = bytemuck::cast_slice(&bytes);
                self.shown = hidden.first().map(|&hidden| u64::from(stored.saturating_sub(hidden)));
            }
            self.readback.unmap();
        }
        if self.arriving.is_none()
            && let Some(stored) = self.counted.take()
        {
            let mut encoder = device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(&self.count, 0, &self.readback, 0, None);
            queue.submit([encoder.finish()]);
            let told = Arc::new(Mutex::new(None));
            self.arriving = Some((told.clone(), stored));
            self.readback.map_async(wgpu::MapMode::Read, .., move |result| {
                if let Ok(mut told) = told.lock() {
                    *told = Some(result.is_ok());
                }
            });
        }
    }
}
