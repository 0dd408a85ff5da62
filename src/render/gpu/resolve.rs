//! Resolve: from the slots that won to colours, then eye-dome lighting.

use super::{
    color::ColorTables,
    columns::Columns,
    targets::{TargetLayouts, Targets},
};
use crate::{
    gpu::{
        kernel::{self, Binding},
        shaders,
        timing::{FrameTimer, Stage},
    },
    render::{ColumnColors, FramePlan, shading::EDL_GAIN},
    store::{Encoding, gpu::Pages},
};

/// Lighting in numbers for the kernel. Layout shared with `shaders/light.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ShadingUniform {
    pub edl_factor: f32,
    pub background: u32,
    pub unused_a: u32,
    pub unused_b: u32,
}

/// Where the colours of a frame are from.
pub enum ColorSource<'a> {
    /// Each file's rule.
    Files,
    /// The pipeline that colours by averages, and the bind group of their sums.
    Averages(&'a wgpu::ComputePipeline, &'a wgpu::BindGroup),
    Column(&'a Columns, &'a ColumnColors),
}

/// The resolve pass.
pub struct Resolve {
    points: PointPipelines,
    light: wgpu::ComputePipeline,
    /// Fills holes, once that was asked for; and whether this frame does.
    holes: Option<wgpu::ComputePipeline>,
    fills_holes: bool,
    /// Of what is written: colours and records.
    pub layout_colors: wgpu::BindGroupLayout,
    layout_light: wgpu::BindGroupLayout,
    /// The words, and the picture.
    layout_holes: [wgpu::BindGroupLayout; 2],
    pub tables: ColorTables,
    shading: wgpu::Buffer,
}

/// What reads points, in one encoding.
struct PointPipelines {
    encoding: Encoding,
    color: wgpu::ComputePipeline,
    identify: wgpu::ComputePipeline,
    blank: wgpu::ComputePipeline,
}

impl Resolve {
    pub fn new(device: &wgpu::Device, layouts: &TargetLayouts, pages: &Pages) -> Resolve {
        use Binding::{Read, ReadWrite, Uniform};
        let compute = wgpu::ShaderStages::COMPUTE;
        let layout_colors = kernel::layout(device, "colors", compute, &[ReadWrite, ReadWrite]);
        let layout_light = kernel::layout(device, "light", compute, &[Uniform, Read, ReadWrite]);
        let light = shaders::LIGHT.module(device);
        let tables = ColorTables::new(device);
        let groups = [&layouts.read, &pages.layout_resolve, &layout_colors, &tables.layout];
        Resolve {
            // That of most scenes.
            points: PointPipelines::new(device, groups, Encoding::Packed),
            light: kernel::compute(device, &light, "light", &[&layouts.read, &layout_light]),
            shading: kernel::uniform(device, "shading", size_of::<ShadingUniform>() as u64),
            holes: None,
            fills_holes: false,
            layout_colors,
            layout_light,
            layout_holes: [layouts.read.clone(), kernel::layout(device, "holes", compute, &[ReadWrite])],
            tables,
        }
    }

    /// For pages in this encoding from now on.
    pub fn set_encoding(&mut self, device: &wgpu::Device, layouts: &TargetLayouts, pages: &Pages) {
        if self.points.encoding != pages.encoding() {
            let groups = [&layouts.read, &pages.layout_resolve, &self.layout_colors, &self.tables.layout];
            self.points = PointPipelines::new(device, groups, pages.encoding());
        }
    }

    /// Uploads the colours and the shading of a frame; true if the colours are others than the last frame's.
    pub fn prepare(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, plan: &FramePlan) -> bool {
        let [r, g, b] = plan.shading.background;
        let uniform = ShadingUniform {
            edl_factor: EDL_GAIN * plan.shading.edl_strength,
            background: u32::from_le_bytes([r, g, b, 255]),
            unused_a: 0,
            unused_b: 0,
        };
        queue.write_buffer(&self.shading, 0, bytemuck::bytes_of(&uniform));
        self.fills_holes = plan.shading.fill_holes;
        if self.fills_holes && self.holes.is_none() {
            let [words, picture] = &self.layout_holes;
            let module = shaders::HOLES.module(device);
            self.holes = Some(kernel::compute(device, &module, "fill_holes", &[words, picture]));
        }
        self.tables.prepare(device, queue, &plan.colors)
    }

    pub fn record(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut FrameTimer,
        targets: &Targets,
        pages: &Pages,
        by: ColorSource<'_>,
    ) {
        let mut pass = timer.compute_pass(encoder, Stage::Resolve);
        match by {
            ColorSource::Files => {
                self.record_pages(device, &mut pass, &self.points.color, &targets.bind_read, targets, pages);
            }
            ColorSource::Averages(pipeline, sums) => {
                self.record_pages(device, &mut pass, pipeline, sums, targets, pages);
            }
            ColorSource::Column(columns, colors) => {
                self.record_pages(device, &mut pass, &self.points.blank, &targets.bind_read, targets, pages);
                // Of what is written, `record_pages` has bound group 2.
                columns.record(&mut pass, targets, colors);
            }
        }
        let buffers = [&self.shading, &targets.colors, &targets.picture];
        let bind = kernel::bind_buffers(device, "light", &self.layout_light, &buffers);
        pass.set_pipeline(&self.light);
        pass.set_bind_group(0, &targets.bind_read, &[]);
        pass.set_bind_group(1, &bind, &[]);
        kernel::dispatch(&mut pass, targets.pixels());
        if let Some(holes) = self.holes.as_ref().filter(|_| self.fills_holes) {
            let bind = kernel::bind_buffers(device, "holes", &self.layout_holes[1], &[&targets.picture]);
            pass.set_pipeline(holes);
            pass.set_bind_group(1, &bind, &[]);
            kernel::dispatch(&mut pass, targets.pixels());
        }
    }

    /// Fills the targets' records, for a read-back.
    pub fn record_identify(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        targets: &Targets,
        pages: &Pages,
    ) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        self.record_pages(device, &mut pass, &self.points.identify, &targets.bind_read, targets, pages);
    }

    fn record_pages(
        &self,
        device: &wgpu::Device,
        pass: &mut wgpu::ComputePass<'_>,
        pipeline: &wgpu::ComputePipeline,
        bind_words: &wgpu::BindGroup,
        targets: &Targets,
        pages: &Pages,
    ) {
        let buffers = [&targets.colors, &targets.records];
        let bind = kernel::bind_buffers(device, "colors", &self.layout_colors, &buffers);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, bind_words, &[]);
        pass.set_bind_group(2, &bind, &[]);
        pass.set_bind_group(3, &self.tables.bind, &[]);
        for page in pages.iter() {
            pass.set_bind_group(1, &page.bind_resolve, &[]);
            kernel::dispatch(pass, targets.pixels());
        }
    }
}

impl PointPipelines {
    /// `groups`: of words, of a page, of what is written, of colours.
    fn new(device: &wgpu::Device, groups: [&wgpu::BindGroupLayout; 4], encoding: Encoding) -> PointPipelines {
        let module = shaders::RESOLVE.module_in(device, encoding);
        let coloring = |entry| kernel::compute(device, &module, entry, &groups);
        PointPipelines { encoding, color: coloring("color"), identify: coloring("identify"), blank: coloring("blank") }
    }
}
