//! Choosing an adapter, and what is asked of it.

use std::{sync::OnceLock, time::Duration};

use super::shaders;
use crate::device::RenderError;

/// Features that are used where the adapter has them. None is required: without 64-bit atomics two
/// 32-bit passes do the work, without timestamps the wall clock is read, and without subgroups each
/// thread works alone.
const WANTED: wgpu::Features =
    shaders::INT64_ATOMICS.union(wgpu::Features::TIMESTAMP_QUERY).union(wgpu::Features::SUBGROUP);

/// Features and limits to ask of an adapter: WebGPU's defaults, but buffers as large as they come.
pub fn descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    let offered = adapter.limits();
    wgpu::DeviceDescriptor {
        label: Some("firstlight"),
        required_features: adapter.features() & WANTED,
        required_limits: wgpu::Limits {
            max_buffer_size: offered.max_buffer_size,
            max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size,
            max_texture_dimension_2d: offered.max_texture_dimension_2d,
            ..wgpu::Limits::default().using_alignment(offered)
        },
        // Points fill most of the memory, in few large buffers.
        memory_hints: wgpu::MemoryHints::MemoryUsage,
        ..Default::default()
    }
}

/// The instance for work without a window, one for all devices of the process: NVIDIA's driver can be loaded
/// some hundred times, then no more. `WGPU_BACKEND` and wgpu's other variables are heeded.
pub fn instance() -> &'static wgpu::Instance {
    static INSTANCE: OnceLock<wgpu::Instance> = OnceLock::new();
    INSTANCE.get_or_init(|| wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env()))
}

/// The best adapter at hand and a device on it, for work without a window.
pub fn headless() -> Result<(wgpu::Adapter, wgpu::Device, wgpu::Queue), RenderError> {
    headless_with(descriptor)
}

/// As [`headless`], with what `describe` asks of the adapter.
pub fn headless_with(
    describe: impl FnOnce(&wgpu::Adapter) -> wgpu::DeviceDescriptor<'static>,
) -> Result<(wgpu::Adapter, wgpu::Device, wgpu::Queue), RenderError> {
    let options =
        wgpu::RequestAdapterOptions { power_preference: wgpu::PowerPreference::HighPerformance, ..Default::default() };
    let adapter = pollster::block_on(instance().request_adapter(&options))
        .map_err(|error| RenderError::NoAdapter(format!(" ({})", what_was_tried(&error.to_string()))))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&describe(&adapter)))
        .map_err(|error| RenderError::NoAdapter(format!(" (the adapter gave no device: {error})")))?;
    Ok((adapter, device, queue))
}

/// wgpu's reason without the backends that this program is built without.
fn what_was_tried(reason: &str) -> String {
    let parts = reason.split([';', ',']).map(str::trim).filter(|part| !part.ends_with("not compiled in"));
    parts.collect::<Vec<_>>().join(", ")
}

/// A device that has not finished by then never will: at the 40 million points per second of a software
/// rasterizer, even the largest scene takes 107 s at once.
const PATIENCE: Duration = Duration::from_secs(120);

/// Waits until all submitted work is done.
///
/// # Errors
/// [`RenderError::DeviceLost`], also if the device does not answer.
pub fn wait(device: &wgpu::Device) -> Result<(), RenderError> {
    poll(device, None)
}

/// Waits until the work of a submission, and of all before it, is done.
///
/// # Errors
/// As [`wait`].
pub fn wait_for(device: &wgpu::Device, submission: wgpu::SubmissionIndex) -> Result<(), RenderError> {
    poll(device, Some(submission))
}

fn poll(device: &wgpu::Device, submission_index: Option<wgpu::SubmissionIndex>) -> Result<(), RenderError> {
    let poll = wgpu::PollType::Wait { submission_index, timeout: Some(PATIENCE) };
    match device.poll(poll) {
        Ok(_) => Ok(()),
        Err(error) => Err(RenderError::DeviceLost(format!("no answer within {} s ({error})", PATIENCE.as_secs()))),
    }
}
