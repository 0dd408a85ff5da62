//! All samples of a measurement; its JSON is the report that tables, charts and other programs read.

use std::path::PathBuf;

use serde::Serialize;

use super::{
    against::AgainstSample,
    coverage::CoverageRuns,
    reader::{ReaderSample, Way},
    screen::ScreenRuns,
};
use crate::{
    measure::{machine::Machine, stats::Summary},
    render::BackendInfo,
};

/// What the JSON says of itself; a folder with such a file may be written over.
pub const TITLE: &str = "firstlight bench-ingest";

/// The whole measurement.
#[derive(Debug, Clone, Serialize)]
pub struct IngestReport {
    pub report: &'static str,
    /// "firstlight" and its version.
    pub program: String,
    /// The command line, quoted for a shell.
    pub command: String,
    pub machine: Machine,
    /// Who drew; null if nothing was drawn.
    pub backend: Option<BackendInfo>,
    pub size_px: Option<[u32; 2]>,
    /// Rounds: samples of everything.
    pub repeat: usize,
    pub files: Vec<IngestFile>,
    /// One line each: inputs that could not be opened, points that are missing.
    pub problems: Vec<String>,
}

/// One input.
#[derive(Debug, Clone, Serialize)]
pub struct IngestFile {
    pub path: PathBuf,
    /// e.g. "LAZ 1.4, format 7".
    pub kind: String,
    pub compressed: bool,
    pub points: u64,
    pub file_bytes: u64,
    /// From the first point to the last, as they lie in the file.
    pub point_bytes: u64,
    /// What all batches hold, read the first of the ways.
    pub batch_bytes: u64,
    pub reader: Vec<ReaderRuns>,
    /// The file's point bytes, only read.
    pub read_alone: Vec<CeilingRuns>,
    /// As many bytes as the batches hold, copied from memory to memory.
    pub memcpy: Vec<CeilingRuns>,
    pub against: Vec<AgainstRuns>,
    pub coverage: Vec<CoverageRuns>,
    pub screen: Option<ScreenRuns>,
}

impl IngestFile {
    /// Bytes of the file per point; NaN without points.
    pub fn bytes_per_point(&self) -> f64 {
        self.point_bytes as f64 / self.points as f64
    }
}

impl CeilingRuns {
    /// Median of bytes per second by so many threads.
    pub fn rate(runs: &[CeilingRuns], threads: Option<usize>) -> Option<f64> {
        let runs = runs.iter().find(|runs| Some(runs.threads) == threads)?;
        Some(runs.bytes_per_sec?.median)
    }
}

/// Runs of the reader, one way.
#[derive(Debug, Clone, Serialize)]
pub struct ReaderRuns {
    #[serde(flatten)]
    pub way: Way,
    pub seconds: Option<Summary>,
    pub points_per_sec: Option<Summary>,
    /// Bytes of the file.
    pub bytes_per_sec: Option<Summary>,
    pub samples: Vec<ReaderSample>,
}

/// Runs of a ceiling.
#[derive(Debug, Clone, Serialize)]
pub struct CeilingRuns {
    pub threads: usize,
    pub bytes: u64,
    pub seconds: Option<Summary>,
    pub bytes_per_sec: Option<Summary>,
    pub samples_secs: Vec<f64>,
}

/// Runs of another program.
#[derive(Debug, Clone, Serialize)]
pub struct AgainstRuns {
    pub command: String,
    pub seconds: Option<Summary>,
    pub points_per_sec: Option<Summary>,
    pub samples: Vec<AgainstSample>,
}

impl AgainstRuns {
    /// How many times faster this program was, round by round.
    pub fn ratios(&self, ours: &ReaderRuns) -> Vec<f64> {
        self.samples.iter().zip(&ours.samples).map(|(their, our)| their.secs / our.secs).collect()
    }

    /// The same by processor time, where it is known and long enough.
    pub fn processor_ratios(&self, ours: &ReaderRuns) -> Vec<f64> {
        let ratio = |(their, our): (&AgainstSample, &ReaderSample)| Some(their.processor_secs? / our.counted_secs()?);
        self.samples.iter().zip(&ours.samples).filter_map(ratio).collect()
    }
}

impl IngestFile {
    /// Puts what stands for the samples beside them.
    pub fn summarize(&mut self) {
        let (points, bytes) = (self.points as f64, self.point_bytes as f64);
        for runs in &mut self.reader {
            let secs: Vec<f64> = runs.samples.iter().map(|sample| sample.secs).collect();
            runs.seconds = Summary::of(&secs);
            runs.points_per_sec = runs.seconds.map(|secs| secs.per(points));
            runs.bytes_per_sec = runs.seconds.map(|secs| secs.per(bytes));
        }
        for runs in self.read_alone.iter_mut().chain(&mut self.memcpy) {
            runs.seconds = Summary::of(&runs.samples_secs);
            runs.bytes_per_sec = runs.seconds.map(|secs| secs.per(runs.bytes as f64));
        }
        for runs in &mut self.against {
            let secs: Vec<f64> = runs.samples.iter().map(|sample| sample.secs).collect();
            runs.seconds = Summary::of(&secs);
            runs.points_per_sec = runs.seconds.map(|secs| secs.per(points));
        }
    }
}
