//! One run: events in, frames, outputs.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use super::{
    decorate::{decorate, text_px},
    default_camera_of,
    outputs::{OutputError, picture_sha256, write_npy_f32, write_npy_i64, write_png},
    progress::{Progress, grouped},
    report::{LegendEntry, Report, Seconds, Tally, file_entries, peak_memory_bytes},
    settings::{BackendChoice, Settings, Stop, fields_of},
};
use crate::{
    render::{
        Backend, CameraError, CpuBackend, FrameReport, FrameRequest, GpuBackend, Look, Pick, PickAt, Picture,
        Progressive, RasterChoice, RenderError, Sheet, overlay,
    },
    scene::{PointBatch, SceneFacts},
    source::{self, Event, OpenOptions, SourceError, SourceReport, Stream},
    store::{Encoding, Packing, TooWide},
};

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum HeadlessError {
    #[error(transparent)]
    Input(#[from] SourceError),
    #[error(transparent)]
    Output(#[from] OutputError),
    #[error(transparent)]
    Camera(#[from] CameraError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    TooWide(#[from] TooWide),
    #[error("the reader ended without saying why")]
    ReaderEnded,
}

/// Renders and writes all outputs. A damaged input still gives its picture, of the points that could
/// be read; see [`Report::is_partial`].
pub fn render(settings: &Settings) -> Result<Report, HeadlessError> {
    let (mut run, last_frame) = Run::of_all_points(settings)?;
    let mut picture = run.progressive.read()?;
    run.decorate(&mut picture)?;
    run.seconds.to_picture = Some(run.now());
    run.report.points_shown = run.progressive.wait_for_points_shown()?;
    if run.report.points_shown == Some(0) && run.progressive.points_stored() > 0 {
        let Look { filter, clip, .. } = &settings.look;
        let set = [!filter.clauses.is_empty(), clip.bounds.is_some(), clip.slab.is_some()];
        let set = ["--filter", "--clip", "--slab"].into_iter().zip(set).filter(|(_, is_set)| *is_set);
        let set = set.map(|(option, _)| option).collect::<Vec<_>>().join(" and ");
        run.report.notes.push(format!("no point is shown: {set} left none"));
    }
    let report = run.into_report(last_frame, &picture);
    write_outputs(settings, &report, &picture)?;
    Ok(report)
}

/// What a picture shows at some pixels.
pub struct Picked {
    pub scene: Arc<SceneFacts>,
    /// In the order of the questions.
    pub picks: Vec<Option<Pick>>,
    pub report: Report,
}

/// Renders without writing anything, and says which points are at these pixels, or near them.
pub fn pick(settings: &Settings, questions: &[PickAt]) -> Result<Picked, HeadlessError> {
    let (mut run, last_frame) = Run::of_all_points(settings)?;
    let mut picks = Vec::new();
    for &at in questions {
        let mut ticket = run.progressive.pick(at);
        if ticket.is_none() {
            // For the kernels; outside of the picture there is nothing, now as then.
            run.progressive.backend_mut().wait()?;
            ticket = run.progressive.pick(at);
        }
        run.progressive.backend_mut().wait()?;
        picks.push(ticket.and_then(|ticket| run.progressive.picked(ticket)).flatten());
    }
    let picture = run.progressive.read()?;
    let scene = run.facts.clone().ok_or(HeadlessError::ReaderEnded)?;
    Ok(Picked { scene, picks, report: run.into_report(last_frame, &picture) })
}

type AnyBackend = Box<dyn Backend>;

/// The backend asked for, its name, and notes for the user on how it was chosen.
///
/// # Errors
/// If a GPU is asked for, by name or by one of its methods, and none can do the work.
pub fn make_backend(
    backend: BackendChoice,
    method: RasterChoice,
    threads: Option<usize>,
) -> Result<(AnyBackend, &'static str, Vec<String>), RenderError> {
    let cpu = || Box::new(CpuBackend::new(threads));
    if backend == BackendChoice::Cpu {
        return Ok((cpu(), "cpu", Vec::new()));
    }
    match GpuBackend::headless(method) {
        Ok(gpu) => Ok((Box::new(gpu), "gpu", Vec::new())),
        // Whoever names one of the GPU's methods wants that one.
        Err(error) if backend == BackendChoice::Auto && method == RasterChoice::Auto => {
            Ok((cpu(), "cpu", vec![format!("{error}; drawn on the processor")]))
        }
        Err(error) => Err(error),
    }
}

struct Run<'a> {
    settings: &'a Settings,
    progressive: Progressive<AnyBackend>,
    facts: Option<Arc<SceneFacts>>,
    /// Known once the camera is.
    request: Option<FrameRequest>,
    tally: Tally,
    /// Known once all is read.
    source: Option<SourceReport>,
    out_of_memory: bool,
    /// Only averages are missing, if they were asked for.
    depths_are_final: bool,
    progress: Progress,
    seconds: Seconds,
    report: Report,
}

impl<'a> Run<'a> {
    /// Reads everything and draws the frames up to the last, and says what that one did.
    fn of_all_points(settings: &'a Settings) -> Result<(Run<'a>, FrameReport), HeadlessError> {
        // Reading starts first: a GPU takes a while to set up.
        // What stops half-way repeats bit for bit: then the order of the points must not depend on the disk.
        let slow_read = matches!(settings.stop, Stop::Frames(_) | Stop::Points(_)).then_some(Duration::MAX);
        let fields = fields_of(&settings.look);
        let options = OpenOptions { threads: settings.threads, slow_read, fields, ..Default::default() };
        let stream = source::open(&settings.inputs, options);
        let (mut backend, backend_name, notes) = make_backend(settings.backend, settings.method, settings.threads)?;
        backend.set_encoding(settings.encoding);
        let mut report = Report::new(settings, backend.info(), backend_name);
        report.notes = notes;

        let mut run = Run {
            settings,
            progressive: Progressive::new(backend, settings.store_options()),
            facts: None,
            request: None,
            tally: Tally::default(),
            source: None,
            out_of_memory: false,
            depths_are_final: false,
            progress: Progress::new(settings.progress),
            seconds: Seconds::default(),
            report,
        };
        run.progressive.set_filter(&settings.look.filter, &settings.look.clip);
        let last_frame = run.draw_to_the_end(stream);
        run.progress.finish();
        Ok((run, last_frame?))
    }

    /// Seconds since the program started.
    fn now(&self) -> f64 {
        Instant::now().duration_since(self.settings.started).as_secs_f64()
    }

    /// Takes the stream, so that its threads stop as soon as the last frame is drawn.
    fn draw_to_the_end(&mut self, stream: Stream) -> Result<FrameReport, HeadlessError> {
        loop {
            self.take_events(&stream)?;
            let Some(final_request) = self.request.clone() else { continue };
            let request = self.without_early_averages(final_request.clone());
            let frame = match self.progressive.frame(&request) {
                Err(error @ RenderError::OutOfMemory { .. }) if !self.out_of_memory => {
                    self.out_of_memory = true;
                    self.report.notes.push(error.to_string());
                    continue;
                }
                other => other?,
            };
            self.progressive.spent().for_each(|batch| stream.recycle(batch));
            self.note_frame(&frame)?;
            if self.is_done(&frame) {
                return if self.settings.brute_force { self.draw_brute_force(&final_request) } else { Ok(frame) };
            }
            self.depths_are_final = self.progressive.is_loaded() && frame.has_all_depths();
        }
    }

    /// Nobody sees the frames before the last, so that averages wait until they can stay: unless the run
    /// stops at a given frame, which is to be what a viewer shows.
    fn without_early_averages(&self, mut request: FrameRequest) -> FrameRequest {
        request.shading.high_quality &= counts_frames(self.settings.stop) || self.depths_are_final;
        request
    }

    /// Waits for as many points as the next frame can take, so that every run draws the same frames,
    /// whatever the threads' timing, and the fewest. Only the first frame takes the first points
    /// that there are: how soon something shows is one of the numbers to report.
    fn take_events(&mut self, stream: &Stream) -> Result<(), HeadlessError> {
        while self.source.is_none() && self.progressive.wants_points() {
            if self.report.frames == 0 && self.progressive.waiting() > 0 {
                break;
            }
            let event = stream.events().recv().map_err(|_| HeadlessError::ReaderEnded)?;
            self.take(event)?;
        }
        Ok(())
    }

    fn take(&mut self, event: Event) -> Result<(), HeadlessError> {
        match event {
            Event::Opened(facts) => {
                if self.settings.encoding == Some(Encoding::Packed) {
                    Packing::of_scene(&facts.grid, &facts.bounds)?;
                }
                self.tally = Tally::new(facts.files.len());
                self.progress.expect(facts.points_in_header());
                self.report.notes.extend(facts.warnings.iter().cloned());
                let coloring = &self.settings.look.coloring;
                self.report.notes.extend(coloring.absences(&facts));
                self.report.notes.extend(coloring.without_effect());
                self.report.notes.extend(self.settings.look.filter.absences(&facts));
                self.report.notes.extend(self.settings.look.point_size.doubt(&facts));
                self.progressive.open(facts.clone());
                self.progressive.set_coloring(coloring);
                self.progressive.carry(self.settings.look.attributes());
                self.facts = Some(facts);
            }
            Event::Batch(batch) => {
                self.aim(Some(&batch))?;
                self.tally.arrive(batch.file, batch.len());
                self.progressive.offer(batch);
            }
            Event::Finished(source) => {
                if self.facts.is_none() {
                    return Err(HeadlessError::ReaderEnded);
                }
                self.aim(None)?;
                self.progressive.end_of_input();
                self.source = Some(source);
            }
            Event::Failed(error) => return Err(error.into()),
        }
        Ok(())
    }

    /// Fixes the camera, once.
    fn aim(&mut self, first: Option<&PointBatch>) -> Result<(), HeadlessError> {
        let (None, Some(facts)) = (&self.request, &self.facts) else { return Ok(()) };
        let settings = self.settings;
        let projection = settings.look.projection;
        let given = settings.camera.map(|camera| camera.or_as(projection));
        let camera = given.unwrap_or_else(|| default_camera_of(facts, first, settings.size, &settings.look));
        let width = settings.look.point_size.on(facts);
        let view = camera.view(&facts.grid, settings.size, width)?;
        (self.report.point_size_px, self.report.point_size_world) = (width.pixels(), width.world());
        self.request = Some(FrameRequest { view, fill: settings.fill_budget(), shading: settings.look.shading });
        self.report.camera = Some(camera);
        Ok(())
    }

    /// Draws what is asked for over the picture.
    fn decorate(&self, picture: &mut Picture) -> Result<(), CameraError> {
        let (decor, size) = (self.settings.look.decor, self.settings.size);
        if let (false, Some(camera), Some(facts)) = (decor.is_empty(), &self.report.camera, &self.facts) {
            let sheet = Sheet { size, text_px: text_px(size), covered_below: 0.0 };
            let overlay = overlay(decor, camera, facts, self.progressive.legend().as_ref(), &sheet)?;
            decorate(picture, &overlay, camera.projection);
        }
        Ok(())
    }

    fn note_frame(&mut self, frame: &FrameReport) -> Result<(), RenderError> {
        self.tally.store_holds(frame.points_stored);
        self.report.frames += u64::from(frame.drawn);
        if frame.points_stored > 0 {
            let now = self.now();
            self.seconds.to_first_point.get_or_insert(now);
            if self.seconds.to_first_picture.is_none() && frame.drawn {
                self.progressive.backend_mut().wait()?;
                self.seconds.to_first_picture = Some(self.now());
            }
        }
        if self.progressive.is_loaded() && self.seconds.to_all_loaded.is_none() {
            // With the one above the only waits for the device before the end.
            self.progressive.backend_mut().wait()?;
            self.seconds.to_all_loaded = Some(self.now());
        }
        let expected = self.facts.as_ref().map_or(0, |facts| facts.points_in_header());
        self.progress.update(frame.points_stored, frame.points_tried, expected);
        Ok(())
    }

    fn is_done(&self, frame: &FrameReport) -> bool {
        let loaded = self.progressive.is_loaded();
        match self.settings.stop {
            _ if self.settings.brute_force => loaded,
            Stop::Frames(frames) if self.report.frames >= frames => true,
            _ => loaded && frame.is_converged() && frame.high_quality == self.is_high_quality(),
        }
    }

    /// High-quality shading is asked for, and these colours can be averaged.
    fn is_high_quality(&self) -> bool {
        self.settings.look.shading.high_quality && self.progressive.can_average()
    }

    fn draw_brute_force(&mut self, request: &FrameRequest) -> Result<FrameReport, HeadlessError> {
        let frame = self.progressive.brute_force(request)?;
        self.report.frames += 1;
        Ok(frame)
    }

    fn into_report(mut self, last: FrameReport, picture: &Picture) -> Report {
        let converged = self.progressive.is_loaded() && last.is_converged();
        if converged {
            self.seconds.to_converged = self.seconds.to_picture;
        }
        let mut report = self.report;
        // What was measured in the meantime.
        let info = self.progressive.backend().info();
        report.method = info.method.to_string();
        report.choice.clone_from(&info.choice);
        report.encoding = info.encoding;
        report.files = file_entries(self.facts.as_deref(), &self.tally, self.source.as_ref());
        report.points_in_header = report.files.iter().map(|f| f.points_in_header).sum();
        report.points_decoded = report.files.iter().map(|f| f.points_decoded).sum();
        report.points_stored = self.progressive.points_stored();
        report.read_to_end = self.source.is_some();
        report.points_missing = report.files.iter().map(|f| f.points_missing).sum();
        if self.out_of_memory {
            let left_out = report.points_in_header - report.points_stored.min(report.points_in_header);
            report.points_missing = Some(left_out);
            report.notes.push(format!("memory ran out: {} points are not in the picture", grouped(left_out)));
        }
        report.notes.extend(self.progressive.colorless_files());
        report.batches = self.progressive.insertions();
        report.converged = converged;
        report.grid = self.facts.as_ref().map(|facts| facts.grid);
        report.bounds = self.facts.as_ref().map(|facts| facts.bounds);
        let map = self.settings.look.coloring.map_in_use();
        report.legend = self.progressive.legend().map(|legend| LegendEntry::new(legend, map));
        report.seconds = self.seconds;
        report.peak_memory_bytes = peak_memory_bytes();
        if let Some(source) = &self.source {
            report.reader_memory_bound_bytes = Some(source.memory_bound_bytes);
            report.reader_threads.clone_from(&source.threads);
        }
        if self.settings.look.shading.high_quality && !self.progressive.can_average() {
            let by = &self.settings.look.coloring.by;
            report.notes.push(format!("--hq averages no {by}: each pixel shows its nearest point"));
        }
        if last.high_quality {
            report.high_quality = Some(self.progressive.backend().sums().to_string());
            report.points_averaged = last.points_averaged;
        }
        report.picture_sha256 = picture_sha256(picture);
        report
    }
}

fn counts_frames(stop: Stop) -> bool {
    matches!(stop, Stop::Frames(_))
}

/// The report comes last: where it is, the rest is too.
fn write_outputs(settings: &Settings, report: &Report, picture: &Picture) -> Result<(), OutputError> {
    let outputs = &settings.outputs;
    let size = [picture.width, picture.height];
    if let Some(destination) = &outputs.picture {
        destination.write(|out| write_png(out, picture))?;
    }
    if let Some(destination) = &outputs.ids {
        destination.write(|out| write_npy_i64(out, size, &picture.records))?;
    }
    if let Some(destination) = &outputs.depth {
        destination.write(|out| write_npy_f32(out, size, &picture.depth))?;
    }
    if let Some(destination) = &outputs.report {
        destination.write(|out| {
            serde_json::to_writer_pretty(&mut *out, report)?;
            out.write_all(b"\n")
        })?;
    }
    Ok(())
}
