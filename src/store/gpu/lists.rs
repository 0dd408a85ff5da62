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
    /// Arguments to draw or dispatch `visible`; the first word is its length, which kernels read as a uniform.
    pub visible_arguments: wgpu::Buffer,
    /// Slots of the points inserted since the last frame.
    pub fresh: wgpu::Buffer,
    /// Length of `fresh`, written by the host for each frame.
    pub fresh_count: wgpu::Buffer,
    /// The visible slots are those of a scene that is gone.
    pub forget_visible: bool,
}

impl SlotLists {
    /// Empty lists, without room.
    pub fn new(device: &wgpu::Device) -> SlotLists {
        SlotLists {
            visible: list(device, "visible slots", 0),
            visible_arguments: kernel::buffer(
                device,
                "visible arguments",
                ARGUMENTS_BYTES,
                BufferUsages::STORAGE
                    | BufferUsages::UNIFORM
                    | BufferUsages::INDIRECT
                    | BufferUsages::COPY_DST
                    | BufferUsages::COPY_SRC,
            ),
            fresh: list(device, "fresh slots", 0),
            fresh_count: kernel::uniform(device, "fresh count", 16),
            forget_visible: false,
        }
    }

    /// Makes room for a slot per pixel; the slots that are in the list stay, since a picture of another
    /// size shows many of the same points.
    ///
    /// # Errors
    /// The device's message, if memory is full.
    pub fn resize_visible(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        pixels: u32,
    ) -> Result<(), String> {
        let held = (self.visible.size() / 4) as u32;
        let resized = kernel::in_memory(device, || list(device, "visible slots", pixels.max(held)))?;
        encoder.copy_buffer_to_buffer(&self.visible, 0, &resized, 0, Some(self.visible.size()));
        self.visible = resized;
        Ok(())
    }

    /// Empties the list of visible slots if they mean nothing any more.
    pub fn drop_forgotten(&mut self, encoder: &mut wgpu::CommandEncoder) {
        if std::mem::take(&mut self.forget_visible) {
            // The length and the dispatch; the second word is the host's.
            encoder.clear_buffer(&self.visible_arguments, 0, Some(4));
            encoder.clear_buffer(&self.visible_arguments, DISPATCH_ARGUMENTS, None);
        }
    }
}

/// A list with room for so many slots.
pub fn list(device: &wgpu::Device, label: &str, slots: u32) -> wgpu::Buffer {
    let usage = BufferUsages::STORAGE | BufferUsages::INDEX | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
    kernel::buffer(device, label, u64::from(slots) * 4, usage)
}
