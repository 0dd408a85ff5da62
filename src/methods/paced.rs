//! A frame in small submissions with a look at the clock between them: for the first frame of a method of
//! which nobody knows how long it takes. A shader cannot be stopped, and a busy loop on a GPU whose threads
//! wait for each other takes minutes for a hundred million points.

use std::time::{Duration, Instant};

use serde::Serialize;

use super::{Drawn, Method, MethodError, Runner, pages::PART_STRIDE, plan::Step};
use crate::{gpu::device, render::View};

/// Points of the first submission: few enough that the worst method known, with all of them in one pixel,
/// is done in less than a second.
const FIRST_POINTS: u32 = 1 << 16;

/// A submission shall last this share of the patience: so much too late is the clock looked at.
const SUBMISSION_SHARE: f64 = 1.0 / 16.0;

/// A frame that took too long.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Abandoned {
    /// Points that were drawn; each geometry pass counts them anew.
    pub points: u64,
    /// Points of the whole frame, counted alike.
    pub of: u64,
    pub secs: f64,
}

/// How a paced frame ended.
#[derive(Debug)]
pub enum Paced {
    /// The whole picture; the seconds, by the wall clock, are those of its geometry passes.
    Drawn {
        drawn: Drawn,
        secs: f64,
    },
    Abandoned(Abandoned),
}

impl Runner {
    /// Draws a frame and reads it back, or abandons it once `patience` is over and points are left. The
    /// picture is that of [`Runner::draw`].
    ///
    /// # Errors
    /// As [`Runner::draw`].
    pub fn draw_paced(&mut self, method: &Method, view: &View, patience: Duration) -> Result<Paced, MethodError> {
        self.prepare(method, view)?;
        self.gpu.queue.write_buffer(&self.targets.counters, 0, &[0; 8]);
        let encoder = || self.gpu.device.create_command_encoder(&Default::default());
        let mut clear = encoder();
        self.record_clear(&mut clear, method.plan, None);
        self.gpu.queue.submit([clear.finish()]);
        device::wait(&self.gpu.device)?;
        let of = self.points() * method.plan.geometry.len() as u64;
        let (start, mut points) = (Instant::now(), 0);
        for step in method.plan.geometry {
            let mut len = FIRST_POINTS;
            let mut is_first = true;
            for page in &self.pages.pages {
                let mut at = 0;
                while at < page.len {
                    if points > 0 && start.elapsed() > patience {
                        let secs = start.elapsed().as_secs_f64();
                        return Ok(Paced::Abandoned(Abandoned { points, of, secs }));
                    }
                    let begun = Instant::now();
                    let part = self.pages.part(&self.gpu.device, &self.gpu.queue, page, at, len);
                    self.submit_part(step, (&part.bind, part.len), is_first)?;
                    is_first = false;
                    at += part.len;
                    points += u64::from(part.len);
                    len = next(len, begun.elapsed(), patience);
                }
            }
            if is_first && matches!(step, Step::Draw) {
                // Without points, the textures are still to be cleared.
                if let Some(page) = self.pages.pages.first() {
                    self.submit_part(step, (&page.bind, 0), true)?;
                }
            }
        }
        let secs = start.elapsed().as_secs_f64();
        let mut resolve = encoder();
        self.record_resolve(&mut resolve, method.plan, None);
        Ok(Paced::Drawn { drawn: self.read_back(resolve, method)?, secs })
    }

    fn submit_part(&self, step: &Step, part: (&wgpu::BindGroup, u32), is_first: bool) -> Result<(), MethodError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.record_step(&mut encoder, step, std::iter::once(part), is_first, None);
        self.gpu.queue.submit([encoder.finish()]);
        Ok(device::wait(&self.gpu.device)?)
    }
}

/// Points of the next submission, after `len` points took `took`: more if that was short, fewer if it was long.
fn next(len: u32, took: Duration, patience: Duration) -> u32 {
    let share = took.as_secs_f64() / (patience.as_secs_f64() * SUBMISSION_SHARE).max(1e-9);
    let next = match share {
        s if s < 1.0 / 8.0 => len.saturating_mul(8),
        s if s < 0.5 => len.saturating_mul(2),
        s if s > 2.0 => len / 4,
        _ => len,
    };
    (next / PART_STRIDE * PART_STRIDE).max(PART_STRIDE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn submissions_follow_the_time_they_take() {
        let secs = Duration::from_secs_f64;
        let next = |len, took| next(len, secs(took), secs(16.0));
        assert_eq!(next(1000, 0.01), 8000);
        assert_eq!(next(1000, 0.3), 2000 / PART_STRIDE * PART_STRIDE);
        assert_eq!(next(1024, 1.0), 1024);
        assert_eq!(next(1024, 5.0), 256);
        assert_eq!(next(64, 99.0), PART_STRIDE, "never nothing");
        assert_eq!(next(u32::MAX, 0.0) % PART_STRIDE, 0);
    }
}
