//! Puts the picture buffer on the window's surface, pixel for pixel, colours unchanged.

use eframe::{
    egui::{PaintCallback, PaintCallbackInfo, Rect},
    egui_wgpu::{Callback, CallbackResources, CallbackTrait},
};
use wgpu::util::DeviceExt as _;

/// Layout shared with `shaders/blit.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Frame {
    size: [u32; 2],
    background: u32,
    target_is_srgb: u32,
}

/// The pipeline, and the picture that it is bound to.
pub struct Blit {
    device: wgpu::Device,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    target_is_srgb: bool,
    bound: Option<Bound>,
}

struct Bound {
    picture: wgpu::Buffer,
    size: [u32; 2],
    background: [u8; 3],
    group: wgpu::BindGroup,
}

impl Blit {
    pub fn new(device: &wgpu::Device, target: wgpu::TextureFormat) -> Blit {
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("blit"),
            source: wgpu::ShaderSource::Wgsl(include_str!("../../shaders/blit.wgsl").into()),
        });
        let buffer = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("blit"),
            entries: &[
                buffer(0, wgpu::BufferBindingType::Storage { read_only: true }),
                buffer(1, wgpu::BufferBindingType::Uniform),
            ],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("blit"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("blit"),
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &shader,
                entry_point: Some("blit_vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &shader,
                entry_point: Some("blit_fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(target.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Blit { device: device.clone(), layout, pipeline, target_is_srgb: target.is_srgb(), bound: None }
    }

    /// What egui is to paint over `rect`, which must start at the window's corner.
    pub fn paint(&mut self, rect: Rect, picture: &wgpu::Buffer, size: [u32; 2], background: [u8; 3]) -> PaintCallback {
        Callback::new_paint_callback(rect, self.draw(picture, size, background))
    }

    fn draw(&mut self, picture: &wgpu::Buffer, size: [u32; 2], background: [u8; 3]) -> Draw {
        let fits = |b: &Bound| b.picture == *picture && b.size == size && b.background == background;
        let bound = match self.bound.take().filter(fits) {
            Some(bound) => bound,
            None => self.bind(picture, size, background),
        };
        let draw = Draw { pipeline: self.pipeline.clone(), group: bound.group.clone() };
        self.bound = Some(bound);
        draw
    }

    fn bind(&self, picture: &wgpu::Buffer, size: [u32; 2], background: [u8; 3]) -> Bound {
        let [r, g, b] = background;
        let frame =
            Frame { size, background: u32::from_le_bytes([r, g, b, 255]), target_is_srgb: self.target_is_srgb.into() };
        let uniform = self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("blit frame"),
            contents: bytemuck::bytes_of(&frame),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("blit"),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: picture.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: uniform.as_entire_binding() },
            ],
        });
        Bound { picture: picture.clone(), size, background, group }
    }
}

/// One frame's draw call.
struct Draw {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
}

impl Draw {
    fn record(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

impl CallbackTrait for Draw {
    fn paint(&self, _: PaintCallbackInfo, pass: &mut wgpu::RenderPass<'static>, _: &CallbackResources) {
        self.record(pass);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device() -> Option<(wgpu::Device, wgpu::Queue)> {
        let instance = wgpu::Instance::default();
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
        let found = adapter
            .ok()
            .and_then(|adapter| pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default())).ok());
        if found.is_none() {
            assert!(std::env::var_os("FIRSTLIGHT_REQUIRE_GPU").is_none(), "no GPU adapter");
            eprintln!("SKIPPED: no GPU adapter; the blit was not tested");
        }
        found
    }

    /// Every level of every channel, and one column more than the picture has.
    #[test]
    fn colours_come_out_unchanged_on_linear_and_srgb_targets() {
        let Some((device, queue)) = device() else { return };
        let background = [24, 28, 34];
        let size = [63, 5];
        let pixels: Vec<[u8; 4]> =
            (0..63 * 5_u32).map(|i| [i as u8, (255 - i % 256) as u8, (i * 7) as u8, 255]).collect();
        let picture = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: bytemuck::cast_slice(&pixels),
            usage: wgpu::BufferUsages::STORAGE,
        });
        for format in [wgpu::TextureFormat::Rgba8Unorm, wgpu::TextureFormat::Rgba8UnormSrgb] {
            let draw = Blit::new(&device, format).draw(&picture, size, background);
            let shown = render(&device, &queue, format, &draw);
            for (at, pixel) in shown.iter().enumerate() {
                let (x, y) = (at % 64, at / 64);
                let [r, g, b] = background;
                let expected = if x < 63 && y < 5 { pixels[y * 63 + x] } else { [r, g, b, 255] };
                assert_eq!(*pixel, expected, "{format:?} at {x}, {y}");
            }
        }
    }

    /// 64 × 6 pixels.
    fn render(device: &wgpu::Device, queue: &wgpu::Queue, format: wgpu::TextureFormat, draw: &Draw) -> Vec<[u8; 4]> {
        let extent = wgpu::Extent3d { width: 64, height: 6, depth_or_array_layers: 1 };
        let target = device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: extent,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let readback = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 256 * 6,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let attachment = wgpu::RenderPassColorAttachment {
            view: &view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations::default(),
        };
        draw.record(&mut encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(attachment)],
            ..Default::default()
        }));
        encoder.copy_texture_to_buffer(
            target.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &readback,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(256), rows_per_image: None },
            },
            extent,
        );
        queue.submit([encoder.finish()]);
        readback.slice(..).map_async(wgpu::MapMode::Read, |mapped| mapped.expect("mapped"));
        device.poll(wgpu::PollType::wait_indefinitely()).expect("poll");
        let bytes = readback.slice(..).get_mapped_range().expect("range").to_vec();
        bytemuck::cast_slice(&bytes).to_vec()
    }
}
