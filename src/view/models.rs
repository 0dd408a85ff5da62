//! What the panels show, gathered from the scene.

use std::{
    path::PathBuf,
    time::{Duration, Instant},
};

use eframe::egui::Context;

use super::{
    loading::Loading,
    panels::{
        color::{BARS, Colors, Value, attribute_title},
        files::{Files, Row, State},
        filter::{Filters, Table},
        performance::{GpuMemory, Performance},
        share::Share,
    },
    scene_state::{self, SceneState},
    settings::{Section, Settings},
};
use crate::{
    headless,
    render::{Backend, ColorBy, Coloring, Legend, Look, palette, table_index},
    scene::{Attribute, FileFacts, SceneFacts},
};

/// The files on screen, and what is known of them.
pub fn files(scene: &SceneState, recent: &[PathBuf], coloring: &Coloring, on_wayland: bool) -> Files {
    let by_file = coloring.by == Attribute::File.into();
    let opening = scene.incoming.as_ref().and_then(|incoming| incoming.inputs.first());
    let mut files = Files {
        opening: opening.map(|path| scene_state::name(path)),
        recent: recent.to_vec(),
        on_wayland,
        ..Default::default()
    };
    let Some((loading, facts)) = scene.loading.as_ref().and_then(|loading| Some((loading, loading.scene()?))) else {
        return files;
    };
    files.is_reading = loading.is_running();
    files.points_per_sec = loading.rate();
    files.secs_to_go = loading.secs_to_go();
    let reports = loading.report().map_or(&[][..], |report| &report.files);
    files.rows = facts
        .files
        .iter()
        .enumerate()
        .map(|(number, file)| {
            let report = reports.get(number);
            let points_read = loading.points_read_of(number);
            Row {
                path: file.path.clone(),
                kind: file.kind.clone(),
                crs: file.crs.clone(),
                points: file.points_in_header,
                points_read,
                state: state(loading, number, points_read < file.points_in_header),
                warnings: report.map(|report| report.warnings.clone()).unwrap_or_default(),
                error: report.and_then(|report| report.error.clone()),
                color: by_file.then(|| coloring.file_color(number)),
            }
        })
        .collect();
    let failed = reports.iter().skip(facts.files.len());
    files.failed = failed.map(|file| (file.path.clone(), file.error.clone().unwrap_or_default())).collect();
    files
}

fn state(loading: &Loading, file: usize, is_incomplete: bool) -> State {
    if is_incomplete && loading.is_stopped(file) {
        State::Stopped
    } else if is_incomplete && loading.is_running() {
        State::Reading
    } else {
        State::Done
    }
}

/// Brings the figures up to date that cost something to ask for.
pub fn measure(performance: &mut Performance, scene: &SceneState, device: &wgpu::Device, now: Instant) {
    let progressive = &scene.progressive;
    let info = progressive.backend().info();
    performance.adapter.clone_from(&info.adapter);
    performance.method = info.method.name().to_owned();
    performance.points_waiting = progressive.waiting();
    performance.points_stored = progressive.points_stored();
    performance.fill_per_frame = progressive.fill_points(scene.fill_budget()).into();
    performance.channel = scene.loading.as_ref().and_then(Loading::channel);
    let memory = device.generate_allocator_report();
    performance.gpu_memory =
        memory.map(|report| GpuMemory { used: report.total_allocated_bytes, reserved: report.total_reserved_bytes });
    if let Some(loading) = &scene.loading {
        let done = (!loading.is_running()).then(|| loading.elapsed().as_secs_f64());
        performance.note_threads(now, loading.thread_times(), done);
    }
}

/// What the section about pictures has to know.
pub fn share(share: &mut Share, scene: &SceneState, settings: &Settings, window_size: [u32; 2], is_writing: bool) {
    share.window_size = window_size;
    share.has_scene = scene.navigation.is_some();
    share.command = command(scene, settings, share.size.unwrap_or(window_size));
    share.taking = match &scene.shot {
        Some(_) => Some(scene.read_for_shot()),
        None => is_writing.then_some(1.0),
    };
}

/// What makes this picture without a window.
pub fn command(scene: &SceneState, settings: &Settings, size: [u32; 2]) -> Option<String> {
    let look = Look { shading: settings.shading(), ..settings.look.clone() };
    scene.navigation.as_ref().map(|navigation| headless::command(&look, navigation.camera(), size, scene.inputs()))
}

/// Histograms and counts are gone through this often at most while points arrive.
const SPREAD_INTERVAL: Duration = Duration::from_millis(200);

/// How the values of the attributes are spread, kept until points or settings change.
#[derive(Default)]
pub struct Spread {
    pub colors: Colors,
    pub filters: Filters,
    pub legend: Option<Legend>,
    key: Option<Key>,
    at: Option<Instant>,
}

/// What a [`Spread`] depends on.
#[derive(PartialEq)]
struct Key {
    scene: usize,
    points_stored: u64,
    points_shown: Option<u64>,
    coloring: Coloring,
    sections: [bool; 2],
    cannot_average: bool,
    /// A button of the mouse is held.
    held: bool,
    reading: Option<u64>,
    versions: Vec<Option<u64>>,
}

impl Spread {
    /// Brings it up to date, or asks for a frame in which it will be.
    pub fn refresh(&mut self, ctx: &Context, scene: &mut SceneState, settings: &Settings) {
        let shown = scene.progressive.points_shown();
        if settings.shows(Section::Filter)
            && scene.facts().is_some_and(|facts| facts.files.iter().any(|file| Attribute::Classification.is_in(file)))
        {
            scene.want(Attribute::Classification);
        }
        let scene = &*scene;
        let Some(facts) = scene.facts() else { return };
        let progressive = &scene.progressive;
        let all = attributes(facts);
        let is_high = settings.look.shading.high_quality;
        let key = Key {
            scene: std::sync::Arc::as_ptr(facts) as usize,
            points_stored: progressive.points_stored(),
            points_shown: shown,
            coloring: settings.look.coloring.clone(),
            sections: [Section::Color, Section::Filter].map(|section| settings.shows(section)),
            cannot_average: is_high && !progressive.can_average(),
            held: ctx.input(|i| i.pointer.any_down()),
            // In steps that a bar shows.
            reading: scene.rereading.progress().map(|(_, points)| points * 200 / facts.points_in_header().max(1)),
            versions: all.iter().map(|a| progressive.column_of(a).map(|(_, version)| version)).collect(),
        };
        if self.key.as_ref() == Some(&key) {
            return;
        }
        // What the user has changed is shown at once.
        let is_same = self.key.as_ref().is_some_and(|k| k.coloring == key.coloring && k.sections == key.sections);
        let left = self.at.map(|at| SPREAD_INTERVAL.saturating_sub(at.elapsed())).unwrap_or_default();
        if is_same && !left.is_zero() {
            return ctx.request_repaint_after(left);
        }
        // Under a hand that drags the range, the histogram stays as it is, until it lets go.
        let is_held = key.held && self.key.as_ref().is_some_and(|k| k.coloring.by == key.coloring.by);
        let extent = self.colors.extent.filter(|_| is_held);
        self.colors = colors(scene, facts, &all, settings, extent);
        self.filters = if key.sections[1] {
            filters(scene, facts, &all, &settings.look.coloring, shown)
        } else {
            Filters::default()
        };
        self.legend = progressive.legend();
        self.key = Some(key);
        self.at = Some(Instant::now());
    }
}

/// What points of some file have.
fn attributes(facts: &SceneFacts) -> Vec<Attribute> {
    let in_any = |attribute: &Attribute| facts.files.iter().any(|file| attribute.is_in(file));
    let named = Attribute::NAMED.into_iter().map(|(_, attribute)| attribute).filter(in_any);
    let extra_of = |file: &FileFacts| file.record.extra_names().collect::<Vec<_>>();
    let mut all: Vec<Attribute> = named.collect();
    for name in facts.files.iter().flat_map(extra_of) {
        let attribute = Attribute::Extra(name);
        if !all.contains(&attribute) {
            all.push(attribute);
        }
    }
    all
}

fn colors(
    scene: &SceneState,
    facts: &SceneFacts,
    all: &[Attribute],
    settings: &Settings,
    held_extent: Option<[f64; 2]>,
) -> Colors {
    let coloring = &settings.look.coloring;
    let progressive = &scene.progressive;
    let has_rgb = facts.files.iter().any(|file| ColorBy::Rgb.is_in(file));
    let usual = std::iter::once(ColorBy::Auto).chain(has_rgb.then_some(ColorBy::Rgb));
    let others = all.iter().filter(|&a| *a != Attribute::File || facts.files.len() > 1).cloned();
    let reading = scene.rereading.progress().map(|(attributes, points)| {
        let names: Vec<String> = attributes.iter().map(attribute_title).collect();
        (names.join(", "), points as f32 / facts.points_in_header().max(1) as f32)
    });
    let mut colors = Colors {
        choices: usual.chain(others.map(ColorBy::Attribute)).collect(),
        reading,
        cannot_average: settings.look.shading.high_quality && !progressive.can_average(),
        ..Default::default()
    };
    let Some(attribute) = coloring.by.attribute() else { return colors };
    if attribute.is_categorical() {
        colors.values = values(scene, attribute, facts, coloring);
        return colors;
    }
    let Some(extent) = progressive.extent(attribute) else { return colors };
    let scale = progressive.scale(attribute);
    // A quarter of the range in use beside it: one outlier must not press all others into one bar. And never so little
    // that a range without width could not be pulled apart.
    let room = ((scale.high - scale.low) * 0.25).max((extent[1] - extent[0]) * 1e-3);
    let shown = held_extent.unwrap_or([
        (scale.low - room).max(extent[0].min(scale.low)),
        (scale.high + room).min(extent[1].max(scale.high)),
    ]);
    colors.range = Some([scale.low, scale.high]);
    colors.bars = progressive.histogram(attribute, shown, BARS).unwrap_or_default();
    colors.extent = Some(shown);
    colors
}

fn values(scene: &SceneState, attribute: &Attribute, facts: &SceneFacts, coloring: &Coloring) -> Vec<Value> {
    let value = |(number, points): (u16, u64)| {
        let n = usize::from(number);
        let (name, color) = match attribute {
            Attribute::Classification => {
                let class = coloring.classes.get(number as u8);
                (format!("{number} {}", class.name), class.color)
            }
            Attribute::File => {
                let name = facts.files.get(n).map(|file| scene_state::name(&file.path));
                (name.unwrap_or_default(), coloring.file_color(n))
            }
            Attribute::ReturnNumber => (format!("return {number}"), palette(table_index(number))),
            Attribute::NumberOfReturns => (format!("{number} returns"), palette(table_index(number))),
            _ => (number.to_string(), palette(table_index(number))),
        };
        Value { number: number.into(), name, color, points }
    };
    scene.progressive.counts(attribute).into_iter().map(value).collect()
}

fn filters(
    scene: &SceneState,
    facts: &SceneFacts,
    all: &[Attribute],
    coloring: &Coloring,
    shown: Option<u64>,
) -> Filters {
    let progressive = &scene.progressive;
    // Files have their own ticks.
    let told_apart = all.iter().filter(|a| a.is_categorical() && **a != Attribute::File);
    let table = |attribute: &Attribute| Table {
        attribute: attribute.clone(),
        values: values(scene, attribute, facts, coloring),
        is_partial: !progressive.has_all_values(attribute),
    };
    let range = |attribute: &Attribute| (attribute.clone(), progressive.extent(attribute));
    Filters {
        tables: told_apart.map(table).collect(),
        ranges: all.iter().filter(|a| !a.is_categorical()).map(range).collect(),
        shown: shown.map(|shown| [shown, progressive.points_stored()]),
    }
}
