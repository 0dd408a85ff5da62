//! What a frame of the window does: take points, move the camera, draw, say what is on screen.

use std::{path::PathBuf, time::Duration};

use eframe::{
    egui::{self, Color32, Context, Id, Rect, Response, Sense, Ui},
    egui_wgpu::RenderState,
};
use glam::DVec3;

use super::{
    Options,
    blit::Blit,
    input::{self, Hand},
    loading::Loading,
    messages::Messages,
    overlay::{self, Averages, Status},
    pace::Pace,
    probe::Probe,
    scene_state::{self, SceneState},
    settings::{Ask, Settings},
};
use crate::render::{Backend, FillBudget, GpuBackend, RenderError, Shading};

/// How often the numbers are brought up to date while nothing else asks for a frame.
const STATUS_INTERVAL: Duration = Duration::from_millis(250);

pub struct App {
    scene: SceneState,
    blit: Blit,
    hand: Hand,
    probe: Probe,
    settings: Settings,
    messages: Messages,
    /// Of the picture, in pixels.
    size: [u32; 2],
    pace: Pace,
}

impl App {
    pub fn new(ctx: &Context, state: &RenderState, options: Options) -> Result<App, RenderError> {
        let backend = GpuBackend::on_device(&state.adapter, state.device.clone(), state.queue.clone(), options.method)?;
        let software = state.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        ctx.set_theme(egui::Theme::Dark);
        let mut app = App {
            scene: SceneState::new(backend, &options, software),
            blit: Blit::new(&state.device, state.target_format),
            hand: Hand::default(),
            probe: Probe::new(&state.device, &state.queue),
            settings: Settings::new(&options),
            messages: Messages::default(),
            size: [0, 0],
            pace: Pace::default(),
        };
        if !options.inputs.is_empty() {
            app.scene.open(ctx, options.inputs, &app.settings);
        }
        Ok(app)
    }

    /// Lets points in and draws; true if the next frame should follow at once.
    fn advance(&mut self, ctx: &Context) -> bool {
        let advance = self.scene.advance(ctx, &mut self.messages, &self.settings, self.size);
        self.pace.note_drawn(advance.drawn);
        advance.again
    }

    fn show_view(&mut self, ask: Ask) {
        let Some(navigation) = &mut self.scene.navigation else { return };
        match ask {
            Ask::Home => navigation.home(),
            Ask::Top => navigation.look_from(DVec3::Z),
            Ask::Front => navigation.look_from(-DVec3::Y),
            Ask::Side => navigation.look_from(DVec3::X),
        }
    }

    fn status(&self) -> Option<Status> {
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
        Some(Status {
            files,
            kind: scene.files.first().map(|file| file.kind.clone()).unwrap_or_default(),
            loading: self.scene.is_loading(),
            points_read: loading.points_read(),
            points_stored: progressive.points_stored(),
            points_total: scene.points_in_header(),
            points_per_sec: loading.rate(),
            loading_secs: loading.elapsed().as_secs_f64(),
            fill: progressive.fill_points(fill),
            fill_is_fixed: matches!(fill, FillBudget::Fixed(_)),
            device_secs: progressive.last_pass_times().map(|times| times.total()),
            window_secs: self.pace.secs,
            points_tried: self.scene.last_report.map_or(0, |report| report.points_tried),
            averages: self.averages(),
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

    /// What lies over the picture, which takes `rect` of the window.
    fn show_overlay(&mut self, ui: &Ui, rect: Rect) -> Option<Ask> {
        let mut asked = None;
        if !overlay::fits(ui.ctx()) {
            return None;
        }
        if self.settings.bar
            && let Some(status) = self.status()
        {
            asked = overlay::bar(ui.ctx(), rect, &status, &mut self.settings);
        }
        if self.scene.loading.is_none() {
            let waiting_for = self.scene.incoming.as_ref().and_then(|(_, inputs)| inputs.first());
            overlay::invitation(ui, rect, waiting_for.map(|path| scene_state::name(path)).as_deref());
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
            self.scene.progressive.backend_mut().measure_at_rest()
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
            && let Some(navigation) = &self.scene.navigation
            && let Some((words, size)) = self.scene.progressive.backend().words_buffer()
        {
            self.probe.ask(words, size, input::pixel(ctx, picture, at), navigation);
        }
    }

    fn paint(&mut self, ui: &Ui, rect: Rect) {
        if let Some((picture, size)) = self.scene.picture() {
            let callback = self.blit.paint(rect, picture, size, Shading::default().background);
            ui.painter().add(callback);
        }
    }
}

impl eframe::App for App {
    /// Loading goes on while the window is hidden, when [`App::ui`] is not called.
    fn logic(&mut self, ctx: &Context, _: &mut eframe::Frame) {
        if ctx.input(|i| i.viewport().visible()) == Some(false) {
            self.scene.take_incoming(ctx, &mut self.messages, self.size);
            if self.advance(ctx) {
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
            self.scene.open(&ctx, dropped, &self.settings);
        }
        self.scene.take_incoming(&ctx, &mut self.messages, self.size);

        let picture = ui.interact(rect, Id::unique("picture"), Sense::drag());
        let mut asked = None;
        let mut flying = false;
        if !ctx.egui_wants_keyboard_input() {
            asked = input::keys(&ctx, &mut self.settings);
        }
        if let Some(touched) = self.probe.answer() {
            self.hand.touched = touched;
        }
        if let Some(navigation) = &mut self.scene.navigation {
            navigation.resize(self.size);
            self.hand.steer(&ctx, &picture, navigation);
            flying = !ctx.egui_wants_keyboard_input() && input::fly(&ctx, navigation);
        }
        if let Some(ask) = asked {
            self.show_view(ask);
        }

        // Nobody will see the frame after the last.
        let closing = ctx.input(|i| i.viewport().close_requested());
        let mut again = !closing && (self.advance(&ctx) || flying);
        if !closing && !again {
            self.measure_at_rest(&ctx);
        }
        self.paint(ui, rect);
        self.feel(&ctx, &picture);

        // Last, so that the numbers are those of the picture; what it changes is for the next frame.
        let before = self.settings.clone();
        if let Some(ask) = self.show_overlay(ui, rect) {
            self.show_view(ask);
            again = true;
        }
        again |= self.settings != before;

        if again {
            ctx.request_repaint();
        } else if self.scene.loading.as_ref().is_some_and(Loading::is_running) {
            ctx.request_repaint_after(STATUS_INTERVAL);
        }
        self.pace.end(again);
    }

    fn on_exit(&mut self) {
        // The decoders end while the GPU finishes what it was given.
        self.scene.close();
    }

    fn clear_color(&self, _: &egui::Visuals) -> [f32; 4] {
        let [r, g, b] = Shading::default().background;
        Color32::from_rgb(r, g, b).to_normalized_gamma_f32()
    }
}
