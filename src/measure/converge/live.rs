//! A run in real time, as a window has it: points as they come from the files, frames at most sixty times a second,
//! each drawn to its end. Nothing is compared here; what every frame did goes into a log, by which
//! [`super::replay`] repeats it.

use std::{
    thread,
    time::{Duration, Instant},
};

use super::{
    ConvergeError,
    driver::Driver,
    input::{self, Feeder, Recording},
    motion::{Director, FRAME, Phase, Seen},
    replay::Logged,
    report::Times,
    settings::Decoded,
};
use crate::{
    measure::{
        feed::{Fed, Feed},
        raster::Input,
    },
    render::FillBudget,
    scene::BATCH_POINTS,
    source::{self, Order},
};

/// Where the points of a run come from, and since when: files, read again, or memory.
pub enum Points<'a> {
    Files(Feed, Instant),
    Memory(Feeder<'a>, Instant),
}

/// Runs through all phases.
///
/// # Errors
/// If nothing can be read or drawn.
pub fn run(
    driver: &mut Driver,
    mut points: Points<'_>,
    phases: &[Phase],
    frames: u32,
    fill: FillBudget,
) -> Result<Vec<Logged>, ConvergeError> {
    let begun = points.begun();
    let mut director = Director::new(phases, frames, true);
    let mut log = Vec::new();
    let mut seen = Seen { loaded: false, converged: false };
    let mut ended = false;
    while let Some((phase, camera)) = director.next(seen) {
        while !ended && driver.progressive.wants_points() {
            // The first picture waits for its points; later frames take what there is.
            match points.next(log.is_empty() && driver.progressive.waiting() == 0)? {
                Fed::Batch(batch) => driver.progressive.offer(batch),
                Fed::Opened(_) => {}
                Fed::Nothing => break,
                Fed::Ended => {
                    driver.progressive.end_of_input();
                    ended = true;
                }
            }
            if log.is_empty() && driver.progressive.waiting() > 0 {
                break;
            }
        }
        let start = Instant::now();
        let report = driver.frame(&camera, fill)?;
        driver.progressive.backend_mut().wait()?;
        let end = Instant::now();
        driver.progressive.spent().for_each(|batch| points.recycle(batch));
        seen = Seen { loaded: driver.progressive.is_loaded(), converged: report.is_converged() };
        if report.drawn {
            let secs = |duration: Duration| duration.as_secs_f64();
            let times = Times { start_secs: secs(start - begun), frame_secs: secs(end - start) };
            let (stored, tried) = (report.points_stored, report.points_tried);
            log.push(Logged { phase, camera, stored, tried, fill: report.fill, times });
        }
        thread::sleep(FRAME.saturating_sub(start.elapsed()));
    }
    Ok(log)
}

impl<'a> Points<'a> {
    /// Opens the files, or begins with the recording if there are none.
    pub fn of(
        input: &Input,
        recording: &'a Recording,
        order: Order,
        decoded: Decoded,
        threads: Option<usize>,
    ) -> Points<'a> {
        let begun = Instant::now();
        match input {
            Input::Files(files) => {
                Points::Files(Feed::Files(source::open(files, input::options(order, decoded, threads))), begun)
            }
            Input::Synth(_) => Points::Memory(Feeder::new(recording), begun),
        }
    }

    fn begun(&self) -> Instant {
        match self {
            Points::Files(_, begun) | Points::Memory(_, begun) => *begun,
        }
    }

    fn next(&mut self, wait: bool) -> Result<Fed, ConvergeError> {
        match self {
            Points::Files(feed, _) => Ok(feed.next(wait)?),
            Points::Memory(feeder, _) => Ok(feeder.next(BATCH_POINTS as u64).map_or(Fed::Ended, Fed::Batch)),
        }
    }

    fn recycle(&self, batch: crate::scene::PointBatch) {
        if let Points::Files(feed, _) = self {
            feed.recycle(batch);
        }
    }
}
