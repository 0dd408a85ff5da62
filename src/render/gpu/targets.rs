//! Everything whose size is that of the picture.

use wgpu::BufferUsages;

use crate::{
    gpu::kernel::{self, Binding},
    render::{Picture, RenderError},
};

/// Words and what becomes of them; row by row from the top.
pub struct Targets {
    pub size: [u32; 2],
    /// Depth (upper half) and slot (lower half) of each pixel.
    pub words: wgpu::Buffer,
    /// Colours before lighting, red in the lowest byte.
    pub colors: wgpu::Buffer,
    /// Colours after lighting.
    pub picture: wgpu::Buffer,
    /// Record that each pixel shows; filled for a read-back.
    pub records: wgpu::Buffer,
    /// For kernels that write words.
    pub binds_write: WriteBinds,
    /// View and words, for kernels that read them.
    pub bind_read: wgpu::BindGroup,
}

/// The layouts of [`Targets`]' bind groups.
pub struct TargetLayouts {
    pub write: wgpu::BindGroupLayout,
    /// The words twice, see `shaders/early.wgsl`.
    pub write_early: wgpu::BindGroupLayout,
    pub read: wgpu::BindGroupLayout,
}

impl TargetLayouts {
    pub fn new(device: &wgpu::Device) -> TargetLayouts {
        use Binding::{Read, ReadWrite, Uniform};
        TargetLayouts {
            write: kernel::layout(device, "words", wgpu::ShaderStages::COMPUTE, &[Uniform, ReadWrite]),
            write_early: kernel::layout(
                device,
                "words, early test",
                wgpu::ShaderStages::COMPUTE,
                &[Uniform, ReadWrite, ReadWrite],
            ),
            read: kernel::layout(device, "words, read", wgpu::ShaderStages::COMPUTE, &[Uniform, Read]),
        }
    }
}

/// View and words, for kernels that write words.
pub struct WriteBinds {
    pub plain: wgpu::BindGroup,
    /// For kernels with the early test.
    pub early: wgpu::BindGroup,
}

impl WriteBinds {
    pub fn new(device: &wgpu::Device, layouts: &TargetLayouts, view: &wgpu::Buffer, words: &wgpu::Buffer) -> Self {
        WriteBinds {
            plain: kernel::bind_buffers(device, "words", &layouts.write, &[view, words]),
            early: kernel::bind_buffers(device, "words, early test", &layouts.write_early, &[view, words, words]),
        }
    }
}

impl Targets {
    pub fn new(
        device: &wgpu::Device,
        layouts: &TargetLayouts,
        view: &wgpu::Buffer,
        size: [u32; 2],
    ) -> Result<Targets, RenderError> {
        let [width, height] = size;
        let pixels = u64::from(width) * u64::from(height);
        let limits = device.limits();
        let limit = (limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) / 8).min(1 << 31);
        if pixels > limit || width.max(height) > limits.max_texture_dimension_2d {
            return Err(RenderError::TooManyPixels { width, height, limit });
        }
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let buffer = |label, bytes: u64| kernel::buffer(device, label, pixels * bytes, storage);
        let [words, colors, picture, records] = kernel::in_memory(device, || {
            [buffer("words", 8), buffer("colors", 4), buffer("picture", 4), buffer("records", 4)]
        })
        .map_err(|detail| RenderError::NoMemoryForPicture { width, height, detail })?;
        Ok(Targets {
            size,
            binds_write: WriteBinds::new(device, layouts, view, &words),
            bind_read: kernel::bind_buffers(device, "words, read", &layouts.read, &[view, &words]),
            words,
            colors,
            picture,
            records,
        })
    }

    pub fn pixels(&self) -> u32 {
        self.size[0] * self.size[1]
    }

    /// Submits the encoder's commands, waits for the device and brings the frame back; `records` must
    /// be filled then.
    pub fn read(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: wgpu::CommandEncoder,
    ) -> Result<Picture, RenderError> {
        let [words, picture, records] =
            kernel::read_all(device, queue, encoder, [&self.words, &self.picture, &self.records])?;
        let is_background = |word: &[u32; 2]| word[0] == u32::MAX;
        let words: &[[u32; 2]] = bytemuck::cast_slice(&words);
        let record = |(word, &record)| if is_background(word) { -1 } else { i64::from(record) };
        let depth = |word| if is_background(word) { f32::INFINITY } else { f32::from_bits(word[1]) };
        Ok(Picture {
            width: self.size[0],
            height: self.size[1],
            rgba: bytemuck::cast_slice(&picture).to_vec(),
            records: words.iter().zip(&records).map(record).collect(),
            depth: words.iter().map(depth).collect(),
        })
    }
}
