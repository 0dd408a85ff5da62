//! The pages that hold the points on the GPU: equal in size, added as the store grows, never copied.

use wgpu::BufferUsages;

use crate::{
    device::RenderError,
    gpu::{
        kernel::{self, Binding},
        shaders,
    },
    store::{Encoding, Packing},
};

/// Bytes of a position in the wide encoding: any page may have to be widened.
const WIDE_BYTES: u64 = 12;
/// Bytes of the attributes: red, green, blue, intensity in 16 bits each.
const ATTRIBUTE_BYTES: u64 = 8;
const RECORD_BYTES: u64 = 4;

/// No page is smaller, whatever a header promises.
const MIN_PAGE_POINTS: u32 = 65_536;
/// No page is larger, whatever a device allows (768 MiB in all): the last page that does not fit into
/// memory should not leave much of it unused. Each page costs a look at every visible slot and pixel.
const MAX_PAGE_POINTS: u32 = 1 << 25;

/// What a kernel knows of a page. Layout shared with `shaders/page.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PageUniform {
    pub base: [i32; 3],
    pub first: u32,
    pub bits: [u32; 3],
    pub len: u32,
}

impl PageUniform {
    /// `packing` is that of the packed encoding.
    pub fn new(packing: Option<Packing>, first: u32, len: u32) -> PageUniform {
        let (base, bits) = packing.map_or(([0; 3], [0; 3]), |packing| (packing.base, packing.bits));
        PageUniform { base, first, bits, len }
    }
}

/// Slots `[first, first + len)`.
pub struct Page {
    pub first: u32,
    pub len: u32,
    /// [`Encoding::position_words`] for each point.
    pub positions: wgpu::Buffer,
    /// Two words for each point.
    pub attributes: wgpu::Buffer,
    /// Record number of each point.
    pub records: wgpu::Buffer,
    /// Everything, for the kernels that move points.
    pub bind_all: wgpu::BindGroup,
    /// Positions alone, for the rasterizers.
    pub bind_positions: wgpu::BindGroup,
    /// Everything, read only, for the resolve pass.
    pub bind_resolve: wgpu::BindGroup,
}

/// All pages, and the layouts of their bind groups.
pub struct Pages {
    pages: Vec<Page>,
    /// Of the packed encoding.
    packing: Option<Packing>,
    page_points: u32,
    max_page_points: u32,
    pub layout_all: wgpu::BindGroupLayout,
    pub layout_positions: wgpu::BindGroupLayout,
    pub layout_resolve: wgpu::BindGroupLayout,
}

impl Pages {
    pub fn new(device: &wgpu::Device) -> Pages {
        use Binding::{Read, ReadWrite, Uniform};
        let layout = |label, visibility, bindings: &[Binding]| kernel::layout(device, label, visibility, bindings);
        let compute = wgpu::ShaderStages::COMPUTE;
        let limits = device.limits();
        let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        Pages {
            pages: Vec::new(),
            packing: None,
            page_points: MIN_PAGE_POINTS,
            max_page_points: (bytes / WIDE_BYTES).min(MAX_PAGE_POINTS.into()) as u32,
            layout_all: layout("page", compute, &[Uniform, ReadWrite, ReadWrite, ReadWrite]),
            layout_positions: layout("page positions", compute | wgpu::ShaderStages::VERTEX, &[Uniform, Read]),
            layout_resolve: layout("page attributes", compute, &[Uniform, Read, Read, Read]),
        }
    }

    /// Drops all pages. `points` are to come: pages are made to hold them in equal parts.
    /// `page_points` overrides that. Positions are packed so, or wide.
    pub fn reset(&mut self, points: u64, page_points: Option<u32>, packing: Option<Packing>) {
        self.pages.clear();
        self.packing = packing;
        let count = points.div_ceil(u64::from(self.max_page_points)).max(1);
        let even = points.div_ceil(count).next_multiple_of(64).min(self.max_page_points.into()) as u32;
        self.page_points = page_points.unwrap_or(even.max(MIN_PAGE_POINTS.min(self.max_page_points)));
    }

    /// What packs positions; none in the wide encoding.
    pub fn packing(&self) -> Option<&Packing> {
        self.packing.as_ref()
    }

    pub fn encoding(&self) -> Encoding {
        if self.packing.is_some() { Encoding::Packed } else { Encoding::Wide }
    }

    pub fn iter(&self) -> std::slice::Iter<'_, Page> {
        self.pages.iter()
    }

    pub fn at(&self, index: usize) -> &Page {
        &self.pages[index]
    }

    /// Pages that hold slots of `[start, end)`.
    pub fn holding(&self, start: u32, end: u32) -> &[Page] {
        if start >= end {
            return &[];
        }
        &self.pages[(start / self.page_points) as usize..end.div_ceil(self.page_points) as usize]
    }

    /// Adds pages until `points` fit. `stored` is for the message.
    pub fn grow(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        points: u32,
        stored: u32,
    ) -> Result<(), RenderError> {
        while (self.pages.len() as u64) * u64::from(self.page_points) < u64::from(points) {
            let page = match self.page(device, queue) {
                Ok(page) => page,
                // All pages have one size, so only the first can ask for less.
                Err(_) if self.pages.is_empty() && self.page_points > MIN_PAGE_POINTS => {
                    self.page_points = (self.page_points / 2).next_multiple_of(64);
                    continue;
                }
                Err(detail) => return Err(RenderError::OutOfMemory { stored: stored.into(), detail }),
            };
            self.pages.push(page);
        }
        Ok(())
    }

    fn page(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Page, String> {
        let first = self.pages.len() as u32 * self.page_points;
        let len = self.page_points.min(u32::MAX - first);
        // A buffer that memory has no room for may not be bound: that would be an error of its own.
        let [positions, attributes, records] = kernel::in_memory(device, || {
            [
                positions_buffer(device, len, self.encoding()),
                column(device, "attributes", len, ATTRIBUTE_BYTES),
                column(device, "records", len, RECORD_BYTES),
            ]
        })?;
        Ok(self.bind(device, queue, [first, len], [positions, attributes, records]))
    }

    /// The page of these columns, in the encoding that the store has now.
    fn bind(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        [first, len]: [u32; 2],
        [positions, attributes, records]: [wgpu::Buffer; 3],
    ) -> Page {
        let uniform = kernel::uniform(device, "page", size_of::<PageUniform>() as u64);
        queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&PageUniform::new(self.packing, first, len)));
        let all = [&uniform, &positions, &attributes, &records];
        Page {
            first,
            len,
            bind_all: kernel::bind_buffers(device, "page", &self.layout_all, &all),
            bind_positions: kernel::bind_buffers(device, "page positions", &self.layout_positions, &all[..2]),
            bind_resolve: kernel::bind_buffers(device, "page attributes", &self.layout_resolve, &all),
            positions,
            attributes,
            records,
        }
    }

    /// From the packed encoding to the wide one, for good: a point lies outside of the box. The slots `[0, stored)` hold
    /// points.
    ///
    /// # Errors
    /// The device's message if memory has no room for it; nothing has changed then.
    pub fn widen(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, stored: u32) -> Result<(), String> {
        let wide = kernel::in_memory(device, || {
            let wide = |page: &Page| positions_buffer(device, page.len, Encoding::Wide);
            self.pages.iter().map(wide).collect::<Vec<_>>()
        })?;
        let compute = wgpu::ShaderStages::COMPUTE;
        let layout = kernel::layout(device, "widen", compute, &[Binding::ReadWrite, Binding::Uniform]);
        let groups = [&layout, &self.layout_positions];
        let pipeline = kernel::compute(device, &shaders::WIDEN.module(device), "widen", &groups);
        self.packing = None;
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut widened = Vec::new();
        for (page, wide) in std::mem::take(&mut self.pages).into_iter().zip(wide) {
            let slots = stored.saturating_sub(page.first).min(page.len);
            let count = kernel::uniform(device, "slots", 16);
            queue.write_buffer(&count, 0, bytemuck::cast_slice(&[slots, 0, 0, 0]));
            let bind = kernel::bind_buffers(device, "widen", &layout, &[&wide, &count]);
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &bind, &[]);
            pass.set_bind_group(1, &page.bind_positions, &[]);
            kernel::dispatch(&mut pass, slots);
            drop(pass);
            widened.push(self.bind(device, queue, [page.first, page.len], [wide, page.attributes, page.records]));
        }
        queue.submit([encoder.finish()]);
        self.pages = widened;
        Ok(())
    }
}

fn column(device: &wgpu::Device, label: &str, len: u32, bytes: u64) -> wgpu::Buffer {
    kernel::buffer(device, label, u64::from(len) * bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC)
}

fn positions_buffer(device: &wgpu::Device, len: u32, encoding: Encoding) -> wgpu::Buffer {
    column(device, "positions", len, 4 * u64::from(encoding.position_words()))
}
