//! Asks which point is at a pixel, without waiting for the answer: a few dozen bytes come back when the device has
//! done what it was given.

use std::{
    sync::mpsc::{Receiver, TryRecvError, channel},
    thread::JoinHandle,
};

use wgpu::BufferUsages;

use super::targets::Targets;
use crate::{
    gpu::{
        kernel::{self, Binding},
        shaders,
    },
    render::{
        Pick, PickAt, PickTicket,
        pick::{MAX_REACH, Picks},
    },
    store::{Encoding, gpu::Pages},
};

/// A question and its answer in numbers for the kernel. Layout shared with `shaders/pick.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PickWords {
    pub width: u32,
    pub height: u32,
    pub x: u32,
    pub y: u32,
    pub reach: u32,
    pub pixel: u32,
    pub slot: u32,
    pub depth: u32,
    pub record: u32,
    pub position_x: i32,
    pub position_y: i32,
    pub position_z: i32,
}

const BYTES: u64 = size_of::<PickWords>() as u64;

/// The kernels, and the questions that are on their way.
pub struct Picker {
    layout: wgpu::BindGroupLayout,
    kernels: Kernels,
    picks: Picks<Asked>,
}

/// Compiled when the first question is asked, on a thread of their own: a driver may take a tenth of a second, which
/// neither the first picture nor a frame has.
enum Kernels {
    None,
    Compiling(JoinHandle<Compiled>),
    Ready(Compiled),
}

struct Compiled {
    encoding: Encoding,
    nearest: wgpu::ComputePipeline,
    point: wgpu::ComputePipeline,
}

struct Asked {
    readback: wgpu::Buffer,
    mapped: Receiver<bool>,
}

impl Picker {
    pub fn new(device: &wgpu::Device) -> Picker {
        let bindings = [Binding::Read, Binding::ReadWrite];
        let layout = kernel::layout(device, "pick", wgpu::ShaderStages::COMPUTE, &bindings);
        Picker { layout, kernels: Kernels::None, picks: Picks::default() }
    }

    /// Waits until the kernels are compiled, if they are being compiled.
    pub fn wait(&mut self) {
        if let Kernels::Compiling(thread) = std::mem::replace(&mut self.kernels, Kernels::None)
            && let Ok(compiled) = thread.join()
        {
            self.kernels = Kernels::Ready(compiled);
        }
    }

    /// Begins to compile the kernels for these pages, if they are not there.
    fn prepare(&mut self, device: &wgpu::Device, pages: &Pages) {
        if matches!(&self.kernels, Kernels::Compiling(thread) if thread.is_finished()) {
            self.wait();
        }
        let encoding = pages.encoding();
        let is_of_others = match &self.kernels {
            Kernels::None => true,
            Kernels::Compiling(_) => false,
            Kernels::Ready(compiled) => compiled.encoding != encoding,
        };
        if is_of_others {
            let (device, own, page) = (device.clone(), self.layout.clone(), pages.layout_resolve.clone());
            let compile = move || {
                let module = shaders::PICK.module_in(&device, encoding);
                let nearest = kernel::compute(&device, &module, "pick_nearest", &[&own]);
                let point = kernel::compute(&device, &module, "pick_point", &[&own, &page]);
                Compiled { encoding, nearest, point }
            };
            self.kernels = match std::thread::Builder::new().name("compile-pick".into()).spawn(compile) {
                Ok(thread) => Kernels::Compiling(thread),
                // Tried again by the next question.
                Err(_) => Kernels::None,
            };
        }
    }

    /// Submits a question to the last frame's words; none while the kernels are being compiled.
    pub fn ask(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        targets: &Targets,
        pages: &Pages,
        at: PickAt,
    ) -> Option<PickTicket> {
        self.prepare(device, pages);
        let Kernels::Ready(kernels) = &self.kernels else { return None };
        let [width, height] = targets.size;
        let [x, y] = at.pixel;
        let mut question =
            PickWords { width, height, x, y, reach: at.reach.min(MAX_REACH), ..bytemuck::Zeroable::zeroed() };
        question.slot = u32::MAX;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let answer = kernel::buffer(device, "pick", BYTES, usage);
        queue.write_buffer(&answer, 0, bytemuck::bytes_of(&question));
        let readback = kernel::buffer(device, "picked", BYTES, BufferUsages::COPY_DST | BufferUsages::MAP_READ);
        let bind = kernel::bind_buffers(device, "pick", &self.layout, &[&targets.words, &answer]);
        let mut encoder = device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_bind_group(0, &bind, &[]);
            pass.set_pipeline(&kernels.nearest);
            pass.dispatch_workgroups(1, 1, 1);
            pass.set_pipeline(&kernels.point);
            for page in pages.iter() {
                pass.set_bind_group(1, &page.bind_resolve, &[]);
                pass.dispatch_workgroups(1, 1, 1);
            }
        }
        encoder.copy_buffer_to_buffer(&answer, 0, &readback, 0, BYTES);
        queue.submit([encoder.finish()]);
        let (done, mapped) = channel();
        readback.map_async(wgpu::MapMode::Read, .., move |result| {
            // Nobody listens once the question is given up.
            let _ = done.send(result.is_ok());
        });
        Some(self.picks.open(Asked { readback, mapped }).0)
    }

    /// The answer, once it is there. The device must have been polled.
    pub fn answer(&mut self, ticket: PickTicket) -> Option<Option<Pick>> {
        if self.picks.get(ticket).is_some_and(|asked| asked.mapped.try_recv() == Err(TryRecvError::Empty)) {
            return None;
        }
        // Given up, or lost with the device, which the next frame reports: nothing is there.
        let Some(asked) = self.picks.close(ticket) else { return Some(None) };
        let Ok(bytes) = asked.readback.get_mapped_range(..) else { return Some(None) };
        let words: PickWords = *bytemuck::from_bytes(&bytes);
        Some((words.slot != u32::MAX).then(|| Pick {
            record: words.record,
            position: [words.position_x, words.position_y, words.position_z],
            depth: f32::from_bits(words.depth),
            pixel: [words.pixel % words.width, words.pixel / words.width],
        }))
    }
}

impl Drop for Picker {
    /// A driver does not like to be left in the middle.
    fn drop(&mut self) {
        self.wait();
    }
}
