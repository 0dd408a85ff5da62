//! What no method can exceed on a device, measured on the same cloud.

use std::time::Instant;

use serde::Serialize;

use super::{MethodError, Runner, modules, timing};
use crate::{
    device::RenderError,
    gpu::{device, kernel},
};

/// Bytes per second, every sample.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ceilings {
    /// A copy from buffer to buffer, each byte counted twice: read and written.
    pub copy: Vec<f64>,
    /// A kernel that reads all positions and writes nothing.
    pub read: Vec<f64>,
}

/// A copy lasts at least so long by the wall clock, in which its submission, about 0.1 ms, is little.
const COPY_SECS: f64 = 0.02;
const MAX_COPIES: u32 = 1024;

/// Measures `samples` times each, on the runner's cloud. Warming up is the caller's.
///
/// # Errors
/// No memory for a copy of a page, a lost device.
pub fn ceilings(runner: &mut Runner, samples: u32) -> Result<Ceilings, MethodError> {
    Ok(Ceilings { copy: copy(runner, samples)?, read: read(runner, samples)? })
}

/// Copies the first page, by the wall clock, as often as it takes to last.
fn copy(runner: &Runner, samples: u32) -> Result<Vec<f64>, MethodError> {
    let gpu = &runner.gpu;
    let Some(page) = runner.pages.pages.first() else { return Ok(Vec::new()) };
    let bytes = page.points.size();
    let usage = wgpu::BufferUsages::COPY_DST;
    let target = kernel::in_memory(&gpu.device, || kernel::buffer(&gpu.device, "copy", bytes, usage))
        .map_err(|detail| RenderError::OutOfMemory { stored: runner.points(), detail })?;
    let time = |copies: u32| -> Result<f64, RenderError> {
        device::wait(&gpu.device)?;
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for _ in 0..copies {
            encoder.copy_buffer_to_buffer(&page.points, 0, &target, 0, None);
        }
        gpu.queue.submit([encoder.finish()]);
        device::wait(&gpu.device)?;
        Ok(start.elapsed().as_secs_f64())
    };
    let mut copies = 1;
    while copies < MAX_COPIES && time(copies)? < COPY_SECS {
        copies *= 2;
    }
    let sample = |_| Ok(2.0 * bytes as f64 * f64::from(copies) / time(copies)?);
    (0..samples).map(sample).collect()
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
