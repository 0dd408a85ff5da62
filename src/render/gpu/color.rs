//! What the kernels need to colour points: each file's rule, and the tables of the frame's scale.

use std::sync::Arc;

use wgpu::BufferUsages;

use crate::{
    gpu::kernel::{self, Binding},
    render::{FileColor, PointColors},
};

/// The scale of the rules in numbers. Layout shared with `shaders/color.wgsl`, where four numbers make a vector.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ColorTablesUniform {
    pub thresholds: [u32; 256],
    pub ramp: [[u8; 4]; 256],
}

/// The tables of `shaders/color.wgsl`.
pub struct ColorTables {
    pub layout: wgpu::BindGroupLayout,
    pub bind: wgpu::BindGroup,
    files: wgpu::Buffer,
    tables: wgpu::Buffer,
    /// What the buffers hold.
    uploaded: Option<Arc<PointColors>>,
}

impl ColorTables {
    pub fn new(device: &wgpu::Device) -> ColorTables {
        let layout =
            kernel::layout(device, "color tables", wgpu::ShaderStages::COMPUTE, &[Binding::Read, Binding::Uniform]);
        let tables = kernel::uniform(device, "color tables", size_of::<ColorTablesUniform>() as u64);
        let files = files_buffer(device, 1);
        let bind = kernel::bind_buffers(device, "color tables", &layout, &[&files, &tables]);
        ColorTables { layout, bind, files, tables, uploaded: None }
    }

    /// Uploads the colours of a frame; true if they are others than the last frame's.
    pub fn prepare(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, colors: &Arc<PointColors>) -> bool {
        if self.uploaded.as_ref().is_some_and(|uploaded| Arc::ptr_eq(uploaded, colors) || uploaded == colors) {
            return false;
        }
        let bytes: &[u8] = bytemuck::cast_slice(&colors.files);
        // The kernels ask the buffer for the number of files.
        if self.files.size() != bytes.len() as u64 && !colors.files.is_empty() {
            self.files = files_buffer(device, colors.files.len());
            self.bind = kernel::bind_buffers(device, "color tables", &self.layout, &[&self.files, &self.tables]);
        }
        queue.write_buffer(&self.files, 0, bytes);
        let tables = ColorTablesUniform { thresholds: colors.thresholds, ramp: colors.ramp };
        queue.write_buffer(&self.tables, 0, bytemuck::bytes_of(&tables));
        self.uploaded = Some(colors.clone());
        true
    }
}

fn files_buffer(device: &wgpu::Device, files: usize) -> wgpu::Buffer {
    let bytes = (files * size_of::<FileColor>()) as u64;
    kernel::buffer(device, "files", bytes, BufferUsages::STORAGE | BufferUsages::COPY_DST)
}
