//! What a frame draws, page by page: the visible list, the fresh list, spans of slots.

use std::ops::Range;

use crate::{
    gpu::{
        kernel::{self, Binding, SPAN_STRIDE},
        timing::Stage,
    },
    store::gpu::{GpuStore, Page},
};

/// A run of slots, all in one page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Piece {
    /// Index of the page.
    pub page: usize,
    pub slots: Range<u32>,
}

/// Cuts ranges of slots at the borders of pages.
pub fn pieces<'p>(ranges: &[Range<u32>], pages: impl Iterator<Item = &'p Page> + Clone) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for range in ranges {
        for (index, page) in pages.clone().enumerate() {
            let slots = range.start.max(page.first)..range.end.min(page.first + page.len);
            if slots.start < slots.end {
                pieces.push(Piece { page: index, slots });
            }
        }
    }
    pieces
}

/// One of the three kinds of slots that a frame draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    Reproject,
    Fresh,
    Fill,
}

impl Source {
    pub fn stage(self) -> Stage {
        match self {
            Source::Reproject => Stage::Reproject,
            Source::Fresh => Stage::Fresh,
            Source::Fill => Stage::Fill,
        }
    }
}

/// Bind groups of the slot lists and spans of one frame.
pub struct Sources {
    pub list: Vec<Source>,
    pub pieces: Vec<Piece>,
    pub fresh_points: u32,
    pub bind_visible: wgpu::BindGroup,
    pub bind_fresh: wgpu::BindGroup,
}

/// Makes [`Sources`] for each frame.
pub struct SourceBinder {
    pub layout: wgpu::BindGroupLayout,
    spans: wgpu::Buffer,
}

impl SourceBinder {
    pub fn new(device: &wgpu::Device) -> SourceBinder {
        use Binding::{Read, Uniform, UniformAt};
        SourceBinder {
            layout: kernel::layout(device, "slots", wgpu::ShaderStages::COMPUTE, &[UniformAt, Read, Uniform]),
            spans: kernel::uniform(device, "spans", 8 * u64::from(SPAN_STRIDE)),
        }
    }

    /// Uploads the spans of a frame. `list` says what it draws.
    pub fn bind(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        store: &GpuStore,
        list: Vec<Source>,
        fill: &[Range<u32>],
    ) -> Sources {
        let pieces = pieces(fill, store.pages.iter());
        let mut words = vec![0u32; pieces.len().max(1) * SPAN_STRIDE as usize / 4];
        for (piece, span) in pieces.iter().zip(words.chunks_exact_mut(SPAN_STRIDE as usize / 4)) {
            span[0] = piece.slots.start;
            span[1] = piece.slots.end - piece.slots.start;
        }
        let bytes = bytemuck::cast_slice::<u32, u8>(&words);
        if self.spans.size() < bytes.len() as u64 {
            self.spans = kernel::uniform(device, "spans", bytes.len() as u64);
        }
        queue.write_buffer(&self.spans, 0, bytes);
        queue.write_buffer(&store.lists.fresh_count, 0, bytemuck::bytes_of(&store.fresh_points()));
        let bind = |list: &wgpu::Buffer, count: &wgpu::Buffer| {
            let span = wgpu::BufferBinding { buffer: &self.spans, offset: 0, size: wgpu::BufferSize::new(16) };
            let count = wgpu::BufferBinding { buffer: count, offset: 0, size: wgpu::BufferSize::new(16) };
            let [span, count] = [span, count].map(wgpu::BindingResource::Buffer);
            let resources = [span, list.as_entire_binding(), count];
            kernel::bind(device, "slots", &self.layout, &resources)
        };
        let lists = &store.lists;
        Sources {
            list,
            pieces,
            fresh_points: store.fresh_points(),
            bind_visible: bind(&lists.visible, &lists.visible_arguments),
            bind_fresh: bind(&lists.fresh, &lists.fresh_count),
        }
    }
}
