//! What the kernels need to colour points: each file's rule, and the elevation ramp.

use wgpu::BufferUsages;

use crate::{
    gpu::kernel::{self, Binding},
    render::{FileColor, elevation_ramp},
};

/// The tables of `shaders/color.wgsl`.
pub struct ColorTables {
    pub layout: wgpu::BindGroupLayout,
    pub bind: wgpu::BindGroup,
    files: wgpu::Buffer,
    ramp: wgpu::Buffer,
}

impl ColorTables {
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> ColorTables {
        let layout =
            kernel::layout(device, "color tables", wgpu::ShaderStages::COMPUTE, &[Binding::Read, Binding::Uniform]);
        let ramp = kernel::uniform(device, "ramp", 256 * 4);
        queue.write_buffer(&ramp, 0, bytemuck::cast_slice(&elevation_ramp()));
        let files = files_buffer(device, 1);
        let bind = kernel::bind_buffers(device, "color tables", &layout, &[&files, &ramp]);
        ColorTables { layout, bind, files, ramp }
    }

    /// Uploads the rules of a frame's files.
    pub fn prepare(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, files: &[FileColor]) {
        let bytes: &[u8] = bytemuck::cast_slice(files);
        // The kernels ask the buffer for the number of files.
        if self.files.size() != bytes.len() as u64 && !files.is_empty() {
            self.files = files_buffer(device, files.len());
            self.bind = kernel::bind_buffers(device, "color tables", &self.layout, &[&self.files, &self.ramp]);
        }
        queue.write_buffer(&self.files, 0, bytes);
    }
}

fn files_buffer(device: &wgpu::Device, files: usize) -> wgpu::Buffer {
    let bytes = (files * size_of::<FileColor>()) as u64;
    kernel::buffer(device, "files", bytes, BufferUsages::STORAGE | BufferUsages::COPY_DST)
}
