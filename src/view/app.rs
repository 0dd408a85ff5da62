//! What a frame of the window does: take points, move the camera, draw, say what is on screen.

use std::{
    path::PathBuf,
    time::{Duration, Instant},
};

use eframe::{
    egui::{self, Color32, Context, Event, Id, Key, Modifiers, Rect, Sense, Ui},
    egui_wgpu::RenderState,
};

use super::{
    Options,
    blit::Blit,
    decor,
    dialogs::{Chosen, Dialogs},
    help,
    keys::Command,
    loading::Loading,
    messages::{Messages, Severity},
    models::{self, Spread},
    overlay::{self, Averages, Shown, Status},
    pace::Pace,
    panels::{self, Typed, performance::Performance, share::Share},
    remembered::{Remembered, Store},
    requests::{Choose, Request},
    scene_state::{self, SceneState, Shot, Taken},
    screenshot::{self, ShotOptions, Writing},
    settings::{Section, Settings},
    style,
    touch::{Touch, covered_below},
};
use crate::{
    headless,
    render::{self, Backend, Camera, ColorBy, FillBudget, GpuBackend, Look, Picture, RenderError, Sheet},
    scene::SceneFacts,
};

/// Frames that the device takes to tell how many points are shown: one to copy the number, one to read it.
const COUNT_FRAMES: u32 = 2;
/// How often the numbers are brought up to date while nothing else asks for a frame.
const STATUS_INTERVAL: Duration = Duration::from_millis(250);

pub struct App {
    scene: SceneState,
    blit: Blit,
    device: wgpu::Device,
    touch: Touch,
    settings: Settings,
    messages: Messages,
    /// Of the picture, in pixels.
    size: [u32; 2],
    pace: Pace,
    store: Store,
    remembered: Remembered,
    dialogs: Dialogs,
    typed: Typed,
    share: Share,
    performance: Performance,
    writing: Option<Writing>,
    spread: Spread,
    /// The file that the bookmarks in hand are kept with.
    bookmarked: Option<PathBuf>,
    /// Until the number of points that are shown is known.
    frames_to_count: u32,
    on_wayland: bool,
}

impl App {
    pub fn new(
        ctx: &Context,
        state: &RenderState,
        options: Options,
        store: Store,
        remembered: Remembered,
    ) -> Result<App, RenderError> {
        let backend = GpuBackend::on_device(&state.adapter, state.device.clone(), state.queue.clone(), options.method)?;
        let software = state.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        let settings = Settings::new(&options, &remembered);
        ctx.set_theme(settings.theme.preference());
        ctx.all_styles_mut(style::readable);
        let mut app = App {
            scene: SceneState::new(backend, &options, software),
            blit: Blit::new(&state.device, state.target_format),
            device: state.device.clone(),
            touch: Touch::default(),
            settings,
            messages: Messages::default(),
            size: [0, 0],
            pace: Pace::default(),
            store,
            remembered,
            dialogs: Dialogs::default(),
            typed: Typed::default(),
            share: Share { wait: true, ..Default::default() },
            performance: Performance::default(),
            writing: None,
            spread: Spread::default(),
            bookmarked: None,
            frames_to_count: 0,
            on_wayland: super::is_on_wayland(),
        };
        if !options.inputs.is_empty() {
            app.scene.open(ctx, options.inputs, false, &app.settings);
        }
        Ok(app)
    }

    fn take_incoming(&mut self, ctx: &Context) {
        let before = self.scene.facts().cloned();
        let taken = self.scene.take_incoming(ctx, &mut self.messages, self.size);
        let Taken::Scene { inputs, keeps_view } = taken else { return };
        self.note_all();
        self.remembered.note_opened(&inputs);
        self.typed.note_opened(&inputs);
        self.performance.forget_threads();
        // What was kept of the scene before means nothing in this one; of the same files and others, moves still do.
        let touch = std::mem::take(&mut self.touch);
        if let (true, Some(before), Some(now)) = (keeps_view, &before, self.scene.facts()) {
            self.touch = touch.in_scene(before, now);
        }
        // What the command line gave is meant for the first one.
        if let Some(before) = before {
            if keeps_view {
                self.follow_files(&before);
            } else {
                self.settings.forget_scene();
            }
        }
        self.leave_absent_colors();
        if let Some(doubt) = self.scene.facts().and_then(|facts| self.settings.look.point_size.doubt(facts)) {
            self.messages.add(Severity::Note, scene_state::sentence(&doubt));
        }
        if let Some(navigation) = self.scene.navigation.as_mut().filter(|_| !keeps_view) {
            navigation.cover(covered_below(ctx, &self.settings));
            navigation.follow_clip(&self.settings.look.clip);
            navigation.home();
        }
        let first = self.first_file();
        if let Some(file) = first.as_ref().filter(|file| !keeps_view || self.bookmarked.as_ref() != Some(file)) {
            self.touch.hand.bookmarks.merge(self.remembered.bookmarks_of(file));
            self.bookmarked = Some(file.clone());
        }
        self.share.path = screenshot::default_path(first.as_deref()).display().to_string();
        self.share.may_replace = false;
    }

    /// Files that were hidden stay hidden, and those with a colour of their own keep it, by the numbers that they have
    /// now.
    fn follow_files(&mut self, before: &SceneFacts) {
        let Some(facts) = self.scene.facts() else { return };
        let number_now = |number: usize| {
            let path = &before.files.get(number)?.path;
            facts.files.iter().position(|file| file.path == *path)
        };
        let Look { filter, coloring, .. } = &mut self.settings.look;
        let colors = std::mem::take(&mut coloring.files).into_iter();
        coloring.files = colors.filter_map(|(number, color)| Some((number_now(number)?, color))).collect();
        panels::files::renumber(filter, before.files.len(), number_now);
    }

    /// Colours that no file of this scene has are those of another one.
    fn leave_absent_colors(&mut self) {
        let coloring = &mut self.settings.look.coloring;
        if let Some(facts) = self.scene.facts()
            && !facts.files.iter().any(|file| coloring.by.is_in(file))
        {
            let title = panels::color::title(&coloring.by);
            self.messages.add(Severity::Note, format!("{title} is in none of these files: coloured automatically"));
            (coloring.by, coloring.range) = (ColorBy::Auto, None);
        }
    }

    /// Lets points in and draws; true if the next frame should follow at once.
    fn advance(&mut self, ctx: &Context) -> bool {
        let advance = self.scene.advance(ctx, &mut self.messages, &self.settings, self.size);
        self.pace.note_drawn(advance.drawn);
        if advance.drawn {
            self.touch.note_drawn();
            self.frames_to_count = if self.settings.look.shows_all() { 0 } else { COUNT_FRAMES };
        }
        if advance.drawn
            && let Some(times) = self.scene.progressive.last_pass_times()
        {
            self.performance.note_frame(*times, self.pace.last_secs());
        }
        advance.again
    }

    fn obey(&mut self, ctx: &Context, request: Request) {
        match request {
            Request::Open { inputs, add } => self.scene.open(ctx, inputs, add, &self.settings),
            Request::Choose { what, add } => {
                let at = match what {
                    Choose::Picture => Some(PathBuf::from(self.share.path.trim())),
                    Choose::Files | Choose::Folder => self.remembered.recent.first().cloned(),
                };
                self.dialogs.show(ctx, what, add, at);
            }
            Request::StopFile(file) => {
                if let Some(loading) = &mut self.scene.loading {
                    loading.stop_file(file);
                }
            }
            Request::StopReading => self.scene.stop_reading(),
            Request::CloseFile(file) => self.scene.close_file(ctx, file, &self.settings),
            Request::Read(attribute) => self.scene.ask_for(attribute),
            Request::ForgetRecent => self.remembered.recent.clear(),
            Request::Screenshot(options) => self.begin_shot(options),
            Request::CopyCommand => {
                let size = self.share.size.unwrap_or(self.size);
                if let Some(command) = models::command(&self.scene, &self.settings, size) {
                    log::debug!("copied {command}");
                    ctx.copy_text(command);
                }
            }
            Request::StopScreenshot => self.scene.shot = None,
            Request::ClearMessages => self.messages.clear(),
        }
    }

    fn begin_shot(&mut self, options: ShotOptions) {
        let Some(navigation) = &self.scene.navigation else { return };
        if self.writing.is_some() {
            self.messages.add(Severity::Note, "A picture is still being written; try again in a moment");
        } else if options.path.as_os_str().is_empty() {
            self.messages.add(Severity::Error, "The picture needs a path: see Pictures in the panel");
        } else {
            self.scene.shot = Some(Shot { options, camera: *navigation.camera() });
            // The dialog asked once, for one picture.
            self.share.may_replace = false;
        }
    }

    /// Takes the picture that was asked for, once it is ready, and tells where it is, once it is written.
    fn go_on_with_shot(&mut self, ctx: &Context) {
        if let Some((Shot { options, camera }, picture)) = self.scene.take_shot(&self.settings) {
            match picture {
                Ok(mut picture) => {
                    self.decorate(&mut picture, &camera);
                    self.writing = Some(Writing::start(ctx, &options, picture));
                }
                Err(error) => self.messages.add(Severity::Error, scene_state::sentence(&error)),
            }
            // The window shows its own picture again.
            self.advance(ctx);
            ctx.request_repaint();
        }
        let Some(result) = self.writing.as_ref().and_then(Writing::answer) else { return };
        self.writing = None;
        match result {
            Ok(path) => {
                log::debug!("picture written to {}", path.display());
                self.messages.add(Severity::Done, format!("The picture is in {}", path.display()));
            }
            Err(error) => self.messages.add(Severity::Error, scene_state::sentence(&error)),
        }
    }

    /// Draws over a picture for a file, as `render` does.
    fn decorate(&self, picture: &mut Picture, camera: &Camera) {
        let decor = self.settings.look.decor;
        let (false, Some(facts)) = (decor.is_empty(), self.scene.facts()) else { return };
        let size = [picture.width, picture.height];
        let sheet = Sheet { size, text_px: headless::text_px(size), covered_below: 0.0 };
        let legend = self.scene.progressive.legend();
        if let Ok(overlay) = render::overlay(decor, camera, facts, legend.as_ref(), &sheet) {
            headless::decorate(picture, &overlay, camera.projection);
        }
    }

    fn take_dialog(&mut self, ctx: &Context) {
        match self.dialogs.answer() {
            None => {}
            Some(Chosen::Files { inputs, add }) => self.scene.open(ctx, inputs, add, &self.settings),
            Some(Chosen::Picture(path)) => {
                self.share.path = path.display().to_string();
                self.share.may_replace = true;
            }
            Some(Chosen::NoDialog(why)) => self.messages.add(Severity::Error, why),
        }
    }

    /// Keys of the window itself; those of the picture are `input`'s.
    fn window_keys(&mut self, ctx: &Context, is_typing: bool) -> Vec<Request> {
        let ctrl_shift = Modifiers::COMMAND | Modifiers::SHIFT;
        let mut requests = Vec::new();
        ctx.input_mut(|i| {
            let add = self.typed.add;
            if i.consume_key(ctrl_shift, Key::O) {
                requests.push(Request::Choose { what: Choose::Folder, add });
            }
            if i.consume_key(Modifiers::COMMAND, Key::O) {
                requests.push(Request::Choose { what: Choose::Files, add });
            }
            if i.consume_key(ctrl_shift, Key::C) {
                requests.push(Request::CopyCommand);
            }
            if i.consume_key(Modifiers::COMMAND, Key::S) {
                self.share.window_size = self.size;
                requests.push(Request::Screenshot(self.share.options()));
            }
            if !is_typing {
                // A slow frame may have several. With Shift first: without, any is meant.
                for (modifiers, forward) in [(Modifiers::SHIFT, false), (Modifiers::NONE, true)] {
                    for _ in 0..i.count_and_consume_key(modifiers, Key::V) {
                        self.spread.colors.step(&mut self.settings.look.coloring, forward);
                        log::debug!("colours by {}", self.settings.look.coloring.by);
                    }
                }
                if self.scene.shot.is_some() && i.consume_key(Modifiers::NONE, Key::Escape) {
                    requests.push(Request::StopScreenshot);
                }
            }
            if i.consume_key(Modifiers::NONE, Key::F6) {
                self.settings.panel = true;
                self.typed.focus = true;
            }
        });
        requests
    }

    fn status(&mut self) -> Option<Status> {
        let hides = !self.settings.look.shows_all();
        let shown = hides.then(|| Shown { points: self.scene.progressive.points_shown() });
        let loading = self.scene.loading.as_ref()?;
        let scene = loading.scene()?;
        let progressive = &self.scene.progressive;
        let info = progressive.backend().info();
        let files = match &scene.files[..] {
            [] => String::new(),
            [file] => scene_state::name(&file.path),
            [first, rest @ ..] => format!("{} and {} more", scene_state::name(&first.path), rest.len()),
        };
        let fill = self.scene.fill_budget();
        let points_tried = self.scene.last_report.map_or(0, |report| report.points_tried);
        let to_try = progressive.points_stored().saturating_sub(points_tried);
        let per_frame = progressive.fill_points(fill);
        Some(Status {
            files,
            kind: scene.files.first().map(|file| file.kind.clone()).unwrap_or_default(),
            loading: self.scene.is_loading(),
            points_read: loading.points_read(),
            points_stored: progressive.points_stored(),
            points_total: scene.points_in_header(),
            points_per_sec: loading.rate(),
            loading_secs: loading.elapsed().as_secs_f64(),
            secs_to_go: loading.secs_to_go(),
            fill: per_frame,
            fill_is_fixed: matches!(fill, FillBudget::Fixed(_)),
            device_secs: progressive.last_pass_times().map(|times| times.total()),
            window_secs: self.pace.secs,
            points_tried,
            secs_to_picture: (per_frame > 0).then(|| to_try as f64 / f64::from(per_frame) * self.pace.secs),
            averages: self.averages(),
            shown,
            is_flying: self.touch.hand.is_flying,
            adapter: info.adapter.clone(),
            choice: info.choice.clone(),
        })
    }

    fn averages(&self) -> Averages {
        let points = self.scene.last_report.map_or(0, |report| report.points_averaged);
        let in_motion = self.scene.progressive.averages_in_motion(self.scene.fill_budget());
        match (self.settings.look.shading.high_quality, in_motion) {
            (false, _) => Averages::Off,
            (true, true) => Averages::On(points),
            (true, false) => Averages::AtRest(points),
        }
    }

    /// The panel at the right; what is left of the window is the picture's.
    fn show_panel(&mut self, ui: &mut Ui) -> Vec<Request> {
        let mut requests = Vec::new();
        if !self.settings.panel || !panels::fits(ui.ctx()) {
            return requests;
        }
        if self.settings.sections.contains(&Section::Performance) {
            models::measure(&mut self.performance, &self.scene, &self.device, Instant::now());
        }
        let coloring = &self.settings.look.coloring;
        let files = models::files(&self.scene, &self.remembered.recent, coloring, self.on_wayland);
        models::share(&mut self.share, &self.scene, &self.settings, self.size, self.writing.is_some());
        let mut model = panels::Model {
            files: &files,
            colors: &self.spread.colors,
            filters: &self.spread.filters,
            performance: &self.performance,
            share: &mut self.share,
            messages: &self.messages,
            typed: &mut self.typed,
        };
        panels::side(ui, &mut self.settings, &mut model, &mut requests);
        requests
    }

    /// What lies over the picture, which takes `rect` of the window.
    fn show_overlay(&mut self, ui: &Ui, rect: Rect) -> Vec<Command> {
        let mut asked = Vec::new();
        if !overlay::fits(ui.ctx()) {
            return asked;
        }
        if self.settings.bar
            && let Some(status) = self.status()
        {
            asked = overlay::bar(ui.ctx(), rect, &status, &mut self.settings);
        }
        if self.scene.loading.is_none() {
            let waiting_for = self.scene.incoming.as_ref().and_then(|incoming| incoming.inputs.first());
            let waiting_for = waiting_for.map(|path| scene_state::name(path));
            let background = self.settings.look.shading.background;
            overlay::invitation(ui, rect, waiting_for.as_deref(), background, self.on_wayland);
        }
        if self.settings.help {
            help::show(ui.ctx(), &mut self.settings);
        }
        if self.scene.shot.is_some() {
            overlay::waiting_for_picture(ui.ctx(), rect, self.scene.read_for_shot());
        }
        self.messages.show(ui.ctx(), rect);
        if ui.input(|i| !i.raw.hovered_files.is_empty()) {
            overlay::drop_target(ui.ctx(), self.typed.add);
        }
        asked
    }

    /// Lets the backend measure which method is the fastest, a few milliseconds a frame, while nothing
    /// moves: neither the picture nor the hand on the mouse.
    fn measure_at_rest(&mut self, ctx: &Context) {
        let again = if ctx.input(|i| i.pointer.any_down()) {
            Ok(Some(STATUS_INTERVAL))
        } else {
            self.scene.progressive.backend_mut().measure_at_rest()
        };
        match again {
            Ok(Some(time)) => ctx.request_repaint_after(time),
            Ok(None) => {}
            Err(error) => self.messages.add(Severity::Error, scene_state::sentence(&error.to_string())),
        }
    }

    fn paint(&mut self, ui: &Ui, rect: Rect) {
        if let Some((picture, size)) = self.scene.picture() {
            let callback = self.blit.paint(rect, picture, size, self.settings.look.shading.background);
            ui.painter().add(callback);
        }
        if let (true, Some(navigation), Some(facts)) =
            (overlay::fits(ui.ctx()), &self.scene.navigation, self.scene.facts())
        {
            decor::paint(ui, rect, &self.settings, navigation.camera(), facts, self.spread.legend.as_ref());
        }
    }

    fn first_file(&self) -> Option<PathBuf> {
        self.scene.facts().and_then(|scene| scene.files.first()).map(|file| file.path.clone())
    }

    /// Settings and bookmarks as they are now.
    fn note_all(&mut self) {
        self.settings.note(&mut self.remembered);
        if let Some(file) = &self.bookmarked {
            self.remembered.set_bookmarks(file, &self.touch.hand.bookmarks);
        }
    }

    /// Keeps what has changed, once nothing moves.
    fn remember(&mut self, ctx: &Context) {
        if ctx.input(|i| i.pointer.any_down()) {
            return;
        }
        self.note_all();
        let (size, is_large) = ctx.input(|i| {
            let viewport = i.viewport();
            (
                viewport.inner_rect.map(|rect| rect.size()),
                viewport.maximized == Some(true) || viewport.fullscreen == Some(true),
            )
        });
        if let Some(size) = size.filter(|size| !is_large && size.x >= 160.0 && size.y >= 160.0) {
            self.remembered.window = [size.x.round(), size.y.round()];
        }
        if let Err(error) = self.store.save(&self.remembered) {
            self.messages.add(Severity::Error, error);
            ctx.request_repaint();
        }
    }
}

impl eframe::App for App {
    /// Loading goes on while the window is hidden, when [`App::ui`] is not called.
    fn logic(&mut self, ctx: &Context, _: &mut eframe::Frame) {
        if ctx.input(|i| i.viewport().visible()) == Some(false) {
            self.take_incoming(ctx);
            if self.advance(ctx) {
                ctx.request_repaint();
            }
        }
    }

    /// Tab is the panel's key as long as no control has the keyboard: it would give it to the first one.
    fn raw_input_hook(&mut self, ctx: &Context, raw: &mut egui::RawInput) {
        if ctx.memory(|memory| memory.focused()).is_some() {
            return;
        }
        let is_tab =
            |event: &Event| matches!(event, Event::Key { key: Key::Tab, modifiers, .. } if modifiers.is_none());
        let pressed = |event: &Event| is_tab(event) && matches!(event, Event::Key { pressed: true, repeat: false, .. });
        if raw.events.iter().any(pressed) {
            self.settings.panel ^= true;
        }
        raw.events.retain(|event| !is_tab(event));
    }

    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        self.pace.begin();
        let ctx = ui.ctx().clone();
        let before = self.settings.clone();

        // Before the panel takes a key that ends the typing.
        let is_typing = ctx.egui_wants_keyboard_input();
        let mut requests = self.window_keys(&ctx, is_typing);
        let add = self.typed.add;
        let dropped: Vec<PathBuf> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).collect());
        if !dropped.is_empty() {
            requests.push(Request::Open { inputs: dropped, add });
        }
        self.take_dialog(&ctx);
        self.scene.follow_coloring(&mut self.messages, &self.settings);
        self.spread.refresh(&ctx, &mut self.scene, &self.settings);
        requests.extend(self.show_panel(ui));
        let obeyed = !requests.is_empty();
        for request in requests {
            self.obey(&ctx, request);
        }
        let rect = ui.available_rect_before_wrap();
        self.size = [rect.width(), rect.height()].map(|side| (side * ctx.pixels_per_point()).round() as u32);
        self.take_incoming(&ctx);

        let picture = ui.interact(rect, Id::unique("picture"), Sense::click_and_drag());
        let moving = self.touch.steer(&ctx, &picture, self.size, is_typing, &mut self.scene, &mut self.settings);

        // Nobody will see the frame after the last.
        let closing = ctx.input(|i| i.viewport().close_requested());
        let mut again = !closing && (self.advance(&ctx) || moving);
        self.go_on_with_shot(&ctx);
        if !closing && !again {
            self.measure_at_rest(&ctx);
        }
        self.paint(ui, rect);
        self.touch.feel(&ctx, &picture, &mut self.scene);

        // Last, so that the numbers are those of the picture; what it changes is for the next frame.
        let mut commands = self.touch.show(ui, &picture, &self.scene, &mut self.settings);
        commands.extend(self.show_overlay(ui, rect));
        for command in commands {
            self.touch.obey(&ctx, command, &mut self.scene, &mut self.settings);
            again = true;
        }
        again |= obeyed || self.settings != before;
        if self.settings.theme != before.theme {
            ctx.set_theme(self.settings.theme.preference());
        }

        if again {
            ctx.request_repaint();
        } else {
            self.remember(&ctx);
            if self.frames_to_count > 0 {
                self.frames_to_count -= 1;
                ctx.request_repaint_after(STATUS_INTERVAL);
            }
            if self.scene.loading.as_ref().is_some_and(Loading::is_running) {
                ctx.request_repaint_after(STATUS_INTERVAL);
            }
        }
        self.pace.end(again);
    }

    fn on_exit(&mut self) {
        self.note_all();
        if let Err(error) = self.store.save(&self.remembered) {
            log::error!("{error}");
        }
        // The decoders end while the GPU finishes what it was given.
        self.scene.close();
    }

    /// What egui itself would keep is of no use without the controls that it belongs to.
    fn persist_egui_memory(&self) -> bool {
        false
    }

    fn clear_color(&self, _: &egui::Visuals) -> [f32; 4] {
        let [r, g, b] = self.settings.look.shading.background;
        Color32::from_rgb(r, g, b).to_normalized_gamma_f32()
    }
}
