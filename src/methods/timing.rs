//! How long each pass of a frame took.

use std::time::Instant;

use serde::Serialize;

use super::Gpu;
use crate::{
    device::RenderError,
    gpu::{device, kernel},
};

/// Seconds of one frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrameTime {
    pub clear_secs: f64,
    /// One for each geometry pass.
    pub geometry_secs: Vec<f64>,
    pub resolve_secs: f64,
    /// The whole frame by the wall clock, where the device cannot time its passes; the others are zero
    /// or empty then. Software rasterizers are waited for after each frame; elsewhere all frames are
    /// submitted at once, and each has the mean.
    pub undivided_secs: Option<f64>,
}

impl FrameTime {
    /// Of the whole frame.
    pub fn total_secs(&self) -> f64 {
        self.clear_secs
            + self.geometry_secs.iter().sum::<f64>()
            + self.resolve_secs
            + self.undivided_secs.unwrap_or(0.0)
    }

    fn undivided(secs: f64) -> FrameTime {
        FrameTime { clear_secs: 0.0, geometry_secs: Vec::new(), resolve_secs: 0.0, undivided_secs: Some(secs) }
    }

    /// From the seconds of all passes in order.
    fn divided(passes: &[f64]) -> FrameTime {
        let (clear, rest) = passes.split_first().map_or((0.0, passes), |(first, rest)| (*first, rest));
        let (resolve, geometry) = rest.split_last().map_or((0.0, rest), |(last, rest)| (*last, rest));
        FrameTime { clear_secs: clear, geometry_secs: geometry.to_vec(), resolve_secs: resolve, undivided_secs: None }
    }
}

/// Queries that WebGPU allows in a set.
const MAX_QUERIES: u32 = 4096;

/// Timestamps of the passes of some frames.
pub struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    passes: u32,
    /// The next query.
    next: u32,
}

impl Queries {
    fn new(device: &wgpu::Device, frames: u32, passes: u32) -> Queries {
        let count = frames * passes * 2;
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        Queries {
            set: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("passes"),
                ty: wgpu::QueryType::Timestamp,
                count,
            }),
            resolved: kernel::buffer(device, "pass times", u64::from(count) * 8, usage),
            passes,
            next: 0,
        }
    }

    /// For the next compute pass.
    pub fn compute(&mut self) -> wgpu::ComputePassTimestampWrites<'_> {
        self.next += 2;
        wgpu::ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(self.next - 2),
            end_of_pass_write_index: Some(self.next - 1),
        }
    }

    /// For the next render pass.
    pub fn render(&mut self) -> wgpu::RenderPassTimestampWrites<'_> {
        let writes = self.compute();
        wgpu::RenderPassTimestampWrites {
            query_set: writes.query_set,
            beginning_of_pass_write_index: writes.beginning_of_pass_write_index,
            end_of_pass_write_index: writes.end_of_pass_write_index,
        }
    }

    fn read(&self, gpu: &Gpu) -> Result<Vec<FrameTime>, RenderError> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.resolve_query_set(&self.set, 0..self.next, &self.resolved, 0);
        let [words] = kernel::read_all(&gpu.device, &gpu.queue, encoder, [&self.resolved])?;
        let tick_secs = f64::from(gpu.queue.get_timestamp_period()) * 1e-9;
        let ticks: Vec<u64> = words.chunks_exact(2).map(|w| u64::from(w[1]) << 32 | u64::from(w[0])).collect();
        let secs = ticks.chunks_exact(2).map(|span| span[1].saturating_sub(span[0]) as f64 * tick_secs);
        let secs: Vec<f64> = secs.collect();
        Ok(secs.chunks_exact(self.passes as usize).map(FrameTime::divided).collect())
    }
}

/// Records a frame.
pub trait Record: FnMut(&mut wgpu::CommandEncoder, Option<&mut Queries>) {}
impl<F: FnMut(&mut wgpu::CommandEncoder, Option<&mut Queries>)> Record for F {}

fn submit(gpu: &Gpu, record: &mut impl Record, queries: Option<&mut Queries>) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    record(&mut encoder, queries);
    gpu.queue.submit([encoder.finish()]);
}

/// Times `frames` frames of `passes` passes each that `record` records.
pub fn time(gpu: &Gpu, frames: u32, passes: u32, mut record: impl Record) -> Result<Vec<FrameTime>, RenderError> {
    if gpu.has_clock() { by_queries(gpu, frames, passes, &mut record) } else { by_wall_clock(gpu, frames, &mut record) }
}

/// Seconds between two timestamps around what `record` records outside of passes; only for devices that
/// have [`wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS`].
pub fn between(gpu: &Gpu, record: impl Fn(&mut wgpu::CommandEncoder)) -> Result<f64, RenderError> {
    let mut queries = Queries::new(&gpu.device, 1, 1);
    device::wait(&gpu.device)?;
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.write_timestamp(&queries.set, 0);
    record(&mut encoder);
    encoder.write_timestamp(&queries.set, 1);
    gpu.queue.submit([encoder.finish()]);
    queries.next = 2;
    Ok(queries.read(gpu)?.iter().map(FrameTime::total_secs).sum())
}

fn by_queries(gpu: &Gpu, frames: u32, passes: u32, record: &mut impl Record) -> Result<Vec<FrameTime>, RenderError> {
    let most = MAX_QUERIES / (2 * passes);
    let mut times = Vec::new();
    while times.len() < frames as usize {
        let batch = (frames - times.len() as u32).min(most);
        let mut queries = Queries::new(&gpu.device, batch, passes);
        for _ in 0..batch {
            submit(gpu, record, Some(&mut queries));
        }
        times.extend(queries.read(gpu)?);
    }
    Ok(times)
}

fn by_wall_clock(gpu: &Gpu, frames: u32, record: &mut impl Record) -> Result<Vec<FrameTime>, RenderError> {
    device::wait(&gpu.device)?;
    let mut clock = Instant::now();
    let mut times = Vec::new();
    for _ in 0..frames {
        submit(gpu, record, None);
        if gpu.is_software() {
            device::wait(&gpu.device)?;
            times.push(FrameTime::undivided(clock.elapsed().as_secs_f64()));
            clock = Instant::now();
        }
    }
    if !gpu.is_software() {
        device::wait(&gpu.device)?;
        let mean = clock.elapsed().as_secs_f64() / f64::from(frames.max(1));
        times = vec![FrameTime::undivided(mean); frames as usize];
    }
    Ok(times)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_are_told_apart() {
        let time = FrameTime::divided(&[1.0, 2.0, 4.0, 8.0]);
        assert_eq!(
            (time.clear_secs, time.geometry_secs.as_slice(), time.resolve_secs),
            (1.0, [2.0, 4.0].as_slice(), 8.0)
        );
        assert_eq!(time.total_secs(), 15.0);
        assert_eq!(FrameTime::undivided(3.0).total_secs(), 3.0);
    }

    /// More frames than a set of queries holds. Where timestamps mean little they exist nevertheless.
    #[test]
    fn every_frame_has_its_queries() {
        let Ok(gpu) = Gpu::headless() else { return };
        if !gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return;
        }
        let frames = MAX_QUERIES / 4 + 3;
        let mut recorded = 0;
        let times =
            by_queries(&gpu, frames, 2, &mut |encoder: &mut wgpu::CommandEncoder, queries: Option<&mut Queries>| {
                let queries = queries.expect("timed frames have queries");
                for _ in 0..2 {
                    let timestamp_writes = Some(queries.compute());
                    drop(encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes }));
                }
                recorded += 1;
            });
        let times = times.expect("a device that answers");
        assert_eq!((times.len() as u32, recorded), (frames, frames));
        assert!(times.iter().all(|time| time.undivided_secs.is_none() && time.total_secs() < 1.0));
    }
}
