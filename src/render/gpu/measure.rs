//! Measuring which candidate is the fastest, on the scene itself: once enough of it is stored, and again
//! when the picture's size has changed and then stayed for [`SETTLE`].
//!
//! The first picture waits for none of this: it is drawn with the method that is the fastest on most
//! devices. Then candidates are compiled on a thread of their own, and timed one by one between frames, in at
//! most [`SHARE`] of the time, or without that limit while nothing else is to be drawn.

use std::{
    collections::VecDeque,
    thread,
    time::{Duration, Instant},
};

use super::{
    GpuBackend, HardwareRaster, Rasterizer,
    choose::left_out,
    compute::{ComputeRaster, Kernels, Reading, modules},
    probe::{MIN_POINTS, Probe, Scene},
};
use crate::{
    render::{Candidate, Choice, Clock, Measured, Measurement, Raster, RasterChoice, RenderError, View, Why, best},
    store::{Encoding, gpu::GpuStore},
};

/// How long the size of the picture must stay before it is measured for: not while a window is dragged.
const SETTLE: Duration = Duration::from_millis(300);
/// Of the time since the first picture, spent on measuring between frames.
const SHARE: f64 = 0.1;
/// Measuring goes on for so long before the next frame gets its turn.
const SLICE: Duration = Duration::from_millis(4);
/// How soon to ask again for a kernel that is being compiled.
const COMPILING: Duration = Duration::from_millis(10);
/// All of a measurement, on a software rasterizer with the compiling; a candidate that would take longer, judged by the slowest before, is left out. On
/// lavapipe with two cores, a kernel takes 3 to 10 ms if Mesa's cache on disk has it, else 35.
const LIMIT: Duration = Duration::from_millis(500);
const SOFTWARE_LIMIT: Duration = Duration::from_millis(80);
/// Points of one pixel that a run draws at most, of larger ones as many fewer as they have more pixels. On a GPU
/// enough for its timestamps: 20 µs at 100 billion points per second; on a software rasterizer 0.4 ms.
const PROBE_POINTS: u32 = 1 << 21;
const SOFTWARE_PROBE_POINTS: u32 = 1 << 14;

const TOO_LONG: &str = "it would take too long to measure";
const HOPELESS: &str = "slow on every software rasterizer, and long to measure";

/// Width and height of the picture, and width of a point: what a measurement holds for.
type Picture = [u32; 3];

/// What the backend knows about its choice.
pub struct Chooser {
    is_auto: bool,
    device_type: wgpu::DeviceType,
    kernels: Kernels,
    /// Without and with a filter.
    hardware: [Option<HardwareRaster>; 2],
    hardware_maker: Option<thread::JoinHandle<HardwareRaster>>,
    /// What the device can run.
    able: Vec<Candidate>,
    /// How rasterizers read positions.
    pub encoding: Encoding,
    /// What it cannot, with the reason.
    unable: Vec<Measured>,
    ready: Instant,
    /// Points promised for the scene, and those stored by the last frame.
    expected: u64,
    pub stored: u32,
    view: Option<View>,
    first_frame: Option<Instant>,
    /// When the picture's size last became another.
    resized: Option<Instant>,
    measured: Option<Picture>,
    measurements: u32,
    spent: Duration,
    round: Option<Round>,
}

/// A measurement under way.
struct Round {
    probe: Probe,
    picture: Picture,
    waiting: VecDeque<Candidate>,
    table: Vec<Measured>,
    spent: Duration,
    /// That a candidate took so far, for each of its kernels.
    longest: Duration,
}

enum Due {
    Never,
    In(Duration),
    Now,
}

impl Drop for Chooser {
    /// As [`Kernels`]'.
    fn drop(&mut self) {
        self.hardware_maker.take().map(thread::JoinHandle::join);
    }
}

impl Chooser {
    pub fn new(
        kernels: Kernels,
        device_type: wgpu::DeviceType,
        choice: RasterChoice,
        (able, unable): (Vec<Candidate>, Vec<Measured>),
    ) -> Chooser {
        Chooser {
            is_auto: choice == RasterChoice::Auto,
            device_type,
            kernels,
            hardware: [None, None],
            hardware_maker: None,
            able,
            // That of most scenes.
            encoding: Encoding::Packed,
            unable,
            ready: Instant::now(),
            expected: 0,
            stored: 0,
            view: None,
            first_frame: None,
            resized: None,
            measured: None,
            measurements: 0,
            spent: Duration::ZERO,
            round: None,
        }
    }

    /// What the report says before anything is measured.
    pub fn first_choice(&self, candidate: Candidate) -> Choice {
        let (why, reason) = if self.is_auto {
            (Why::Default, "the default of this device; nothing was measured so far")
        } else {
            (Why::AskedFor, "named on the command line")
        };
        let unmeasured = self.able.iter().map(|&candidate| left_out(candidate, "not measured".into()));
        let candidates = unmeasured.chain(self.unable.iter().cloned()).collect();
        Choice { candidate, why, reason: reason.into(), measurement: None, candidates }
    }

    /// A rasterizer that the device can run. `masked`: draws only what a filter shows.
    pub fn rasterizer(
        &mut self,
        device: &wgpu::Device,
        store: &GpuStore,
        candidate: Candidate,
        masked: bool,
    ) -> Rasterizer {
        let reading = self.reading(masked);
        if candidate.method == Raster::Points {
            let make = || HardwareRaster::new(device, &store.pages.layout_positions, reading);
            let raster = self.hardware[usize::from(masked)].get_or_insert_with(make);
            return Rasterizer::Hardware(raster.clone());
        }
        Rasterizer::Compute(ComputeRaster::new(device, candidate, &mut self.kernels, reading))
    }

    fn reading(&self, masked: bool) -> Reading {
        Reading { encoding: self.encoding, masked }
    }

    /// Starts to make what these candidates need, on threads of their own.
    fn make_aside(&mut self, device: &wgpu::Device, store: &GpuStore, candidates: Vec<Candidate>) {
        let wants_points = candidates.iter().any(|candidate| candidate.method == Raster::Points);
        let reading = self.reading(false);
        if self.hardware[0].is_none() && self.hardware_maker.is_none() && wants_points {
            let (device, layout) = (device.clone(), store.pages.layout_positions.clone());
            let make = move || HardwareRaster::new(&device, &layout, reading);
            self.hardware_maker = thread::Builder::new().name("point lists".into()).spawn(make).ok();
        }
        self.kernels.make_aside(device, candidates, reading);
    }

    /// Whether nothing need be compiled for a candidate any more.
    fn is_ready(&mut self, candidate: Candidate) -> bool {
        if candidate.method != Raster::Points {
            return self.kernels.is_ready(candidate, self.reading(false));
        }
        if self.hardware_maker.as_ref().is_some_and(|maker| !maker.is_finished()) {
            return false;
        }
        if let Some(raster) = self.hardware_maker.take().and_then(|maker| maker.join().ok())
            // The encoding may have become another since.
            && raster.reading == self.reading(false)
        {
            self.hardware[0] = Some(raster);
        }
        true
    }

    /// A scene begins; what was measured on the one before need not hold for it.
    pub fn reset(&mut self, points: u64) {
        self.expected = points;
        self.stored = 0;
        self.measured = None;
        self.round = None;
    }

    /// Positions are read otherwise from now on; what was measured need not hold.
    pub fn set_encoding(&mut self, encoding: Encoding) {
        self.encoding = encoding;
        self.hardware = [None, None];
        self.measured = None;
        self.round = None;
    }

    fn picture(&self) -> Option<Picture> {
        self.view.map(|view| [view.width, view.height, view.point_size])
    }

    fn is_software(&self) -> bool {
        self.device_type == wgpu::DeviceType::Cpu
    }

    fn probe_points(&self, point_size: u32) -> u32 {
        let points = if self.is_software() { SOFTWARE_PROBE_POINTS } else { PROBE_POINTS };
        (points / point_size.pow(2)).max(MIN_POINTS)
    }

    /// A frame was drawn.
    fn note_frame(&mut self, view: View, now: Instant) {
        let before = self.picture();
        self.view = Some(view);
        self.first_frame.get_or_insert(now);
        if before.is_some() && before != self.picture() {
            self.resized = Some(now);
            self.round = None;
        }
    }

    fn due(&mut self, now: Instant) -> Due {
        let (true, Some([_, _, point_size])) = (self.is_auto, self.picture()) else { return Due::Never };
        // A scene that is still being read has half of it stored at least, or enough.
        let enough = self.probe_points(point_size).min((self.expected / 2).min(u32::MAX.into()) as u32);
        if let Some(round) = &self.round {
            let next = round.waiting.front().copied();
            return if next.is_none_or(|next| self.is_ready(next)) { Due::Now } else { Due::In(COMPILING) };
        }
        if self.measured == self.picture() || self.stored < enough.max(MIN_POINTS) {
            return Due::Never;
        }
        match self.resized.map(|at| now.saturating_duration_since(at)) {
            Some(since) if since < SETTLE => Due::In(SETTLE - since),
            _ => Due::Now,
        }
    }
}

impl GpuBackend {
    /// After each frame: measures on, as far as time allows.
    pub(super) fn measure_between_frames(&mut self, view: View) -> Result<(), RenderError> {
        let now = Instant::now();
        let chooser = &mut self.chooser;
        chooser.note_frame(view, now);
        let since = chooser.first_frame.map_or(Duration::ZERO, |first| now - first);
        let allowed = since.mul_f64(SHARE).saturating_sub(chooser.spent);
        if !allowed.is_zero() && matches!(chooser.due(now), Due::Now) {
            self.measure(SLICE.min(allowed))?;
        }
        Ok(())
    }

    /// While nothing is to be drawn: measures on for a few milliseconds if that is due, and says when it
    /// wants to be called again, if at all.
    ///
    /// # Errors
    /// A lost device.
    pub fn measure_at_rest(&mut self) -> Result<Option<Duration>, RenderError> {
        match self.chooser.due(Instant::now()) {
            Due::Never => Ok(None),
            Due::In(time) => Ok(Some(time)),
            Due::Now => {
                // In one go on a processor, where each frame of a window between two slices would cost more
                // than what it shows.
                let slice = if self.chooser.is_software() { SOFTWARE_LIMIT } else { SLICE };
                self.measure(slice).map(|()| Some(Duration::ZERO))
            }
        }
    }

    /// Measures to the end, if that is due.
    pub(super) fn measure_all(&mut self) -> Result<(), RenderError> {
        loop {
            match self.measure_at_rest()? {
                None => return Ok(()),
                // Being compiled.
                Some(time) if self.chooser.round.is_some() => thread::sleep(time),
                Some(Duration::ZERO) => {}
                // The size of the picture may still change.
                Some(_) => return Ok(()),
            }
        }
    }

    /// Times candidates until `slice` is over, at least one.
    fn measure(&mut self, slice: Duration) -> Result<(), RenderError> {
        let start = Instant::now();
        let current = self.current();
        let limit = if self.chooser.is_software() { SOFTWARE_LIMIT } else { LIMIT };
        let mut round = match self.chooser.round.take() {
            Some(round) => round,
            None => match self.begin_round()? {
                Some(round) => round,
                None => return Ok(()),
            },
        };
        let spent_before = round.spent;
        loop {
            round.spent = spent_before + start.elapsed();
            let Some(&candidate) = round.waiting.front() else { break };
            if !self.chooser.is_ready(candidate) {
                break;
            }
            round.waiting.pop_front();
            let kernels = modules(candidate.method).len().max(1) as u32;
            if round.spent + kernels * round.longest > limit && candidate != current {
                round.table.push(left_out(candidate, TOO_LONG.into()));
                continue;
            }
            let begun = Instant::now();
            let mut rasterizer = self.chooser.rasterizer(&self.device, &self.store, candidate, false);
            let compiled = begun.elapsed();
            let speed = round.probe.speed(&mut self.scene(), &mut rasterizer)?;
            round.longest = round.longest.max(begun.elapsed() / kernels);
            log::debug!("measuring {candidate}: {compiled:.1?} to compile, {:.1?} in all", begun.elapsed());
            let left_out = speed.is_none().then(|| "no time could be taken".into());
            round.table.push(Measured { candidate, speed, left_out });
            if start.elapsed() >= slice && !round.waiting.is_empty() {
                break;
            }
        }
        if round.waiting.is_empty() {
            self.measure_again(&mut round)?;
        }
        round.spent = spent_before + start.elapsed();
        self.chooser.spent += start.elapsed();
        if round.waiting.is_empty() {
            self.finish_round(round);
        } else {
            self.chooser.round = Some(round);
        }
        Ok(())
    }

    /// Another look at the winner and at the current candidate, which was timed first, with caches cold: the
    /// best of many noisy figures is often one that was lucky.
    fn measure_again(&mut self, round: &mut Round) -> Result<(), RenderError> {
        let current = self.current();
        let winner = best(current, &round.table);
        if winner == current {
            return Ok(());
        }
        for candidate in [current, winner] {
            let mut rasterizer = self.chooser.rasterizer(&self.device, &self.store, candidate, false);
            let again = round.probe.speed(&mut self.scene(), &mut rasterizer)?;
            for row in round.table.iter_mut().filter(|row| row.candidate == candidate) {
                row.speed = row.speed.zip(again).map(|(before, again)| before.faster(again));
            }
        }
        Ok(())
    }

    /// Lets a GPU's driver compile what a filter would need before one is set; on a processor that is quick, and would
    /// slow down everything else.
    fn make_masked_aside(&mut self, candidate: Candidate) {
        if !self.chooser.is_software() {
            let reading = self.chooser.reading(true);
            self.chooser.kernels.make_aside(&self.device, vec![candidate], reading);
        }
    }

    pub(super) fn current(&self) -> Candidate {
        self.info.choice.as_ref().map_or(Candidate::new(self.info.method), |choice| choice.candidate)
    }

    fn scene(&mut self) -> Scene<'_> {
        Scene { device: &self.device, queue: &self.queue, store: &self.store, binder: &mut self.binder }
    }

    /// None, and no more attempts for this picture, if there is no memory for it.
    fn begin_round(&mut self) -> Result<Option<Round>, RenderError> {
        let (Some(view), Some(picture)) = (self.chooser.view, self.chooser.picture()) else { return Ok(None) };
        let points = self.chooser.probe_points(view.point_size).min(self.chooser.stored);
        let device_type = self.chooser.device_type;
        let start = Instant::now();
        let current = self.current();
        let scene = Scene { device: &self.device, queue: &self.queue, store: &self.store, binder: &mut self.binder };
        let mut probe = match Probe::new(&scene, &self.layouts, device_type, &view, points) {
            Ok(probe) => probe,
            Err(detail) => {
                self.chooser.measured = Some(picture);
                if let Some(choice) = &mut self.info.choice {
                    choice.reason = format!("no memory to measure with ({detail})");
                }
                return Ok(None);
            }
        };
        let mut rasterizer = self.chooser.rasterizer(&self.device, &self.store, current, false);
        let clear = self.clear.clone();
        probe.prepare(&mut self.scene(), &mut rasterizer, &clear)?;
        // The current one first: without its figure there is nothing to compare with.
        let others = self.chooser.able.iter().copied().filter(|&candidate| candidate != current);
        let mut waiting: VecDeque<_> = [current].into_iter().chain(others).collect();
        let mut table = Vec::new();
        if self.chooser.is_software() {
            let is_hopeless =
                |candidate: &Candidate| *candidate != current && is_hopeless_in_software(candidate.method);
            let hopeless = waiting.iter().copied().filter(is_hopeless);
            table.extend(hopeless.map(|candidate| left_out(candidate, HOPELESS.into())));
            waiting.retain(|candidate| !is_hopeless(candidate));
        }
        // On a processor, compiling aside would slow down everything else.
        if !self.chooser.is_software() {
            self.chooser.make_aside(&self.device, &self.store, waiting.iter().copied().collect());
        }
        log::debug!("measuring: ready after {:.1?}", start.elapsed());
        Ok(Some(Round { probe, picture, waiting, table, spent: Duration::ZERO, longest: Duration::ZERO }))
    }

    fn finish_round(&mut self, round: Round) {
        let before = self.current();
        let now = best(before, &round.table);
        let secs_of = |wanted: Candidate| {
            let row = round.table.iter().find(|row| row.candidate == wanted);
            row.and_then(|row| row.speed).map(|speed| speed.secs_per_point())
        };
        let reason = match (secs_of(now), secs_of(before)) {
            (Some(secs), Some(secs_before)) if now != before => {
                format!("{:.2} times as fast as {before}", secs_before / secs)
            }
            (Some(_), _) => "none is more than 5 % faster".into(),
            _ => "it could not be timed, and nothing can be compared with it".into(),
        };
        let chooser = &mut self.chooser;
        let [width, height, point_size_px] = round.picture;
        let measurement = Measurement {
            at_secs: chooser.ready.elapsed().as_secs_f64(),
            took_secs: round.spent.as_secs_f64(),
            points: round.probe.points,
            size_px: [width, height],
            point_size_px,
            before: chooser.measurements,
        };
        chooser.measured = Some(round.picture);
        chooser.measurements += 1;
        let candidates: Vec<_> = round.table.into_iter().chain(chooser.unable.iter().cloned()).collect();
        log::info!(
            "{now}: {reason}; measured for {width}x{height}, {point_size_px} px points, in {:.1} ms: {}",
            measurement.took_secs * 1e3,
            candidates.iter().filter_map(in_words).collect::<Vec<_>>().join(", "),
        );
        if now != before {
            let mut rasterizer = self.chooser.rasterizer(&self.device, &self.store, now, self.masked);
            if let (Rasterizer::Hardware(raster), Some(targets)) = (&mut rasterizer, &self.targets)
                && let Err(detail) = raster.resize(&self.device, &self.view, &targets.words, targets.size)
            {
                log::warn!("{now} is faster than {before}, but has no memory ({detail})");
                return;
            }
            self.rasterizer = rasterizer;
        }
        self.make_masked_aside(now);
        self.info.method = now.method;
        self.info.choice =
            Some(Choice { candidate: now, why: Why::Measured, reason, measurement: Some(measurement), candidates });
    }
}

/// On a processor, subgroups have a quarter of early-z's speed (15 to 20 million points/s of 70, lavapipe) and
/// take 80 to 200 ms to compile; point lists have a fifteenth.
fn is_hopeless_in_software(method: Raster) -> bool {
    let uses_subgroups = modules(method).iter().any(|shader| shader.needs.contains(wgpu::Features::SUBGROUP));
    method == Raster::Points || uses_subgroups
}

/// Speeds in millions of points per second, of what was measured.
fn in_words(row: &Measured) -> Option<String> {
    let speed = row.speed?;
    let clock = if speed.clock == Clock::Wall { " (wall clock)" } else { "" };
    let [overview, far] = [speed.overview_points_per_sec, speed.far_points_per_sec].map(|rate| rate * 1e-6);
    Some(format!("{} {overview:.0}/{far:.0} M points/s{clock}", row.candidate))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As on a GPU, whose kernels are compiled aside.
    #[test]
    fn what_is_made_aside_arrives() {
        let Ok(mut backend) = GpuBackend::headless(RasterChoice::Auto) else { return };
        let wanted = [Raster::Points, Raster::AtomicMin, Raster::TwoPass32].map(Candidate::new);
        let wanted: Vec<_> = wanted.into_iter().filter(|candidate| backend.chooser.able.contains(candidate)).collect();
        let GpuBackend { chooser, device, store, .. } = &mut backend;
        chooser.make_aside(device, store, wanted.clone());
        let patience = Instant::now() + Duration::from_secs(60);
        for candidate in wanted {
            while !chooser.is_ready(candidate) {
                assert!(Instant::now() < patience, "{candidate} does not arrive");
                thread::sleep(Duration::from_millis(1));
            }
        }
        assert!(chooser.hardware[0].is_some() && chooser.is_ready(Candidate::new(Raster::AtomicMin)));
    }
}
