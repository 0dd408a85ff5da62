//! What a run did, for people who measure.

use std::{collections::VecDeque, path::PathBuf};

use serde::Serialize;

use super::settings::Settings;
use crate::{
    render::{BackendInfo, Camera, Choice, ColorMap, Filter, Legend, LegendClass, LegendKey, Look, Transfer},
    scene::{Bounds, Grid, SceneFacts},
    source::{SourceReport, ThreadTimes},
    store::Encoding,
};

/// The contents of REPORT.json.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// "firstlight" and its version.
    pub program: &'static str,
    pub files: Vec<FileEntry>,
    /// Sums over the files.
    pub points_in_header: u64,
    pub points_decoded: u64,
    pub points_stored: u64,
    /// Points that the filter shows, of those stored.
    pub points_shown: Option<u64>,
    /// Promised by the headers but not decoded; null if the reading was stopped before the end.
    pub points_missing: Option<u64>,
    /// False if the reading was stopped before the end (`--stop`, or memory ran out).
    pub read_to_end: bool,
    /// Insertions into the store.
    pub batches: u64,
    /// Frames drawn.
    pub frames: u64,
    /// The picture equals that of all points stored, and nothing more was to be loaded.
    pub converged: bool,
    pub stop: String,
    pub brute_force: bool,
    /// "gpu" or "cpu".
    pub backend: &'static str,
    /// How points became pixels: a method's name as in `firstlight bench --list`, or "cpu".
    pub method: String,
    /// How positions were stored: "packed", 8 bytes, or "wide", 12.
    pub encoding: Encoding,
    /// What speaks for the method: the speeds of all that were measured. Null on the CPU backend.
    pub choice: Option<Choice>,
    pub adapter: String,
    /// "vulkan", "metal", "dx12" or "cpu".
    pub api: String,
    pub driver: String,
    pub seed: u64,
    /// Points per insertion.
    pub insertion_points: u32,
    /// Points that each frame's fill tried; null for brute force.
    pub fill_points: Option<u32>,
    /// As `--camera` takes it, in the file's own coordinates.
    pub camera: Option<Camera>,
    /// False if the camera was fitted to the scene.
    pub camera_given: bool,
    /// Width and height.
    pub size_px: [u32; 2],
    /// Null where points have a size in space.
    pub point_size_px: Option<u32>,
    /// In the file's unit; null where it is in pixels.
    pub point_size_world: Option<f64>,
    pub edl_strength: f32,
    /// All that was asked for of how the scene is shown, with the defaults of what was not.
    pub look: Look,
    /// What the colours mean; null for rgb, and for automatic colours, which differ from file to file.
    pub legend: Option<LegendEntry>,
    /// As `--filter` takes them.
    pub filter: Filter,
    /// As `--clip` and `--slab` take them; null where there is none.
    pub clip: Option<String>,
    pub slab: Option<String>,
    /// How colours were summed up for high-quality shading, "hqs1r" or "hqs"; null without it.
    pub high_quality: Option<String>,
    /// Points whose colours the averages of high-quality shading hold.
    pub points_averaged: u64,
    /// `world = origin + scale * i`; what all positions lie on.
    pub grid: Option<Grid>,
    /// Union of the headers' boxes, in the file's own coordinates.
    pub bounds: Option<Bounds>,
    pub seconds: Seconds,
    /// Largest resident memory of the process; null where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
    /// Most heap memory that the reader takes, whatever the size of the files; null if it was stopped.
    pub reader_memory_bound_bytes: Option<u64>,
    /// How the decoder threads spent their time; empty if the reading was stopped before the end.
    pub reader_threads: Vec<ThreadTimes>,
    /// Of red, green, blue, alpha (one byte each) per pixel, row by row from the top.
    pub picture_sha256: String,
    pub outputs: OutputPaths,
    /// One line each: what the run decided or ran into.
    pub notes: Vec<String>,
}

/// What the colours of the picture mean.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LegendEntry {
    /// What the points are coloured by, and its unit.
    pub title: String,
    #[serde(flatten)]
    pub key: KeyEntry,
}

/// How values became colours.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum KeyEntry {
    /// The values with the first and the last colour of the map, and how those between are spread.
    Scale { low: f64, high: f64, transfer: Transfer, map: ColorMap },
    /// Of values that are told apart: each that there is, with its colour and how many of the points stored have it.
    Classes { classes: Vec<LegendClass> },
}

impl LegendEntry {
    pub(super) fn new(legend: Legend, map: ColorMap) -> LegendEntry {
        let key = match legend.key {
            LegendKey::Scale { scale, .. } => {
                KeyEntry::Scale { low: scale.low, high: scale.high, transfer: scale.transfer, map }
            }
            LegendKey::Classes(classes) => KeyEntry::Classes { classes },
        };
        LegendEntry { title: legend.title, key }
    }
}

/// One input file.
#[derive(Debug, Clone, Serialize)]
pub struct FileEntry {
    pub path: PathBuf,
    /// e.g. "LAZ 1.4, format 7"; null if the header could not be read.
    pub kind: Option<String>,
    /// Record number, in `--ids`, of the file's first point.
    pub first_record: Option<u32>,
    /// The header's box, in the file's own coordinates.
    pub bounds: Option<Bounds>,
    pub points_in_header: u64,
    pub points_decoded: u64,
    pub points_stored: u64,
    /// Promised by the header but not decoded; null if the reading was stopped before the end.
    pub points_missing: Option<u64>,
    /// Decoded points outside of the header's box; null if the reading was stopped before the end.
    pub points_outside_bounds: Option<u64>,
    pub warnings: Vec<String>,
    /// Why points are missing, if any are.
    pub error: Option<String>,
}

/// Seconds since the program started; null for what was not reached.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Seconds {
    /// The first points are in the store (on the GPU: their insertion is submitted).
    pub to_first_point: Option<f64>,
    /// The first frame with points is finished on the device.
    pub to_first_picture: Option<f64>,
    /// All points are in the store, and the frame that inserted the last of them is finished.
    pub to_all_loaded: Option<f64>,
    /// The converged picture is finished on the device and was read back.
    pub to_converged: Option<f64>,
    /// The picture is read back, whether it has converged or not; nothing is written yet.
    pub to_picture: Option<f64>,
}

/// Where the outputs went.
#[derive(Debug, Clone, Default, Serialize)]
pub struct OutputPaths {
    pub picture: Option<PathBuf>,
    pub ids: Option<PathBuf>,
    pub depth: Option<PathBuf>,
    pub report: Option<PathBuf>,
}

impl Report {
    /// True if points are missing that the inputs promise: a file is damaged, or memory ran out.
    pub fn is_partial(&self) -> bool {
        self.points_missing.is_some_and(|n| n > 0) || self.files.iter().any(|file| file.error.is_some())
    }
}

/// Who stored what: batches enter the store in the order in which they arrive.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// Runs of points that arrived and are not yet stored: file and count.
    waiting: VecDeque<(usize, u64)>,
    counted: u64,
    /// Per file.
    pub arrived: Vec<u64>,
    pub stored: Vec<u64>,
}

impl Tally {
    pub fn new(files: usize) -> Tally {
        Tally { arrived: vec![0; files], stored: vec![0; files], ..Default::default() }
    }

    pub fn arrive(&mut self, file: u32, points: usize) {
        let file = file as usize;
        self.arrived[file] += points as u64;
        match self.waiting.back_mut() {
            Some((last, count)) if *last == file => *count += points as u64,
            _ => self.waiting.push_back((file, points as u64)),
        }
    }

    /// `total`: points in the store by now.
    pub fn store_holds(&mut self, total: u64) {
        let mut new = total - self.counted;
        self.counted = total;
        while new > 0
            && let Some((file, count)) = self.waiting.front_mut()
        {
            let taken = new.min(*count);
            self.stored[*file] += taken;
            *count -= taken;
            new -= taken;
            if *count == 0 {
                self.waiting.pop_front();
            }
        }
    }
}

/// One entry per file of the scene, then those that never became part of it.
pub(super) fn file_entries(facts: Option<&SceneFacts>, tally: &Tally, source: Option<&SourceReport>) -> Vec<FileEntry> {
    let mut told: Vec<_> = source.map(|s| s.files.iter().collect()).unwrap_or_default();
    let mut entries = Vec::new();
    for (index, file) in facts.iter().flat_map(|facts| &facts.files).enumerate() {
        let found = told.iter().position(|t| t.path == file.path).map(|at| told.remove(at));
        let decoded = found.map_or(tally.arrived[index], |t| t.points_decoded);
        entries.push(FileEntry {
            path: file.path.clone(),
            kind: Some(file.kind.clone()),
            first_record: Some(file.first_record),
            bounds: Some(file.bounds),
            // A scene expects no more points than a cut file has room for; the reader's report says
            // what the header promised.
            points_in_header: found.map_or(file.points_in_header, |t| t.points_in_header),
            points_decoded: decoded,
            points_stored: tally.stored[index],
            points_missing: found.map(|t| t.points_in_header.saturating_sub(decoded)),
            points_outside_bounds: found.map(|t| t.points_outside_bounds),
            warnings: found.map(|t| t.warnings.clone()).unwrap_or_default(),
            error: found.and_then(|t| t.error.clone()),
        });
    }
    entries.extend(told.into_iter().map(|t| FileEntry {
        path: t.path.clone(),
        kind: None,
        first_record: None,
        bounds: None,
        points_in_header: t.points_in_header,
        points_decoded: t.points_decoded,
        points_stored: 0,
        points_missing: Some(t.points_in_header.saturating_sub(t.points_decoded)),
        points_outside_bounds: None,
        warnings: t.warnings.clone(),
        error: t.error.clone(),
    }));
    entries
}

impl Report {
    /// What the settings alone say.
    pub(super) fn new(settings: &Settings, info: &BackendInfo, backend: &'static str) -> Report {
        let path = |d: &Option<super::Destination>| d.as_ref().map(|d| d.path().to_path_buf());
        Report {
            program: concat!("firstlight ", env!("CARGO_PKG_VERSION")),
            files: Vec::new(),
            points_in_header: 0,
            points_decoded: 0,
            points_stored: 0,
            points_shown: None,
            points_missing: None,
            read_to_end: false,
            batches: 0,
            frames: 0,
            converged: false,
            stop: settings.stop.to_string(),
            brute_force: settings.brute_force,
            backend,
            method: info.method.to_string(),
            encoding: info.encoding,
            choice: info.choice.clone(),
            adapter: info.adapter.clone(),
            api: info.api.clone(),
            driver: info.driver.clone(),
            seed: settings.seed,
            insertion_points: settings.insertion_points,
            fill_points: (!settings.brute_force).then(|| settings.fill_points()),
            camera: settings.camera,
            camera_given: settings.camera.is_some(),
            size_px: settings.size,
            point_size_px: settings.look.point_size.pixels(),
            point_size_world: None,
            edl_strength: settings.look.shading.edl_strength,
            look: settings.look.clone(),
            legend: None,
            filter: settings.look.filter.clone(),
            clip: settings.look.clip.bounds.map(|bounds| bounds.to_string()),
            slab: settings.look.clip.slab.map(|slab| slab.to_string()),
            high_quality: None,
            points_averaged: 0,
            grid: None,
            bounds: None,
            seconds: Seconds::default(),
            peak_memory_bytes: None,
            reader_memory_bound_bytes: None,
            reader_threads: Vec::new(),
            picture_sha256: String::new(),
            outputs: OutputPaths {
                picture: path(&settings.outputs.picture),
                ids: path(&settings.outputs.ids),
                depth: path(&settings.outputs.depth),
                report: path(&settings.outputs.report),
            },
            notes: Vec::new(),
        }
    }
}

/// Largest resident memory of this process so far, bytes.
pub(super) fn peak_memory_bytes() -> Option<u64> {
    // Linux only: elsewhere it takes a system call, and that takes `unsafe`.
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_counted_for_the_file_they_came_from() {
        let mut tally = Tally::new(3);
        tally.arrive(0, 10);
        tally.arrive(1, 5);
        tally.arrive(1, 5);
        tally.store_holds(12);
        assert_eq!(tally.stored, [10, 2, 0]);
        tally.arrive(2, 7);
        tally.store_holds(21);
        assert_eq!(tally.stored, [10, 10, 1]);
        assert_eq!(tally.arrived, [10, 10, 7]);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn linux_tells_the_peak_memory() {
        assert!(peak_memory_bytes().unwrap() > 1 << 20);
    }
}
