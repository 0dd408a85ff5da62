//! The whole way of a point, from the file to the picture, as fast as it goes.

use std::{
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use crossbeam_channel::RecvTimeoutError;
use serde::Serialize;

use super::{IngestError, reader::Way};
use crate::{
    device::{PassTimes, Raster, RenderError},
    headless::{BackendChoice, default_camera, make_backend},
    measure::stats::quantile,
    render::{
        Backend, BackendInfo, Camera, ColumnId, FillBudget, FramePlan, FrameReport, FrameRequest, INSERTION_POINTS,
        Keys, Picture, Progressive, RasterChoice, Shading, StoreOptions, Sums,
    },
    scene::{PointBatch, SceneFacts},
    source::{self, Event, SourceError},
    store::{Encoding, Insertion, Packing},
};

/// Where and what to draw.
#[derive(Debug, Clone, Copy)]
pub struct ScreenSettings {
    pub backend: BackendChoice,
    pub method: RasterChoice,
    pub size: [u32; 2],
    pub point_size: u32,
    /// Frame time that the fill budget, and the number of insertions, aim at.
    pub target_secs: f64,
}

/// One frame, drawn to its end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FrameSample {
    /// When it was finished, seconds from the start.
    pub at_secs: f64,
    /// From its first command, insertions included, to its last pixel.
    pub wall_ms: f64,
    pub points_stored: u64,
    pub fill_points: u32,
}

/// One run. Seconds count from the start: the file is opened, and while its header is read, the
/// device is set up, as the program does when it is started.
#[derive(Debug, Clone, Serialize)]
pub struct ScreenSample {
    /// Until the device was ready.
    pub setup_secs: f64,
    /// Until the first batch was taken out of the channel; null without points, as are the next three.
    pub secs_to_first_batch: Option<f64>,
    /// Until the first frame with points was finished.
    pub secs_to_first_picture: Option<f64>,
    /// Until the frame that took in the last points was finished.
    pub secs_to_all_loaded: Option<f64>,
    /// Until all points had been tried in one still view: the picture of all points at once.
    pub secs_to_converged: Option<f64>,
    pub points_stored: u64,
    /// Batches that entered the store.
    pub insertions: u64,
    /// Time on the host to hand the points to the device; null where the store is in its own memory.
    pub upload_secs: Option<f64>,
    /// Time to scatter the points to their slots; null where the device cannot tell it from the
    /// rest of a frame.
    pub scatter_secs: Option<f64>,
    /// Insertions that `scatter_secs` is of: times of some frames may not come back.
    pub scatter_insertions: u64,
    /// Of the frames while points arrived, milliseconds; null without any.
    pub frame_ms_median: Option<f64>,
    pub frame_ms_p99: Option<f64>,
    /// All frames until everything was loaded.
    pub frames: Vec<FrameSample>,
    /// Pixels that show a point in the end.
    pub covered_pixels: u64,
    pub out_of_memory: bool,
}

/// All runs of one way to read.
#[derive(Debug, Clone, Serialize)]
pub struct ScreenRuns {
    #[serde(flatten)]
    pub way: Way,
    pub target_ms: f64,
    pub samples: Vec<ScreenSample>,
}

impl ScreenRuns {
    /// The run that took the median time to load everything.
    pub fn median(&self) -> Option<&ScreenSample> {
        let mut runs: Vec<&ScreenSample> = self.samples.iter().collect();
        let secs = |run: &ScreenSample| run.secs_to_all_loaded.unwrap_or(f64::INFINITY);
        runs.sort_by(|a, b| secs(a).total_cmp(&secs(b)));
        runs.get((runs.len().max(1) - 1) / 2).copied()
    }
}

/// Opens a file, loads it and draws it, with the camera in motion until all is loaded, then still
/// until the picture has converged.
///
/// # Errors
/// If the file cannot be opened, or no device draws.
pub fn run(path: &Path, settings: &ScreenSettings, way: &Way) -> Result<ScreenSample, IngestError> {
    let start = Instant::now();
    let inputs: [PathBuf; 1] = [path.into()];
    let stream = source::open(&inputs, way.options());
    let (backend, _, _) = make_backend(settings.backend, settings.method, None)?;
    let setup_secs = start.elapsed().as_secs_f64();
    let method = backend.info().method;
    let mut run = Run {
        settings,
        start,
        progressive: Progressive::new(Timed::new(backend), StoreOptions::default()),
        scene: None,
        ended: false,
        out_of_memory: false,
        frame: 0,
        first_batch: None,
        frames: Vec::new(),
    };
    let lost = || {
        let reason = "the reader ended without saying why".into();
        SourceError::Io { path: path.into(), doing: "read it", reason }
    };
    let mut due = start;
    while !(run.progressive.is_loaded() || run.out_of_memory) {
        run.take_events(&stream, due, lost)?;
        due = Instant::now() + Duration::from_secs_f64(settings.target_secs);
        if let Some(request) = run.request()? {
            run.draw(&request)?;
        }
        run.progressive.spent().for_each(|batch| stream.recycle(batch));
    }
    let loaded_secs = start.elapsed().as_secs_f64();
    let points = run.progressive.points_stored();
    let mut converged_secs = None;
    let mut covered_pixels = 0;
    if let Some(request) = run.still().filter(|_| points > 0) {
        while !run.still_frame(&request)?.is_converged() {}
        run.progressive.backend_mut().wait()?;
        converged_secs = Some(start.elapsed().as_secs_f64());
        let picture = run.progressive.read()?;
        covered_pixels = picture.records.iter().filter(|&&record| record >= 0).count() as u64;
    }
    let insertions = run.progressive.insertions();
    let timed = run.progressive.backend();
    let (upload_secs, scatter_secs, scatter_insertions) = timed.split(method);
    let wall: Vec<f64> = run.frames.iter().map(|frame| frame.wall_ms).collect();
    Ok(ScreenSample {
        setup_secs,
        secs_to_first_batch: run.first_batch,
        secs_to_first_picture: run.frames.first().map(|frame| frame.at_secs),
        secs_to_all_loaded: (points > 0).then_some(loaded_secs),
        secs_to_converged: converged_secs,
        points_stored: points,
        insertions,
        upload_secs,
        scatter_secs,
        scatter_insertions,
        frame_ms_median: (!wall.is_empty()).then(|| quantile(&wall, 0.5)),
        frame_ms_p99: (!wall.is_empty()).then(|| quantile(&wall, 0.99)),
        frames: run.frames,
        covered_pixels,
        out_of_memory: run.out_of_memory,
    })
}

struct Run<'a> {
    settings: &'a ScreenSettings,
    start: Instant,
    progressive: Progressive<Timed>,
    /// Known once the first batch, or the end, has come.
    scene: Option<(std::sync::Arc<SceneFacts>, Camera)>,
    ended: bool,
    out_of_memory: bool,
    frame: u32,
    first_batch: Option<f64>,
    frames: Vec<FrameSample>,
}

impl Run<'_> {
    /// Takes what the next frame can insert. Points that are enough to insert wait for no more; without
    /// any, frames follow each other at the pace of a display and leave the processor to the decoders.
    fn take_events(
        &mut self,
        stream: &source::Stream,
        due: Instant,
        lost: impl Fn() -> SourceError,
    ) -> Result<(), IngestError> {
        while !self.ended && self.progressive.wants_points() {
            // The first picture waits for one batch only.
            let has_points = self.progressive.points_stored() > 0;
            let enough = if has_points { u64::from(INSERTION_POINTS) } else { 1 };
            let event = if self.progressive.waiting() >= enough {
                stream.events().try_recv().map_err(|error| match error {
                    crossbeam_channel::TryRecvError::Empty => RecvTimeoutError::Timeout,
                    crossbeam_channel::TryRecvError::Disconnected => RecvTimeoutError::Disconnected,
                })
            } else if !has_points {
                // Nothing to draw yet.
                stream.events().recv().map_err(|_| RecvTimeoutError::Disconnected)
            } else {
                stream.events().recv_deadline(due)
            };
            match event {
                Ok(Event::Opened(facts)) => self.progressive.open(facts),
                Ok(Event::Batch(batch)) => {
                    self.first_batch.get_or_insert(self.start.elapsed().as_secs_f64());
                    self.aim(Some(&batch));
                    self.progressive.offer(batch);
                }
                Ok(Event::Finished(_)) => {
                    self.aim(None);
                    self.progressive.end_of_input();
                    self.ended = true;
                }
                Ok(Event::Failed(error)) => return Err(error.into()),
                Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => return Err(lost().into()),
            }
        }
        Ok(())
    }

    /// Fixes the camera, once.
    fn aim(&mut self, first: Option<&PointBatch>) {
        if let (None, Some(facts)) = (&self.scene, self.progressive.scene()) {
            self.scene = Some((facts.clone(), default_camera(facts, first, self.settings.size)));
        }
    }

    /// The next frame's view: a degree further round the scene.
    fn request(&mut self) -> Result<Option<FrameRequest>, IngestError> {
        let Some((facts, camera)) = &self.scene else { return Ok(None) };
        let camera = camera.turned(self.frame.into());
        self.frame += 1;
        let view = camera.view(&facts.grid, self.settings.size, self.settings.point_size)?;
        Ok(Some(FrameRequest { view, fill: self.fill(), shading: Shading::default() }))
    }

    /// The view that loading started with.
    fn still(&self) -> Option<FrameRequest> {
        let (facts, camera) = self.scene.as_ref()?;
        let view = camera.view(&facts.grid, self.settings.size, self.settings.point_size).ok()?;
        Some(FrameRequest { view, fill: self.fill(), shading: Shading::default() })
    }

    fn fill(&self) -> FillBudget {
        FillBudget::Target(self.settings.target_secs)
    }

    fn draw(&mut self, request: &FrameRequest) -> Result<(), IngestError> {
        let begun = Instant::now();
        let frame = match self.progressive.frame(request) {
            Err(RenderError::OutOfMemory { .. }) if !self.out_of_memory => {
                self.out_of_memory = true;
                return Ok(());
            }
            other => other?,
        };
        self.progressive.backend_mut().wait()?;
        if frame.points_stored > 0 {
            self.frames.push(FrameSample {
                at_secs: self.start.elapsed().as_secs_f64(),
                wall_ms: begun.elapsed().as_secs_f64() * 1e3,
                points_stored: frame.points_stored,
                fill_points: frame.fill,
            });
        }
        Ok(())
    }

    fn still_frame(&mut self, request: &FrameRequest) -> Result<FrameReport, IngestError> {
        let frame = self.progressive.frame(request)?;
        self.progressive.backend_mut().wait()?;
        Ok(frame)
    }
}

/// A backend with a clock at the door of its store.
struct Timed {
    inner: Box<dyn Backend>,
    /// Spent in [`Backend::insert`], on the host.
    insert_secs: f64,
    passes: Vec<PassTimes>,
}

impl Timed {
    fn new(inner: Box<dyn Backend>) -> Timed {
        Timed { inner, insert_secs: 0.0, passes: Vec::new() }
    }

    /// Seconds of upload and of scatter, and the insertions that the latter are of.
    fn split(&self, method: Raster) -> (Option<f64>, Option<f64>, u64) {
        let timed = || self.passes.iter().filter(|times| times.insertions > 0);
        let insertions = timed().map(|times| u64::from(times.insertions)).sum();
        let scatter: f64 = timed().map(|times| times.insert).sum();
        if method == Raster::Cpu {
            // Inserting is scattering there.
            return (None, Some(scatter), insertions);
        }
        let tells = insertions > 0 && timed().all(|times| times.undivided == 0.0);
        (Some(self.insert_secs), tells.then_some(scatter), if tells { insertions } else { 0 })
    }
}

impl Backend for Timed {
    fn info(&self) -> &BackendInfo {
        self.inner.info()
    }
    fn sums(&self) -> Sums {
        self.inner.sums()
    }
    fn set_encoding(&mut self, encoding: Option<Encoding>) {
        self.inner.set_encoding(encoding);
    }
    fn reset(&mut self, points: u64, packing: Option<Packing>) {
        self.inner.reset(points, packing);
    }
    fn insertions_per_frame(&self) -> usize {
        self.inner.insertions_per_frame()
    }
    fn resize(&mut self, size: [u32; 2]) -> Result<(), RenderError> {
        self.inner.resize(size)
    }
    fn insert(&mut self, insertion: &Insertion, points: &PointBatch) -> Result<(), RenderError> {
        let begun = Instant::now();
        let inserted = self.inner.insert(insertion, points);
        self.insert_secs += begun.elapsed().as_secs_f64();
        inserted
    }
    fn fill_column(&mut self, column: ColumnId, records: &[u32], keys: Keys<'_>) -> Result<(), RenderError> {
        self.inner.fill_column(column, records, keys)
    }
    fn drop_column(&mut self, column: ColumnId) {
        self.inner.drop_column(column);
    }
    fn set_relocation(&mut self, on: bool) {
        self.inner.set_relocation(on);
    }
    fn draw(&mut self, plan: &FramePlan) -> Result<(), RenderError> {
        self.inner.draw(plan)
    }
    fn pass_times(&mut self) -> Option<PassTimes> {
        let times = self.inner.pass_times()?;
        self.passes.push(times);
        Some(times)
    }
    fn choose(&mut self) -> Result<(), RenderError> {
        self.inner.choose()
    }
    fn wait(&mut self) -> Result<(), RenderError> {
        self.inner.wait()
    }
    fn read(&mut self) -> Result<Picture, RenderError> {
        self.inner.read()
    }
}
