//! `firstlight bench-ingest`: how fast points come from a file to the screen, and what holds them up.
//!
//! All that is compared runs in turn, round after round, in one process: the reader in each of the ways
//! asked for, its ceilings (the same bytes only read, as many bytes only copied), other programs, and the
//! whole way to the picture. Machines change their speed from minute to minute; a ratio of two runs
//! that stand side by side survives that, one of two runs an hour apart does not. Every second round runs
//! backwards, so that nobody always follows the same neighbour. Every sample is kept.
//!
//! ```text
//! reader    everything decoded, nothing drawn
//! ceilings  read alone, memory to memory
//! against   other programs on the same file
//! coverage  how soon the points so far show the whole extent
//! screen    the whole pipeline, with frame times
//! run       the rounds
//! report    all samples, and what stands for them
//! tables    the figures, as Markdown and HTML
//! page      tables and charts on one page
//! csv       one line per run
//! ```

use std::{io, path::PathBuf};

use crate::{
    render::{CameraError, RenderError},
    source::SourceError,
};

mod against;
mod ceilings;
mod coverage;
mod csv;
mod page;
mod reader;
mod report;
mod run;
mod screen;
mod tables;

pub use against::{AgainstCommand, AgainstSample};
pub use ceilings::PointData;
pub use coverage::{Coverage, CoverageRuns, Step};
pub use csv::write_csv;
pub use page::page;
pub use reader::{FieldSet, LazDecoder, ReadOrder, ReaderSample, Way};
pub use report::{AgainstRuns, CeilingRuns, IngestFile, IngestReport, ReaderRuns, TITLE};
pub use run::{BenchIngest, bench_ingest};
pub use screen::{FrameSample, ScreenRuns, ScreenSample, ScreenSettings};
pub use tables::markdown;

/// Why there is nothing to report.
#[derive(Debug, thiserror::Error)]
pub enum IngestError {
    #[error(transparent)]
    Source(#[from] SourceError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Camera(#[from] CameraError),
    #[error("cannot read the points of {} alone: {source}", path.display())]
    ReadAlone { path: PathBuf, source: io::Error },
    #[error("--against \"{command}\" on {}: {what}", file.display())]
    Against { command: String, file: PathBuf, what: String },
    #[error("{}: {found} points in one run, {expected} in another: the file changed while it was measured", path.display())]
    Unsteady { path: PathBuf, expected: u64, found: u64 },
}
