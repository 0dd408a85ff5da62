//! The GPU backend: wgpu on Vulkan, Metal or DX12.

use super::{Backend, BackendInfo, FramePlan, PassTimes, Picture, RenderError};
use crate::{scene::PointBatch, store::Insertion};

/// Which rasterizer to use.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum RasterChoice {
    /// The faster one, measured at start.
    #[default]
    Auto,
    /// Compute shaders; with 64-bit atomics where the device has them.
    Compute,
    /// Compute shaders with 32-bit atomics only.
    Compute32,
    /// Point-list draws.
    Hardware,
}

/// Stores points and draws frames on a GPU.
pub struct GpuBackend {
    info: BackendInfo,
}

impl GpuBackend {
    /// Features and limits to ask of an adapter.
    pub fn device_descriptor(_adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
        wgpu::DeviceDescriptor::default()
    }

    /// A backend on the best adapter at hand, without a window.
    pub fn headless(_choice: RasterChoice) -> Result<GpuBackend, RenderError> {
        Err(RenderError::NoAdapter(String::new()))
    }

    /// A backend on a device made with [`GpuBackend::device_descriptor`].
    pub fn on_device(
        _adapter: &wgpu::Adapter,
        _device: wgpu::Device,
        _queue: wgpu::Queue,
        _choice: RasterChoice,
    ) -> Result<GpuBackend, RenderError> {
        Err(RenderError::NoAdapter(String::new()))
    }

    /// The picture of the last frame: one u32 per pixel (red in the lowest byte, then green, blue,
    /// alpha), row by row from the top; and its width and height. The buffer is another one after
    /// the size of the picture changed.
    pub fn picture_buffer(&self) -> Option<(&wgpu::Buffer, [u32; 2])> {
        None
    }
}

impl Backend for GpuBackend {
    fn info(&self) -> &BackendInfo {
        &self.info
    }
    fn reset(&mut self, _points: u64) {}
    fn insertions_per_frame(&self) -> usize {
        16
    }
    fn insert(&mut self, _insertion: &Insertion, _points: &PointBatch) -> Result<(), RenderError> {
        Ok(())
    }
    fn draw(&mut self, _plan: &FramePlan) -> Result<(), RenderError> {
        Ok(())
    }
    fn pass_times(&mut self) -> Option<PassTimes> {
        None
    }
    fn read(&mut self) -> Result<Picture, RenderError> {
        Err(RenderError::NoAdapter(String::new()))
    }
}
