//! Mouse and keys to camera moves.

use eframe::egui::{Context, Key, PointerButton, Pos2, Response};
use glam::{DVec2, DVec3};

use super::{
    keys::Command,
    navigation::{Bookmarks, Gesture, Glide, History, Navigation},
};
use crate::render::{Camera, Projection};

/// Pivot distances per second.
const FLY_SPEED: f64 = 0.6;
/// Pixels of dragging per second that an arrow key is worth.
const ORBIT_SPEED: f64 = 240.0;
/// Zoom per second of a key, as an exponent.
const ZOOM_SPEED: f64 = 1.2;
/// With Shift held.
const FAST: f64 = 5.0;
/// A touched point this far from the cursor, in pixels, says nothing of what is under it now.
const TOUCH_REACH: f64 = 24.0;
/// Zoom per point of scrolling, as an exponent: a wheel's notch (40 points) is 18 %.
const ZOOM_PER_POINT: f64 = 0.0042;

/// What the mouse holds, and where the camera was and is going to be.
#[derive(Debug, Default)]
pub struct Hand {
    held: Option<Held>,
    /// Number of the drag that goes on, or went on last.
    drags: u64,
    /// What the cursor was on when it was last asked for.
    pub touched: Option<DVec3>,
    /// The mouse looks around instead of turning the scene.
    pub is_flying: bool,
    pub bookmarks: Bookmarks,
    history: History,
    glide: Option<Glide>,
}

#[derive(Debug, Clone, Copy)]
enum Held {
    Orbit { about: DVec3, last: DVec2 },
    Look { last: DVec2 },
    Pan { grabbed: DVec3 },
}

impl Hand {
    /// Moves the camera as the mouse over the picture, the keys that are held (if `keys`) and a glide that goes on
    /// ask; true if the next frame should follow at once.
    pub fn steer(&mut self, ctx: &Context, picture: &Response, navigation: &mut Navigation, keys: bool) -> bool {
        let now = ctx.input(|i| i.time);
        let before = *navigation.camera();
        let held = keys && hold(ctx, navigation, self.cursor(ctx, picture, navigation), self);
        self.note(Gesture::Keys, before, navigation, now);

        let before = *navigation.camera();
        self.drag(ctx, picture, navigation);
        self.note(Gesture::Drag(self.drags), before, navigation, now);

        let before = *navigation.camera();
        self.wheel(ctx, picture, navigation);
        self.note(Gesture::Wheel, before, navigation, now);

        let Some(glide) = &self.glide else { return held };
        let (camera, over) = glide.at(now);
        navigation.set_camera(camera);
        if over {
            self.glide = None;
        }
        true
    }

    /// Who takes the camera into the hand ends a glide where it is.
    fn note(&mut self, gesture: Gesture, before: Camera, navigation: &Navigation, now: f64) {
        if *navigation.camera() != before {
            self.glide = None;
            self.history.note(gesture, before, now);
        }
    }

    fn drag(&mut self, ctx: &Context, picture: &Response, navigation: &mut Navigation) {
        if !picture.dragged() {
            self.held = None;
            return;
        }
        let Some(cursor) = picture.interact_pointer_pos().map(|at| pixel(ctx, picture, at)) else { return };
        if picture.drag_started() {
            // A drag is one after a few pixels; what it grabs is where it began.
            let pressed = ctx.input(|i| i.pointer.press_origin()).map_or(cursor, |at| pixel(ctx, picture, at));
            self.drags += 1;
            self.held = Some(self.grab(ctx, picture, navigation, pressed));
        }
        match &mut self.held {
            Some(Held::Orbit { about, last }) => {
                navigation.orbit_about(*about, cursor - *last);
                *last = cursor;
            }
            Some(Held::Look { last }) => {
                navigation.look_around(cursor - *last);
                *last = cursor;
            }
            Some(Held::Pan { grabbed }) => navigation.pan(*grabbed, cursor),
            None => {}
        }
    }

    fn grab(&self, ctx: &Context, picture: &Response, navigation: &Navigation, at: DVec2) -> Held {
        let (modifiers, flies) = ctx.input(|i| (i.modifiers, FLY_KEYS.iter().any(|&key| i.key_down(key))));
        let pan = Held::Pan { grabbed: navigation.grab(at, self.depth(navigation, at)) };
        if picture.dragged_by(PointerButton::Middle) {
            pan
        } else if picture.dragged_by(PointerButton::Secondary) {
            if self.is_flying || flies { Held::Look { last: at } } else { pan }
        } else if modifiers.command || self.is_flying && !modifiers.shift {
            Held::Look { last: at }
        } else if modifiers.shift {
            pan
        } else {
            let pivot = DVec3::from_array(navigation.camera().target);
            let about = self.depth(navigation, at).map_or(pivot, |depth| navigation.grab(at, Some(depth)));
            Held::Orbit { about, last: at }
        }
    }

    fn wheel(&mut self, ctx: &Context, picture: &Response, navigation: &mut Navigation) {
        if !picture.contains_pointer() {
            return;
        }
        let Some(cursor) = picture.hover_pos().map(|at| pixel(ctx, picture, at)) else { return };
        let (scroll, pinch) = ctx.input(|i| (f64::from(i.smooth_scroll_delta().y), f64::from(i.zoom_delta())));
        let factor = (-scroll * ZOOM_PER_POINT).exp() / pinch;
        if factor != 1.0 && factor.is_finite() {
            navigation.zoom(cursor, factor, self.depth(navigation, cursor));
        }
    }

    /// What keys and buttons ask the camera for; `smooth`: on a way that the eye can follow.
    pub fn obey(&mut self, command: Command, ctx: &Context, navigation: &mut Navigation, cursor: DVec2, smooth: bool) {
        let now = ctx.input(|i| i.time);
        match command {
            Command::Show(view) => self.go(navigation, now, smooth, |n| n.show(view)),
            Command::Center => self.center(navigation, cursor, now, smooth),
            Command::Undo => {
                let destination = self.destination(navigation);
                if let Some(camera) = self.history.undo(destination) {
                    self.glide_to(navigation, camera, now, smooth);
                }
            }
            Command::Redo => {
                let destination = self.destination(navigation);
                if let Some(camera) = self.history.redo(destination) {
                    self.glide_to(navigation, camera, now, smooth);
                }
            }
            Command::ToggleProjection => {
                let projection = match self.destination(navigation).projection {
                    Projection::Perspective => Projection::Orthographic,
                    Projection::Orthographic => Projection::Perspective,
                };
                self.set_projection(ctx, navigation, projection);
            }
            Command::FlyMode => self.is_flying ^= true,
            Command::AddBookmark => {
                let number = self.bookmarks.add(self.destination(navigation));
                log::debug!("bookmark {number}");
            }
            Command::SetBookmark(number) => {
                let number = self.bookmarks.set(number, self.destination(navigation));
                log::debug!("bookmark {number}");
            }
            Command::GoToBookmark(number) => {
                if let Some(camera) = self.bookmarks.get(number).map(|bookmark| bookmark.camera) {
                    self.go(navigation, now, smooth, |n| n.set_camera(camera));
                }
            }
            _ => {}
        }
    }

    /// Perspective or not, as the controls say.
    pub fn set_projection(&mut self, ctx: &Context, navigation: &mut Navigation, projection: Projection) {
        if self.destination(navigation).projection == projection {
            return;
        }
        let (now, before) = (ctx.input(|i| i.time), *navigation.camera());
        self.glide = None;
        navigation.set_projection(projection);
        self.history.note(Gesture::Jump, before, now);
    }

    /// What is under the cursor comes to the middle, if anything is.
    pub fn center(&mut self, navigation: &mut Navigation, cursor: DVec2, now: f64, smooth: bool) {
        if let Some(depth) = self.depth(navigation, cursor) {
            let point = navigation.grab(cursor, Some(depth));
            self.go(navigation, now, smooth, |n| n.center_on(point));
        }
    }

    /// Moves the camera in one go, which can be undone.
    pub fn go(&mut self, navigation: &mut Navigation, now: f64, smooth: bool, go: impl FnOnce(&mut Navigation)) {
        let before = self.destination(navigation);
        let mut there = navigation.clone();
        go(&mut there);
        let camera = *there.camera();
        if camera != before {
            self.history.note(Gesture::Jump, before, now);
        }
        self.glide_to(navigation, camera, now, smooth);
    }

    fn glide_to(&mut self, navigation: &mut Navigation, camera: Camera, now: f64, smooth: bool) {
        self.glide = None;
        if smooth && *navigation.camera() != camera {
            self.glide = Some(Glide::new(*navigation.camera(), camera, now));
        } else {
            navigation.set_camera(camera);
        }
    }

    /// Where the camera is, or is going to be.
    fn destination(&self, navigation: &Navigation) -> Camera {
        self.glide.as_ref().map_or(*navigation.camera(), Glide::to)
    }

    /// Depth of what is under the cursor, if it is known.
    fn depth(&self, navigation: &Navigation, cursor: DVec2) -> Option<f64> {
        let (at, depth) = navigation.locate(self.touched?)?;
        (at.distance(cursor) <= TOUCH_REACH).then_some(depth)
    }

    /// Pixel under the cursor; the middle of the picture where the cursor is elsewhere.
    pub fn cursor(&self, ctx: &Context, picture: &Response, navigation: &Navigation) -> DVec2 {
        let hovered = picture.contains_pointer().then(|| ctx.input(|i| i.pointer.hover_pos())).flatten();
        hovered.map_or(navigation.size() * 0.5, |at| pixel(ctx, picture, at))
    }
}

/// Pixel of the picture at a position of the window.
pub fn pixel(ctx: &Context, picture: &Response, at: Pos2) -> DVec2 {
    let at = at - picture.rect.min;
    DVec2::new(at.x.into(), at.y.into()) * f64::from(ctx.pixels_per_point())
}

const FLY_KEYS: [Key; 6] = [Key::W, Key::A, Key::S, Key::D, Key::Q, Key::E];

/// Moves while keys are held; true if any is.
fn hold(ctx: &Context, navigation: &mut Navigation, cursor: DVec2, hand: &Hand) -> bool {
    let (fly, orbit, zoom) = ctx.input(|i| {
        if i.modifiers.command || i.modifiers.alt {
            return (DVec3::ZERO, DVec2::ZERO, 0.0);
        }
        let axis = |plus, minus| f64::from(i.key_down(plus)) - f64::from(i.key_down(minus));
        let speed = if i.modifiers.shift { FAST } else { 1.0 };
        // After a stall nobody wants to find the camera elsewhere.
        let by = speed * f64::from(i.stable_dt).min(0.1);
        let fly = DVec3::new(axis(Key::D, Key::A), axis(Key::W, Key::S), axis(Key::E, Key::Q));
        let orbit = DVec2::new(axis(Key::ArrowRight, Key::ArrowLeft), axis(Key::ArrowDown, Key::ArrowUp));
        let zoom = axis(Key::PageDown, Key::PageUp);
        (fly * by * FLY_SPEED, orbit * by * ORBIT_SPEED, zoom * by * ZOOM_SPEED)
    });
    if fly != DVec3::ZERO {
        navigation.fly(fly.x, fly.y, fly.z);
    }
    if orbit != DVec2::ZERO {
        navigation.orbit(orbit);
    }
    if zoom != 0.0 {
        navigation.zoom(cursor, zoom.exp(), hand.depth(navigation, cursor));
    }
    fly != DVec3::ZERO || orbit != DVec2::ZERO || zoom != 0.0
}
