//! The compute rasterizer: `atomicMin` decides each pixel. With 64-bit atomics one pass writes depth
//! and slot at once; without, a pass for the depth and one for the slot.

use super::{
    sources::{Source, SourceBinder, Sources},
    targets::{TargetLayouts, Targets},
};
use crate::{
    gpu::{kernel, shaders, timing::FrameTimer},
    render::Raster,
    store::gpu::{DISPATCH_ARGUMENTS, GpuStore},
};

struct Plot {
    from_list: wgpu::ComputePipeline,
    from_span: wgpu::ComputePipeline,
}

/// Rasterizes with compute shaders.
pub struct ComputeRaster {
    /// One, or first depths and then slots.
    plots: Vec<Plot>,
}

impl ComputeRaster {
    pub fn new(
        device: &wgpu::Device,
        raster: Raster,
        layouts: &TargetLayouts,
        store: &GpuStore,
        binder: &SourceBinder,
    ) -> ComputeRaster {
        let modules: &[shaders::Shader] = match raster {
            Raster::Compute if device.features().contains(shaders::RASTER_64.needs) => &[shaders::RASTER_64],
            Raster::Compute => &[shaders::RASTER_64_MIN],
            _ => &[shaders::RASTER_DEPTH_32, shaders::RASTER_SLOT_32],
        };
        let plots = modules.iter().map(|shader| {
            let module = shader.module(device);
            let groups = [&layouts.write, &store.pages.layout_positions, &binder.layout];
            Plot {
                from_list: kernel::compute(device, &module, "from_list", &groups),
                from_span: kernel::compute(device, &module, "from_span", &groups),
            }
        });
        ComputeRaster { plots: plots.collect() }
    }

    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut FrameTimer,
        targets: &Targets,
        store: &GpuStore,
        sources: &Sources,
    ) {
        for plot in &self.plots {
            for &source in &sources.list {
                let mut pass = timer.compute_pass(encoder, source.stage());
                pass.set_bind_group(0, &targets.bind_write, &[]);
                match source {
                    Source::Reproject | Source::Fresh => {
                        pass.set_pipeline(&plot.from_list);
                        for page in store.pages.iter() {
                            pass.set_bind_group(1, &page.bind_positions, &[]);
                            if source == Source::Reproject {
                                pass.set_bind_group(2, &sources.bind_visible, &[0]);
                                pass.dispatch_workgroups_indirect(&store.lists.visible_arguments, DISPATCH_ARGUMENTS);
                            } else {
                                pass.set_bind_group(2, &sources.bind_fresh, &[0]);
                                kernel::dispatch(&mut pass, sources.fresh_points);
                            }
                        }
                    }
                    Source::Fill => {
                        pass.set_pipeline(&plot.from_span);
                        for (piece, offset) in sources.pieces.iter().zip((0..).step_by(kernel::SPAN_STRIDE as usize)) {
                            pass.set_bind_group(1, &store.pages.at(piece.page).bind_positions, &[]);
                            pass.set_bind_group(2, &sources.bind_fresh, &[offset]);
                            kernel::dispatch(&mut pass, piece.slots.end - piece.slots.start);
                        }
                    }
                }
            }
        }
    }
}
