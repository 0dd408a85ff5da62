//! Mouse and keys on the picture: who moves the camera, which tool a click is for, and what the cursor is on.

use eframe::egui::{Context, PointerButton, Response, Ui};
use glam::DVec2;

use super::{
    input::{self, Hand},
    keys::{self, Command},
    overlay::{self, BAR_HEIGHT},
    probe::Probe,
    scene_state::SceneState,
    settings::Settings,
    tools::{self, ANSWER_INTERVAL, Tools},
};
use crate::{render::Camera, scene::SceneFacts};

/// All that the user does to one scene in its picture.
#[derive(Default)]
pub struct Touch {
    pub hand: Hand,
    pub tools: Tools,
    probe: Probe,
    /// What the probe was asked about last: the same picture at the same pixel has the same answer.
    probed: Option<(DVec2, Camera)>,
}

/// Pixels at the picture's lower edge that the bar lies over.
pub fn covered_below(ctx: &Context, settings: &Settings) -> f64 {
    if settings.bar && overlay::fits(ctx) { f64::from(BAR_HEIGHT * ctx.pixels_per_point()) } else { 0.0 }
}

impl Touch {
    /// What stays when a scene is read anew with more files, or fewer: record numbers are others then.
    pub fn in_scene(self, before: &SceneFacts, now: &SceneFacts) -> Touch {
        Touch { hand: self.hand, tools: self.tools.in_scene(before, now), ..Default::default() }
    }

    /// The picture is another one: what the cursor is on may be, too.
    pub fn note_drawn(&mut self) {
        self.probed = None;
    }

    /// Mouse and keys to camera moves, settings and tools; `size` is the picture's, in pixels. `was_typing`: a field had
    /// the keyboard when the frame began, and may have given it back by the key that is not for the picture. True if
    /// the next frame should follow at once.
    pub fn steer(
        &mut self,
        ctx: &Context,
        picture: &Response,
        size: [u32; 2],
        was_typing: bool,
        scene: &mut SceneState,
        settings: &mut Settings,
    ) -> bool {
        self.take_answers(ctx, scene);
        let has_keys = !was_typing && !ctx.egui_wants_keyboard_input();
        let mut moving = false;
        if let Some(navigation) = &mut scene.navigation {
            navigation.resize(size);
            navigation.cover(covered_below(ctx, settings));
            self.hand.set_projection(ctx, navigation, settings.look.projection);
            moving = self.hand.steer(ctx, picture, navigation, has_keys);
        }
        let pressed = if has_keys { keys::pressed(ctx) } else { Vec::new() };
        let double_clicked = self.take_click(ctx, picture).then_some(Command::Center);
        for command in pressed.into_iter().chain(double_clicked) {
            self.obey_at(ctx, command, Some(picture), scene, settings);
            moving = true;
        }
        if let Some(navigation) = &scene.navigation {
            // A bookmark or an undone move may have brought another one.
            settings.look.projection = navigation.camera().projection;
        }
        moving
    }

    /// Gives a click to the tool; true if it was a double click that is for the camera.
    fn take_click(&mut self, ctx: &Context, picture: &Response) -> bool {
        if picture.double_clicked_by(PointerButton::Primary) {
            return self.tools.double_click();
        }
        if picture.clicked_by(PointerButton::Primary)
            && let Some(at) = picture.interact_pointer_pos()
        {
            self.tools.click(input::pixel(ctx, picture, at));
        }
        false
    }

    fn take_answers(&mut self, ctx: &Context, scene: &mut SceneState) {
        let Some(facts) = scene.facts().cloned() else { return };
        if let Some(touched) = self.probe.answer(&mut scene.progressive) {
            self.hand.touched = touched.map(|touched| touched.place);
            self.tools.hover(touched.map(|touched| touched.pick), &facts);
        }
        self.tools.answer(ctx, &mut scene.progressive, &facts);
    }

    /// What a button asks for.
    pub fn obey(&mut self, ctx: &Context, command: Command, scene: &mut SceneState, settings: &mut Settings) {
        self.obey_at(ctx, command, None, scene, settings);
    }

    fn obey_at(
        &mut self,
        ctx: &Context,
        command: Command,
        picture: Option<&Response>,
        scene: &mut SceneState,
        settings: &mut Settings,
    ) {
        if command == Command::Close && settings.help {
            // Escape puts away one thing at a time, and help lies above all others.
            settings.help = false;
            return;
        }
        settings.obey(command);
        let facts = scene.facts().cloned();
        if let (Some(navigation), Some(facts)) = (&mut scene.navigation, &facts) {
            let cursor = picture.map_or(DVec2::ZERO, |picture| self.hand.cursor(ctx, picture, navigation));
            navigation.follow_clip(&settings.look.clip);
            self.hand.obey(command, ctx, navigation, cursor, settings.smooth);
            self.tools.obey(command, ctx, facts, cursor, &mut settings.look.clip);
        }
    }

    /// Asks what the cursor is on, unless that is known: an idle window asks nothing.
    pub fn feel(&mut self, ctx: &Context, picture: &Response, scene: &mut SceneState) {
        if picture.contains_pointer()
            && let Some(at) = ctx.input(|i| i.pointer.hover_pos())
            && let Some(navigation) = &scene.navigation
        {
            let about = (input::pixel(ctx, picture, at), *navigation.camera());
            if self.probed != Some(about) && self.probe.ask(&mut scene.progressive, about.0, navigation) {
                self.probed = Some(about);
            }
        }
        if self.probe.is_waiting() {
            ctx.request_repaint_after(ANSWER_INTERVAL);
        }
    }

    /// Draws the tools over the picture; what their buttons ask for is the answer.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        picture: &Response,
        scene: &SceneState,
        settings: &mut Settings,
    ) -> Vec<Command> {
        let facts = scene.facts();
        let (Some(navigation), Some(facts)) = (&scene.navigation, facts) else { return Vec::new() };
        let ctx = ui.ctx().clone();
        let free = picture.contains_pointer() && !ctx.input(|i| i.pointer.any_down());
        let cursor = ctx.input(|i| i.pointer.hover_pos()).filter(|_| free).map(|at| input::pixel(&ctx, picture, at));
        let mut free = picture.rect;
        if settings.bar {
            free.max.y -= BAR_HEIGHT;
        }
        self.tools.show(ui, [picture.rect, free], navigation, facts, &mut settings.look.clip, cursor);
        if !settings.bar {
            return Vec::new();
        }
        tools::strip(&ctx, free, &self.tools, &mut self.hand.bookmarks)
    }
}
