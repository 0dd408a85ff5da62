//! What a frame of the window does: take points, move the camera, draw, say what is on screen.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use eframe::{
    egui::{self, Color32, Context, Id, Response, Sense, Ui, ViewportCommand},
    egui_wgpu::RenderState,
};
use glam::DVec3;

use super::{
    Options,
    blit::Blit,
    input::{self, Hand},
    loading::{Drained, End, First, Loading},
    messages::{Messages, Severity},
    navigation::Navigation,
    overlay::{self, Ask, Averages, Settings, Status},
    probe::Probe,
};
use crate::{
    render::{
        Backend, FillBudget, FrameReport, FrameRequest, GpuBackend, Progressive, RenderError, Shading, StoreOptions,
    },
    scene::SceneFacts,
};

/// Time that a frame may spend on taking batches from the decoders.
const DRAIN_TIME: Duration = Duration::from_millis(4);
/// Device time that the automatic fill budget aims at: at 60 frames per second on a GPU, the rest is
/// for egui, the compositor and other programs.
const GPU_FRAME_SECS: f64 = 0.012;
/// The same for a software adapter, which has no better than 20 frames per second to give.
const SOFTWARE_FRAME_SECS: f64 = 0.040;
/// How often the numbers are brought up to date while nothing else asks for a frame.
const STATUS_INTERVAL: Duration = Duration::from_millis(250);

pub struct App {
    options: Options,
    ctx: Context,
    progressive: Progressive<GpuBackend>,
    blit: Blit,
    target_secs: f64,
    /// The scene on screen.
    loading: Option<Loading>,
    /// The one that replaces it as soon as its headers are read.
    incoming: Option<(Loading, Vec<PathBuf>)>,
    navigation: Option<Navigation>,
    hand: Hand,
    probe: Probe,
    settings: Settings,
    messages: Messages,
    size: [u32; 2],
    /// Size of the picture that could not be drawn; another may do.
    undrawable: Option<([u32; 2], bool)>,
    last_report: Option<FrameReport>,
    pace: Pace,
}

impl App {
    pub fn new(ctx: &Context, state: &RenderState, options: Options) -> Result<App, RenderError> {
        let backend = GpuBackend::on_device(&state.adapter, state.device.clone(), state.queue.clone(), options.method)?;
        let software = state.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        ctx.set_theme(egui::Theme::Dark);
        let store = StoreOptions { seed: options.seed, ..Default::default() };
        let mut look = options.look.clone();
        // Switched off, it comes back with the usual strength.
        let edl = look.shading.edl_strength > 0.0;
        if !edl {
            look.shading.edl_strength = Shading::default().edl_strength;
        }
        let mut app = App {
            ctx: ctx.clone(),
            progressive: Progressive::new(backend, store),
            blit: Blit::new(&state.device, state.target_format),
            target_secs: if software { SOFTWARE_FRAME_SECS } else { GPU_FRAME_SECS },
            loading: None,
            incoming: None,
            navigation: None,
            hand: Hand::default(),
            probe: Probe::new(&state.device, &state.queue),
            settings: Settings { look, edl, overlay: true, help: false },
            messages: Messages::default(),
            size: [0, 0],
            undrawable: None,
            last_report: None,
            pace: Pace::default(),
            options,
        };
        if !app.options.inputs.is_empty() {
            app.open(app.options.inputs.clone());
        }
        Ok(app)
    }

    /// Starts to read; what is on screen stays until the new headers are known.
    fn open(&mut self, inputs: Vec<PathBuf>) {
        let ctx = self.ctx.clone();
        let wake = Arc::new(move || ctx.request_repaint());
        self.incoming = Some((Loading::start(&inputs, self.options.threads, wake), inputs));
    }

    /// Takes over the incoming scene once its headers are read.
    fn take_incoming(&mut self) {
        // The first camera is chosen for the window's shape.
        if self.size.contains(&0) {
            return;
        }
        let Some((loading, inputs)) = &mut self.incoming else { return };
        match loading.take_first() {
            First::Nothing => {}
            First::Failed(error) => {
                self.messages.add(Severity::Error, error);
                self.incoming = None;
            }
            First::Opened(scene) => {
                self.messages.clear();
                for warning in &scene.warnings {
                    self.messages.add(Severity::Note, warning.as_str());
                }
                let title = format!("{} – firstlight", title(&scene, inputs));
                self.ctx.send_viewport_cmd(ViewportCommand::Title(title));
                self.navigation = Some(Navigation::new(scene.grid, &scene.bounds, self.size));
                self.progressive.open(scene);
                self.undrawable = None;
                self.last_report = None;
                self.loading = self.incoming.take().map(|(loading, _)| loading);
            }
        }
    }

    /// Lets points in and draws; true if the next frame should follow at once.
    fn advance(&mut self) -> bool {
        let mut again = false;
        let fill = self.fill_budget();
        if let Some(loading) = &mut self.loading {
            match loading.drain(&mut self.progressive, DRAIN_TIME) {
                Drained::Empty => {}
                Drained::More => again = true,
                Drained::Ended(End::Finished(report)) => {
                    again = true;
                    self.messages.add_report(&report);
                    log::debug!("read {} points in {:.3?}", loading.points_read(), loading.elapsed());
                }
                Drained::Ended(End::Failed(error)) => {
                    again = true;
                    self.messages.add(Severity::Error, error);
                }
            }
            if loading.is_running() && self.progressive.is_full() {
                loading.stop();
                self.progressive.end_of_input();
            }
        }
        if let Some(navigation) = &self.navigation
            && self.size[0] > 0
            && self.size[1] > 0
            && self.undrawable != Some((self.size, self.settings.look.shading.high_quality))
        {
            match draw(&mut self.progressive, navigation, self.size, &self.settings, fill) {
                Ok(report) => {
                    self.last_report = Some(report);
                    self.pace.note_drawn(&report);
                    again |= report.drawn;
                }
                Err(error) => {
                    // What is stored is still there to be shown.
                    again |= matches!(error, RenderError::OutOfMemory { .. });
                    if !again {
                        self.undrawable = Some((self.size, self.settings.look.shading.high_quality));
                    }
                    self.messages.add(Severity::Error, sentence(&error.to_string()));
                }
            }
        }
        again
    }

    fn fill_budget(&self) -> FillBudget {
        self.options.fill.map_or(FillBudget::Target(self.target_secs), FillBudget::Fixed)
    }

    fn show_view(&mut self, ask: Ask) {
        let Some(navigation) = &mut self.navigation else { return };
        match ask {
            Ask::Home => navigation.home(),
            Ask::Top => navigation.look_from(DVec3::Z),
            Ask::Front => navigation.look_from(-DVec3::Y),
            Ask::Side => navigation.look_from(DVec3::X),
        }
    }

    fn status(&self) -> Option<Status> {
        let loading = self.loading.as_ref()?;
        let scene = loading.scene()?;
        let info = self.progressive.backend().info();
        let files = match &scene.files[..] {
            [] => String::new(),
            [file] => name(&file.path),
            [first, rest @ ..] => format!("{} and {} more", name(&first.path), rest.len()),
        };
        Some(Status {
            files,
            kind: scene.files.first().map(|file| file.kind.clone()).unwrap_or_default(),
            loading: loading.is_running() || !self.progressive.is_loaded(),
            points_read: loading.points_read(),
            points_stored: self.progressive.points_stored(),
            points_total: scene.points_in_header(),
            points_per_sec: loading.rate(),
            loading_secs: loading.elapsed().as_secs_f64(),
            fill: self.progressive.fill_points(self.fill_budget()),
            fill_is_fixed: self.options.fill.is_some(),
            device_secs: self.progressive.last_pass_times().map(|times| times.total()),
            window_secs: self.pace.secs,
            points_tried: self.last_report.map_or(0, |report| report.points_tried),
            averages: self.averages(),
            adapter: info.adapter.clone(),
            choice: info.choice.clone(),
        })
    }

    fn averages(&self) -> Averages {
        let points = self.last_report.map_or(0, |report| report.points_averaged);
        match (self.settings.look.shading.high_quality, self.progressive.averages_in_motion(self.fill_budget())) {
            (false, _) => Averages::Off,
            (true, true) => Averages::On(points),
            (true, false) => Averages::AtRest(points),
        }
    }

    fn show_overlay(&mut self, ui: &Ui) -> Option<Ask> {
        let mut asked = None;
        if !overlay::fits(ui.ctx()) {
            return None;
        }
        if self.settings.overlay
            && let Some(status) = self.status()
        {
            asked = overlay::bar(ui.ctx(), &status, &mut self.settings);
        }
        if self.loading.is_none() {
            let waiting_for = self.incoming.as_ref().and_then(|(_, inputs)| inputs.first());
            overlay::invitation(ui, waiting_for.map(|path| name(path)).as_deref());
        }
        if self.settings.help {
            overlay::help(ui.ctx(), &mut self.settings);
        }
        self.messages.show(ui.ctx());
        if ui.input(|i| !i.raw.hovered_files.is_empty()) {
            overlay::drop_target(ui.ctx());
        }
        asked
    }

    /// Lets the backend measure which method is the fastest, a few milliseconds a frame, while nothing
    /// moves: neither the picture nor the hand on the mouse.
    fn measure_at_rest(&mut self, ctx: &Context) {
        let again = if ctx.input(|i| i.pointer.any_down()) {
            Ok(Some(STATUS_INTERVAL))
        } else {
            self.progressive.backend_mut().measure_at_rest()
        };
        match again {
            Ok(Some(time)) => ctx.request_repaint_after(time),
            Ok(None) => {}
            // The next frame's error is the one to show.
            Err(error) => log::error!("{error}"),
        }
    }

    /// Asks what the cursor is on, for the next move of the mouse.
    fn feel(&mut self, ctx: &Context, picture: &Response) {
        if picture.contains_pointer()
            && let Some(at) = ctx.input(|i| i.pointer.hover_pos())
            && let Some(navigation) = &self.navigation
            && let Some((words, size)) = self.progressive.backend().words_buffer()
        {
            self.probe.ask(words, size, input::pixel(ctx, picture, at), navigation);
        }
    }

    fn paint(&mut self, ui: &Ui) {
        if self.loading.is_none() {
            return;
        }
        if let Some((picture, size)) = self.progressive.backend().picture_buffer() {
            let callback = self.blit.paint(ui.max_rect(), picture, size, Shading::default().background);
            ui.painter().add(callback);
        }
    }
}

impl eframe::App for App {
    /// Loading goes on while the window is hidden, when [`App::ui`] is not called.
    fn logic(&mut self, ctx: &Context, _: &mut eframe::Frame) {
        if ctx.input(|i| i.viewport().visible()) == Some(false) {
            self.take_incoming();
            if self.advance() {
                ctx.request_repaint();
            }
        }
    }

    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        self.pace.begin();
        let ctx = ui.ctx().clone();
        let rect = ui.max_rect();
        self.size = [rect.width(), rect.height()].map(|side| (side * ctx.pixels_per_point()).round() as u32);

        let dropped: Vec<PathBuf> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).collect());
        if !dropped.is_empty() {
            self.open(dropped);
        }
        self.take_incoming();

        let picture = ui.interact(rect, Id::unique("picture"), Sense::drag());
        let mut asked = None;
        let mut flying = false;
        if !ctx.egui_wants_keyboard_input() {
            asked = input::keys(&ctx, &mut self.settings);
        }
        if let Some(touched) = self.probe.answer() {
            self.hand.touched = touched;
        }
        if let Some(navigation) = &mut self.navigation {
            navigation.resize(self.size);
            self.hand.steer(&ctx, &picture, navigation);
            flying = !ctx.egui_wants_keyboard_input() && input::fly(&ctx, navigation);
        }
        if let Some(ask) = asked {
            self.show_view(ask);
        }

        // Nobody will see the frame after the last.
        let closing = ctx.input(|i| i.viewport().close_requested());
        let mut again = !closing && (self.advance() || flying);
        if !closing && !again {
            self.measure_at_rest(&ctx);
        }
        self.paint(ui);
        self.feel(&ctx, &picture);

        // Last, so that the numbers are those of the picture; what it changes is for the next frame.
        let before = self.settings.clone();
        if let Some(ask) = self.show_overlay(ui) {
            self.show_view(ask);
            again = true;
        }
        again |= self.settings != before;

        if again {
            ctx.request_repaint();
        } else if self.loading.as_ref().is_some_and(Loading::is_running) {
            ctx.request_repaint_after(STATUS_INTERVAL);
        }
        self.pace.end(again);
    }

    fn on_exit(&mut self) {
        // The decoders end while the GPU finishes what it was given.
        self.incoming = None;
        self.loading = None;
    }

    fn clear_color(&self, _: &egui::Visuals) -> [f32; 4] {
        let [r, g, b] = Shading::default().background;
        Color32::from_rgb(r, g, b).to_normalized_gamma_f32()
    }
}

/// Draws what the camera sees, if anything changed.
fn draw(
    progressive: &mut Progressive<GpuBackend>,
    navigation: &Navigation,
    size: [u32; 2],
    settings: &Settings,
    fill: FillBudget,
) -> Result<FrameReport, RenderError> {
    progressive.set_coloring(&settings.look.coloring);
    let mut shading = settings.look.shading;
    if !settings.edl {
        shading.edl_strength = 0.0;
    }
    match navigation.camera().view(navigation.grid(), size, settings.look.point_size) {
        Ok(view) => progressive.frame(&FrameRequest { view, fill, shading }),
        // Navigation keeps its camera usable; if it ever fails to, the last picture stays.
        Err(error) => {
            log::error!("{error}");
            let stored = progressive.points_stored();
            Ok(FrameReport {
                drawn: false,
                points_stored: stored,
                points_tried: stored,
                settled: true,
                fill: 0,
                high_quality: shading.high_quality,
                points_averaged: stored,
            })
        }
    }
}

/// How fast window frames follow each other, and how many there were.
#[derive(Debug, Default)]
struct Pace {
    /// Smoothed time from one frame to the next, while they follow at once.
    secs: f64,
    began: Option<Instant>,
    follows: bool,
    frames: u64,
    drawn: u64,
}

impl Pace {
    fn begin(&mut self) {
        let now = Instant::now();
        if let Some(before) = self.began.replace(now)
            && self.follows
        {
            let secs = (now - before).as_secs_f64();
            self.secs = if self.secs == 0.0 { secs } else { self.secs + 0.2 * (secs - self.secs) };
        }
        self.frames += 1;
    }

    fn note_drawn(&mut self, report: &FrameReport) {
        self.drawn += u64::from(report.drawn);
    }

    fn end(&mut self, follows: bool) {
        if self.follows && !follows {
            log::debug!("at rest after {} window frames, {} drawn", self.frames, self.drawn);
        }
        self.follows = follows;
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// What the user opened, in few words: the folder rather than its files.
fn title(scene: &SceneFacts, inputs: &[PathBuf]) -> String {
    match (inputs, &scene.files[..]) {
        ([input], _) => name(input),
        ([first, rest @ ..], _) => format!("{} and {} more", name(first), rest.len()),
        ([], files) => format!("{} files", files.len()),
    }
}

/// With a capital letter, as a message stands alone.
fn sentence(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or(String::new(), |first| first.to_uppercase().chain(chars).collect())
}
