//! A device to measure on: all features that any method can use.

use super::table::{Method, Needs};
use crate::{device::RenderError, gpu::device};

#[derive(Clone)]
/// Device and queue, with what the methods ask about them.
pub struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub info: wgpu::AdapterInfo,
    can_draw: bool,
}

impl Gpu {
    /// The best adapter at hand. `WGPU_BACKEND` and wgpu's other variables are heeded.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`].
    pub fn headless() -> Result<Gpu, RenderError> {
        Gpu::without(wgpu::Features::empty())
    }

    /// As [`Gpu::headless`], as if the adapter lacked these features.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`].
    pub fn without(features: wgpu::Features) -> Result<Gpu, RenderError> {
        let wanted = wgpu::Features::SUBGROUP | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let (adapter, device, queue) = device::headless_with(|adapter| {
            let mut descriptor = device::descriptor(adapter);
            descriptor.required_features |= adapter.features() & wanted;
            descriptor.required_features.remove(features);
            descriptor
        })?;
        let flags = adapter.get_downlevel_capabilities().flags;
        let can_draw = flags.contains(wgpu::DownlevelFlags::VERTEX_STORAGE);
        Ok(Gpu { device, queue, info: adapter.get_info(), can_draw })
    }

    /// What this device lacks for a method.
    ///
    /// # Errors
    /// A sentence that names the device and what is missing.
    pub fn supports(&self, method: &Method) -> Result<(), String> {
        let missing: Needs = method.needs.missing(self.device.features(), self.can_draw);
        if missing == (Needs { features: wgpu::Features::empty(), draws: false }) {
            return Ok(());
        }
        Err(format!("{} cannot run {}: it lacks {missing}", self.info.name, method.name))
    }

    /// Whether the device is a processor.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Whether timestamps of passes exist and mean something, see `gpu::timing`.
    pub(super) fn has_clock(&self) -> bool {
        !self.is_software() && self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY)
    }
}
