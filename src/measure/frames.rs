//! `firstlight bench-frames`: does the frame time stay flat while a scene grows?
//!
//! Loads a scene with the camera in motion, every frame drawn to its end before the next begins, and
//! stops at given numbers of points to time frames there, with nothing else going on.

use std::{fmt::Write, time::Instant};

use serde::Serialize;

use super::{
    feed::{Fed, Feed},
    stats::quantile,
};
use crate::{
    headless::default_camera_of,
    render::{
        Backend, BackendInfo, Camera, ColorBy, FillBudget, FrameRequest, Look, PassTimes, PointSize, Progressive,
        RenderError, StoreOptions, Sums,
    },
    scene::SceneFacts,
    source::SourceError,
    store::{Encoding, Packing, TooWide},
};

/// What to measure.
#[derive(Debug, Clone)]
pub struct BenchFrames {
    pub size: [u32; 2],
    pub seed: u64,
    pub fill: FillBudget,
    /// Numbers of points at which loading pauses; the end of the scene is always one.
    pub at: Vec<u64>,
    /// Frames to time at each.
    pub frames: u32,
    pub look: Look,
    /// How positions are stored; `None`: as a viewer does.
    pub encoding: Option<Encoding>,
}

/// Frame times, milliseconds, in the order they were drawn.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Samples {
    /// From the frame's first command to its last pixel, as the program sees it.
    pub wall_ms: Vec<f64>,
    /// Passes on the device's clock, where it has one; a frame may be missing.
    pub passes: Vec<PassTimes>,
}

impl Samples {
    fn device_ms(&self) -> Vec<f64> {
        self.passes.iter().map(|times| times.total() * 1e3).collect()
    }
}

/// What was measured with a number of points loaded.
#[derive(Debug, Clone, Serialize)]
pub struct Level {
    pub points: u64,
    /// Frames drawn while loading, since the level before.
    pub loading: Samples,
    /// Frames drawn with loading paused and the camera in motion.
    pub moving: Samples,
    /// Frames drawn after that with the camera at rest, until the picture has converged.
    pub resting: Samples,
    /// Frames that draw all points at once.
    pub brute_force: Samples,
    /// Points that the last moving frame tried.
    pub fill_points: u32,
    /// Pixels that show a point once all were tried. Frames cost what they show, not what is loaded.
    pub covered_pixels: u64,
    /// Seconds spent loading, from the start of the program, without the pauses.
    pub loaded_secs: f64,
}

/// The whole measurement.
#[derive(Debug, Clone, Serialize)]
pub struct BenchFramesReport {
    pub program: String,
    #[serde(flatten)]
    pub backend: BackendInfo,
    pub inputs: Vec<String>,
    pub size_px: [u32; 2],
    /// How the scene was shown.
    pub look: Look,
    /// How colours were summed up for high-quality shading; none without it.
    pub high_quality: Option<Sums>,
    pub color_by: ColorBy,
    /// Points that its filter shows once all are loaded.
    pub points_shown: Option<u64>,
    pub seed: u64,
    /// Points per second of the reader alone, without a GPU; only for files.
    pub decoded_points_per_sec: Option<f64>,
    pub secs_to_first_picture: f64,
    pub levels: Vec<Level>,
}

/// Why there is nothing to report.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    #[error(transparent)]
    Source(#[from] SourceError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Camera(#[from] crate::render::CameraError),
    #[error(transparent)]
    TooWide(#[from] TooWide),
    #[error("the scene has no points to measure with")]
    NoPoints,
}

struct Run<'a> {
    settings: &'a BenchFrames,
    progressive: Progressive<Box<dyn Backend>>,
    scene: Option<(std::sync::Arc<SceneFacts>, Camera)>,
    frame: u32,
}

/// Measures. `started` is where seconds to the first picture begin; `decoded_points_per_sec` is passed
/// on to the report.
///
/// # Errors
/// If nothing can be read or drawn.
pub fn bench_frames(
    settings: &BenchFrames,
    mut feed: Feed,
    mut backend: Box<dyn Backend>,
    decoded_points_per_sec: Option<f64>,
    started: Instant,
) -> Result<BenchFramesReport, BenchError> {
    backend.set_encoding(settings.encoding);
    let info = backend.info().clone();
    let backend_sums = backend.sums();
    let options = StoreOptions { seed: settings.seed, ..Default::default() };
    let mut run = Run { settings, progressive: Progressive::new(backend, options), scene: None, frame: 0 };
    run.progressive.set_filter(&settings.look.filter, &settings.look.clip);
    let mut report = BenchFramesReport {
        program: concat!("firstlight ", env!("CARGO_PKG_VERSION")).into(),
        backend: info,
        inputs: vec![],
        size_px: settings.size,
        high_quality: settings.look.shading.high_quality.then_some(backend_sums),
        color_by: settings.look.coloring.by.clone(),
        points_shown: None,
        look: settings.look.clone(),
        seed: settings.seed,
        decoded_points_per_sec,
        secs_to_first_picture: 0.0,
        levels: vec![],
    };
    let mut at = settings.at.clone();
    at.sort_unstable();
    let mut at = at.into_iter().peekable();
    let mut loading = Samples::default();
    let mut paused_secs = 0.0;
    let mut ended = false;
    loop {
        let mut wait = true;
        while !ended && run.progressive.wants_points() {
            match feed.next(wait || run.scene.is_none())? {
                Fed::Opened(facts) => {
                    report.inputs = facts.files.iter().map(|file| file.path.display().to_string()).collect();
                    if settings.encoding == Some(Encoding::Packed) {
                        Packing::of_scene(&facts.grid, &facts.bounds)?;
                    }
                    run.progressive.open(facts.clone());
                    run.progressive.set_coloring(&settings.look.coloring);
                    run.progressive.set_filter(&settings.look.filter, &settings.look.clip);
                    run.progressive.carry(settings.look.attributes());
                    let camera = default_camera_of(&facts, None, settings.size, &settings.look);
                    run.scene = Some((facts, camera));
                }
                Fed::Batch(batch) => run.progressive.offer(batch),
                Fed::Ended => {
                    run.progressive.end_of_input();
                    ended = true;
                }
                Fed::Nothing => break,
            }
            // Once a frame has something to insert, it waits for no more.
            wait = run.progressive.waiting() == 0;
        }
        match run.draw(&mut loading) {
            // What fits is measured.
            Err(BenchError::Render(RenderError::OutOfMemory { .. })) => ended = true,
            other => other?,
        }
        run.progressive.spent().for_each(|batch| feed.recycle(batch));
        let points = run.progressive.points_stored();
        if points > 0 && report.secs_to_first_picture == 0.0 {
            report.secs_to_first_picture = started.elapsed().as_secs_f64();
        }
        let done = run.progressive.is_loaded() || (ended && run.progressive.is_full());
        if done || at.peek().is_some_and(|&level| points >= level) {
            while at.next_if(|&level| level <= points).is_some() {}
            let pause = Instant::now();
            let loaded_secs = (pause - started).as_secs_f64() - paused_secs;
            report.levels.push(run.level(std::mem::take(&mut loading), loaded_secs)?);
            paused_secs += pause.elapsed().as_secs_f64();
        }
        if done {
            report.backend.clone_from(run.progressive.backend().info());
            report.points_shown = run.progressive.wait_for_points_shown()?;
            return if points > 0 { Ok(report) } else { Err(BenchError::NoPoints) };
        }
    }
}

impl Run<'_> {
    /// The camera goes round the scene, a degree a frame.
    fn request(&mut self) -> Result<Option<FrameRequest>, BenchError> {
        let Some((facts, camera)) = &self.scene else { return Ok(None) };
        let camera = camera.turned(self.frame.into());
        self.frame += 1;
        let view = camera.view(&facts.grid, self.settings.size, self.settings.look.point_size.on(facts))?;
        Ok(Some(FrameRequest { view, fill: self.settings.fill, shading: self.settings.look.shading }))
    }

    /// Draws the next frame to its end. Without points there is nothing to time.
    fn draw(&mut self, samples: &mut Samples) -> Result<(), BenchError> {
        let Some(request) = self.request()? else { return Ok(()) };
        let start = Instant::now();
        let frame = self.progressive.frame(&request)?;
        self.progressive.backend_mut().wait()?;
        if frame.points_stored > 0 {
            samples.wall_ms.push(start.elapsed().as_secs_f64() * 1e3);
            // Times of the frame before: this frame took them in to set its budget.
            samples.passes.extend(self.progressive.last_pass_times());
        }
        Ok(())
    }

    /// Frames of a still camera until nothing is left to draw.
    fn come_to_rest(&mut self) -> Result<Samples, BenchError> {
        let mut samples = Samples::default();
        let Some(request) = self.request()? else { return Ok(samples) };
        loop {
            let start = Instant::now();
            let drawn = self.progressive.frame(&request)?.drawn;
            self.progressive.backend_mut().wait()?;
            if !drawn {
                return Ok(samples);
            }
            samples.wall_ms.push(start.elapsed().as_secs_f64() * 1e3);
            samples.passes.extend(self.progressive.last_pass_times());
        }
    }

    fn level(&mut self, loading: Samples, loaded_secs: f64) -> Result<Level, BenchError> {
        // Not in a frame that is timed.
        self.progressive.backend_mut().choose()?;
        // The same views at every level.
        self.frame = 0;
        let mut moving = Samples::default();
        for _ in 0..self.settings.frames {
            self.draw(&mut moving)?;
        }
        let fill_points = self.progressive.last_pass_times().map_or(0, |times| times.fill_points);
        let resting = self.come_to_rest()?;
        let mut brute_force = Samples::default();
        for _ in 0..3 {
            let Some(request) = self.request()? else { break };
            let start = Instant::now();
            self.progressive.brute_force(&request)?;
            self.progressive.backend_mut().wait()?;
            brute_force.wall_ms.push(start.elapsed().as_secs_f64() * 1e3);
            brute_force.passes.extend(self.progressive.backend_mut().pass_times());
        }
        let picture = self.progressive.read()?;
        let covered_pixels = picture.records.iter().filter(|&&record| record >= 0).count() as u64;
        let points = self.progressive.points_stored();
        Ok(Level { points, loading, moving, resting, brute_force, fill_points, covered_pixels, loaded_secs })
    }
}

/// The report as a table.
pub fn markdown(report: &BenchFramesReport) -> String {
    let mut out = String::new();
    let [width, height] = report.size_px;
    let points = match report.look.point_size {
        PointSize::Pixels(pixels) => format!("{pixels} px"),
        world => world.to_string(),
    };
    let mut line = |text: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{text}");
    };
    line(format!(
        "{} ({}), {}, {} positions, {width}x{height}, {} points{}, coloured by {}; {}",
        report.backend.adapter,
        report.backend.api,
        report.backend.method,
        report.backend.encoding.name(),
        points,
        report.high_quality.map(|sums| format!(", high quality ({sums})")).unwrap_or_default(),
        report.color_by,
        report.inputs.join(", ")
    ));
    line(format!("first picture after {:.2} s", report.secs_to_first_picture));
    if let Some(rate) = report.decoded_points_per_sec {
        line(format!("reader alone: {:.1} million points/s", rate * 1e-6));
    }
    let (last, shown) = (report.levels.last(), report.points_shown);
    if let Some((level, shown)) = last.zip(shown).filter(|(level, shown)| *shown < level.points) {
        line(format!("{shown} of {} points are shown", level.points));
    }
    line(String::new());
    line("| points loaded | pixels covered | frame, ms (median) | 99th percentile | on the device | points tried | at rest, frames | ms in all | while loading, ms (median) | 99th percentile | all points at once, ms | loaded after, s |".into());
    line("|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|".into());
    for level in &report.levels {
        line(format!(
            "| {:.1} M | {:.2} M | {:.1} | {:.1} | {:.1} | {:.2} M | {} | {:.1} | {:.1} | {:.1} | {:.1} | {:.2} |",
            level.points as f64 * 1e-6,
            level.covered_pixels as f64 * 1e-6,
            quantile(&level.moving.wall_ms, 0.5),
            quantile(&level.moving.wall_ms, 0.99),
            quantile(&level.moving.device_ms(), 0.5),
            f64::from(level.fill_points) * 1e-6,
            level.resting.wall_ms.len(),
            level.resting.wall_ms.iter().sum::<f64>(),
            quantile(&level.loading.wall_ms, 0.5),
            quantile(&level.loading.wall_ms, 0.99),
            quantile(&level.brute_force.wall_ms, 0.5),
            level.loaded_secs,
        ));
    }
    out
}
