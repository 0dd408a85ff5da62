//! Values by record number on the GPU, see [`crate::render::ColumnColors`]: pages of keys, made when a value comes for
//! them, and the kernels that fill them and colour by them.

use wgpu::BufferUsages;

use super::targets::{TargetLayouts, Targets};
use crate::{
    gpu::{
        kernel::{self, Binding},
        shaders,
    },
    render::{ColumnColors, ColumnId, Keys, Lookup, RenderError},
    scene::BATCH_POINTS,
};

/// Batches that wait for the next submission at most: 13 MB of staging.
const STAGED_BATCHES: usize = 16;

/// Most records of a page, whatever a device allows: 256 MiB of wide keys.
const MAX_PAGE_RECORDS: u32 = 1 << 25;
/// No page is smaller, whatever a header promises.
const MIN_PAGE_RECORDS: u32 = 65_536;

/// A page's keys, to be written and to be read.
struct ColumnPage {
    bind: wgpu::BindGroup,
    bind_read: wgpu::BindGroup,
}

/// Values of one attribute.
struct Column {
    is_wide: bool,
    /// Page `i` holds the records from `i` times the page's size on; there may be none yet.
    pages: Vec<Option<ColumnPage>>,
}

/// A batch on its way.
struct Staging {
    uniform: wgpu::Buffer,
    words: wgpu::Buffer,
    bind: wgpu::BindGroup,
}

struct Staged {
    column: ColumnId,
    points: u32,
    /// Its pages.
    pages: std::ops::RangeInclusive<usize>,
}

/// All columns of a scene.
pub struct Columns {
    device: wgpu::Device,
    queue: wgpu::Queue,
    columns: Vec<Option<Column>>,
    page_records: u32,
    forced_page_records: Option<u32>,
    ring: Vec<Staging>,
    staged: Vec<Staged>,
    layout_staged: wgpu::BindGroupLayout,
    layout_write: wgpu::BindGroupLayout,
    /// A page, to be read: its uniform and its keys.
    pub layout_read: wgpu::BindGroupLayout,
    /// Eight bytes for pages without keys.
    no_keys: wgpu::Buffer,
    fill_small: wgpu::ComputePipeline,
    fill_wide: wgpu::ComputePipeline,
    by_table: wgpu::ComputePipeline,
    by_small_scale: wgpu::ComputePipeline,
    by_wide_scale: wgpu::ComputePipeline,
    scale: wgpu::Buffer,
    bind_scale: wgpu::BindGroup,
}

/// The scale of a column in numbers. Layout shared with `shaders/column.wgsl`, where four numbers make a vector.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ColumnScaleUniform {
    pub high: [u32; 256],
    pub low: [u32; 256],
    pub colors: [[u8; 4]; 256],
}

impl Columns {
    /// `layout_colors` is that of the resolve pass's outputs.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layouts: &TargetLayouts,
        layout_colors: &wgpu::BindGroupLayout,
    ) -> Columns {
        use Binding::{Read, ReadWrite, Uniform};
        let compute = wgpu::ShaderStages::COMPUTE;
        let layout = |label, bindings: &[Binding]| kernel::layout(device, label, compute, bindings);
        let layout_staged = layout("staged values", &[Uniform, Read]);
        let layout_write = layout("column, written", &[Uniform, ReadWrite]);
        let layout_read = layout("column", &[Uniform, Read]);
        let layout_scale = layout("column's scale", &[Uniform]);
        let (fill, color) = (shaders::FILL_COLUMN.module(device), shaders::COLUMN.module(device));
        let filling = |entry| kernel::compute(device, &fill, entry, &[&layout_staged, &layout_write]);
        let groups = [&layouts.read, &layout_read, layout_colors, &layout_scale];
        let coloring = |entry| kernel::compute(device, &color, entry, &groups);
        let scale = kernel::uniform(device, "column's scale", size_of::<ColumnScaleUniform>() as u64);
        Columns {
            fill_small: filling("fill_small"),
            fill_wide: filling("fill_wide"),
            by_table: coloring("by_table"),
            by_small_scale: coloring("by_small_scale"),
            by_wide_scale: coloring("by_wide_scale"),
            bind_scale: kernel::bind_buffers(device, "column's scale", &layout_scale, &[&scale]),
            scale,
            columns: Vec::new(),
            page_records: MIN_PAGE_RECORDS,
            forced_page_records: None,
            ring: Vec::new(),
            staged: Vec::new(),
            layout_staged,
            layout_write,
            layout_read,
            no_keys: kernel::buffer(device, "no keys", 8, BufferUsages::STORAGE),
            device: device.clone(),
            queue: queue.clone(),
        }
    }

    /// Size of the pages of scenes to come; by default as large as the device allows.
    pub fn set_page_records(&mut self, records: Option<u32>) {
        self.forced_page_records = records;
    }

    /// Drops all columns; `points` are to come.
    pub fn reset(&mut self, points: u64) {
        self.columns.clear();
        self.staged.clear();
        let limits = self.device.limits();
        let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let most = (bytes / 8).min(MAX_PAGE_RECORDS.into());
        let usual = points.next_multiple_of(64).clamp(MIN_PAGE_RECORDS.into(), most.max(MIN_PAGE_RECORDS.into()));
        self.page_records = self.forced_page_records.unwrap_or(usual.min(most) as u32);
    }

    /// Frees a column. What is on its way into it goes nowhere: if the column comes again, with fewer pages so far and
    /// perhaps wider, so do its values.
    pub fn drop_column(&mut self, column: ColumnId) {
        self.staged.iter_mut().filter(|staged| staged.column == column).for_each(|staged| staged.points = 0);
        if let Some(place) = self.columns.get_mut(column) {
            *place = None;
        }
    }

    /// Uploads keys, to be put in their places by [`Columns::record_fill`].
    ///
    /// # Errors
    /// If memory has no room for them.
    pub fn stage(&mut self, column: ColumnId, records: &[u32], keys: Keys<'_>) -> Result<(), RenderError> {
        let is_wide = matches!(keys, Keys::Wide(_));
        let refusal = |detail| RenderError::NoMemoryForValues { detail };
        let (Some(&first), Some(&last)) = (records.iter().min(), records.iter().max()) else { return Ok(()) };
        assert_eq!(records.len(), keys.len());
        assert!(records.len() <= BATCH_POINTS, "{} values", records.len());
        let pages = (first / self.page_records) as usize..=(last / self.page_records) as usize;
        self.make_room(column, is_wide, pages.clone()).map_err(refusal)?;
        if self.staged.len() == STAGED_BATCHES {
            self.flush();
        }
        if self.ring.len() == self.staged.len() {
            let staging = self.staging().map_err(refusal)?;
            self.ring.push(staging);
        }
        let staging = &self.ring[self.staged.len()];
        let points = records.len() as u32;
        self.queue.write_buffer(&staging.uniform, 0, bytemuck::cast_slice(&[points, BATCH_POINTS as u32, 0, 0]));
        self.queue.write_buffer(&staging.words, 0, bytemuck::cast_slice(records));
        let keys: &[u8] = match keys {
            Keys::Small(keys) => bytemuck::cast_slice(keys),
            Keys::Wide(keys) => bytemuck::cast_slice(keys),
        };
        self.queue.write_buffer(&staging.words, 4 * BATCH_POINTS as u64, keys);
        self.staged.push(Staged { column, points, pages });
        Ok(())
    }

    /// Makes the pages of a column that are missing.
    fn make_room(
        &mut self,
        column: ColumnId,
        is_wide: bool,
        pages: std::ops::RangeInclusive<usize>,
    ) -> Result<(), String> {
        if self.columns.len() <= column {
            self.columns.resize_with(column + 1, || None);
        }
        let place = self.columns[column].get_or_insert_with(|| Column { is_wide, pages: Vec::new() });
        assert_eq!(place.is_wide, is_wide, "a column's keys are of one kind");
        if place.pages.len() <= *pages.end() {
            place.pages.resize_with(pages.end() + 1, || None);
        }
        for index in pages {
            if place.pages[index].is_none() {
                let first = index as u32 * self.page_records;
                let len = self.page_records.min(u32::MAX - first);
                let bytes = u64::from(len) * if is_wide { 8 } else { 4 };
                let device = &self.device;
                let (uniform, keys) = kernel::in_memory(device, || {
                    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
                    (kernel::uniform(device, "column page", 16), kernel::buffer(device, "column", bytes, usage))
                })?;
                self.queue.write_buffer(&uniform, 0, bytemuck::cast_slice(&[first, len, 0, 0]));
                let bind = |layout| kernel::bind_buffers(device, "column", layout, &[&uniform, &keys]);
                let (bind, bind_read) = (bind(&self.layout_write), bind(&self.layout_read));
                place.pages[index] = Some(ColumnPage { bind, bind_read });
            }
        }
        Ok(())
    }

    /// All records of the scene in pages: those of a column that there are, to be read, and between and behind them
    /// pages without keys, where every key reads as 0.
    pub fn whole(&self, column: ColumnId) -> Vec<wgpu::BindGroup> {
        let no_pages = Vec::new();
        let pages = self.columns.get(column).and_then(Option::as_ref).map_or(&no_pages, |column| &column.pages);
        let mut binds = Vec::new();
        let mut next = 0;
        for (index, page) in pages.iter().enumerate() {
            let Some(page) = page else { continue };
            let first = index as u32 * self.page_records;
            if next < first {
                binds.push(self.without_keys(next, first - next));
            }
            binds.push(page.bind_read.clone());
            next = first.saturating_add(self.page_records);
        }
        binds.push(self.without_keys(next, u32::MAX - next));
        binds
    }

    fn without_keys(&self, first: u32, len: u32) -> wgpu::BindGroup {
        let uniform = kernel::uniform(&self.device, "no keys", 16);
        self.queue.write_buffer(&uniform, 0, bytemuck::cast_slice(&[first, len, 0, 0]));
        kernel::bind_buffers(&self.device, "no keys", &self.layout_read, &[&uniform, &self.no_keys])
    }

    fn staging(&self) -> Result<Staging, String> {
        let device = &self.device;
        let (uniform, words) = kernel::in_memory(device, || {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
            let words = kernel::buffer(device, "staged values", 12 * BATCH_POINTS as u64, usage);
            (kernel::uniform(device, "staged values", 16), words)
        })?;
        let bind = kernel::bind_buffers(device, "staged values", &self.layout_staged, &[&uniform, &words]);
        Ok(Staging { uniform, words, bind })
    }

    /// Puts what is staged in its place at once.
    fn flush(&mut self) {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        self.record_fill(&mut encoder);
        self.queue.submit([encoder.finish()]);
    }

    /// Puts what is staged in its place.
    pub fn record_fill(&mut self, encoder: &mut wgpu::CommandEncoder) {
        if self.staged.is_empty() {
            return;
        }
        let mut pass = encoder.begin_compute_pass(&Default::default());
        for (staged, staging) in self.staged.drain(..).zip(&self.ring) {
            let Some(column) = self.columns[staged.column].as_ref().filter(|_| staged.points > 0) else { continue };
            pass.set_pipeline(if column.is_wide { &self.fill_wide } else { &self.fill_small });
            pass.set_bind_group(0, &staging.bind, &[]);
            for page in column.pages[staged.pages].iter().flatten() {
                pass.set_bind_group(1, &page.bind, &[]);
                kernel::dispatch(&mut pass, staged.points);
            }
        }
    }

    /// Uploads a scale.
    pub fn prepare(&self, colors: &ColumnColors) {
        let uniform = ColumnScaleUniform {
            high: colors.thresholds.map(|key| (key >> 32) as u32),
            low: colors.thresholds.map(|key| key as u32),
            colors: colors.colors,
        };
        self.queue.write_buffer(&self.scale, 0, bytemuck::bytes_of(&uniform));
    }

    /// Colours the pixels whose records have keys. Group 2, the outputs, is bound.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, targets: &Targets, colors: &ColumnColors) {
        let Some(Some(column)) = self.columns.get(colors.column) else { return };
        pass.set_pipeline(match colors.lookup {
            Lookup::Table => &self.by_table,
            Lookup::Small => &self.by_small_scale,
            Lookup::Wide => &self.by_wide_scale,
        });
        pass.set_bind_group(0, &targets.bind_read, &[]);
        pass.set_bind_group(3, &self.bind_scale, &[]);
        for page in column.pages.iter().flatten() {
            pass.set_bind_group(1, &page.bind_read, &[]);
            kernel::dispatch(pass, targets.pixels());
        }
    }
}
