//! What the panels show, gathered from the scene.

use std::{path::PathBuf, time::Instant};

use super::{
    loading::Loading,
    panels::{
        files::{Files, Row, State},
        performance::{GpuMemory, Performance},
        share::Share,
    },
    scene_state::{self, SceneState},
};
use crate::render::Backend;

/// The files on screen, and what is known of them.
pub fn files(scene: &SceneState, recent: &[PathBuf], on_wayland: bool) -> Files {
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
                crs: None,
                points: file.points_in_header,
                points_read,
                state: state(loading, number, points_read < file.points_in_header),
                warnings: report.map(|report| report.warnings.clone()).unwrap_or_default(),
                error: report.and_then(|report| report.error.clone()),
                color: None,
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
pub fn share(share: &mut Share, scene: &SceneState, window_size: [u32; 2], is_writing: bool) {
    share.window_size = window_size;
    share.has_scene = scene.navigation.is_some();
    let done = |(tried, stored): (u64, u64)| (tried as f32 / stored.max(1) as f32).min(1.0);
    share.taking = match &scene.shot {
        Some(_) => Some(scene.last_report.map_or(0.0, |report| {
            let stored = scene.facts().map_or(report.points_stored, |facts| facts.points_in_header());
            done((report.points_tried, stored.max(report.points_stored)))
        })),
        None => is_writing.then_some(1.0),
    };
}
