//! All samples of a measurement; its JSON is the report that tables, charts and other programs read.

use serde::{Serialize, Serializer};

use super::{accuracy::Accuracy, orders::Order};
use crate::{
    measure::{machine::Machine, stats::Summary},
    methods::{Abandoned, Encoding, FrameTime, Method},
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
    /// How positions lay in memory; curves have the first.
    pub encodings: Vec<Encoding>,
    /// The most frames of a method in a round, and rounds. Slow methods draw fewer.
    pub frames: u32,
    pub repeat: u32,
    /// A method whose first frame is longer draws no other.
    pub max_frame_secs: f64,
    /// Of the shuffles.
    pub seed: u64,
    /// Frames were timed by the wall clock, not by the device's timestamps.
    pub wall_clock: bool,
    pub methods: Vec<MethodEntry>,
    /// How long what is not measured took on the host: making or reading the points, orders, uploads, the
    /// processor's pictures, blocks as a whole.
    pub host: Vec<HostTime>,
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

/// Something that the host did.
#[derive(Debug, Clone, Serialize)]
pub struct HostTime {
    pub what: String,
    pub secs: f64,
}

/// What no method can exceed, measured between the blocks; bytes per second.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Ceilings {
    /// Buffer to buffer on the device, which may leave that to an engine apart; every byte is counted once as
    /// read and once as written.
    pub copy_bytes_per_sec: Option<Summary>,
    /// The same by a kernel.
    pub copy_kernel_bytes_per_sec: Option<Summary>,
    pub copy_samples: Vec<f64>,
    pub copy_kernel_samples: Vec<f64>,
    pub read: Vec<ReadCeiling>,
}

/// A kernel that only reads the positions.
#[derive(Debug, Clone, Serialize)]
pub struct ReadCeiling {
    pub encoding: Encoding,
    pub bytes_per_sec: Option<Summary>,
    pub samples: Vec<f64>,
}

impl Ceilings {
    /// Adds samples of a cloud in this encoding.
    pub fn add(&mut self, encoding: Encoding, copy: &[f64], copy_kernel: &[f64], read: &[f64]) {
        self.copy_samples.extend(copy);
        self.copy_kernel_samples.extend(copy_kernel);
        let known = self.read.iter().position(|ceiling| ceiling.encoding == encoding);
        let place = known.unwrap_or_else(|| {
            self.read.push(ReadCeiling { encoding, bytes_per_sec: None, samples: Vec::new() });
            self.read.len() - 1
        });
        self.read[place].samples.extend(read);
    }

    pub fn summarize(&mut self) {
        self.copy_bytes_per_sec = Summary::of(&self.copy_samples);
        self.copy_kernel_bytes_per_sec = Summary::of(&self.copy_kernel_samples);
        self.read.iter_mut().for_each(|read| read.bytes_per_sec = Summary::of(&read.samples));
    }

    pub fn read_bytes_per_sec(&self, encoding: Encoding) -> Option<Summary> {
        self.read.iter().find(|read| read.encoding == encoding)?.bytes_per_sec
    }
}

/// One order in one encoding, seen from one viewpoint.
#[derive(Debug, Clone, Serialize)]
pub struct Block {
    pub order: Order,
    pub encoding: Encoding,
    pub view: String,
    pub camera: Camera,
    /// Points in the frustum, and pixels that show one.
    pub fragments: u64,
    pub covered_pixels: u64,
    /// The method of the device that all are compared with: `atomic-min`, or `two-pass-32`.
    pub reference: &'static str,
    /// Pixels in which it differs from the processor's picture, and those of them that rounding explains.
    pub reference_differs: u64,
    pub reference_excused: u64,
    pub rows: Vec<Row>,
}

impl Block {
    /// Points per covered pixel; NaN without any.
    pub fn overdraw(&self) -> f64 {
        self.fragments as f64 / self.covered_pixels as f64
    }

    /// Pixels of the reference that are wrong: rounding does not explain them.
    pub fn reference_errors(&self) -> u64 {
        self.reference_differs.saturating_sub(self.reference_excused)
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
    /// Bytes of the cloud that a frame must read: positions once in each geometry pass, and colours where they
    /// lie apart and are looked up.
    pub bytes: u64,
    pub bytes_per_sec: Option<Summary>,
    /// `None` for a method that was abandoned.
    pub accuracy: Option<Accuracy>,
    /// The first frame took so long that it was left.
    pub abandoned: Option<Abandoned>,
    /// One frame only: longer than allowed.
    pub is_single: bool,
    #[serde(serialize_with = "in_columns")]
    pub samples: Vec<Sample>,
}

impl Row {
    /// A row without samples yet.
    pub fn new(method: &'static str, bytes: u64) -> Row {
        Row {
            method,
            frame_secs: None,
            points_per_sec: None,
            bytes,
            bytes_per_sec: None,
            accuracy: None,
            abandoned: None,
            is_single: false,
            samples: Vec::new(),
        }
    }

    /// True if a frame was timed by the wall clock.
    pub fn has_wall_clock(&self) -> bool {
        self.samples.iter().any(|sample| sample.passes.undivided_secs.is_some())
    }

    pub fn summarize(&mut self, points: u64) {
        let secs: Vec<f64> = self.samples.iter().map(|sample| sample.frame_secs).collect();
        self.frame_secs = Summary::of(&secs);
        self.points_per_sec = self.frame_secs.map(|secs| secs.per(points as f64));
        self.bytes_per_sec = self.frame_secs.map(|secs| secs.per(self.bytes as f64));
    }

    /// Share of a ceiling, by medians.
    pub fn share_of(&self, ceiling: Option<Summary>) -> Option<f64> {
        Some(self.bytes_per_sec?.median / ceiling?.median)
    }
}

/// One frame.
#[derive(Debug, Clone)]
pub struct Sample {
    /// From 1.
    pub round: u32,
    pub frame_secs: f64,
    /// Its passes; zero and empty where the device cannot tell them apart.
    pub passes: FrameTime,
}

impl Sample {
    pub fn new(round: u32, time: &FrameTime) -> Sample {
        Sample { round, frame_secs: time.total_secs(), passes: time.clone() }
    }
}

/// Samples as lists, one for each of their numbers: a third of the bytes that lists of samples take. Passes are
/// left out where the device cannot tell them apart.
fn in_columns<S: Serializer>(samples: &[Sample], serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Columns {
        round: Vec<u32>,
        frame_secs: Vec<f64>,
        #[serde(skip_serializing_if = "Vec::is_empty")]
        clear_secs: Vec<f64>,
        /// A list for each geometry pass.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        geometry_secs: Vec<Vec<f64>>,
        #[serde(skip_serializing_if = "Vec::is_empty")]
        resolve_secs: Vec<f64>,
    }
    let divided: Vec<&FrameTime> =
        samples.iter().map(|sample| &sample.passes).filter(|passes| passes.undivided_secs.is_none()).collect();
    let passes = divided.first().map_or(0, |first| first.geometry_secs.len());
    let pass = |i: usize| divided.iter().filter_map(|time| time.geometry_secs.get(i).copied()).collect();
    let columns = Columns {
        round: samples.iter().map(|sample| sample.round).collect(),
        frame_secs: samples.iter().map(|sample| sample.frame_secs).collect(),
        clear_secs: divided.iter().map(|time| time.clear_secs).collect(),
        geometry_secs: (0..passes).map(pass).collect(),
        resolve_secs: divided.iter().map(|time| time.resolve_secs).collect(),
    };
    columns.serialize(serializer)
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
    /// The first frame took so long that it was left.
    pub abandoned: Option<Abandoned>,
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
            encodings: vec![Encoding::Wide],
            frames: 1,
            repeat: 1,
            max_frame_secs: 1.0,
            seed: 1,
            wall_clock: true,
            methods: Vec::new(),
            host: Vec::new(),
            ceilings: Ceilings::default(),
            blocks: Vec::new(),
            curves: Vec::new(),
            checks: Vec::new(),
            problems: Vec::new(),
        }
    }
}
