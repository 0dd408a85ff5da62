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
    /// One bit for each point that a filter hides; four bytes while there is none.
    pub hidden: wgpu::Buffer,
    uniform: wgpu::Buffer,
    /// Everything, for the kernels that move points.
    pub bind_all: wgpu::BindGroup,
    /// Positions and what is hidden, for the rasterizers.
    pub bind_positions: wgpu::BindGroup,
    /// Everything but what is hidden, read only, for the resolve pass.
    pub bind_resolve: wgpu::BindGroup,
    /// Everything, read only, for averages.
    pub bind_average: wgpu::BindGroup,
    /// Everything, with what is hidden to be written; none without a filter.
    pub bind_mask: Option<wgpu::BindGroup>,
}

/// All pages, and the layouts of their bind groups.
pub struct Pages {
    pages: Vec<Page>,
    /// Of the packed encoding.
    packing: Option<Packing>,
    page_points: u32,
    max_page_points: u32,
    /// A filter is set: pages have a bit for each point.
    is_masked: bool,
    no_mask: wgpu::Buffer,
    pub layout_all: wgpu::BindGroupLayout,
    pub layout_positions: wgpu::BindGroupLayout,
    pub layout_resolve: wgpu::BindGroupLayout,
    pub layout_average: wgpu::BindGroupLayout,
    pub layout_mask: wgpu::BindGroupLayout,
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
            layout_positions: layout("page positions", compute | wgpu::ShaderStages::VERTEX, &[Uniform, Read, Read]),
            layout_resolve: layout("page attributes", compute, &[Uniform, Read, Read, Read]),
            layout_average: layout("page averages", compute, &[Uniform, Read, Read, Read, Read]),
            layout_mask: layout("page mask", compute, &[Uniform, Read, Read, Read, ReadWrite]),
            is_masked: false,
            no_mask: kernel::buffer(device, "no mask", 4, BufferUsages::STORAGE),
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

    /// Whether pages have a bit for each point, to hide it.
    pub fn is_masked(&self) -> bool {
        self.is_masked
    }

    /// Gives all pages bits, of which none is set, or takes them away.
    ///
    /// # Errors
    /// The device's message if it has no memory for them; nothing has changed then.
    pub fn set_masked(&mut self, device: &wgpu::Device, on: bool) -> Result<(), String> {
        let masks = self.pages.iter().map(|page| self.mask(device, page.len, on)).collect::<Result<Vec<_>, _>>()?;
        self.is_masked = on;
        for (index, hidden) in masks.into_iter().enumerate() {
            let Page { first, len, uniform, positions, attributes, records, .. } = &self.pages[index];
            let columns = [uniform, positions, attributes, records].map(wgpu::Buffer::clone);
            self.pages[index] = self.bound(device, [*first, *len], columns, hidden);
        }
        Ok(())
    }

    fn mask(&self, device: &wgpu::Device, points: u32, on: bool) -> Result<wgpu::Buffer, String> {
        if !on {
            return Ok(self.no_mask.clone());
        }
        let bytes = u64::from(points.div_ceil(32)) * 4;
        kernel::in_memory(device, || {
            kernel::buffer(device, "hidden", bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC)
        })
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
        let hidden = self.mask(device, len, self.is_masked)?;
        let uniform = self.uniform(device, queue, first, len);
        Ok(self.bound(device, [first, len], [uniform, positions, attributes, records], hidden))
    }

    /// A page's uniform, in the encoding that the store has now.
    fn uniform(&self, device: &wgpu::Device, queue: &wgpu::Queue, first: u32, len: u32) -> wgpu::Buffer {
        let uniform = kernel::uniform(device, "page", size_of::<PageUniform>() as u64);
        queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&PageUniform::new(self.packing, first, len)));
        uniform
    }

    /// A page of these columns: its uniform, positions, attributes and records.
    fn bound(
        &self,
        device: &wgpu::Device,
        [first, len]: [u32; 2],
        columns: [wgpu::Buffer; 4],
        hidden: wgpu::Buffer,
    ) -> Page {
        let [uniform, positions, attributes, records] = &columns;
        let all = [uniform, positions, attributes, records, &hidden];
        let bind = |label, layout, buffers: &[&wgpu::Buffer]| kernel::bind_buffers(device, label, layout, buffers);
        let bind_all = bind("page", &self.layout_all, &all[..4]);
        let bind_positions = bind("page positions", &self.layout_positions, &[uniform, positions, &hidden]);
        let bind_resolve = bind("page attributes", &self.layout_resolve, &all[..4]);
        let bind_average = bind("page averages", &self.layout_average, &all);
        let bind_mask = self.is_masked.then(|| bind("page mask", &self.layout_mask, &all));
        let [uniform, positions, attributes, records] = columns;
        Page {
            first,
            len,
            positions,
            attributes,
            records,
            hidden,
            uniform,
            bind_all,
            bind_positions,
            bind_resolve,
            bind_average,
            bind_mask,
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
            let uniform = self.uniform(device, queue, page.first, page.len);
            let columns = [uniform, wide, page.attributes, page.records];
            widened.push(self.bound(device, [page.first, page.len], columns, page.hidden));
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
