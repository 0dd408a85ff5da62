//! The lines over the picture: what is on screen, and the few controls. Only paints what it is given.

use eframe::egui::{
    self, Align, Align2, Area, Button, Color32, CornerRadius, FontId, Frame, Id, Label, Layout, Margin, Order, Rect,
    RichText, Slider, Ui, vec2,
};

use super::{
    format::{count, duration, percent},
    keys::Command,
    navigation::StandardView,
    settings::Settings,
};
use crate::render::{Choice, Clock, MAX_PX, PointSize};

/// How much of the picture the lines at the edge hide, of 255: texts and ticks keep their contrast on a white picture.
pub const PANEL_ALPHA: u8 = 235;
const ACCENT: Color32 = Color32::from_rgb(106, 182, 255);
const LINE_HEIGHT: f32 = 20.0;
/// Two lines, the space between them and around them.
pub const BAR_HEIGHT: f32 = 2.0 * LINE_HEIGHT + 3.0 + 10.0;
/// Narrower windows show the lines without the controls.
const CONTROLS_FROM_WIDTH: f32 = 900.0;
/// With less room left beside the numbers nothing is said of the device.
const DEVICE_FROM_WIDTH: f32 = 100.0;

/// What the lines say.
#[derive(Debug, Clone, Default)]
pub struct Status {
    pub files: String,
    /// Files after the first one.
    pub kind: String,
    pub loading: bool,
    pub points_read: u64,
    pub points_stored: u64,
    /// Promised by the headers.
    pub points_total: u64,
    pub points_per_sec: f64,
    pub loading_secs: f64,
    /// Until all is read.
    pub secs_to_go: Option<f64>,
    /// Points tried per frame.
    pub fill: u32,
    pub fill_is_fixed: bool,
    /// Of the last frame, where the device can tell.
    pub device_secs: Option<f64>,
    /// From window frame to window frame, while they follow each other.
    pub window_secs: f64,
    /// Since the camera moved.
    pub points_tried: u64,
    /// Until all that is stored has been tried.
    pub secs_to_picture: Option<f64>,
    pub averages: Averages,
    /// Where a filter or a clipping box or slab hides points.
    pub shown: Option<Shown>,
    /// The mouse looks around instead of turning the scene.
    pub is_flying: bool,
    pub adapter: String,
    /// Which method draws, and the figures behind it.
    pub choice: Option<Choice>,
}

/// What is left by a filter and by clipping.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shown {
    /// As soon as the device has told.
    pub points: Option<u64>,
}

/// How high-quality shading stands.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Averages {
    #[default]
    Off,
    /// In every frame; so many points are in the averages that stay.
    On(u64),
    /// Only while nothing moves or loads: frames would take too long.
    AtRest(u64),
}

/// Whether the window has room for any words.
pub fn fits(ctx: &egui::Context) -> bool {
    let size = ctx.content_rect().size();
    size.x >= 160.0 && size.y >= 120.0
}

/// Two lines at the lower edge of the picture, which takes `screen` of the window.
pub fn bar(ctx: &egui::Context, screen: Rect, status: &Status, settings: &mut Settings) -> Vec<Command> {
    let mut asked = Vec::new();
    let corner = screen.left_bottom() - vec2(0.0, BAR_HEIGHT);
    Area::new(Id::unique("status")).order(Order::Foreground).fixed_pos(corner).constrain(false).show(ctx, |ui| {
        Frame::new().fill(panel_fill(ui)).inner_margin(Margin::symmetric(10, 5)).show(ui, |ui| {
            ui.set_width(screen.width() - 20.0);
            ui.set_height(BAR_HEIGHT - 10.0);
            ui.spacing_mut().item_spacing = vec2(8.0, 3.0);
            line(ui, |ui| {
                if screen.width() >= CONTROLS_FROM_WIDTH {
                    controls(ui, settings, &mut asked);
                }
                hidden(ui, status, settings);
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| loading_line(ui, status));
            });
            line(ui, |ui| {
                if status.is_flying {
                    flying(ui, &mut asked);
                }
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    frame_line(ui, status);
                    if ui.available_width() >= DEVICE_FROM_WIDTH {
                        ui.with_layout(Layout::right_to_left(Align::Center), |ui| device(ui, status));
                    }
                });
            });
        });
        progress(ui, screen, status);
    });
    asked
}

/// One line, filled from the right; what comes last gets what is left of it.
fn line(ui: &mut Ui, contents: impl FnOnce(&mut Ui)) {
    ui.allocate_ui_with_layout(vec2(ui.available_width(), LINE_HEIGHT), Layout::right_to_left(Align::Center), contents);
}

/// That there is more than can be seen, and a button that shows it.
fn hidden(ui: &mut Ui, s: &Status, settings: &mut Settings) {
    let Some(shown) = s.shown else { return };
    if ui.add(Button::new(small("Show all")).small()).on_hover_text("No filter, no clipping").clicked() {
        settings.show_all();
    }
    let points = shown.points.map_or("…".to_owned(), count);
    let text = small(&format!("{points} of {} shown", count(s.points_stored)));
    let hides_any = shown.points.is_some_and(|points| points < s.points_stored);
    ui.label(if hides_any { text.color(ui.visuals().warn_fg_color) } else { text });
}

/// That the mouse flies, and how it turns the scene again.
fn flying(ui: &mut Ui, asked: &mut Vec<Command>) {
    let button = Button::new(small("Fly mode: F ends it")).small().selected(true);
    if ui.add(button).on_hover_text("Left drag looks around; W A S D Q E fly").clicked() {
        asked.push(Command::FlyMode);
    }
}

fn small(text: &str) -> RichText {
    RichText::new(text).font(FontId::proportional(12.5))
}

fn panel_fill(ui: &Ui) -> Color32 {
    let [r, g, b, _] = ui.visuals().panel_fill.to_array();
    Color32::from_rgba_unmultiplied(r, g, b, PANEL_ALPHA)
}

/// Who draws, with which method; why, and how fast the others are, when the mouse asks.
fn device(ui: &mut Ui, s: &Status) {
    let method = s.choice.as_ref().map_or(String::new(), |choice| format!(" · {}", choice.candidate));
    let label = ui.add(Label::new(small(&format!("{}{method}", s.adapter)).weak()).truncate());
    if let Some(choice) = &s.choice {
        label.on_hover_ui(|ui| choice_table(ui, choice));
    }
}

fn choice_table(ui: &mut Ui, choice: &Choice) {
    ui.label(small(&format!("{}: {}", choice.candidate, choice.reason)).strong());
    let Some(measurement) = &choice.measurement else { return };
    let [width, height] = measurement.size_px;
    let clock = choice.candidates.iter().find_map(|row| row.speed).map_or("", |speed| match speed.clock {
        Clock::Device => "device timestamps",
        Clock::Wall => "wall clock",
    });
    let text = format!(
        "{} points at {width}×{height}, {} px, {} after the start, {clock}",
        count(measurement.points.into()),
        measurement.point_size_px,
        duration(measurement.at_secs),
    );
    ui.label(small(&text).weak());
    egui::Grid::new("methods").num_columns(3).spacing(vec2(18.0, 2.0)).show(ui, |ui| {
        for heading in ["points/s", "overview", "far"] {
            ui.label(small(heading).weak());
        }
        ui.end_row();
        for row in choice.candidates.iter().filter(|row| row.speed.is_some()) {
            let marked =
                |text: &str| if row.candidate == choice.candidate { small(text).strong() } else { small(text) };
            ui.label(marked(&row.candidate.to_string()));
            for rate in row.speed.iter().flat_map(|s| [s.overview_points_per_sec, s.far_points_per_sec]) {
                ui.label(marked(&count(rate as u64)));
            }
            ui.end_row();
        }
    });
    let left_out = choice.candidates.iter().filter(|row| row.speed.is_none()).count();
    if left_out > 0 {
        ui.label(small(&format!("{left_out} more not measured")).weak());
    }
}

fn loading_line(ui: &mut Ui, s: &Status) {
    ui.add(Label::new(small(&s.files).strong()).truncate());
    let read = percent(s.points_read, s.points_total);
    let mut text = format!("{} · {read} read · {} of {} points", s.kind, count(s.points_stored), count(s.points_total));
    text += &if s.loading {
        let to_go = s.secs_to_go.map_or(String::new(), |secs| format!(" · {} to go", duration(secs)));
        format!(" · {} points/s{to_go}", count(s.points_per_sec as u64))
    } else {
        format!(" · loaded in {} ({} points/s)", duration(s.loading_secs), count(s.points_per_sec as u64))
    };
    ui.add(Label::new(small(&text)).truncate());
}

fn frame_line(ui: &mut Ui, s: &Status) {
    let fixed = if s.fill_is_fixed { " (fixed)" } else { "" };
    let device = s.device_secs.map_or("–".to_owned(), duration);
    let averages = match s.averages {
        Averages::Off => String::new(),
        Averages::On(points) => format!(" · HQ {}", percent(points, s.points_stored)),
        Averages::AtRest(0) => " · HQ at rest".to_owned(),
        Averages::AtRest(points) => format!(" · HQ at rest {}", percent(points, s.points_stored)),
    };
    let to_go = match s.secs_to_picture {
        Some(secs) if secs >= 1.0 => format!(" · {} to go", duration(secs)),
        _ => String::new(),
    };
    let text = format!(
        "{} tried since the last move{to_go}{averages} · fill {} per frame{fixed} · device {device} · window {}",
        percent(s.points_tried, s.points_stored),
        count(s.fill.into()),
        duration(s.window_secs),
    );
    ui.add(Label::new(small(&text)).truncate());
}

/// Two hairlines along the bar's upper edge: read, and tried.
fn progress(ui: &Ui, screen: Rect, s: &Status) {
    let top = ui.min_rect().top();
    let share = |part: u64, whole: u64| if whole == 0 { 0.0 } else { (part as f32 / whole as f32).min(1.0) };
    let hairline = |y: f32, share: f32, color| {
        let rect = Rect::from_min_size(egui::pos2(screen.left(), y), vec2(screen.width() * share, 2.0));
        ui.painter().rect_filled(rect, CornerRadius::ZERO, color);
    };
    hairline(top, 1.0, Color32::from_black_alpha(120));
    hairline(top, share(s.points_tried, s.points_stored), Color32::from_gray(110));
    if s.loading {
        hairline(top, share(s.points_read, s.points_total), ACCENT);
    }
}

/// From the right.
fn controls(ui: &mut Ui, settings: &mut Settings, asked: &mut Vec<Command>) {
    let button = |ui: &mut Ui, text: &str, hint: &str| ui.add(Button::new(small(text)).small()).on_hover_text(hint);
    if button(ui, "?", "Keys and mouse (F1)").clicked() {
        settings.help = !settings.help;
    }
    if button(ui, "Panel", "Files, looks, pictures, performance, messages (Tab)").clicked() {
        settings.panel = !settings.panel;
    }
    for (ask, text, hint) in [
        (StandardView::Right, "Side", "From the east (3)"),
        (StandardView::Front, "Front", "From the south (1)"),
        (StandardView::Top, "Top", "From above (7)"),
        (StandardView::Home, "Fit", "Show all (Home or H)"),
    ] {
        if button(ui, text, hint).clicked() {
            asked.push(Command::Show(ask));
        }
    }
    ui.checkbox(&mut settings.look.shading.high_quality, small("HQ"))
        .on_hover_text("High quality: mean colour of all points within 1 % of the nearest (B)");
    ui.checkbox(&mut settings.edl, small("shading")).on_hover_text("Eye-dome lighting (L)");
    ui.spacing_mut().slider_width = 64.0;
    if let PointSize::Pixels(pixels) = &mut settings.look.point_size {
        ui.add(Slider::new(pixels, 1..=MAX_PX).suffix(" px")).on_hover_text("Size of points ([ and ])");
    }
}

/// In the middle of an empty window.
pub fn invitation(ui: &Ui, screen: Rect, waiting_for: Option<&str>, background: [u8; 3], on_wayland: bool) {
    let is_bright = background.iter().map(|&channel| u32::from(channel)).sum::<u32>() > 384;
    let color = if is_bright { Color32::from_gray(40) } else { Color32::from_rgb(226, 230, 236) };
    let middle = screen.center();
    let (first, second) = match waiting_for {
        Some(name) => (format!("Opening {name} …"), String::new()),
        // Not every compositor lets files be dropped.
        None if on_wayland => (
            "Open a LAS or LAZ file with Ctrl+O".to_owned(),
            "or a folder with Ctrl+Shift+O · F1 shows the keys".to_owned(),
        ),
        None => ("Drop a LAS or LAZ file here".to_owned(), "or a folder · Ctrl+O opens · F1 shows the keys".to_owned()),
    };
    let paint = |offset: f32, text: String, size: f32, color| {
        ui.painter().text(middle + vec2(0.0, offset), Align2::CENTER_CENTER, text, FontId::proportional(size), color);
    };
    paint(0.0, first, 24.0, color);
    paint(30.0, second, 14.0, color.gamma_multiply(0.7));
}

/// Over the picture while one for a file waits for its points.
pub fn waiting_for_picture(ctx: &egui::Context, screen: Rect, read: f32) {
    let painter = ctx.layer_painter(egui::LayerId::new(Order::Middle, Id::unique("waiting for a picture")));
    let read = (read * 100.0).floor();
    let text = format!("The picture of this view is taken once all is read … {read:.0} % (Esc stops it)");
    let text = painter.layout(text, FontId::proportional(15.0), Color32::WHITE, screen.width() - 40.0);
    let plate = Rect::from_center_size(screen.center_top() + vec2(0.0, 40.0), text.size() + vec2(20.0, 12.0));
    painter.rect_filled(plate, CornerRadius::same(6), Color32::from_black_alpha(200));
    painter.galley(plate.min + vec2(10.0, 6.0), text, Color32::WHITE);
}

/// Shown while files hover over the window.
pub fn drop_target(ctx: &egui::Context, add: bool) {
    let painter = ctx.layer_painter(egui::LayerId::new(Order::Tooltip, Id::unique("drop target")));
    let screen = ctx.content_rect();
    painter.rect_filled(screen, CornerRadius::ZERO, Color32::from_black_alpha(150));
    let frame = screen.shrink(16.0);
    painter.rect_stroke(frame, CornerRadius::same(8), (2.0, ACCENT), egui::StrokeKind::Inside);
    let font = FontId::proportional(24.0);
    painter.text(
        screen.center(),
        Align2::CENTER_CENTER,
        if add { "Drop to add" } else { "Drop to open" },
        font,
        Color32::WHITE,
    );
}

#[cfg(test)]
mod tests {
    use eframe::egui::Pos2;
    use egui_kittest::{Harness, kittest::Queryable as _};

    use super::*;
    use crate::{
        render::ClipBox,
        view::{Options, remembered::Remembered},
    };

    struct World {
        status: Status,
        settings: Settings,
        asked: Vec<Command>,
    }

    fn bar_of(width: f32, status: Status) -> Harness<'static, World> {
        let mut settings = Settings::new(&Options::default(), &Remembered::default());
        settings.look.clip.bounds = Some(ClipBox { min: [0.0; 3], max: [1.0; 3], degrees: 0.0 });
        let contents = move |ui: &mut Ui, world: &mut World| {
            let screen = Rect::from_min_size(Pos2::ZERO, vec2(width, 400.0));
            world.asked.extend(bar(ui.ctx(), screen, &world.status, &mut world.settings));
        };
        let world = World { status, settings, asked: Vec::new() };
        let mut harness = Harness::builder().with_size(vec2(width, 400.0)).build_ui_state(contents, world);
        harness.run();
        harness
    }

    fn status() -> Status {
        Status {
            files: "town.laz".into(),
            kind: "LAZ 1.4, format 7".into(),
            points_read: 215_000,
            points_stored: 215_000,
            points_total: 215_000,
            points_tried: 215_000,
            adapter: "llvmpipe (LLVM 15.0.6, 256 bits)".into(),
            shown: Some(Shown { points: Some(58_000) }),
            ..Default::default()
        }
    }

    #[test]
    fn narrow_bars_say_the_numbers_before_the_device() {
        let numbers = |width: f32| {
            let harness = bar_of(width, status());
            let has_device = harness.query_by_label_contains("llvmpipe").is_some();
            (harness.get_by_label_contains("tried since the last move").rect().width(), has_device)
        };
        let (whole, has_device) = numbers(1280.0);
        assert!(has_device && whole > 300.0, "{whole}");
        for width in [900.0, 640.0, 560.0] {
            assert_eq!(numbers(width).0, whole, "a window {width} points wide");
        }
        let (cut, has_device) = numbers(330.0);
        assert!(!has_device && cut > 280.0, "{cut}");
    }

    #[test]
    fn hidden_points_are_told_and_shown_again_at_any_width() {
        for width in [1280.0, 640.0, 330.0] {
            let mut harness = bar_of(width, status());
            let told = harness.get_by_label("58.0 k of 215 k shown").rect();
            assert!(told.left() >= 0.0 && told.right() <= width, "{told:?}");
            harness.get_by_label("Show all").click();
            harness.run();
            assert!(harness.state().settings.look.shows_all(), "{width}");
        }
        let all = bar_of(640.0, Status { shown: None, ..status() });
        assert!(all.query_by_label("Show all").is_none());
    }

    #[test]
    fn fly_mode_is_told_and_left() {
        assert!(bar_of(640.0, status()).query_by_label_contains("Fly mode").is_none());
        let mut harness = bar_of(330.0, Status { is_flying: true, ..status() });
        harness.get_by_label_contains("Fly mode").click();
        harness.run();
        assert_eq!(harness.state().asked, [Command::FlyMode]);
    }
}
