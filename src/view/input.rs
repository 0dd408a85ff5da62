//! Mouse and keys to camera moves and settings.

use eframe::egui::{Context, Key, PointerButton, Pos2, Response};
use glam::{DVec2, DVec3};

use super::{
    navigation::Navigation,
    settings::{Ask, Settings},
};

/// Pivot distances per second.
const FLY_SPEED: f64 = 0.6;
/// With Shift held.
const FLY_SPEED_FAST: f64 = 3.0;
/// A touched point this far from the cursor, in pixels, says nothing of what is under it now.
const TOUCH_REACH: f64 = 24.0;
/// Zoom per point of scrolling, as an exponent: a wheel's notch (40 points) is 18 %.
const ZOOM_PER_POINT: f64 = 0.0042;

/// What the mouse holds.
#[derive(Debug, Default)]
pub struct Hand {
    held: Option<Held>,
    /// What the cursor was on when it was last asked for.
    pub touched: Option<DVec3>,
}

#[derive(Debug, Clone, Copy)]
enum Held {
    Orbit,
    Pan { grabbed: DVec3 },
}

impl Hand {
    /// Moves the camera as the mouse over the picture asks.
    pub fn steer(&mut self, ctx: &Context, picture: &Response, navigation: &mut Navigation) {
        let scale = f64::from(ctx.pixels_per_point());
        let cursor = picture.interact_pointer_pos().map(|at| pixel(ctx, picture, at));
        if picture.drag_started()
            && let Some(cursor) = cursor
        {
            let orbit = picture.dragged_by(PointerButton::Primary) && !ctx.input(|i| i.modifiers.shift);
            self.held = Some(if orbit {
                Held::Orbit
            } else {
                Held::Pan { grabbed: navigation.grab(cursor, self.depth(navigation, cursor)) }
            });
        }
        if !picture.dragged() {
            self.held = None;
        }
        match (self.held, cursor) {
            (Some(Held::Orbit), _) => {
                let moved = picture.drag_delta();
                if moved != eframe::egui::Vec2::ZERO {
                    navigation.orbit(DVec2::new(moved.x.into(), moved.y.into()) * scale);
                }
            }
            (Some(Held::Pan { grabbed }), Some(cursor)) => navigation.pan(grabbed, cursor),
            _ => {}
        }
        if picture.contains_pointer()
            && let Some(at) = picture.hover_pos()
        {
            let (scroll, pinch) = ctx.input(|i| (f64::from(i.smooth_scroll_delta().y), f64::from(i.zoom_delta())));
            let factor = (-scroll * ZOOM_PER_POINT).exp() / pinch;
            let cursor = pixel(ctx, picture, at);
            if factor != 1.0 && factor.is_finite() {
                navigation.zoom(cursor, factor, self.depth(navigation, cursor));
            }
            let double_click = ctx.input(|i| i.pointer.button_double_clicked(PointerButton::Primary));
            if double_click && let Some(depth) = self.depth(navigation, cursor) {
                navigation.center_on(navigation.grab(cursor, Some(depth)));
            }
        }
    }

    /// Depth of what is under the cursor, if it is known.
    fn depth(&self, navigation: &Navigation, cursor: DVec2) -> Option<f64> {
        let (at, depth) = navigation.locate(self.touched?)?;
        (at.distance(cursor) <= TOUCH_REACH).then_some(depth)
    }
}

/// Pixel of the picture at a position of the window.
pub fn pixel(ctx: &Context, picture: &Response, at: Pos2) -> DVec2 {
    let at = at - picture.rect.min;
    DVec2::new(at.x.into(), at.y.into()) * f64::from(ctx.pixels_per_point())
}

/// Flies while keys are held; true if any is.
pub fn fly(ctx: &Context, navigation: &mut Navigation) -> bool {
    let (right, forward, up, by) = ctx.input(|i| {
        if i.modifiers.command || i.modifiers.alt {
            return (0.0, 0.0, 0.0, 0.0);
        }
        let axis = |plus, minus| f64::from(i.key_down(plus)) - f64::from(i.key_down(minus));
        let speed = if i.modifiers.shift { FLY_SPEED_FAST } else { FLY_SPEED };
        // After a stall nobody wants to find the camera elsewhere.
        let secs = f64::from(i.stable_dt).min(0.1);
        (axis(Key::D, Key::A), axis(Key::W, Key::S), axis(Key::E, Key::Q), speed * secs)
    });
    if (right, forward, up) == (0.0, 0.0, 0.0) {
        return false;
    }
    navigation.fly(right * by, forward * by, up * by);
    true
}

/// Keys that switch something; returns the view that one asks for.
pub fn keys(ctx: &Context, settings: &mut Settings) -> Option<Ask> {
    ctx.input(|i| {
        if i.modifiers.command || i.modifiers.alt {
            return None;
        }
        let pressed = |keys: &[Key]| keys.iter().any(|&key| i.key_pressed(key));
        if pressed(&[Key::OpenBracket, Key::Minus]) {
            settings.change_point_size(-1);
        }
        if pressed(&[Key::CloseBracket, Key::Equals, Key::Plus]) {
            settings.change_point_size(1);
        }
        settings.edl ^= pressed(&[Key::L]);
        settings.look.shading.high_quality ^= pressed(&[Key::B]);
        settings.bar ^= pressed(&[Key::O]);
        settings.help ^= pressed(&[Key::F1, Key::Questionmark]);
        if pressed(&[Key::Escape]) {
            settings.help = false;
        }
        [
            (&[Key::Home, Key::H][..], Ask::Home),
            (&[Key::Num7], Ask::Top),
            (&[Key::Num1], Ask::Front),
            (&[Key::Num3], Ask::Side),
        ]
        .into_iter()
        .find(|(keys, _)| pressed(keys))
        .map(|(_, ask)| ask)
    })
}
