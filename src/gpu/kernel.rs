//! Bind groups, pipelines and dispatches in few words.

use super::device;
use crate::device::RenderError;

/// Threads in a workgroup of every kernel that does not say otherwise, as `GROUP` in `shaders/group.wgsl`.
pub const GROUP: u32 = 256;

/// WebGPU's limit of workgroups per axis.
const MAX_GROUPS: u32 = 65_535;

/// What one binding of a layout is.
#[derive(Clone, Copy)]
pub enum Binding {
    Uniform,
    /// A uniform of which each dispatch reads another piece, [`SPAN_STRIDE`] apart.
    UniformAt,
    Read,
    ReadWrite,
    DepthTexture,
}

/// Distance of the pieces of a [`Binding::UniformAt`]: the largest alignment that WebGPU allows a
/// device to ask for.
pub const SPAN_STRIDE: u32 = 256;

/// A layout whose bindings are numbered as listed.
pub fn layout(
    device: &wgpu::Device,
    label: &str,
    visibility: wgpu::ShaderStages,
    bindings: &[Binding],
) -> wgpu::BindGroupLayout {
    let buffer = |ty, has_dynamic_offset| wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None };
    let entries: Vec<_> = bindings
        .iter()
        .zip(0..)
        .map(|(kind, binding)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility,
            ty: match kind {
                Binding::Uniform => buffer(wgpu::BufferBindingType::Uniform, false),
                Binding::UniformAt => buffer(wgpu::BufferBindingType::Uniform, true),
                Binding::Read => buffer(wgpu::BufferBindingType::Storage { read_only: true }, false),
                Binding::ReadWrite => buffer(wgpu::BufferBindingType::Storage { read_only: false }, false),
                Binding::DepthTexture => wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Depth,
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
            },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// A bind group of whole resources, numbered as listed.
pub fn bind(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    let entries: Vec<_> = resources
        .iter()
        .zip(0..)
        .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}

/// A bind group of whole buffers, numbered as listed.
pub fn bind_buffers(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let resources: Vec<_> = buffers.iter().map(|buffer| buffer.as_entire_binding()).collect();
    bind(device, label, layout, &resources)
}

/// A pipeline layout of these groups, in order.
pub fn pipeline_layout(device: &wgpu::Device, label: &str, groups: &[&wgpu::BindGroupLayout]) -> wgpu::PipelineLayout {
    let groups: Vec<_> = groups.iter().copied().map(Some).collect();
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &groups,
        immediate_size: 0,
    })
}

/// The entry point `entry` of a module as a compute pipeline.
pub fn compute(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    entry: &str,
    groups: &[&wgpu::BindGroupLayout],
) -> wgpu::ComputePipeline {
    compute_with(device, module, entry, groups, &[])
}

/// As [`compute`], with values for the module's overrides.
pub fn compute_with(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    entry: &str,
    groups: &[&wgpu::BindGroupLayout],
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(&pipeline_layout(device, entry, groups)),
        module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
        cache: None,
    })
}

/// A buffer of `size` bytes, at least four.
pub fn buffer(device: &wgpu::Device, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size.max(4).next_multiple_of(4),
        usage,
        mapped_at_creation: false,
    })
}

/// What `make` makes, unless memory has no room for it; the message of the device then.
pub fn in_memory<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, String> {
    let scope = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let made = make();
    // Native devices answer at once.
    match pollster::block_on(scope.pop()) {
        Some(error) => Err(error.to_string()),
        None => Ok(made),
    }
}

/// A uniform buffer that the host writes.
pub fn uniform(device: &wgpu::Device, label: &str, size: u64) -> wgpu::Buffer {
    buffer(device, label, size, wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST)
}

/// Rows of at least so many workgroups, as `line_index` in `shaders/group.wgsl` numbers them.
fn rows_of(groups: u32) -> [u32; 2] {
    let rows = groups.div_ceil(MAX_GROUPS).max(1);
    [groups.div_ceil(rows), rows]
}

/// Dispatches at least `threads` threads.
pub fn dispatch(pass: &mut wgpu::ComputePass<'_>, threads: u32) {
    dispatch_groups(pass, threads.div_ceil(GROUP));
}

/// Dispatches at least so many workgroups, numbered row by row.
pub fn dispatch_groups(pass: &mut wgpu::ComputePass<'_>, groups: u32) {
    let [x, y] = rows_of(groups);
    if x > 0 {
        pass.dispatch_workgroups(x, y, 1);
    }
}

/// Waits for the device and brings a buffer of 32-bit words back.
pub fn read_words(device: &wgpu::Device, queue: &wgpu::Queue, buffer: &wgpu::Buffer) -> Result<Vec<u32>, RenderError> {
    let encoder = device.create_command_encoder(&Default::default());
    let [words] = read_all(device, queue, encoder, [buffer])?;
    Ok(words)
}

/// Submits the encoder's commands, waits for the device, and brings buffers of 32-bit words back.
pub fn read_all<const N: usize>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    mut encoder: wgpu::CommandEncoder,
    buffers: [&wgpu::Buffer; N],
) -> Result<[Vec<u32>; N], RenderError> {
    let staging = buffers.map(|source| {
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let staging = buffer(device, "readback", source.size(), usage);
        encoder.copy_buffer_to_buffer(source, 0, &staging, 0, None);
        staging
    });
    queue.submit([encoder.finish()]);
    for buffer in &staging {
        // A failure shows when the mapped range is asked for.
        buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    }
    let lost = |error: &dyn std::fmt::Display| RenderError::DeviceLost(error.to_string());
    device::wait(device)?;
    let mut all = [const { Vec::new() }; N];
    for (words, buffer) in all.iter_mut().zip(&staging) {
        let bytes = buffer.get_mapped_range(..).map_err(|error| lost(&error))?;
        *words = bytemuck::cast_slice(&bytes).to_vec();
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_hold_all_groups_within_the_limit() {
        for groups in [0, 1, MAX_GROUPS - 1, MAX_GROUPS, MAX_GROUPS + 1, 2 * MAX_GROUPS + 1, 1 << 24, 1 << 26] {
            let [x, y] = rows_of(groups);
            assert!(x <= MAX_GROUPS && y <= MAX_GROUPS, "{groups}: {x} x {y}");
            assert!(x * y >= groups && x * y - groups <= y, "{groups}: {x} x {y}");
        }
    }
}
