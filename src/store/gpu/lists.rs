//! Lists of slots on the GPU: what was visible in the last frame, and what arrived since.

use wgpu::BufferUsages;

use crate::gpu::kernel;

/// Where the arguments of the indirect dispatch begin in [`SlotLists::visible_arguments`], behind
/// those of the indirect draw. Layout shared with `shaders/index.wgsl`.
pub const DISPATCH_ARGUMENTS: u64 = 32;
const ARGUMENTS_BYTES: u64 = 44;

/// The lists that insertion relocates and the next frame draws.
pub struct SlotLists {
    /// Slots visible in the last frame.
    pub visible: wgpu::Buffer,
    /// Arguments to draw or dispatch `visible`; the first word is its length.
    pub visible_arguments: wgpu::Buffer,
    /// Slots of the points inserted since the last frame.
    pub fresh: wgpu::Buffer,
    /// Length of `fresh`, written by the host for each frame.
    pub fresh_count: wgpu::Buffer,
}

impl SlotLists {
    /// Empty lists, without room.
    pub fn new(device: &wgpu::Device) -> SlotLists {
        SlotLists {
            visible: SlotLists::list(device, "visible slots", 0),
            visible_arguments: kernel::buffer(
                device,
                "visible arguments",
                ARGUMENTS_BYTES,
                BufferUsages::STORAGE | BufferUsages::INDIRECT | BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
            ),
            fresh: SlotLists::list(device, "fresh slots", 0),
            fresh_count: kernel::buffer(device, "fresh count", 4, BufferUsages::STORAGE | BufferUsages::COPY_DST),
        }
    }

    /// Room for another number of visible slots; the list is empty then.
    pub fn resize_visible(&mut self, device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, visible: u32) {
        self.visible = SlotLists::list(device, "visible slots", visible);
        encoder.clear_buffer(&self.visible_arguments, 0, None);
    }

    /// Room for another number of fresh slots; the list must be empty.
    pub fn resize_fresh(&mut self, device: &wgpu::Device, fresh: u32) {
        self.fresh = SlotLists::list(device, "fresh slots", fresh);
    }

    fn list(device: &wgpu::Device, label: &str, slots: u32) -> wgpu::Buffer {
        let usage = BufferUsages::STORAGE | BufferUsages::INDEX | BufferUsages::COPY_SRC;
        kernel::buffer(device, label, u64::from(slots) * 4, usage)
    }
}
