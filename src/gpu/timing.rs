//! How long each stage of a frame took on the device.

use std::{
    sync::{Arc, Mutex},
    time::Instant,
};

use super::{device, kernel};
use crate::device::{PassTimes, Passes};

/// A stage of a frame, as in [`PassTimes`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    Insert,
    Reproject,
    Fresh,
    Fill,
    Index,
    Average,
    AverageFill,
    Resolve,
}

/// Passes that one frame may time; the hardware rasterizer with high-quality shading needs the most, 13.
const MAX_SPANS: usize = 16;
/// Frames whose times may be on their way back.
const IN_FLIGHT: usize = 3;

const BYTES: u64 = (MAX_SPANS * 2 * 8) as u64;

/// Begin and end of a pass as two query numbers.
pub type Span = Option<(u32, u32)>;

enum Clock {
    /// Timestamp queries; a nanosecond count per tick.
    Device { queries: wgpu::QuerySet, resolved: wgpu::Buffer, readbacks: Vec<Readback>, period_ns: f64 },
    /// From submission until the device says that it is done: one figure for the whole frame. Also for
    /// software rasterizers, whose timestamps exist but say little: with Mesa 22.3's lavapipe a fill of
    /// a million points took 0.1 ms by them, in a frame of 40. Such a device is waited for, since it
    /// has no other processor to overlap with.
    Wall { waits: bool },
}

/// What a frame did, beside the time that it took.
#[derive(Debug, Clone, Copy)]
pub struct Work {
    pub fill_points: u32,
    pub insertions: u32,
    pub average_points: u32,
    pub passes: Passes,
}

impl Work {
    fn times(self) -> PassTimes {
        let Work { fill_points, insertions, average_points, passes } = self;
        PassTimes { fill_points, insertions, average_points, passes, ..Default::default() }
    }
}

struct Readback {
    buffer: wgpu::Buffer,
    /// What is on its way, if anything.
    frame: Option<(Vec<Stage>, Work)>,
    mapped: Arc<Mutex<Option<bool>>>,
}

/// Times the passes of frames.
pub struct FrameTimer {
    clock: Clock,
    stages: Vec<Stage>,
    finished: Arc<Mutex<Option<PassTimes>>>,
    /// The readback that this frame writes to.
    target: Option<usize>,
}

impl FrameTimer {
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, device_type: wgpu::DeviceType) -> FrameTimer {
        let is_software = device_type == wgpu::DeviceType::Cpu;
        let clock = if !is_software && device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
            Clock::Device {
                queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("passes"),
                    ty: wgpu::QueryType::Timestamp,
                    count: 2 * MAX_SPANS as u32,
                }),
                resolved: kernel::buffer(device, "pass times", BYTES, usage),
                readbacks: (0..IN_FLIGHT)
                    .map(|_| Readback {
                        buffer: kernel::buffer(
                            device,
                            "pass times readback",
                            BYTES,
                            wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                        ),
                        frame: None,
                        mapped: Arc::default(),
                    })
                    .collect(),
                period_ns: f64::from(queue.get_timestamp_period()),
            }
        } else {
            Clock::Wall { waits: is_software }
        };
        FrameTimer { clock, stages: Vec::new(), finished: Arc::default(), target: None }
    }

    /// Begins a frame. If too many are in flight, this one is not timed.
    pub fn begin(&mut self) {
        self.stages.clear();
        self.target = match &self.clock {
            Clock::Device { readbacks, .. } => readbacks.iter().position(|r| r.frame.is_none()),
            Clock::Wall { .. } => None,
        };
    }

    fn span(&mut self, stage: Stage) -> Span {
        if self.target.is_none() || self.stages.len() == MAX_SPANS {
            return None;
        }
        self.stages.push(stage);
        let first = 2 * (self.stages.len() as u32 - 1);
        Some((first, first + 1))
    }

    /// A compute pass that counts as `stage`.
    pub fn compute_pass<'e>(&mut self, encoder: &'e mut wgpu::CommandEncoder, stage: Stage) -> wgpu::ComputePass<'e> {
        let span = self.span(stage);
        let timestamp_writes = self.writes(span);
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes })
    }

    /// A render pass without colours that counts as `stage`. `clear` clears the depths; without
    /// `depth_ops` they are read only.
    pub fn depth_pass<'e>(
        &mut self,
        encoder: &'e mut wgpu::CommandEncoder,
        stage: Stage,
        view: &wgpu::TextureView,
        depth_ops: Option<wgpu::Operations<f32>>,
    ) -> wgpu::RenderPass<'e> {
        let span = self.span(stage);
        let timestamp_writes = self.writes(span).map(|w| wgpu::RenderPassTimestampWrites {
            query_set: w.query_set,
            beginning_of_pass_write_index: w.beginning_of_pass_write_index,
            end_of_pass_write_index: w.end_of_pass_write_index,
        });
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: None,
            color_attachments: &[],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view,
                depth_ops,
                stencil_ops: None,
            }),
            timestamp_writes,
            occlusion_query_set: None,
            multiview_mask: None,
        })
    }

    fn writes(&self, span: Span) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let (Clock::Device { queries, .. }, Some((begin, end))) = (&self.clock, span) else {
            return None;
        };
        Some(wgpu::ComputePassTimestampWrites {
            query_set: queries,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(end),
        })
    }

    /// Ends a frame's commands.
    pub fn end(&mut self, encoder: &mut wgpu::CommandEncoder, work: Work) {
        if let (Clock::Device { queries, resolved, readbacks, .. }, Some(target)) = (&mut self.clock, self.target) {
            let count = 2 * self.stages.len() as u32;
            encoder.resolve_query_set(queries, 0..count, resolved, 0);
            encoder.copy_buffer_to_buffer(resolved, 0, &readbacks[target].buffer, 0, Some(u64::from(count) * 8));
            readbacks[target].frame = Some((self.stages.clone(), work));
        }
    }

    /// After the frame's commands were submitted.
    pub fn submitted(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, work: Work) {
        match (&self.clock, self.target) {
            (Clock::Device { readbacks, .. }, Some(target)) => {
                let mapped = readbacks[target].mapped.clone();
                readbacks[target].buffer.map_async(wgpu::MapMode::Read, .., move |result| {
                    if let Ok(mut mapped) = mapped.lock() {
                        *mapped = Some(result.is_ok());
                    }
                });
            }
            (Clock::Device { .. }, None) => {}
            (&Clock::Wall { waits }, _) => {
                let (start, finished) = (Instant::now(), self.finished.clone());
                queue.on_submitted_work_done(move || {
                    if let Ok(mut finished) = finished.lock() {
                        *finished = Some(PassTimes { undivided: start.elapsed().as_secs_f64(), ..work.times() });
                    }
                });
                if waits {
                    // An error here is a lost device, which the next frame reports.
                    let _ = device::wait(device);
                }
            }
        }
    }

    /// Times of the latest finished frame, each once. Call after polling the device.
    pub fn take(&mut self) -> Option<PassTimes> {
        let mut latest = self.finished.lock().ok()?.take();
        if let Clock::Device { readbacks, period_ns, .. } = &mut self.clock {
            for readback in readbacks {
                let Some(ok) = readback.mapped.lock().ok()?.take() else { continue };
                let Some((stages, work)) = readback.frame.take() else { continue };
                if !ok {
                    continue;
                }
                let mut times = work.times();
                if let Ok(bytes) = readback.buffer.get_mapped_range(..) {
                    let ticks: &[u64] = bytemuck::cast_slice(&bytes);
                    for (stage, span) in stages.iter().zip(ticks.chunks_exact(2)) {
                        let secs = span[1].saturating_sub(span[0]) as f64 * *period_ns * 1e-9;
                        *match stage {
                            Stage::Insert => &mut times.insert,
                            Stage::Reproject => &mut times.reproject,
                            Stage::Fresh => &mut times.fresh,
                            Stage::Fill => &mut times.fill,
                            Stage::Index => &mut times.index,
                            Stage::Average => &mut times.average,
                            Stage::AverageFill => &mut times.average_fill,
                            Stage::Resolve => &mut times.resolve,
                        } += secs;
                    }
                    latest = Some(times);
                }
                readback.buffer.unmap();
            }
        }
        latest
    }
}
