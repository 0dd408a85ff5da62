//! The scene on screen: what comes in, what is stored, what was drawn. One step a frame.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use eframe::egui::{Context, ViewportCommand};

use super::{
    Options,
    loading::{Drained, End, First, Loading},
    messages::{Messages, Severity},
    navigation::Navigation,
    rereading::Rereading,
    settings::Settings,
};
use crate::{
    render::{FillBudget, FrameReport, FrameRequest, GpuBackend, Progressive, RenderError, StoreOptions, View},
    scene::SceneFacts,
};

/// Time that a frame may spend on taking batches from the decoders.
const DRAIN_TIME: Duration = Duration::from_millis(4);
/// Device time that the automatic fill budget aims at: at 60 frames per second on a GPU, the rest is
/// for egui, the compositor and other programs.
const GPU_FRAME_SECS: f64 = 0.012;
/// The same for a software adapter, which has no better than 20 frames per second to give.
const SOFTWARE_FRAME_SECS: f64 = 0.040;

pub struct SceneState {
    pub progressive: Progressive<GpuBackend>,
    /// The scene on screen.
    pub loading: Option<Loading>,
    /// The one that replaces it as soon as its headers are read.
    pub incoming: Option<(Loading, Vec<PathBuf>)>,
    /// Where the user looks from; none before a scene's headers are read.
    pub navigation: Option<Navigation>,
    pub last_report: Option<FrameReport>,
    fill: FillBudget,
    threads: Option<usize>,
    /// Values that a look needs and that the points came without.
    pub rereading: Rereading,
    /// Size of the picture that could not be drawn; another may do.
    undrawable: Option<([u32; 2], bool, bool)>,
}

/// What [`SceneState::advance`] did.
#[derive(Debug, Clone, Copy)]
pub struct Advance {
    /// The next frame should follow at once.
    pub again: bool,
    pub drawn: bool,
}

impl SceneState {
    pub fn new(backend: GpuBackend, options: &Options, is_software: bool) -> SceneState {
        let store = StoreOptions { seed: options.seed, ..Default::default() };
        let target = FillBudget::Target(if is_software { SOFTWARE_FRAME_SECS } else { GPU_FRAME_SECS });
        let mut progressive = Progressive::new(backend, store);
        progressive.set_coloring(&options.look.coloring);
        SceneState {
            progressive,
            loading: None,
            incoming: None,
            navigation: None,
            last_report: None,
            fill: options.fill.map_or(target, FillBudget::Fixed),
            threads: options.threads,
            rereading: Rereading::default(),
            undrawable: None,
        }
    }

    /// Starts to read; what is on screen stays until the new headers are known.
    pub fn open(&mut self, ctx: &Context, inputs: Vec<PathBuf>, settings: &Settings) {
        let ctx = ctx.clone();
        let wake = Arc::new(move || ctx.request_repaint());
        let carried = settings.look.attributes();
        self.incoming = Some((Loading::start(&inputs, self.threads, carried, wake), inputs));
    }

    /// Takes over the incoming scene once its headers are read.
    pub fn take_incoming(&mut self, ctx: &Context, messages: &mut Messages, size: [u32; 2]) {
        // The first camera is chosen for the window's shape.
        if size.contains(&0) {
            return;
        }
        let Some((loading, inputs)) = &mut self.incoming else { return };
        match loading.take_first() {
            First::Nothing => {}
            First::Failed(error) => {
                messages.add(Severity::Error, error);
                self.incoming = None;
            }
            First::Opened(scene) => {
                messages.clear();
                for warning in &scene.warnings {
                    messages.add(Severity::Note, warning.as_str());
                }
                for absence in self.progressive.coloring().absences(&scene) {
                    messages.add(Severity::Note, absence);
                }
                let title = format!("{} – firstlight", title(&scene, inputs));
                ctx.send_viewport_cmd(ViewportCommand::Title(title));
                self.navigation = Some(Navigation::new(scene.grid, &scene.bounds, size));
                self.progressive.open(scene);
                self.progressive.carry(loading.carried.iter().cloned());
                self.rereading = Rereading::default();
                self.undrawable = None;
                self.last_report = None;
                self.loading = self.incoming.take().map(|(loading, _)| loading);
            }
        }
    }

    /// Lets points in; true if there may be more than this frame takes.
    fn take_points(&mut self, messages: &mut Messages) -> bool {
        let Some(loading) = &mut self.loading else { return false };
        let again = match loading.drain(&mut self.progressive, DRAIN_TIME) {
            Drained::Empty => false,
            Drained::More => true,
            Drained::Ended(End::Finished(report)) => {
                messages.add_report(&report);
                log::debug!("read {} points in {:.3?}", loading.points_read(), loading.elapsed());
                true
            }
            Drained::Ended(End::Failed(error)) => {
                messages.add(Severity::Error, error);
                true
            }
        };
        if loading.is_running() && self.progressive.is_full() {
            loading.stop();
            self.progressive.end_of_input();
        }
        again
    }

    /// Sees to it that the values that the look takes are read, and lets them in; true if there may be more.
    fn take_values(&mut self, ctx: &Context, messages: &mut Messages, settings: &Settings) -> bool {
        if self.progressive.coloring() != &settings.look.coloring {
            self.progressive.set_coloring(&settings.look.coloring);
            self.say_absences(messages, settings);
        }
        let wanted = settings.look.attributes();
        let wake = || {
            let ctx = ctx.clone();
            Arc::new(move || ctx.request_repaint()) as Arc<dyn Fn() + Send + Sync>
        };
        self.rereading.follow(&mut self.progressive, &wanted, self.threads, wake);
        match self.rereading.drain(&mut self.progressive, DRAIN_TIME) {
            Ok(again) => again,
            Err(error) => {
                messages.add(Severity::Error, sentence(&error));
                false
            }
        }
    }

    /// Says which files lack what the points are to be coloured by.
    fn say_absences(&self, messages: &mut Messages, settings: &Settings) {
        if let Some(scene) = self.progressive.scene() {
            for absence in settings.look.coloring.absences(scene) {
                messages.add(Severity::Note, absence);
            }
        }
    }

    /// Lets points in and draws.
    pub fn advance(&mut self, ctx: &Context, messages: &mut Messages, settings: &Settings, size: [u32; 2]) -> Advance {
        let mut again = self.take_points(messages);
        again |= self.take_values(ctx, messages, settings);
        let key = (size, settings.look.shading.high_quality, settings.look.shows_all());
        if size.contains(&0) || self.undrawable == Some(key) {
            return Advance { again, drawn: false };
        }
        let Some(view) = self.view(settings, size) else { return Advance { again, drawn: false } };
        let shading = settings.shading();
        self.progressive.set_filter(&settings.look.filter, &settings.look.clip);
        match self.progressive.frame(&FrameRequest { view, fill: self.fill, shading }) {
            Ok(report) => {
                self.last_report = Some(report);
                Advance { again: again | report.drawn, drawn: report.drawn }
            }
            Err(error) => {
                // What is stored is still there to be shown.
                let again =
                    again | matches!(error, RenderError::OutOfMemory { .. } | RenderError::NoMemoryForValues { .. });
                if !again {
                    self.undrawable = Some(key);
                }
                messages.add(Severity::Error, sentence(&error.to_string()));
                Advance { again, drawn: false }
            }
        }
    }

    /// What the camera sees. Navigation keeps its camera usable; if it ever fails to, the last picture stays.
    pub fn view(&self, settings: &Settings, size: [u32; 2]) -> Option<View> {
        let navigation = self.navigation.as_ref()?;
        let view = navigation.camera().view(navigation.grid(), size, settings.look.point_size);
        view.inspect_err(|error| log::error!("{error}")).ok()
    }

    pub fn fill_budget(&self) -> FillBudget {
        self.fill
    }

    /// Points are on their way.
    pub fn is_loading(&self) -> bool {
        self.loading.as_ref().is_some_and(|loading| loading.is_running()) || !self.progressive.is_loaded()
    }

    /// The picture's buffer and size, if there is a picture.
    pub fn picture(&self) -> Option<(&wgpu::Buffer, [u32; 2])> {
        self.loading.as_ref()?;
        self.progressive.backend().picture_buffer()
    }

    /// Stops reading.
    pub fn close(&mut self) {
        self.incoming = None;
        self.loading = None;
        self.rereading = Rereading::default();
    }
}

/// A path's last part.
pub fn name(path: &Path) -> String {
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
