//! The pages that hold the points on the GPU: equal in size, added as the store grows, never copied.

use wgpu::BufferUsages;

use crate::{
    device::RenderError,
    gpu::kernel::{self, Binding},
};

/// Bytes of a position: three 32-bit integers on the scene's grid.
const POSITION_BYTES: u64 = 12;
/// Bytes of the attributes: red, green, blue, intensity in 16 bits each.
const ATTRIBUTE_BYTES: u64 = 8;
const RECORD_BYTES: u64 = 4;

/// No page is smaller, whatever a header promises.
const MIN_PAGE_POINTS: u32 = 65_536;
/// No page is larger, whatever a device allows (768 MiB in all): the last page that does not fit into
/// memory should not leave much of it unused. Each page costs a look at every visible slot and pixel.
const MAX_PAGE_POINTS: u32 = 1 << 25;

/// Slots `[first, first + len)`.
pub struct Page {
    pub first: u32,
    pub len: u32,
    /// Three words for each point.
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
            page_points: MIN_PAGE_POINTS,
            max_page_points: (bytes / POSITION_BYTES).min(MAX_PAGE_POINTS.into()) as u32,
            layout_all: layout("page", compute, &[Uniform, ReadWrite, ReadWrite, ReadWrite]),
            layout_positions: layout("page positions", compute | wgpu::ShaderStages::VERTEX, &[Uniform, Read]),
            layout_resolve: layout("page attributes", compute, &[Uniform, Read, Read, Read]),
        }
    }

    /// Drops all pages. `points` are to come: pages are made to hold them in equal parts.
    /// `page_points` overrides that.
    pub fn reset(&mut self, points: u64, page_points: Option<u32>) {
        self.pages.clear();
        let count = points.div_ceil(u64::from(self.max_page_points)).max(1);
        let even = points.div_ceil(count).next_multiple_of(64).min(self.max_page_points.into()) as u32;
        self.page_points = page_points.unwrap_or(even.max(MIN_PAGE_POINTS.min(self.max_page_points)));
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
        let column = |label, bytes| {
            kernel::buffer(device, label, u64::from(len) * bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC)
        };
        // A buffer that memory has no room for may not be bound: that would be an error of its own.
        let [uniform, positions, attributes, records] = kernel::in_memory(device, || {
            [
                kernel::uniform(device, "page", 16),
                column("positions", POSITION_BYTES),
                column("attributes", ATTRIBUTE_BYTES),
                column("records", RECORD_BYTES),
            ]
        })?;
        queue.write_buffer(&uniform, 0, bytemuck::cast_slice(&[first, len, 0, 0]));
        let all = [&uniform, &positions, &attributes, &records];
        Ok(Page {
            first,
            len,
            bind_all: kernel::bind_buffers(device, "page", &self.layout_all, &all),
            bind_positions: kernel::bind_buffers(device, "page positions", &self.layout_positions, &all[..2]),
            bind_resolve: kernel::bind_buffers(device, "page attributes", &self.layout_resolve, &all),
            positions,
            attributes,
            records,
        })
    }
}
