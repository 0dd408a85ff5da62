//! The hardware rasterizer: point lists and the depth test, then the slots of the points that passed.
//! Equal to the compute rasterizer in every pixel, see `shaders/hardware.wgsl`; here to be measured
//! against, and for devices whose atomics are slow.

use super::{
    compute::Reading,
    sources::{Source, Sources},
};
use crate::{
    gpu::{
        kernel::{self, Binding},
        shaders,
        timing::FrameTimer,
    },
    store::gpu::GpuStore,
};

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Rasterizes with draws. A clone shares the pipelines, and has targets of its own after it is resized.
#[derive(Clone)]
pub struct HardwareRaster {
    depth: wgpu::RenderPipeline,
    claim: wgpu::RenderPipeline,
    pub reading: Reading,
    layout_words: wgpu::BindGroupLayout,
    layout_depths: wgpu::BindGroupLayout,
    target: Option<Target>,
}

#[derive(Clone)]
struct Target {
    size: [u32; 2],
    view: wgpu::TextureView,
    bind_words: wgpu::BindGroup,
    bind_depths: wgpu::BindGroup,
}

impl HardwareRaster {
    /// What the adapter lacks for it, if anything.
    pub fn missing(adapter: &wgpu::Adapter) -> Option<&'static str> {
        let flags = adapter.get_downlevel_capabilities().flags;
        let needed = [
            (wgpu::DownlevelFlags::FRAGMENT_WRITABLE_STORAGE, "storage buffers written by fragment shaders"),
            (wgpu::DownlevelFlags::VERTEX_STORAGE, "storage buffers read by vertex shaders"),
            (wgpu::DownlevelFlags::INDIRECT_EXECUTION, "indirect draws"),
            (wgpu::DownlevelFlags::FULL_DRAW_INDEX_UINT32, "32-bit indices"),
        ];
        needed.iter().find(|(flag, _)| !flags.contains(*flag)).map(|&(_, name)| name)
    }

    pub fn new(device: &wgpu::Device, layout_positions: &wgpu::BindGroupLayout, reading: Reading) -> HardwareRaster {
        let layout_words = words_layout(device);
        let layout_depths = kernel::layout(device, "depths", wgpu::ShaderStages::FRAGMENT, &[Binding::DepthTexture]);
        let module = shaders::HARDWARE.module_in(device, reading.encoding);
        let constants = [("HAS_MASK", f64::from(u8::from(reading.masked)))];
        let pipeline = |label, claims: bool| {
            let groups: &[&wgpu::BindGroupLayout] = if claims {
                &[&layout_words, layout_positions, &layout_depths]
            } else {
                &[&layout_words, layout_positions]
            };
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(label),
                layout: Some(&kernel::pipeline_layout(device, label, groups)),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("place"),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &constants,
                        ..Default::default()
                    },
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::PointList, ..Default::default() },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: FORMAT,
                    depth_write_enabled: Some(!claims),
                    depth_compare: Some(if claims {
                        wgpu::CompareFunction::Equal
                    } else {
                        wgpu::CompareFunction::Less
                    }),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: claims.then(|| wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("claim"),
                    compilation_options: Default::default(),
                    targets: &[],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        HardwareRaster {
            depth: pipeline("depth", false),
            claim: pipeline("claim", true),
            reading,
            layout_words,
            layout_depths,
            target: None,
        }
    }

    /// Draws to these words from now on, a picture of `size` pixels.
    ///
    /// # Errors
    /// The device's message if it has no memory for the depths.
    pub fn resize(
        &mut self,
        device: &wgpu::Device,
        view: &wgpu::Buffer,
        words: &wgpu::Buffer,
        size: [u32; 2],
    ) -> Result<(), String> {
        let [width, height] = size;
        let descriptor = wgpu::TextureDescriptor {
            label: Some("depths"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let texture = kernel::in_memory(device, || device.create_texture(&descriptor))?;
        let depths = texture.create_view(&Default::default());
        self.target = Some(Target {
            size,
            bind_words: kernel::bind_buffers(device, "hardware words", &self.layout_words, &[view, words]),
            bind_depths: kernel::bind(
                device,
                "depths",
                &self.layout_depths,
                &[wgpu::BindingResource::TextureView(&depths)],
            ),
            view: depths,
        });
        Ok(())
    }

    /// `size` must be that of the words; `instances` is the number of pixels of a point.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut FrameTimer,
        size: [u32; 2],
        store: &GpuStore,
        sources: &Sources,
        instances: u32,
    ) {
        let Some(target) = self.target.as_ref().filter(|target| target.size == size) else { return };
        for claims in [false, true] {
            for (n, &source) in sources.list.iter().enumerate() {
                let load = if n == 0 { wgpu::LoadOp::Clear(1.0) } else { wgpu::LoadOp::Load };
                let depth_ops = (!claims).then_some(wgpu::Operations { load, store: wgpu::StoreOp::Store });
                let mut pass = timer.depth_pass(encoder, source.stage(), &target.view, depth_ops);
                pass.set_pipeline(if claims { &self.claim } else { &self.depth });
                pass.set_bind_group(0, &target.bind_words, &[]);
                if claims {
                    pass.set_bind_group(2, &target.bind_depths, &[]);
                }
                draw(&mut pass, store, sources, source, instances);
            }
        }
    }
}

fn draw(pass: &mut wgpu::RenderPass<'_>, store: &GpuStore, sources: &Sources, source: Source, instances: u32) {
    let lists = &store.lists;
    match source {
        Source::Reproject => {
            pass.set_index_buffer(lists.visible.slice(..), wgpu::IndexFormat::Uint32);
            for page in store.pages.iter() {
                pass.set_bind_group(1, &page.bind_positions, &[]);
                pass.draw_indexed_indirect(&lists.visible_arguments, 0);
            }
        }
        Source::Fresh => {
            pass.set_index_buffer(lists.fresh.slice(..), wgpu::IndexFormat::Uint32);
            for page in store.pages.iter() {
                pass.set_bind_group(1, &page.bind_positions, &[]);
                pass.draw_indexed(0..sources.fresh_points, 0, 0..instances);
            }
        }
        Source::Fill => {
            for piece in &sources.pieces {
                pass.set_bind_group(1, &store.pages.at(piece.page).bind_positions, &[]);
                pass.draw(piece.slots.clone(), 0..instances);
            }
        }
    }
}

/// View for both stages; words for fragments alone, since a vertex stage may not see writable storage.
fn words_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    let writable = wgpu::BufferBindingType::Storage { read_only: false };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("hardware words"),
        entries: &[
            entry(0, wgpu::ShaderStages::VERTEX_FRAGMENT, wgpu::BufferBindingType::Uniform),
            entry(1, wgpu::ShaderStages::FRAGMENT, writable),
        ],
    })
}
