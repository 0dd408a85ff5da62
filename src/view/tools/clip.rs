//! The clipping box and the slab over the picture: handles, and the numbers in a small window.

use eframe::egui::{self, Context, CursorIcon, DragValue, Id, Rect, Role, Sense, Ui, WidgetInfo, Window, vec2};
use glam::{DVec2, DVec3};

use super::{
    Tool,
    copy::copy,
    handles::{
        BOX_EDGES, Drag, Handle, box_corners, drag_box, drag_slab, middle_slab, place_on_box, place_on_slab,
        plane_outline, whole_box,
    },
    measure::places,
    sheet::{ACCENT, Sheet, WARM},
};
use crate::{
    render::{Clip, ClipBox, Slab},
    scene::{Bounds, SceneFacts},
};

/// How far from its middle the mouse takes a knob, points.
const REACH: f32 = 11.0;

/// What the mouse holds of a box or a slab.
#[derive(Debug, Default)]
pub struct Clipping {
    held: Option<Held>,
    /// What is shown a box or a slab of was asked for once; taken away, it stays away.
    offered: Option<Tool>,
}

#[derive(Debug, Clone, Copy)]
struct Held {
    handle: Handle,
    /// As it was when the drag began, and where that was.
    clip: Clip,
    from: DVec2,
}

impl Clipping {
    /// Draws the outlines of what clips, the handles of the one that the tool is for, and its numbers. True if the
    /// mouse is at a handle.
    pub fn show(&mut self, ui: &mut Ui, sheet: &Sheet<'_>, tool: Tool, facts: &SceneFacts, clip: &mut Clip) -> bool {
        let bounds = *sheet.navigation.bounds();
        if self.offered != Some(tool) {
            self.offered = Some(tool);
            self.held = None;
            match tool {
                Tool::Box => clip.bounds = clip.bounds.or(Some(whole_box(&bounds))),
                Tool::Slab => clip.slab = clip.slab.or(Some(middle_slab(&bounds, sheet.navigation.forward()))),
                Tool::Inspect | Tool::Distance | Tool::Polyline => {}
            }
        }
        let mut at_handle = false;
        if tool == Tool::Box {
            if let Some(shown) = clip.bounds {
                draw_box(sheet, &shown);
                let dragged = self.handles(ui, sheet, &Handle::OF_BOX, clip, |handle| place_on_box(&shown, handle));
                at_handle = dragged.at_handle;
                if let (Some((held, drag)), Some(begin)) = (dragged.drag, dragged.begin.bounds) {
                    clip.bounds = Some(drag_box(&begin, held, &drag, &bounds));
                }
            }
            box_numbers(ui.ctx(), sheet.free, facts, &bounds, clip);
        }
        if tool == Tool::Slab {
            if let Some(shown) = clip.slab {
                draw_slab(sheet, &shown, &bounds);
                let place = |handle| place_on_slab(&shown, handle, &bounds);
                let dragged = self.handles(ui, sheet, &Handle::OF_SLAB, clip, place);
                at_handle = dragged.at_handle;
                if let (Some((held, drag)), Some(begin)) = (dragged.drag, dragged.begin.slab) {
                    clip.slab = Some(drag_slab(&begin, held, &drag, &bounds));
                }
            }
            slab_numbers(ui.ctx(), sheet, facts, &bounds, clip);
        }
        // What hides points is never out of sight.
        if let Some(shown) = clip.bounds.filter(|_| tool != Tool::Box) {
            let corners = box_corners(&shown);
            for [a, b] in BOX_EDGES {
                sheet.thin_line(corners[a], corners[b], ACCENT);
            }
        }
        if let Some(shown) = clip.slab.filter(|_| tool != Tool::Slab) {
            for outline in slab_outlines(&shown, &bounds) {
                for (at, &corner) in outline.iter().enumerate() {
                    sheet.thin_line(corner, outline[(at + 1) % outline.len()], ACCENT);
                }
            }
        }
        at_handle
    }

    fn handles(
        &mut self,
        ui: &mut Ui,
        sheet: &Sheet<'_>,
        handles: &[Handle],
        clip: &Clip,
        place: impl Fn(Handle) -> DVec3,
    ) -> Dragged {
        let mut dragged = Dragged { at_handle: false, drag: None, begin: *clip };
        let mut hot = None;
        sheet.line(place(Handle::Middle), place(Handle::Turn), WARM);
        for &handle in handles {
            let at = match handle {
                // Beside the box or the slab there may be no picture: then where the line to it leaves that.
                Handle::Turn => sheet.last_seen(place(Handle::Middle), place(Handle::Turn), REACH),
                _ => sheet.place(place(handle)).filter(|at| sheet.rect.contains(*at)),
            };
            let Some(at) = at else { continue };
            let rect = Rect::from_center_size(at, vec2(2.0 * REACH, 2.0 * REACH));
            let response = ui.interact(rect, Id::unique(("clip", handle.name())), Sense::drag());
            response.widget_info(|| WidgetInfo::labeled(Role::Button, true, handle.name()));
            let is_hot = response.hovered() || response.dragged();
            dragged.at_handle |= is_hot;
            let color = if matches!(handle, Handle::Middle | Handle::Turn) { WARM } else { ACCENT };
            sheet.knob(at, color, is_hot);
            if is_hot {
                ui.ctx().set_cursor_icon(CursorIcon::Grab);
                hot = Some((at, handle.name(), color));
            }
            if response.drag_started() {
                let from = ui.input(|i| i.pointer.press_origin()).map_or_else(|| sheet.pixel(at), |at| sheet.pixel(at));
                self.held = Some(Held { handle, clip: *clip, from });
            }
            if let Some(held) = self.held.filter(|held| held.handle == handle)
                && response.dragged()
                && let Some(to) = response.interact_pointer_pos()
            {
                let to = sheet.pixel(to);
                let drag = Drag {
                    from: sheet.navigation.ray_through(held.from),
                    to: sheet.navigation.ray_through(to),
                    forward: sheet.navigation.forward(),
                    moved: to - held.from,
                };
                dragged.drag = Some((handle, drag));
                dragged.begin = held.clip;
            }
            if response.drag_stopped() {
                self.held = None;
                log::debug!("clipped by {clip:?}");
            }
        }
        // Above all lines.
        if let Some((at, name, color)) = hot {
            sheet.words(at + vec2(14.0, 0.0), egui::Align2::LEFT_CENTER, name, color);
        }
        dragged
    }
}

struct Dragged {
    at_handle: bool,
    drag: Option<(Handle, Drag)>,
    /// What was there when the drag began.
    begin: Clip,
}

fn draw_box(sheet: &Sheet<'_>, clip: &ClipBox) {
    let corners = box_corners(clip);
    for [a, b] in BOX_EDGES {
        sheet.line(corners[a], corners[b], ACCENT);
    }
}

/// Of both of its planes, as far as they are in the scene.
fn slab_outlines(slab: &Slab, bounds: &Bounds) -> [Vec<DVec3>; 2] {
    let normal = DVec3::from_array(slab.across());
    [-0.5, 0.5].map(|side| {
        let point = DVec3::from_array(slab.point) + normal * (side * slab.thickness);
        plane_outline(point, normal, bounds)
    })
}

fn draw_slab(sheet: &Sheet<'_>, slab: &Slab, bounds: &Bounds) {
    for outline in slab_outlines(slab, bounds) {
        sheet.fill(&outline, ACCENT.gamma_multiply(0.08));
        sheet.outline(&outline, ACCENT);
    }
    sheet.line(
        place_on_slab(slab, Handle::Plane { upper: false }, bounds),
        place_on_slab(slab, Handle::Plane { upper: true }, bounds),
        ACCENT,
    );
}

/// A small window in the lower right corner of the picture: the legend is in the upper one.
fn numbers(ctx: &Context, rect: Rect, title: &str, contents: impl FnOnce(&mut Ui)) {
    Window::new(title)
        .id(Id::unique(("clip numbers", title)))
        .pivot(egui::Align2::RIGHT_BOTTOM)
        .default_pos(rect.right_bottom() - vec2(10.0, 10.0))
        .constrain_to(rect)
        .resizable(false)
        .show(ctx, contents);
}

/// A number that is typed or dragged, with a name for screen readers.
fn number(ui: &mut Ui, value: &mut f64, name: &str, speed: f64, digits: usize) {
    let field = DragValue::new(value).speed(speed).fixed_decimals(digits);
    let response = ui.add(field).on_hover_text(name);
    response.widget_info(|| WidgetInfo::labeled(Role::SpinButton, true, name));
}

fn box_numbers(ctx: &Context, rect: Rect, facts: &SceneFacts, bounds: &Bounds, clip: &mut Clip) {
    let (speed, digits) = (bounds.diagonal() / 1000.0, places(&facts.grid));
    numbers(ctx, rect, "Clipping box", |ui| {
        let Some(mut shown) = clip.bounds else {
            if ui.button("Clip with a box").clicked() {
                clip.bounds = Some(whole_box(bounds));
            }
            return;
        };
        egui::Grid::new("box").num_columns(3).show(ui, |ui| {
            for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
                ui.label(name);
                number(ui, &mut shown.min[axis], &format!("smallest {name}"), speed, digits);
                number(ui, &mut shown.max[axis], &format!("largest {name}"), speed, digits);
                ui.end_row();
            }
            ui.label("Turned");
            number(ui, &mut shown.degrees, "degrees around the vertical", 0.5, 3);
            ui.end_row();
        });
        // A face that is typed beyond the other one stops there.
        for axis in 0..3 {
            shown.max[axis] = shown.max[axis].max(shown.min[axis]);
        }
        if Some(shown) != clip.bounds {
            clip.bounds = Some(shown);
        }
        ui.horizontal(|ui| {
            if ui.button("All").on_hover_text("Around the whole scene").clicked() {
                clip.bounds = Some(whole_box(bounds));
            }
            if ui.button("Copy").on_hover_text("Copy as the option of the command line").clicked() {
                copy(ui.ctx(), format!("--clip {shown}"));
            }
            if ui.button("Remove").on_hover_text("Do not clip (Delete)").clicked() {
                clip.bounds = None;
            }
        });
    });
}

fn slab_numbers(ctx: &Context, sheet: &Sheet<'_>, facts: &SceneFacts, bounds: &Bounds, clip: &mut Clip) {
    let (speed, digits) = (bounds.diagonal() / 1000.0, places(&facts.grid));
    numbers(ctx, sheet.free, "Slab", |ui| {
        let across_view = || middle_slab(bounds, sheet.navigation.forward());
        let Some(mut shown) = clip.slab else {
            if ui.button("Clip with a slab").clicked() {
                clip.slab = Some(across_view());
            }
            return;
        };
        egui::Grid::new("slab").num_columns(4).show(ui, |ui| {
            ui.label("Through");
            for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
                number(ui, &mut shown.point[axis], &format!("{name} of a point halfway"), speed, digits);
            }
            ui.end_row();
            ui.label("Across");
            let mut normal = shown.normal;
            for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
                number(ui, &mut normal[axis], &format!("{name} of the direction across"), 0.01, 4);
            }
            if DVec3::from_array(normal).normalize_or_zero() != DVec3::ZERO {
                shown.normal = normal;
            }
            ui.end_row();
            ui.label("Thick");
            number(ui, &mut shown.thickness, "distance of the planes", speed, digits);
            ui.end_row();
        });
        if !(shown.thickness > 0.0 && shown.thickness.is_finite()) {
            shown.thickness = clip.slab.map_or(1.0, |slab| slab.thickness);
        }
        ui.horizontal(|ui| {
            let directions = [("East", DVec3::X), ("North", DVec3::Y), ("Level", DVec3::Z)];
            for (name, normal) in directions {
                if ui.button(name).on_hover_text("The direction across").clicked() {
                    shown.normal = normal.into();
                }
            }
            if ui.button("View").on_hover_text("Across the view").clicked() {
                shown.normal = across_view().normal;
            }
        });
        if Some(shown) != clip.slab {
            clip.slab = Some(shown);
        }
        ui.horizontal(|ui| {
            if ui.button("Middle").on_hover_text("Through the middle of the scene").clicked() {
                clip.slab = Some(Slab { point: bounds.center(), ..shown });
            }
            if ui.button("Copy").on_hover_text("Copy as the option of the command line").clicked() {
                copy(ui.ctx(), format!("--slab {shown}"));
            }
            if ui.button("Remove").on_hover_text("Do not clip (Delete)").clicked() {
                clip.slab = None;
            }
        });
    });
}
