//! The cloud on the device, in pages within its limits.

use std::{ops::Range, thread};

use wgpu::BufferUsages;

use super::{Arranged, Cloud, Encoding, MethodError, Packing, parallel::part_len};
use crate::{
    device::RenderError,
    gpu::{
        device,
        kernel::{self, Binding},
    },
    store::gpu::PageUniform,
};

/// Points uploaded at once: 128 MiB in the wide encoding. Large enough for many threads, small enough that two
/// pieces on their way need little memory.
const UPLOAD_POINTS: usize = 1 << 23;

pub struct Page {
    /// Slot of the first point.
    first: u32,
    pub len: u32,
    points: wgpu::Buffer,
    colors: wgpu::Buffer,
    pub bind: wgpu::BindGroup,
}

/// Some points of a page, bound as if they were a page.
pub struct Part {
    pub len: u32,
    pub bind: wgpu::BindGroup,
}

/// A part begins at a multiple of so many points: then its bindings begin at multiples of 256 bytes, the
/// largest alignment that WebGPU allows a device to ask for.
pub const PART_STRIDE: u32 = 64;

/// All pages.
pub struct Pages {
    pub layout: wgpu::BindGroupLayout,
    pub pages: Vec<Page>,
    pub points: u32,
    /// Lowest and highest corner of the cloud.
    pub extent: [[i32; 3]; 2],
    /// Of the packed encoding.
    pub packing: Option<Packing>,
}

impl Pages {
    /// Uploads a cloud. `page_points` is for tests; without it pages are as large as the device allows.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        arranged: Arranged<'_>,
        encoding: Encoding,
        page_points: Option<u32>,
    ) -> Result<Pages, MethodError> {
        let (positions, colors) = (arranged.cloud.positions.len(), arranged.cloud.colors.len());
        if positions != colors {
            return Err(MethodError::Unequal { positions, colors });
        }
        let slots = arranged.len();
        // The last number means that there is no point.
        let points = u32::try_from(slots).ok().filter(|&n| n < u32::MAX).ok_or(MethodError::TooMany(slots))?;
        let extent = arranged.extent();
        let packing = match encoding {
            Encoding::Wide => None,
            Encoding::Packed => Some(Packing::of(extent)?),
        };
        use Binding::{Read, Uniform};
        let bindings: &[Binding] = if packing.is_some() { &[Uniform, Read, Read] } else { &[Uniform, Read] };
        let stages = wgpu::ShaderStages::COMPUTE | wgpu::ShaderStages::VERTEX;
        let limits = device.limits();
        let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let most = (bytes / encoding.bytes()).min(1 << 30) as usize;
        let page_points = page_points.map_or(most, |n| (n as usize).clamp(1, most));
        let layout = kernel::layout(device, "points", stages, bindings);
        let mut pages = Pages { layout, pages: Vec::new(), points, extent, packing };
        // A cloud without points has a page nevertheless, for there to be something to bind.
        for first in (0..slots.max(1)).step_by(page_points) {
            let len = page_points.min(slots - first);
            let page = pages.page(device, queue, arranged, encoding, first..first + len)?;
            pages.pages.push(page);
        }
        Ok(pages)
    }

    fn page(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        arranged: Arranged<'_>,
        encoding: Encoding,
        range: Range<usize>,
    ) -> Result<Page, MethodError> {
        let len = range.len() as u32;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let column = |label, bytes: u64| kernel::buffer(device, label, u64::from(len.max(1)) * bytes, usage);
        let [points, colors] = kernel::in_memory(device, || {
            [column("points", encoding.bytes()), column("colours", if self.packing.is_some() { 4 } else { 0 })]
        })
        .map_err(|detail| RenderError::OutOfMemory { stored: range.start as u64, detail })?;
        let Cloud { positions, colors: rgba } = arranged.cloud;
        let mut upload = Upload { device, queue, last: None };
        for start in range.clone().step_by(UPLOAD_POINTS) {
            let piece = start..range.end.min(start + UPLOAD_POINTS);
            let at = (start - range.start) as u64;
            match &self.packing {
                None => upload.write(&points, at, piece, |slot| {
                    let point = arranged.point(slot);
                    let [x, y, z] = positions[point].map(|axis| axis as u32);
                    bytemuck::cast::<[u32; 4], [u8; 16]>([x, y, z, rgba[point]])
                })?,
                Some(packing) => {
                    upload.write(&points, at, piece.clone(), |slot| {
                        let word = packing.pack(positions[arranged.point(slot)]);
                        bytemuck::cast::<[u32; 2], [u8; 8]>([word as u32, (word >> 32) as u32])
                    })?;
                    upload.write(&colors, at, piece, |slot| rgba[arranged.point(slot)].to_ne_bytes())?;
                }
            }
        }
        device::wait(device)?;
        let first = range.start as u32;
        let uniform = self.uniform(device, queue, first, len);
        let all = [&uniform, &points, &colors];
        let used = if self.packing.is_some() { 3 } else { 2 };
        let bind = kernel::bind_buffers(device, "points", &self.layout, &all[..used]);
        Ok(Page { first, len, points, colors, bind })
    }

    fn uniform(&self, device: &wgpu::Device, queue: &wgpu::Queue, first: u32, len: u32) -> wgpu::Buffer {
        let page = PageUniform::new(self.packing, first, len);
        let uniform = kernel::uniform(device, "page", size_of::<PageUniform>() as u64);
        queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&page));
        uniform
    }

    /// Up to `len` points of a page from its point `start` on, which is a multiple of [`PART_STRIDE`].
    pub fn part(&self, device: &wgpu::Device, queue: &wgpu::Queue, page: &Page, start: u32, len: u32) -> Part {
        let len = len.min(page.len - start);
        let uniform = self.uniform(device, queue, page.first + start, len);
        let bytes = if self.packing.is_some() { Encoding::Packed.bytes() } else { Encoding::Wide.bytes() };
        let range = |buffer, bytes: u64| {
            wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset: u64::from(start) * bytes,
                size: wgpu::BufferSize::new(u64::from(len) * bytes),
            })
        };
        let all = [uniform.as_entire_binding(), range(&page.points, bytes), range(&page.colors, 4)];
        let used = if self.packing.is_some() { 3 } else { 2 };
        Part { len, bind: kernel::bind(device, "part of a page", &self.layout, &all[..used]) }
    }
}

/// Writes points straight into the memory that the device copies from, by all threads.
struct Upload<'a> {
    device: &'a wgpu::Device,
    queue: &'a wgpu::Queue,
    last: Option<wgpu::SubmissionIndex>,
}

impl Upload<'_> {
    /// `bytes` of each slot of `piece`, from item `at` of the buffer on. One piece is written while the
    /// one before is copied; more are not on their way.
    fn write<const N: usize>(
        &mut self,
        buffer: &wgpu::Buffer,
        at: u64,
        piece: Range<usize>,
        bytes: impl Fn(usize) -> [u8; N] + Sync,
    ) -> Result<(), RenderError> {
        let part = part_len(piece.len());
        let parts: Vec<Range<usize>> =
            piece.clone().step_by(part).map(|first| first..piece.end.min(first + part)).collect();
        // Each thread has its own view: wgpu 30's views are `Send`, slices of them are not.
        let views = parts.iter().map(|slots| {
            let size = wgpu::BufferSize::new((slots.len() * N) as u64)?;
            self.queue.write_buffer_with(buffer, (at + (slots.start - piece.start) as u64) * N as u64, size)
        });
        let views: Option<Vec<_>> = views.collect();
        let views = views.ok_or_else(|| RenderError::DeviceLost("no memory for an upload".into()))?;
        thread::scope(|scope| {
            for (mut view, slots) in views.into_iter().zip(parts) {
                let bytes = &bytes;
                scope.spawn(move || view.slice(..).into_chunks::<N>().0.write_iter(slots.map(bytes)));
            }
        });
        let index = self.queue.submit([]);
        if let Some(before) = self.last.replace(index) {
            device::wait_for(self.device, before)?;
        }
        Ok(())
    }
}
