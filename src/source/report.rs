//! What was read of each file, what is missing and why.

use std::path::PathBuf;

use super::{
    SourceError,
    plan::{FilePlan, Layout},
    record::Oddities,
};

/// What was read, complete or not.
#[derive(Debug, Clone, Default, serde::Serialize)]
pub struct SourceReport {
    /// The files of [`SceneFacts::files`](crate::scene::SceneFacts::files), in that order, then the inputs that could not be opened.
    pub files: Vec<FileReport>,
    /// What each decoder thread did.
    pub threads: Vec<ThreadTimes>,
    /// Most heap memory that reading takes at any time, whatever the size of the files: batches on their
    /// way, buffers, kept decoders, lists of chunks.
    pub memory_bound_bytes: u64,
}

/// How a decoder thread spent its time.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct ThreadTimes {
    pub name: String,
    /// Reading bytes from files.
    pub read_secs: f64,
    /// Decompressing LAZ.
    pub decode_secs: f64,
    /// From raw records to columns.
    pub convert_secs: f64,
    /// Waiting until its batches were taken.
    pub wait_secs: f64,
    /// Of the time spent reading, decoding and converting: for the preview.
    pub preview_secs: f64,
    pub points: u64,
    /// Bytes read, compressed or not.
    pub bytes: u64,
}

impl SourceReport {
    /// Points of all files.
    pub fn points_decoded(&self) -> u64 {
        self.files.iter().map(|f| f.points_decoded).sum()
    }
}

impl ThreadTimes {
    /// Seconds spent working, not waiting.
    pub fn busy_secs(&self) -> f64 {
        self.read_secs + self.decode_secs + self.convert_secs
    }
}

/// What was read of one file.
#[derive(Debug, Clone, serde::Serialize)]
pub struct FileReport {
    pub path: PathBuf,
    /// The header's count, whatever the file can hold.
    pub points_in_header: u64,
    pub points_decoded: u64,
    /// Decoded points outside of the header's box.
    pub points_outside_bounds: u64,
    /// One line each: oddities that cost nothing.
    pub warnings: Vec<String>,
    /// Why points are missing, if any are.
    pub error: Option<String>,
}

impl FileReport {
    /// The report of an input that could not be opened.
    pub(super) fn not_opened(path: PathBuf, error: &SourceError) -> FileReport {
        FileReport {
            path,
            points_in_header: 0,
            points_decoded: 0,
            points_outside_bounds: 0,
            warnings: Vec::new(),
            error: Some(error.to_string()),
        }
    }
}

/// How a task ended.
#[derive(Default)]
pub struct Outcome {
    pub oddities: Oddities,
    /// The foremost fault, by record or chunk, and how many there are.
    pub fault: Option<(u64, String)>,
    pub faults: u64,
    /// The foremost chunk that looks damaged although it could be decoded, and how many do.
    pub suspect: Option<(u64, String)>,
    pub suspects: u64,
}

impl Outcome {
    pub fn note_fault(&mut self, at: u64, what: String) {
        self.faults += 1;
        foremost(&mut self.fault, Some((at, what)));
    }

    pub fn note_suspect(&mut self, at: u64, what: impl FnOnce() -> String) {
        self.suspects += 1;
        if self.suspect.as_ref().is_none_or(|(before, _)| at < *before) {
            self.suspect = Some((at, what()));
        }
    }

    /// Adds another task's outcome.
    pub fn merge(&mut self, other: Outcome) {
        self.oddities.outside_bounds += other.oddities.outside_bounds;
        self.oddities.beyond_grid += other.oddities.beyond_grid;
        self.faults += other.faults;
        foremost(&mut self.fault, other.fault);
        self.suspects += other.suspects;
        foremost(&mut self.suspect, other.suspect);
    }
}

/// Keeps what lies further to the front of the file.
fn foremost(kept: &mut Option<(u64, String)>, other: Option<(u64, String)>) {
    if let Some(other) = other
        && kept.as_ref().is_none_or(|(before, _)| other.0 < *before)
    {
        *kept = Some(other);
    }
}

/// One file's report, when all of it was read, or it was cancelled.
pub fn file_report(plan: &FilePlan, (decoded, outcome): (u64, Outcome), cancelled: bool) -> FileReport {
    let header = &plan.header;
    let mut warnings = plan.warnings.clone();
    if let Some((_, suspect)) = outcome.suspect {
        warnings.push(if outcome.suspects > 1 {
            format!("{suspect}; so are {} more chunks", outcome.suspects - 1)
        } else {
            suspect
        });
    }
    if outcome.oddities.outside_bounds > 0 {
        let n = outcome.oddities.outside_bounds;
        warnings.push(format!("{n} of {decoded} points lie outside of the header's box; they are shown"));
    }
    if outcome.oddities.beyond_grid > 0 {
        let n = outcome.oddities.beyond_grid;
        warnings.push(format!("{n} points lie beyond the scene's 32-bit grid; they are shown at its border"));
    }
    let missing = header.points.saturating_sub(decoded);
    let error = (missing > 0 || outcome.fault.is_some()).then(|| {
        let why = match (&outcome.fault, &plan.layout) {
            _ if cancelled => "reading it was stopped; open it again to read all of it".to_owned(),
            (Some((_, fault)), _) if outcome.faults > 1 => format!("{fault}; {} more faults", outcome.faults - 1),
            (Some((_, fault)), _) => fault.clone(),
            (None, Layout::Las) => format!(
                "expected {} records of {} bytes from byte {} on, the file ends at byte {} (in record {})",
                header.points,
                header.record_length(),
                header.data_at(),
                header.file_length,
                plan.points
            ),
            (None, Layout::Laz(layout)) => {
                format!("expected {} points, the {} chunks hold {}", header.points, layout.chunks.len(), plan.points)
            }
        };
        format!("{missing} of {} points are missing, {decoded} are kept: {why}", header.points)
    });
    FileReport {
        path: header.path.clone(),
        points_in_header: header.points,
        points_decoded: decoded,
        points_outside_bounds: outcome.oddities.outside_bounds,
        warnings,
        error,
    }
}
