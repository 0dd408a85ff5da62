//! The cloud on the device, in pages within its limits.

use wgpu::BufferUsages;

use super::{Cloud, Encoding, MethodError, Packing};
use crate::{
    device::RenderError,
    gpu::{
        device,
        kernel::{self, Binding},
    },
};

/// Points uploaded at once: 16 MiB in the wide encoding, so that what is on its way needs little memory.
const UPLOAD_POINTS: usize = 1 << 20;

/// What a kernel knows of a page. Layout shared with `shaders/methods/page.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PageUniform {
    pub base: [i32; 3],
    pub first: u32,
    pub len: u32,
    pub unused_a: u32,
    pub unused_b: u32,
    pub unused_c: u32,
}

pub struct Page {
    pub len: u32,
    pub points: wgpu::Buffer,
    pub bind: wgpu::BindGroup,
}

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
        cloud: &Cloud,
        encoding: Encoding,
        page_points: Option<u32>,
    ) -> Result<Pages, MethodError> {
        let (positions, colors) = (cloud.positions.len(), cloud.colors.len());
        if positions != colors {
            return Err(MethodError::Unequal { positions, colors });
        }
        // The last number means that there is no point.
        let points = u32::try_from(positions).ok().filter(|&n| n < u32::MAX).ok_or(MethodError::TooMany(positions))?;
        let extent = cloud.extent();
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
        for first in (0..positions.max(1)).step_by(page_points) {
            let len = page_points.min(positions - first);
            let page = pages.page(device, queue, cloud, encoding, first..first + len)?;
            pages.pages.push(page);
        }
        Ok(pages)
    }

    fn page(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        cloud: &Cloud,
        encoding: Encoding,
        range: std::ops::Range<usize>,
    ) -> Result<Page, MethodError> {
        let len = range.len() as u32;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let column = |label, bytes: u64| kernel::buffer(device, label, u64::from(len.max(1)) * bytes, usage);
        let [uniform, points, colors] = kernel::in_memory(device, || {
            [
                kernel::uniform(device, "page", size_of::<PageUniform>() as u64),
                column("points", encoding.bytes()),
                column("colours", if self.packing.is_some() { 4 } else { 0 }),
            ]
        })
        .map_err(|detail| RenderError::OutOfMemory { stored: range.start as u64, detail })?;
        let base = self.packing.map_or([0; 3], |packing| packing.base);
        let page = PageUniform { base, first: range.start as u32, len, unused_a: 0, unused_b: 0, unused_c: 0 };
        queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&page));
        for start in range.clone().step_by(UPLOAD_POINTS) {
            let piece = start..range.end.min(start + UPLOAD_POINTS);
            let at = (start - range.start) as u64;
            let (point_words, color_words) = cloud.words(piece, self.packing.as_ref());
            queue.write_buffer(&points, at * encoding.bytes(), bytemuck::cast_slice(&point_words));
            if !color_words.is_empty() {
                queue.write_buffer(&colors, at * 4, bytemuck::cast_slice(&color_words));
            }
            queue.submit([]);
            device::wait(device)?;
        }
        let all = [&uniform, &points, &colors];
        let used = if self.packing.is_some() { 3 } else { 2 };
        let bind = kernel::bind_buffers(device, "points", &self.layout, &all[..used]);
        Ok(Page { len, points, bind })
    }
}
