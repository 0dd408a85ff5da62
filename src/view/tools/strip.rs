//! The buttons at the left edge of the picture.

use eframe::egui::{
    Area, Button, Context, Frame, Id, Order, PopupCloseBehavior, Rect, RichText, Role, Ui, WidgetInfo,
    containers::menu::{MenuButton, MenuConfig},
    vec2,
};

use super::{Tool, Tools};
use crate::view::{
    keys::{self, Command},
    navigation::{Bookmarks, StandardView},
};

/// Height that the buttons need; lower windows go without.
const HEIGHT: f32 = 260.0;

impl Tool {
    fn label(self) -> (&'static str, &'static str) {
        match self {
            Tool::Inspect => ("Inspect", "A click pins a card with everything that the file says of the point"),
            Tool::Distance => ("Distance", "Two clicks measure from point to point"),
            Tool::Polyline => ("Line", "Clicks measure along a line of points; Enter or a double click ends it"),
            Tool::Box => ("Box", "A clipping box with handles"),
            Tool::Slab => ("Slab", "A section between two planes, with handles"),
        }
    }
}

/// The tools and the views; what is asked for is the answer.
pub fn strip(ctx: &Context, rect: Rect, tools: &Tools, bookmarks: &mut Bookmarks) -> Vec<Command> {
    let mut asked = Vec::new();
    if rect.height() < HEIGHT || rect.width() < HEIGHT {
        return asked;
    }
    let corner = rect.left_center() + vec2(8.0, -0.5 * HEIGHT + 40.0);
    Area::new(Id::unique("tools")).order(Order::Middle).fixed_pos(corner).constrain(false).show(ctx, |ui| {
        Frame::popup(ui.style()).shadow(Default::default()).inner_margin(4).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 3.0;
            ui.set_width(64.0);
            for tool in Tool::ALL {
                let (name, what) = tool.label();
                let command = Command::Take(tool);
                let button =
                    Button::new(RichText::new(name).small()).selected(tools.tool == tool).min_size(vec2(64.0, 20.0));
                let hint = keys::of(command).map_or(what.to_owned(), |key| format!("{what} ({key})"));
                if ui.add(button).on_hover_text(hint).clicked() && tools.tool != tool {
                    asked.push(command);
                }
            }
            ui.separator();
            // A click into a bookmark's name must not close it: what is typed would act on the picture.
            let stays = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
            let menu = MenuButton::new(RichText::new("Views").small()).config(stays);
            menu.ui(ui, |ui| views(ui, bookmarks, &mut asked));
        });
    });
    asked
}

fn views(ui: &mut Ui, bookmarks: &mut Bookmarks, asked: &mut Vec<Command>) {
    let mut entry = |ui: &mut Ui, name: &str, command: Command| {
        let key = keys::of(command).unwrap_or_default();
        if ui.add(Button::new(name).shortcut_text(key).min_size(vec2(150.0, 0.0))).clicked() {
            asked.push(command);
            ui.close();
        }
    };
    for (name, view) in [
        ("Show all", StandardView::Home),
        ("Show all from this side", StandardView::Fit),
        ("From above", StandardView::Top),
        ("From below", StandardView::Bottom),
        ("From the south", StandardView::Front),
        ("From the north", StandardView::Back),
        ("From the east", StandardView::Right),
        ("From the west", StandardView::Left),
        ("Isometric", StandardView::Isometric),
    ] {
        entry(ui, name, Command::Show(view));
    }
    entry(ui, "With or without perspective", Command::ToggleProjection);
    ui.separator();
    entry(ui, "Undo the last move", Command::Undo);
    entry(ui, "Redo it", Command::Redo);
    ui.separator();
    list(ui, bookmarks, &mut entry);
    entry(ui, "Keep this view", Command::AddBookmark);
}

/// The bookmarks: a button that goes there, the name to be edited, one to put it away.
fn list(ui: &mut Ui, bookmarks: &mut Bookmarks, entry: &mut impl FnMut(&mut Ui, &str, Command)) {
    let mut away = None;
    for (at, bookmark) in bookmarks.entries.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            entry(ui, &bookmark.name, Command::GoToBookmark(at + 1));
            let name = ui.text_edit_singleline(&mut bookmark.name).on_hover_text("Another name");
            name.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, "Name of the bookmark"));
            if ui.small_button("×").on_hover_text("Put the bookmark away").clicked() {
                away = Some(at);
            }
        });
    }
    if let Some(at) = away {
        bookmarks.entries.remove(at);
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::Pos2;
    use egui_kittest::{Harness, kittest::Queryable as _};

    use super::*;

    #[derive(Default)]
    struct World {
        bookmarks: Bookmarks,
        asked: Vec<Command>,
    }

    fn menu() -> Harness<'static, World> {
        let mut world = World::default();
        world.bookmarks.add(crate::render::Camera::default());
        let contents = |ui: &mut Ui, world: &mut World| {
            let rect = Rect::from_min_size(Pos2::ZERO, vec2(800.0, 700.0));
            world.asked.extend(strip(ui.ctx(), rect, &Tools::default(), &mut world.bookmarks));
        };
        let mut harness = Harness::builder().with_size(vec2(800.0, 700.0)).build_ui_state(contents, world);
        harness.run();
        harness.get_by_label("Views").click();
        harness.run();
        harness
    }

    /// By mouse: a click into the field closes no menu, and what is typed is a name and no shortcut.
    #[test]
    fn bookmarks_are_renamed() {
        let mut harness = menu();
        let field = harness.get_by_label("Name of the bookmark").rect().center();
        harness.hover_at(field);
        harness.drag_at(field);
        harness.drop_at(field);
        harness.run();
        assert!(harness.get_by_label("Name of the bookmark").is_focused());
        harness.get_by_label("Name of the bookmark").type_text("x");
        harness.run();
        let names: Vec<&str> = harness.state().bookmarks.entries.iter().map(|entry| entry.name.as_str()).collect();
        assert!(matches!(names[..], [name] if name.ends_with('x')), "{names:?}");
        assert_eq!(harness.state().asked, []);
    }

    #[test]
    fn a_view_that_is_chosen_closes_the_menu() {
        let mut harness = menu();
        harness.get_by_label_contains("From above").click();
        harness.run();
        assert_eq!(harness.state().asked, [Command::Show(StandardView::Top)]);
        assert!(harness.query_by_label("Name of the bookmark").is_none());
    }
}
