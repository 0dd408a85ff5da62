//! Index build: the slots visible in a frame, compacted, with the arguments to reproject them in the
//! next frame. No round trip to the host.

use super::targets::{TargetLayouts, Targets};
use crate::{
    gpu::{
        kernel::{self, Binding},
        shaders,
        timing::{FrameTimer, Stage},
    },
    store::gpu::SlotLists,
};

/// The index build pass.
pub struct IndexBuild {
    build: wgpu::ComputePipeline,
    finish: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

impl IndexBuild {
    pub fn new(device: &wgpu::Device, layouts: &TargetLayouts) -> IndexBuild {
        let layout =
            kernel::layout(device, "index", wgpu::ShaderStages::COMPUTE, &[Binding::ReadWrite, Binding::ReadWrite]);
        let module = shaders::INDEX.module(device);
        let pipeline = |entry| kernel::compute(device, &module, entry, &[&layouts.read, &layout]);
        IndexBuild { build: pipeline("build"), finish: pipeline("finish"), layout }
    }

    pub fn record(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut FrameTimer,
        targets: &Targets,
        lists: &SlotLists,
    ) {
        // The first word is the number of indices, counted anew.
        encoder.clear_buffer(&lists.visible_arguments, 0, Some(4));
        let bind = kernel::bind_buffers(device, "index", &self.layout, &[&lists.visible, &lists.visible_arguments]);
        let mut pass = timer.compute_pass(encoder, Stage::Index);
        pass.set_bind_group(0, &targets.bind_read, &[]);
        pass.set_bind_group(1, &bind, &[]);
        pass.set_pipeline(&self.build);
        kernel::dispatch(&mut pass, targets.pixels());
        pass.set_pipeline(&self.finish);
        pass.dispatch_workgroups(1, 1, 1);
    }
}
