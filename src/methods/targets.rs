//! Everything whose size is that of the picture.

use wgpu::BufferUsages;

use super::{Depth40, MethodError, hardware::Textures};
use crate::{
    device::RenderError,
    gpu::kernel::{self, Binding},
    render::View,
};

/// Words, sums and colours; see `shaders/methods/targets.wgsl`.
pub struct Targets {
    pub size: [u32; 2],
    view: wgpu::Buffer,
    depth40: wgpu::Buffer,
    /// 8 bytes a pixel.
    pub words: wgpu::Buffer,
    /// 8 bytes a pixel: locks, one-word sums, or identified points.
    pub accumulators: wgpu::Buffer,
    /// Give-ups, and what the reading kernel never writes.
    pub counters: wgpu::Buffer,
    /// 4 bytes a pixel.
    pub rgba: wgpu::Buffer,
    pub layout: wgpu::BindGroupLayout,
    pub bind: wgpu::BindGroup,
    pub layout_view: wgpu::BindGroupLayout,
    /// The view alone, for vertices.
    pub bind_view: wgpu::BindGroup,
    /// For the hardware's points, made when they are first drawn.
    pub textures: Option<Textures>,
}

impl Targets {
    pub fn new(device: &wgpu::Device, size: [u32; 2]) -> Result<Targets, MethodError> {
        use Binding::{ReadWrite, Uniform};
        let [width, height] = size;
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 {
            return Err(MethodError::NoPixels(width, height));
        }
        let limits = device.limits();
        let limit = (limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) / 16).min(1 << 29);
        if pixels > limit || width.max(height) > limits.max_texture_dimension_2d {
            return Err(RenderError::TooManyPixels { width, height, limit }.into());
        }
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let buffer = |label, bytes: u64| kernel::buffer(device, label, pixels * bytes, storage);
        let [words, sums, accumulators, rgba] = kernel::in_memory(device, || {
            [buffer("words", 8), buffer("sums", 16), buffer("accumulators", 8), buffer("rgba", 4)]
        })
        .map_err(|detail| RenderError::NoMemoryForPicture { width, height, detail })?;
        let counters = kernel::buffer(device, "counters", 8, storage);
        let view = kernel::uniform(device, "view", size_of::<View>() as u64);
        let depth40 = kernel::uniform(device, "depth40", size_of::<Depth40>() as u64);
        let layout = kernel::layout(
            device,
            "targets",
            wgpu::ShaderStages::COMPUTE,
            &[Uniform, ReadWrite, ReadWrite, ReadWrite, ReadWrite, ReadWrite, ReadWrite, Uniform],
        );
        let layout_view = kernel::layout(device, "view", wgpu::ShaderStages::VERTEX, &[Uniform]);
        // The words a second time: without atomics, for the early test.
        let all = [&view, &words, &words, &sums, &accumulators, &counters, &rgba, &depth40];
        Ok(Targets {
            size,
            bind: kernel::bind_buffers(device, "targets", &layout, &all),
            bind_view: kernel::bind_buffers(device, "view", &layout_view, &[&view]),
            view,
            depth40,
            words,
            accumulators,
            counters,
            rgba,
            layout,
            layout_view,
            textures: None,
        })
    }

    pub fn pixels(&self) -> u32 {
        self.size[0] * self.size[1]
    }

    /// Uploads a view, with points of one pixel.
    pub fn set_view(&self, queue: &wgpu::Queue, view: &View) -> Result<(), MethodError> {
        let found = [view.width, view.height];
        if found != self.size {
            return Err(MethodError::OtherSize { expected: self.size, found });
        }
        queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&View { point_size: 1, ..*view }));
        queue.write_buffer(&self.depth40, 0, bytemuck::bytes_of(&Depth40::of(view)));
        Ok(())
    }
}
