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
    screenshot::ShotOptions,
    settings::{Section, Settings},
};
use crate::{
    render::{
        Backend, Camera, CameraError, FillBudget, FrameReport, FrameRequest, GpuBackend, Picture, Progressive,
        RenderError, StoreOptions, View,
    },
    scene::{Attribute, SceneFacts},
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
    pub incoming: Option<Incoming>,
    /// What the user opened.
    inputs: Vec<PathBuf>,
    /// Where the user looks from; none before a scene's headers are read.
    pub navigation: Option<Navigation>,
    pub last_report: Option<FrameReport>,
    fill: FillBudget,
    threads: Option<usize>,
    /// Values that a look needs and that the points came without.
    pub rereading: Rereading,
    /// Size of the picture that could not be drawn; another may do.
    undrawable: Option<([u32; 2], bool, bool)>,
    /// The picture that is to be taken for a file.
    pub shot: Option<Shot>,
    /// Attributes that the panel asks for, besides those of the look.
    asked: Vec<Attribute>,
}

/// A picture that is to be taken, of what the camera saw when it was asked for.
pub struct Shot {
    pub options: ShotOptions,
    pub camera: Camera,
}

/// A scene whose headers are being read.
pub struct Incoming {
    loading: Loading,
    pub inputs: Vec<PathBuf>,
    /// The camera stays where it is.
    keeps_view: bool,
    /// Files on screen that this one is to be without.
    closed: Vec<PathBuf>,
}

/// What [`SceneState::take_incoming`] found.
#[derive(Debug, PartialEq, Eq)]
pub enum Taken {
    Nothing,
    /// A scene has replaced the last one. `keeps_view`: by the same files and others, or fewer.
    Scene {
        inputs: Vec<PathBuf>,
        keeps_view: bool,
    },
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
            inputs: Vec::new(),
            navigation: None,
            last_report: None,
            fill: options.fill.map_or(target, FillBudget::Fixed),
            threads: options.threads,
            rereading: Rereading::default(),
            undrawable: None,
            shot: None,
            asked: Vec::new(),
        }
    }

    /// Starts to read; what is on screen stays until the new headers are known. Files that are added are read together
    /// with those on screen, all of them anew: scenes have one grid.
    pub fn open(&mut self, ctx: &Context, inputs: Vec<PathBuf>, add: bool, settings: &Settings) {
        if !add || self.loading.is_none() {
            return self.start(ctx, inputs, false, Vec::new(), settings);
        }
        // What was asked for last counts, on screen or not yet.
        let (mut all, mut closed, keeps_view) = match self.incoming.take() {
            Some(incoming) => (incoming.inputs, incoming.closed, incoming.keeps_view),
            None => (self.inputs.clone(), Vec::new(), true),
        };
        closed.retain(|path| !inputs.contains(path));
        let others: Vec<PathBuf> = inputs.into_iter().filter(|input| !all.contains(input)).collect();
        all.extend(others);
        self.start(ctx, all, keeps_view, closed, settings);
    }

    /// Takes one file away; the others are read anew.
    pub fn close_file(&mut self, ctx: &Context, file: usize, settings: &Settings) {
        let Some(scene) = self.loading.as_ref().and_then(Loading::scene) else { return };
        let Some(path) = scene.files.get(file).map(|file| file.path.clone()) else { return };
        let (asked, mut closed) = match self.incoming.as_ref() {
            // All that is on screen is about to go.
            Some(incoming) if !incoming.keeps_view => return,
            Some(incoming) => (&incoming.inputs, incoming.closed.clone()),
            None => (&self.inputs, Vec::new()),
        };
        closed.push(path);
        // A folder is no more than its files from here on; what is being added stays.
        let kept = scene.files.iter().map(|file| &file.path).filter(|path| !closed.contains(path));
        let added =
            asked.iter().filter(|input| !self.inputs.contains(input) && !scene.files.iter().any(|f| f.path == **input));
        let others: Vec<PathBuf> = kept.chain(added).cloned().collect();
        if !others.is_empty() {
            self.start(ctx, others, true, closed, settings);
        }
    }

    fn start(
        &mut self,
        ctx: &Context,
        inputs: Vec<PathBuf>,
        keeps_view: bool,
        closed: Vec<PathBuf>,
        settings: &Settings,
    ) {
        let ctx = ctx.clone();
        let wake = Arc::new(move || ctx.request_repaint());
        let mut carried = settings.look.attributes();
        // The section counts classes while they come.
        if settings.shows(Section::Filter) && !carried.contains(&Attribute::Classification) {
            carried.push(Attribute::Classification);
        }
        let loading = Loading::start(&inputs, self.threads, carried, wake);
        self.incoming = Some(Incoming { loading, inputs, keeps_view, closed });
    }

    /// Takes over the incoming scene once its headers are read.
    pub fn take_incoming(&mut self, ctx: &Context, messages: &mut Messages, size: [u32; 2]) -> Taken {
        // The first camera is chosen for the window's shape.
        if size.contains(&0) {
            return Taken::Nothing;
        }
        let Some(Incoming { loading, inputs, .. }) = &mut self.incoming else { return Taken::Nothing };
        match loading.take_first() {
            First::Nothing => {}
            First::Failed(error) => {
                messages.add(Severity::Error, error);
                self.incoming = None;
            }
            First::Opened(scene) => {
                messages.begin_scene();
                for warning in &scene.warnings {
                    messages.add(Severity::Note, warning.as_str());
                }
                // Where no file has it, the points are coloured by something else, which is said then.
                let coloring = self.progressive.coloring();
                if scene.files.iter().any(|file| coloring.by.is_in(file)) {
                    for absence in coloring.absences(&scene) {
                        messages.add(Severity::Note, absence);
                    }
                }
                let title = format!("{} – firstlight", title(&scene, inputs));
                ctx.send_viewport_cmd(ViewportCommand::Title(title));
                let mut navigation = Navigation::new(scene.grid, &scene.bounds, size);
                self.progressive.open(scene);
                self.progressive.carry(loading.carried.iter().cloned());
                self.rereading = Rereading::default();
                self.asked.clear();
                self.undrawable = None;
                self.last_report = None;
                if self.incoming.as_ref().is_some_and(|incoming| !incoming.keeps_view) && self.shot.take().is_some() {
                    messages.add(Severity::Note, "Another scene has come before the picture of the last one was taken");
                }
                if let Some(Incoming { loading, inputs, keeps_view, .. }) = self.incoming.take() {
                    if let Some(before) = self.navigation.as_ref().filter(|_| keeps_view) {
                        navigation.set_camera(*before.camera());
                    }
                    self.navigation = Some(navigation);
                    self.loading = Some(loading);
                    self.inputs.clone_from(&inputs);
                    return Taken::Scene { inputs, keeps_view };
                }
            }
        }
        Taken::Nothing
    }

    /// Reads the values of one more attribute, also if that has failed before.
    pub fn ask_for(&mut self, attribute: Attribute) {
        self.rereading.retry(&attribute);
        self.want(attribute);
    }

    /// Reads the values of one more attribute, unless that has failed.
    pub fn want(&mut self, attribute: Attribute) {
        if !self.asked.contains(&attribute) {
            self.asked.push(attribute);
        }
    }

    /// Stops reading; what is read stays, and what is not on screen yet does not come.
    pub fn stop_reading(&mut self) {
        if self.incoming.take().is_some() {
            return;
        }
        if let Some(loading) = self.loading.as_mut().filter(|loading| loading.is_running()) {
            loading.stop();
            self.progressive.end_of_input();
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

    /// Colours the points as the user wants them from now on. Before anything that tells what the colours mean.
    pub fn follow_coloring(&mut self, messages: &mut Messages, settings: &Settings) {
        let coloring = &settings.look.coloring;
        if self.progressive.coloring() != coloring {
            if let (true, Some(attribute)) = (self.progressive.coloring().by != coloring.by, coloring.by.attribute()) {
                self.rereading.retry(attribute);
            }
            self.progressive.set_coloring(coloring);
            self.say_absences(messages, settings);
        }
    }

    /// Sees to it that the values that the look takes are read, and lets them in; true if there may be more.
    fn take_values(&mut self, ctx: &Context, messages: &mut Messages, settings: &Settings) -> bool {
        self.follow_coloring(messages, settings);
        let mut wanted = settings.look.attributes();
        wanted.extend(self.asked.iter().filter(|asked| !wanted.contains(asked)).cloned().collect::<Vec<_>>());
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
        let view = match self.view(settings, size) {
            Ok(Some(view)) => view,
            Ok(None) => return Advance { again, drawn: false },
            // Navigation keeps its camera usable; if it ever fails to, the last picture stays.
            Err(error) => {
                messages.add(Severity::Error, sentence(&error.to_string()));
                return Advance { again, drawn: false };
            }
        };
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

    /// The picture that was asked for, once it can be taken: then all points stored are drawn for it, whatever the
    /// window shows meanwhile, unless that is the same picture. The next frame is to be drawn before anything asks what
    /// the window shows.
    pub fn take_shot(&mut self, settings: &Settings) -> Option<(Shot, Result<Picture, String>)> {
        let wait = self.shot.as_ref()?.options.wait;
        if wait && (self.is_loading() || self.rereading.progress().is_some()) {
            return None;
        }
        let shot = self.shot.take()?;
        let is_on_screen = self.last_report.is_some_and(|report| report.is_converged())
            && self.picture().is_some_and(|(_, size)| size == shot.options.size)
            && self.navigation.as_ref().is_some_and(|navigation| *navigation.camera() == shot.camera);
        let picture = if is_on_screen {
            self.progressive.read().map_err(|error| error.to_string())
        } else {
            self.whole_picture(settings, &shot)
        };
        Some((shot, picture))
    }

    /// How much is read of what a picture waits for, from 0 to 1.
    pub fn read_for_shot(&self) -> f32 {
        let Some(facts) = self.facts() else { return 0.0 };
        let reread = self.rereading.progress().map(|(_, points)| points);
        let read = self.loading.as_ref().map_or(0, Loading::points_read);
        (reread.map_or(read, |reread| reread.min(read)) as f32 / facts.points_in_header().max(1) as f32).min(1.0)
    }

    fn whole_picture(&mut self, settings: &Settings, shot: &Shot) -> Result<Picture, String> {
        let facts = self.facts().ok_or("there is no scene")?;
        let (size, width) = (shot.options.size, settings.look.point_size.on(facts));
        let view = shot.camera.view(&facts.grid, size, width).map_err(|error| error.to_string())?;
        let request = FrameRequest { view, fill: self.fill, shading: settings.shading() };
        let drawn = self.progressive.backend_mut().resize(size).and_then(|()| self.progressive.brute_force(&request));
        drawn.and_then(|_| self.progressive.read()).map_err(|error| error.to_string())
    }

    /// What the camera sees, if there is one.
    fn view(&self, settings: &Settings, size: [u32; 2]) -> Result<Option<View>, CameraError> {
        let Some((navigation, facts)) = self.navigation.as_ref().zip(self.facts()) else { return Ok(None) };
        navigation.camera().view(navigation.grid(), size, settings.look.point_size.on(facts)).map(Some)
    }

    /// What the headers say of the scene on screen.
    pub fn facts(&self) -> Option<&Arc<SceneFacts>> {
        self.loading.as_ref()?.scene()
    }

    /// What the user opened.
    pub fn inputs(&self) -> &[PathBuf] {
        &self.inputs
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

/// With a capital letter, as a message stands alone; a path at its beginning is another one with it.
pub fn sentence(text: &str) -> String {
    let first_word = text.split([' ', ':']).next().unwrap_or_default();
    if first_word.contains(['/', '\\', '.']) {
        return text.to_owned();
    }
    let mut chars = text.chars();
    chars.next().map_or(String::new(), |first| first.to_uppercase().chain(chars).collect())
}

#[cfg(test)]
mod tests {
    use super::sentence;

    #[test]
    fn a_path_keeps_its_first_letter() {
        assert_eq!(sentence("no memory for 3 values"), "No memory for 3 values");
        for path in ["data/gone.laz: no such file", "gone.laz: no such file", r"scans\gone.laz: no such file"] {
            assert_eq!(sentence(path), path);
        }
        assert_eq!(sentence(""), "");
    }
}
