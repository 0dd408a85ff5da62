//! What no method can exceed on a device: how fast it reads the cloud, and how fast it copies.

use std::time::Instant;

use serde::Serialize;

use super::{Gpu, MethodError, Runner, modules, timing};
use crate::{
    device::RenderError,
    gpu::{
        device,
        kernel::{self, Binding},
        shaders,
    },
};

/// Bytes per second, every sample.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ceilings {
    /// Copies from buffer to buffer, which a device may leave to an engine apart; each byte counts twice, as
    /// read and as written.
    pub copy: Vec<f64>,
    /// The same by a kernel.
    pub copy_kernel: Vec<f64>,
    /// A kernel that reads all positions and writes nothing.
    pub read: Vec<f64>,
}

/// Pairs of buffers that are copied in one submission. Copies to one buffer wait for each other (WebGPU orders
/// them); those of different pairs need not.
const PAIRS: u64 = 4;

/// Bytes that are read, and written, by one copy of all pairs: on a GPU 1 GiB, far more than its caches hold
/// and half a millisecond of a fast one; on a processor 64 MiB.
const GPU_BYTES: u64 = 1 << 30;
const SOFTWARE_BYTES: u64 = 64 << 20;

/// By the wall clock, copies last at least so long, in which their submission, about 0.1 ms, is little.
const WALL_SECS: f64 = 0.02;
const MAX_COPIES: u32 = 1024;

/// Points that a thread of `shaders/methods/copy.wgsl` copies 16 bytes of.
const WORDS_PER_THREAD: u32 = 4;

/// Buffers to copy between, apart from any cloud: a small cloud would be copied within a cache.
pub struct Copies {
    gpu: Gpu,
    pairs: Vec<(wgpu::Buffer, wgpu::Buffer, wgpu::BindGroup)>,
    pipeline: wgpu::ComputePipeline,
}

impl Copies {
    /// As large as they should be, or as memory allows.
    ///
    /// # Errors
    /// No memory for 4 MiB.
    pub fn new(gpu: &Gpu) -> Result<Copies, MethodError> {
        let limits = gpu.device.limits();
        let largest = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let mut bytes = if gpu.is_software() { SOFTWARE_BYTES } else { GPU_BYTES };
        loop {
            match Copies::with_bytes(gpu, (bytes / PAIRS).min(largest)) {
                Err(_) if bytes > 4 << 20 => bytes /= 2,
                made => return made,
            }
        }
    }

    /// Pairs of buffers of `bytes` each.
    ///
    /// # Errors
    /// No memory for them.
    pub fn with_bytes(gpu: &Gpu, bytes: u64) -> Result<Copies, MethodError> {
        let device = &gpu.device;
        let layout = kernel::layout(device, "copy", wgpu::ShaderStages::COMPUTE, &[Binding::Read, Binding::ReadWrite]);
        let pipeline = kernel::compute(device, &shaders::COPY.module(device), "copy_words", &[&layout]);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        // Whole words of the kernel.
        let bytes = bytes.max(16).next_multiple_of(16);
        let pair = |_| {
            let [from, to] = ["copied from", "copied to"].map(|label| kernel::buffer(device, label, bytes, usage));
            let bind = kernel::bind_buffers(device, "copy", &layout, &[&from, &to]);
            (from, to, bind)
        };
        let pairs = kernel::in_memory(device, || (0..PAIRS).map(pair).collect())
            .map_err(|detail| RenderError::OutOfMemory { stored: 0, detail })?;
        Ok(Copies { gpu: gpu.clone(), pairs, pipeline })
    }

    /// Bytes read, or written, by one copy of all pairs.
    pub fn bytes(&self) -> u64 {
        self.pairs.iter().map(|(from, ..)| from.size()).sum()
    }

    /// Buffer to buffer, `samples` times, bytes per second. Warming up is the caller's.
    ///
    /// # Errors
    /// A lost device.
    pub fn by_engine(&self, samples: u32) -> Result<Vec<f64>, MethodError> {
        let inside = wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let record = |encoder: &mut wgpu::CommandEncoder| {
            self.pairs.iter().for_each(|(from, to, _)| encoder.copy_buffer_to_buffer(from, 0, to, 0, None));
        };
        let moved = 2.0 * self.bytes() as f64;
        if self.gpu.has_clock() && self.gpu.device.features().contains(inside) {
            let sample = |_| Ok(moved / timing::between(&self.gpu, record)?);
            return (0..samples).map(sample).collect();
        }
        let time = |copies: u32| -> Result<f64, RenderError> {
            device::wait(&self.gpu.device)?;
            let start = Instant::now();
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            (0..copies).for_each(|_| record(&mut encoder));
            self.gpu.queue.submit([encoder.finish()]);
            device::wait(&self.gpu.device)?;
            Ok(start.elapsed().as_secs_f64())
        };
        let mut copies = 1;
        while copies < MAX_COPIES && time(copies)? < WALL_SECS {
            copies *= 2;
        }
        (0..samples).map(|_| Ok(moved * f64::from(copies) / time(copies)?)).collect()
    }

    /// By a kernel, `samples` times, bytes per second.
    ///
    /// # Errors
    /// A lost device.
    pub fn by_kernel(&self, samples: u32) -> Result<Vec<f64>, MethodError> {
        let times = timing::time(&self.gpu, samples, 1, |encoder, queries| {
            let timestamp_writes = queries.map(timing::Queries::compute);
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
            pass.set_pipeline(&self.pipeline);
            for (from, _, bind) in &self.pairs {
                let threads = (from.size() / 16) as u32;
                pass.set_bind_group(0, bind, &[]);
                kernel::dispatch(&mut pass, threads.div_ceil(WORDS_PER_THREAD * kernel::GROUP) * kernel::GROUP);
            }
        })?;
        Ok(times.iter().map(|time| 2.0 * self.bytes() as f64 / time.total_secs()).collect())
    }

    /// Copies a pair's worth of words by the kernel: what the buffer copied to holds afterwards.
    ///
    /// # Errors
    /// A lost device.
    pub fn copied(&self, words: &[u32]) -> Result<Vec<u32>, MethodError> {
        let Some((from, to, _)) = self.pairs.last() else { return Ok(Vec::new()) };
        let len = words.len().min((from.size() / 4) as usize);
        self.gpu.queue.write_buffer(from, 0, bytemuck::cast_slice(&words[..len]));
        self.by_kernel(1)?;
        Ok(kernel::read_words(&self.gpu.device, &self.gpu.queue, to)?)
    }
}

/// Measures `samples` times each; reading, on the runner's cloud. Warming up is the caller's.
///
/// # Errors
/// A lost device.
pub fn ceilings(runner: &mut Runner, copies: &Copies, samples: u32) -> Result<Ceilings, MethodError> {
    Ok(Ceilings {
        copy: copies.by_engine(samples)?,
        copy_kernel: copies.by_kernel(samples)?,
        read: read(runner, samples)?,
    })
}

fn read(runner: &mut Runner, samples: u32) -> Result<Vec<f64>, MethodError> {
    let groups = [&runner.targets.layout, &runner.pages.layout];
    runner.pipelines.make(&runner.gpu.device, &modules::READ, &groups);
    let runner = &*runner;
    let times = timing::time(&runner.gpu, samples, 1, |encoder, queries| {
        runner.over_points(&mut runner.pass(encoder, queries), &modules::READ);
    })?;
    let bytes = (runner.points() * runner.bytes_per_point()) as f64;
    Ok(times.iter().map(|time| bytes / time.total_secs()).collect())
}
