//! Resolve: from the slots that won to colours, then eye-dome lighting.

use wgpu::BufferUsages;

use super::targets::{TargetLayouts, Targets};
use crate::{
    gpu::{
        kernel::{self, Binding},
        shaders,
        timing::{FrameTimer, Stage},
    },
    render::{FileColor, FramePlan, elevation_ramp, shading::EDL_GAIN},
    store::gpu::Pages,
};

/// Lighting in numbers for the kernel. Layout shared with `shaders/light.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ShadingUniform {
    pub edl_factor: f32,
    pub background: u32,
    pub unused_a: u32,
    pub unused_b: u32,
}

/// The resolve pass.
pub struct Resolve {
    color: wgpu::ComputePipeline,
    identify: wgpu::ComputePipeline,
    light: wgpu::ComputePipeline,
    layout_colors: wgpu::BindGroupLayout,
    layout_light: wgpu::BindGroupLayout,
    ramp: wgpu::Buffer,
    files: wgpu::Buffer,
    shading: wgpu::Buffer,
}

impl Resolve {
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, layouts: &TargetLayouts, pages: &Pages) -> Resolve {
        use Binding::{Read, ReadWrite, Uniform};
        let compute = wgpu::ShaderStages::COMPUTE;
        let layout_colors = kernel::layout(device, "colors", compute, &[Read, Read, ReadWrite, ReadWrite]);
        let layout_light = kernel::layout(device, "light", compute, &[Uniform, Read, ReadWrite]);
        let (resolve, light) = (shaders::RESOLVE.module(device), shaders::LIGHT.module(device));
        let coloring =
            |entry| kernel::compute(device, &resolve, entry, &[&layouts.read, &pages.layout_resolve, &layout_colors]);
        let table = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let ramp = kernel::buffer(device, "ramp", 256 * 4, table);
        queue.write_buffer(&ramp, 0, bytemuck::cast_slice(&elevation_ramp()));
        Resolve {
            color: coloring("color"),
            identify: coloring("identify"),
            light: kernel::compute(device, &light, "light", &[&layouts.read, &layout_light]),
            ramp,
            files: kernel::buffer(device, "files", size_of::<FileColor>() as u64, table),
            shading: kernel::uniform(device, "shading", size_of::<ShadingUniform>() as u64),
            layout_colors,
            layout_light,
        }
    }

    /// Uploads the colour rules and the shading of a frame.
    pub fn prepare(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, plan: &FramePlan) {
        let files: &[u8] = bytemuck::cast_slice(&plan.files);
        if self.files.size() != files.len() as u64 && !files.is_empty() {
            self.files =
                kernel::buffer(device, "files", files.len() as u64, BufferUsages::STORAGE | BufferUsages::COPY_DST);
        }
        queue.write_buffer(&self.files, 0, files);
        let [r, g, b] = plan.shading.background;
        let uniform = ShadingUniform {
            edl_factor: EDL_GAIN * plan.shading.edl_strength,
            background: u32::from_le_bytes([r, g, b, 255]),
            unused_a: 0,
            unused_b: 0,
        };
        queue.write_buffer(&self.shading, 0, bytemuck::bytes_of(&uniform));
    }

    pub fn record(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut FrameTimer,
        targets: &Targets,
        pages: &Pages,
    ) {
        let mut pass = timer.compute_pass(encoder, Stage::Resolve);
        self.record_pages(device, &mut pass, &self.color, targets, pages);
        let buffers = [&self.shading, &targets.colors, &targets.picture];
        let bind = kernel::bind_buffers(device, "light", &self.layout_light, &buffers);
        pass.set_pipeline(&self.light);
        pass.set_bind_group(1, &bind, &[]);
        kernel::dispatch(&mut pass, targets.pixels());
    }

    /// Fills the targets' records, for a read-back.
    pub fn record_identify(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        targets: &Targets,
        pages: &Pages,
    ) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        self.record_pages(device, &mut pass, &self.identify, targets, pages);
    }

    fn record_pages(
        &self,
        device: &wgpu::Device,
        pass: &mut wgpu::ComputePass<'_>,
        pipeline: &wgpu::ComputePipeline,
        targets: &Targets,
        pages: &Pages,
    ) {
        let buffers = [&self.files, &self.ramp, &targets.colors, &targets.records];
        let bind = kernel::bind_buffers(device, "colors", &self.layout_colors, &buffers);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &targets.bind_read, &[]);
        pass.set_bind_group(2, &bind, &[]);
        for page in pages.iter() {
            pass.set_bind_group(1, &page.bind_resolve, &[]);
            kernel::dispatch(pass, targets.pixels());
        }
    }
}
