//! The store on the GPU: staging buffers for the batches of a frame, the kernels that insert a batch into random slots
//! and move the points it evicts, and the pages that hold all of it.

mod lists;
mod pages;

pub use lists::{DISPATCH_ARGUMENTS, SlotLists};
pub use pages::{Page, PageUniform, Pages};
use wgpu::BufferUsages;

use super::{Encoding, Insertion, Packing, ROUNDS};
use crate::{
    device::RenderError,
    gpu::{
        kernel::{self, Binding},
        shaders,
    },
    scene::PointBatch,
};

/// Insertions that one frame may take. More would let the look-ups of a visible point outgrow its
/// drawing; at 65,536 points each, 60 frames a second take 63 million points.
pub const INSERTIONS_PER_FRAME: usize = 16;

/// The scratch has room for at least so many points.
const SCRATCH_POINTS: u32 = 65_536;

/// Words of a point on its way: position, attributes, record.
const POINT_WORDS: u64 = 6;

/// An insertion in numbers for the kernels. Layout shared with `shaders/permutation.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct InsertionUniform {
    pub old_points: u32,
    pub new_points: u32,
    pub left_bits: u32,
    pub right_bits: u32,
    pub keys: [u32; ROUNDS],
    pub fresh_before: u32,
    pub staging_capacity: u32,
    pub domain: u32,
    pub shift: u32,
}

/// One batch uploaded and not yet inserted.
struct Staging {
    uniform: wgpu::Buffer,
    points: wgpu::Buffer,
    bind: wgpu::BindGroup,
}

struct Pipelines {
    count: wgpu::ComputePipeline,
    scan: wgpu::ComputePipeline,
    assign: wgpu::ComputePipeline,
    link: wgpu::ComputePipeline,
    relocate_visible: wgpu::ComputePipeline,
    relocate_fresh: wgpu::ComputePipeline,
}

/// What moves points in one encoding.
struct Moves {
    encoding: Encoding,
    evict: wgpu::ComputePipeline,
    settle: wgpu::ComputePipeline,
}

/// What depends on the size of an insertion.
struct Scratch {
    capacity: u32,
    ring: Vec<Staging>,
    moved_to: wgpu::Buffer,
    bind_assign: wgpu::BindGroup,
    bind_move: wgpu::BindGroup,
}

/// The shuffled, growing, paged point buffer on the GPU.
pub struct GpuStore {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pub pages: Pages,
    pub lists: SlotLists,
    page_points: Option<u32>,
    relocation: bool,
    pipelines: Pipelines,
    moves: Moves,
    layout_staging: wgpu::BindGroupLayout,
    layout_assign: wgpu::BindGroupLayout,
    layout_move: wgpu::BindGroupLayout,
    layout_relocate: wgpu::BindGroupLayout,
    scratch: Option<Scratch>,
    /// Uploaded in the ring, in order, to be inserted by the next frame; each with the number of fresh
    /// slots before it.
    pending: Vec<(Insertion, u32)>,
    fresh_points: u32,
}

impl GpuStore {
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> GpuStore {
        use Binding::{Read, ReadWrite, Uniform};
        let compute = wgpu::ShaderStages::COMPUTE;
        let layout = |label, bindings: &[Binding]| kernel::layout(device, label, compute, bindings);
        let layout_staging = layout("staging", &[Uniform, Read]);
        let layout_assign = layout("assign", &[ReadWrite; 6]);
        let layout_move = layout("move", &[Read, Read, ReadWrite]);
        let layout_relocate = layout("relocate", &[Uniform, Read, ReadWrite, Read, ReadWrite]);
        let pages = Pages::new(device);
        let insert = shaders::INSERT.module(device);
        let relocate = shaders::RELOCATE.module(device);
        let assigns = |entry| kernel::compute(device, &insert, entry, &[&layout_staging, &layout_assign]);
        let relocating = |entry| kernel::compute(device, &relocate, entry, &[&layout_relocate]);
        let groups = [&layout_staging, &pages.layout_all, &layout_move];
        GpuStore {
            // That of most scenes.
            moves: Moves::new(device, groups, Encoding::Packed),
            pipelines: Pipelines {
                count: assigns("count"),
                scan: assigns("scan"),
                assign: assigns("assign"),
                link: assigns("link"),
                relocate_visible: relocating("relocate_visible"),
                relocate_fresh: relocating("relocate_fresh"),
            },
            lists: SlotLists::new(device),
            pages,
            device: device.clone(),
            queue: queue.clone(),
            page_points: None,
            relocation: true,
            layout_staging,
            layout_assign,
            layout_move,
            layout_relocate,
            scratch: None,
            pending: Vec::new(),
            fresh_points: 0,
        }
    }

    /// Size of the pages of scenes to come; by default equal parts of what the header promises, within the
    /// limits of the device and of [`Pages`].
    pub fn set_page_points(&mut self, points: Option<u32>) {
        self.page_points = points;
    }

    /// Whether lists of slots follow points that an insertion moves. Without it pixels are lost while
    /// points arrive: for measuring just that.
    pub fn set_relocation(&mut self, on: bool) {
        self.relocation = on;
    }

    /// Empties the store; `points` are to come. With a packing, positions take 8 bytes until one lies outside of its box.
    pub fn reset(&mut self, points: u64, packing: Option<Packing>) {
        self.pages.reset(points, self.page_points, packing);
        self.lists.forget_visible = true;
        self.pending.clear();
        self.fresh_points = 0;
    }

    /// Points inserted since the last frame.
    pub fn fresh_points(&self) -> u32 {
        self.fresh_points
    }

    /// Insertions that [`GpuStore::record`] will perform.
    pub fn pending_insertions(&self) -> u32 {
        self.pending.len() as u32
    }

    /// Uploads a batch, to be inserted by [`GpuStore::record`].
    pub fn upload(&mut self, insertion: &Insertion, points: &PointBatch) -> Result<(), RenderError> {
        assert!(self.pending.len() < INSERTIONS_PER_FRAME, "a frame takes {INSERTIONS_PER_FRAME} insertions");
        if self.pages.packing().is_some_and(|packing| !packing.holds_all(&points.positions)) {
            self.widen(insertion.old)?;
        }
        if self.moves.encoding != self.pages.encoding() {
            let groups = [&self.layout_staging, &self.pages.layout_all, &self.layout_move];
            self.moves = Moves::new(&self.device, groups, self.pages.encoding());
        }
        self.pages.grow(&self.device, &self.queue, insertion.old + insertion.new, insertion.old)?;
        if self.scratch.as_ref().is_none_or(|scratch| scratch.capacity < insertion.new) {
            assert!(self.pending.is_empty(), "a frame's first insertion is its largest");
            // The first insertion may be a small one, and should not make a small scratch.
            self.scratch = Some(
                self.make_scratch(insertion.new.max(SCRATCH_POINTS))
                    .map_err(|detail| RenderError::OutOfMemory { stored: insertion.old.into(), detail })?,
            );
        }
        let Some(scratch) = &self.scratch else { unreachable!("just made") };
        let staging = &scratch.ring[self.pending.len()];
        let (left_bits, right_bits, keys) = insertion.permutation.parts();
        let (domain, shift) = insertion.permutation.domain_and_shift();
        let uniform = InsertionUniform {
            old_points: insertion.old,
            new_points: insertion.new,
            left_bits,
            right_bits,
            keys,
            fresh_before: self.fresh_points,
            staging_capacity: scratch.capacity,
            domain,
            shift,
        };
        self.queue.write_buffer(&staging.uniform, 0, bytemuck::bytes_of(&uniform));
        let capacity = u64::from(scratch.capacity);
        self.write_positions(&staging.points, &points.positions)?;
        self.queue.write_buffer(&staging.points, 12 * capacity, bytemuck::cast_slice(&points.colors));
        self.queue.write_buffer(&staging.points, 20 * capacity, bytemuck::cast_slice(&points.records));
        self.pending.push((*insertion, self.fresh_points));
        self.fresh_points += insertion.new;
        Ok(())
    }

    /// To the start of a buffer, in the encoding of the pages.
    fn write_positions(&self, to: &wgpu::Buffer, positions: &[[i32; 3]]) -> Result<(), RenderError> {
        let (Some(packing), Some(bytes)) = (self.pages.packing(), wgpu::BufferSize::new(8 * positions.len() as u64))
        else {
            self.queue.write_buffer(to, 0, bytemuck::cast_slice(positions));
            return Ok(());
        };
        // Straight into the memory that the device copies from.
        let view = self.queue.write_buffer_with(to, 0, bytes);
        let mut view = view.ok_or_else(|| RenderError::DeviceLost("no memory for an upload".into()))?;
        let words = positions.iter().map(|&position| packing.pack(position).to_le_bytes());
        view.slice(..).into_chunks::<8>().0.write_iter(words);
        Ok(())
    }

    /// Performs all pending insertions now. Their points stay fresh.
    pub fn flush(&mut self) {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        self.lists.drop_forgotten(&mut encoder);
        self.record(&mut encoder.begin_compute_pass(&Default::default()));
        self.queue.submit([encoder.finish()]);
    }

    /// From now on, positions take 12 bytes; `stored` points are there or on their way.
    ///
    /// # Errors
    /// [`RenderError::OutOfMemory`]; the positions stay as they are then.
    pub fn widen(&mut self, stored: u32) -> Result<(), RenderError> {
        log::info!("a point lies outside of the box that was promised: {stored} positions are widened to 12 bytes");
        // What was uploaded in the other encoding is inserted in it.
        if !self.pending.is_empty() {
            self.flush();
        }
        let widened = self.pages.widen(&self.device, &self.queue, stored);
        widened.map_err(|detail| RenderError::OutOfMemory { stored: stored.into(), detail })
    }

    /// Records all pending insertions: assignment, moves, and the relocation of both lists.
    pub fn record(&mut self, pass: &mut wgpu::ComputePass<'_>) {
        let Some(scratch) = &self.scratch else { return };
        let p = &self.pipelines;
        for (&(insertion, fresh_before), staging) in self.pending.iter().zip(&scratch.ring) {
            pass.set_bind_group(0, &staging.bind, &[]);
            pass.set_bind_group(1, &scratch.bind_assign, &[]);
            for (pipeline, threads) in
                [(&p.count, insertion.new), (&p.scan, 1), (&p.assign, insertion.new), (&p.link, insertion.new)]
            {
                pass.set_pipeline(pipeline);
                kernel::dispatch(pass, threads);
            }
            let end = insertion.old + insertion.new;
            for (pipeline, first) in [(&self.moves.evict, 0), (&self.moves.settle, insertion.old)] {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(2, &scratch.bind_move, &[]);
                for page in self.pages.holding(first, end) {
                    pass.set_bind_group(1, &page.bind_all, &[]);
                    kernel::dispatch(pass, insertion.new);
                }
            }
            if self.relocation {
                self.record_relocation(pass, scratch, staging, fresh_before);
            }
        }
        self.pending.clear();
    }

    fn record_relocation(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        scratch: &Scratch,
        staging: &Staging,
        fresh_before: u32,
    ) {
        let lists = &self.lists;
        let bind = kernel::bind_buffers(
            &self.device,
            "relocate",
            &self.layout_relocate,
            &[&staging.uniform, &scratch.moved_to, &lists.visible, &lists.visible_arguments, &lists.fresh],
        );
        pass.set_bind_group(0, &bind, &[]);
        pass.set_pipeline(&self.pipelines.relocate_visible);
        pass.dispatch_workgroups_indirect(&lists.visible_arguments, DISPATCH_ARGUMENTS);
        pass.set_pipeline(&self.pipelines.relocate_fresh);
        kernel::dispatch(pass, fresh_before);
    }

    /// Positions, attributes and records of all slots of the pages, in order, as [`PointBatch`] has
    /// them; waits for the device. Slots beyond the points stored mean nothing.
    pub fn read_points(&self) -> Result<PointBatch, RenderError> {
        let mut points = PointBatch::default();
        for page in self.pages.iter() {
            let column = |buffer| kernel::read_words(&self.device, &self.queue, buffer);
            let words = column(&page.positions)?;
            match self.pages.packing() {
                None => points.positions.extend_from_slice(bytemuck::cast_slice(&words)),
                Some(packing) => {
                    let word = |pair: &[u32]| u64::from(pair[1]) << 32 | u64::from(pair[0]);
                    points.positions.extend(words.chunks_exact(2).map(|pair| packing.unpack(word(pair))));
                }
            }
            points.colors.extend_from_slice(bytemuck::cast_slice(&column(&page.attributes)?));
            points.records.extend(column(&page.records)?);
        }
        Ok(points)
    }

    /// After a frame: its fresh points are drawn.
    pub fn forget_fresh(&mut self) {
        self.fresh_points = 0;
    }

    fn make_scratch(&mut self, capacity: u32) -> Result<Scratch, String> {
        let device = &self.device;
        let n = u64::from(capacity);
        let words = |label, words: u64| {
            kernel::buffer(device, label, words * 4, BufferUsages::STORAGE | BufferUsages::COPY_DST)
        };
        let (staged, [targets, ranks, free_slots, moved_to, sums, carried], fresh) = kernel::in_memory(device, || {
            let staged: Vec<_> = (0..INSERTIONS_PER_FRAME)
                .map(|_| {
                    let uniform = kernel::uniform(device, "insertion", size_of::<InsertionUniform>() as u64);
                    (uniform, words("staging", POINT_WORDS * n))
                })
                .collect();
            let columns = [
                words("targets", n),
                words("ranks", n),
                words("free slots", n),
                words("moved to", n),
                words("sums", 2 * n.div_ceil(kernel::GROUP.into())),
                words("carried", POINT_WORDS * n),
            ];
            (staged, columns, lists::list(device, "fresh slots", capacity * INSERTIONS_PER_FRAME as u32))
        })?;
        let bind_staging = |(uniform, points)| {
            let bind = kernel::bind_buffers(device, "staging", &self.layout_staging, &[&uniform, &points]);
            Staging { uniform, points, bind }
        };
        self.lists.fresh = fresh;
        let assign = [&targets, &ranks, &free_slots, &moved_to, &sums, &self.lists.fresh];
        Ok(Scratch {
            capacity,
            ring: staged.into_iter().map(bind_staging).collect(),
            bind_assign: kernel::bind_buffers(device, "assign", &self.layout_assign, &assign),
            bind_move: kernel::bind_buffers(device, "move", &self.layout_move, &[&targets, &moved_to, &carried]),
            moved_to,
        })
    }
}

impl Moves {
    /// `groups`: of what is staged, of a page, of what is on its way.
    fn new(device: &wgpu::Device, groups: [&wgpu::BindGroupLayout; 3], encoding: Encoding) -> Moves {
        let module = shaders::MOVE.module(device);
        let constants = [("POSITION_WORDS", f64::from(encoding.position_words()))];
        let moving = |entry| kernel::compute_with(device, &module, entry, &groups, &constants);
        Moves { encoding, evict: moving("evict"), settle: moving("settle") }
    }
}
