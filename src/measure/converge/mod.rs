//! `firstlight measure`: how wrong the picture is, frame by frame, while a file loads, at rest and in motion.
//!
//! After every frame the picture is compared with that of all points received so far and with that of all points of
//! the file, both drawn by brute force on the same device from the same store. Theory stands beside it: what a
//! uniform random sample of as many points would show on this view, computed exactly; a shuffle that is worse is a
//! bug. So do the methods that this program's is judged against.
//!
//! With the virtual clock, so many points arrive and are tried per frame: the report is the same, byte for byte, on
//! every machine but for the adapter's name. With the real clock a run is first timed, without comparisons, and
//! then repeated by its log with them: comparing takes longer than drawing, and nothing that is timed waits for it.
//!
//! ```text
//! settings   methods, fill, point size, clock: what makes runs differ
//! motion     how the camera moves, and which part of a run comes when
//! input      the scan in memory, handed out in pieces
//! driver     one method at work
//! live       a run in real time → a log of its frames
//! replay     the same frames again, or virtual ones, with a comparison after each
//! metrics    a frame against a truth; what changed between two frames
//! theory     what a uniform sample would show
//! headline   a few figures per run
//! checks     what must hold
//! run        all runs
//! report     all samples: JSON
//! csv        one line per frame
//! charts     curves, and dots of settings
//! page       tables and charts on one page
//! ```

use crate::{
    measure::report_dir::ReportDirError,
    render::{CameraError, RenderError},
    source::SourceError,
    store::TooWide,
    synth::SynthError,
};

mod charts;
mod checks;
mod csv;
mod driver;
mod headline;
mod input;
mod live;
mod metrics;
mod motion;
mod page;
mod replay;
mod report;
mod run;
mod settings;
mod theory;

pub use checks::{SIGMAS, checks};
pub use csv::write_csv;
pub use input::Recording;
pub use metrics::{CHANGE_LEVELS, Change, EDGE_STEP, Metrics};
pub use motion::Motion;
pub use page::{markdown, page};
pub use report::{ConvergeReport, Frame, Headline, Reached, Run, TITLE, Times};
pub use run::{MOST_LOAD, Watcher, measure};
pub use settings::{Clock, Decoded, Fill, Measure, Setting, VIEWER_POINT_SIZE, Variant};
pub use theory::{Counts, Expected};

/// Why a measurement ends early.
#[derive(Debug, thiserror::Error)]
pub enum ConvergeError {
    #[error(transparent)]
    Source(#[from] SourceError),
    #[error(transparent)]
    Synth(#[from] SynthError),
    #[error("the scene has no points to measure with")]
    NoPoints,
    #[error("an automatic fill follows the time that frames take; --clock virtual has none: give --fill N")]
    AutoNeedsTime,
    #[error(transparent)]
    TooWide(#[from] TooWide),
    #[error(transparent)]
    Camera(#[from] CameraError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    ReportDir(#[from] ReportDirError),
}
