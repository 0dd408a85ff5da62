//! The hardware's points: the one method that draws instead of dispatching.

use super::{modules, pages::Pages, pipelines::Pipelines, targets::Targets};
use crate::gpu::kernel;

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const SLOT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;

/// Depth and point of each pixel.
pub struct Textures {
    depths: wgpu::TextureView,
    slots: wgpu::TextureView,
    pub layout: wgpu::BindGroupLayout,
    pub bind: wgpu::BindGroup,
    pipeline: wgpu::RenderPipeline,
}

impl Textures {
    pub fn new(device: &wgpu::Device, targets: &Targets, pages: &Pages, pipelines: &Pipelines) -> Textures {
        let [width, height] = targets.size;
        let texture = |label, format| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        let (depths, slots) = (texture("depths", DEPTH), texture("slots", SLOT));
        let entry = |binding, sample_type| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Texture {
                sample_type,
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("textures"),
            entries: &[entry(0, wgpu::TextureSampleType::Depth), entry(1, wgpu::TextureSampleType::Uint)],
        });
        let resources = [wgpu::BindingResource::TextureView(&depths), wgpu::BindingResource::TextureView(&slots)];
        Textures {
            bind: kernel::bind(device, "textures", &layout, &resources),
            pipeline: pipeline(device, targets, pages, pipelines),
            depths,
            slots,
            layout,
        }
    }

    /// Draws points, page by page or part by part, after clearing the textures if these are a frame's first.
    pub fn draw<'p>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &Targets,
        parts: impl Iterator<Item = (&'p wgpu::BindGroup, u32)>,
        is_first: bool,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let clear = wgpu::LoadOp::Clear(wgpu::Color::BLACK);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("points"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.slots,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: if is_first { clear } else { wgpu::LoadOp::Load },
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depths,
                depth_ops: Some(wgpu::Operations {
                    load: if is_first { wgpu::LoadOp::Clear(1.0) } else { wgpu::LoadOp::Load },
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            timestamp_writes,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &targets.bind_view, &[]);
        for (bind, len) in parts {
            pass.set_bind_group(1, bind, &[]);
            pass.draw(0..len, 0..1);
        }
    }
}

fn pipeline(device: &wgpu::Device, targets: &Targets, pages: &Pages, pipelines: &Pipelines) -> wgpu::RenderPipeline {
    let module = pipelines.module(device, &modules::POINTS);
    let groups = [&targets.layout_view, &pages.layout];
    let constants = pipelines.constants();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("points"),
        layout: Some(&kernel::pipeline_layout(device, "points", &groups)),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("place"),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::PointList, ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("shade"),
            compilation_options: Default::default(),
            targets: &[Some(SLOT.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
