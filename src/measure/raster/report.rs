//! All samples of a measurement; its JSON is the report that tables, charts and other programs read.

use serde::Serialize;

use super::{accuracy::Accuracy, orders::Order};
use crate::{
    measure::{machine::Machine, stats::Summary},
    methods::{FrameTime, Method},
    render::Camera,
};

/// What the JSON says of itself; a folder with such a file may be written over.
pub const TITLE: &str = "firstlight bench";

/// The whole measurement, or as much of it as is done.
#[derive(Debug, Clone, Serialize)]
pub struct RasterReport {
    pub report: &'static str,
    /// "firstlight" and its version.
    pub program: String,
    /// The command line, quoted for a shell.
    pub command: String,
    /// False until everything was measured: the program was stopped before, or is still at it.
    pub complete: bool,
    pub machine: Machine,
    pub device: Device,
    /// What was read, in words.
    pub input: String,
    pub points: u64,
    pub size_px: [u32; 2],
    /// "wide" or "packed".
    pub encoding: &'static str,
    /// Of positions, and of whatever lies between them.
    pub bytes_per_point: u64,
    /// Frames of a sample run, and rounds: `frames * repeat` samples of everything.
    pub frames: u32,
    pub repeat: u32,
    /// Of the shuffles.
    pub seed: u64,
    /// Frames were timed by the wall clock, not by the device's timestamps.
    pub wall_clock: bool,
    pub methods: Vec<MethodEntry>,
    pub ceilings: Ceilings,
    pub blocks: Vec<Block>,
    pub curves: Vec<CurveRuns>,
    /// Whether methods that are wrong on purpose came out wrong, and the right ones right.
    pub checks: Vec<Check>,
    /// One line each: what could not be read or measured, checks that failed.
    pub problems: Vec<String>,
}

/// Who drew.
#[derive(Debug, Clone, Serialize)]
pub struct Device {
    pub adapter: String,
    /// Vulkan, Metal, Dx12.
    pub api: String,
    /// Driver and its version, as far as known.
    pub driver: String,
    /// A processor that stands in for a GPU.
    pub is_software: bool,
}

/// A method of the table that was asked for.
#[derive(Debug, Clone, Serialize)]
pub struct MethodEntry {
    pub name: &'static str,
    pub what: &'static str,
    pub source: &'static str,
    pub needs: String,
    pub wrong_on_purpose: Option<&'static str>,
    pub blends: bool,
    /// What this device lacks; such a method was not measured.
    pub missing: Option<String>,
}

impl MethodEntry {
    pub fn new(method: &Method, missing: Option<String>) -> MethodEntry {
        MethodEntry {
            name: method.name,
            what: method.what,
            source: method.source,
            needs: method.needs.to_string(),
            wrong_on_purpose: method.wrong_on_purpose,
            blends: method.blends,
            missing,
        }
    }
}

/// What no method can exceed, measured between the blocks; bytes per second.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Ceilings {
    /// Buffer to buffer on the device; every byte is counted once as read and once as written.
    pub copy_bytes_per_sec: Option<Summary>,
    /// A kernel that only reads the positions.
    pub read_bytes_per_sec: Option<Summary>,
    pub copy_samples: Vec<f64>,
    pub read_samples: Vec<f64>,
}

impl Ceilings {
    pub fn summarize(&mut self) {
        self.copy_bytes_per_sec = Summary::of(&self.copy_samples);
        self.read_bytes_per_sec = Summary::of(&self.read_samples);
    }
}

/// One order seen from one viewpoint.
#[derive(Debug, Clone, Serialize)]
pub struct Block {
    pub order: Order,
    pub view: String,
    pub camera: Camera,
    /// Points in the frustum, and pixels that show one.
    pub fragments: u64,
    pub covered_pixels: u64,
    /// Covered pixels in which the device's `atomic-min`, what all are compared with, differs from the
    /// processor's: rounding of another order.
    pub reference_differs: u64,
    pub rows: Vec<Row>,
}

impl Block {
    /// Points per covered pixel; NaN without any.
    pub fn overdraw(&self) -> f64 {
        self.fragments as f64 / self.covered_pixels as f64
    }
}

/// One method in a block.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    pub method: &'static str,
    /// Whole frames: clear, all passes over the points, resolve.
    pub frame_secs: Option<Summary>,
    /// All points of the cloud, seen or not, per second of a frame.
    pub points_per_sec: Option<Summary>,
    /// Bytes of the cloud's positions per second of a frame; methods that read them twice are not counted twice.
    pub bytes_per_sec: Option<Summary>,
    pub accuracy: Accuracy,
    pub samples: Vec<Sample>,
}

impl Row {
    /// A row without samples yet.
    pub fn new(method: &'static str, accuracy: Accuracy) -> Row {
        Row { method, frame_secs: None, points_per_sec: None, bytes_per_sec: None, accuracy, samples: Vec::new() }
    }

    /// True if a frame was timed by the wall clock.
    pub fn has_wall_clock(&self) -> bool {
        self.samples.iter().any(|sample| sample.passes.undivided_secs.is_some())
    }

    pub fn summarize(&mut self, points: u64, bytes_per_point: u64) {
        let secs: Vec<f64> = self.samples.iter().map(|sample| sample.frame_secs).collect();
        self.frame_secs = Summary::of(&secs);
        self.points_per_sec = self.frame_secs.map(|secs| secs.per(points as f64));
        self.bytes_per_sec = self.frame_secs.map(|secs| secs.per((points * bytes_per_point) as f64));
    }

    /// Share of a ceiling, by medians.
    pub fn share_of(&self, ceiling: Option<Summary>) -> Option<f64> {
        Some(self.bytes_per_sec?.median / ceiling?.median)
    }
}

/// One frame.
#[derive(Debug, Clone, Serialize)]
pub struct Sample {
    /// From 1.
    pub round: u32,
    pub frame_secs: f64,
    /// Its passes; zero and empty where the device cannot tell them apart.
    #[serde(flatten)]
    pub passes: FrameTime,
}

impl Sample {
    pub fn new(round: u32, time: &FrameTime) -> Sample {
        Sample { round, frame_secs: time.total_secs(), passes: time.clone() }
    }
}

/// Which curve a run belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CurveKind {
    /// The scan thinned to fewer points.
    Points,
    /// Planes stacked before the camera, each with a point for every pixel.
    Planes,
    /// A stack of planes with so many points, its base shrunk to fewer pixels.
    Base,
}

/// One method at one place of a curve.
#[derive(Debug, Clone, Serialize)]
pub struct CurveRuns {
    pub curve: CurveKind,
    pub method: &'static str,
    pub points: u64,
    /// Points per covered pixel.
    pub fragments_per_pixel: f64,
    pub frame_secs: Option<Summary>,
    pub samples_secs: Vec<f64>,
}

/// Something that must hold, or the figures mean nothing.
#[derive(Debug, Clone, Serialize)]
pub struct Check {
    pub what: String,
    /// Null: nothing in this run could tell.
    pub holds: Option<bool>,
    pub found: String,
}

#[cfg(test)]
impl RasterReport {
    /// A report of nothing.
    pub fn for_tests() -> RasterReport {
        RasterReport {
            report: TITLE,
            program: String::new(),
            command: String::new(),
            complete: true,
            machine: Machine::find(),
            device: Device { adapter: String::new(), api: String::new(), driver: String::new(), is_software: true },
            input: String::new(),
            points: 1000,
            size_px: [64, 48],
            encoding: "wide",
            bytes_per_point: 16,
            frames: 1,
            repeat: 1,
            seed: 1,
            wall_clock: true,
            methods: Vec::new(),
            ceilings: Ceilings::default(),
            blocks: Vec::new(),
            curves: Vec::new(),
            checks: Vec::new(),
            problems: Vec::new(),
        }
    }
}
