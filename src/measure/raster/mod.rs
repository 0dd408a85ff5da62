//! `firstlight bench`: every rasterization method, on any device and any scan, in the orders and from the
//! viewpoints of the field, each speed beside what it costs in accuracy.
//!
//! A block is one order in one encoding, seen from one viewpoint. In a block all methods run in turn, round after round, every
//! second round backwards, so that a clock that drifts hurts all alike; a first run of each is not counted. Every
//! sample is kept. After each block the whole report is written again, each file whole or not at all: whatever
//! stops the program, Ctrl-C among it, leaves what was done, without a signal handler.
//!
//! ```text
//! input      files or a generator → the cloud, in the order of the file
//! orders     original, Morton, shuffled, shuffled Morton
//! morton     sorting a billion points in little memory
//! views      where to look from
//! accuracy   a picture against the right one
//! rounding   how far 32-bit arithmetic may end from where a point is
//! processor  the processor's picture, and whether a device's is one that rounding allows
//! block      one order, one encoding, one viewpoint, all methods
//! run        all blocks and curves
//! curves     cost against points, and against points per pixel (stacks: the planes for it)
//! checks     what must hold, or the figures mean nothing
//! report     all samples, and what stands for them
//! reference  figures that others published
//! tables     the figures, as Markdown and HTML
//! plot       lines and dots with names
//! page       tables and plots on one page
//! csv        one line per frame
//! json       every sample in few bytes
//! growth     one chart of several reports
//! ```

use crate::{
    measure::report_dir::ReportDirError,
    methods::MethodError,
    render::{CameraError, RenderError},
    source::SourceError,
    synth::SynthError,
};

mod accuracy;
mod block;
mod checks;
mod csv;
mod curves;
mod growth;
mod input;
mod json;
mod morton;
mod orders;
mod page;
pub(super) mod plot;
mod processor;
mod reference;
mod report;
mod rounding;
mod run;
mod stacks;
mod tables;
mod views;

pub use accuracy::{Accuracy, ssim};
pub use checks::checks;
pub use csv::write_csv;
pub use growth::Growth;
pub use input::{Input, Scan};
pub use json::write_json;
pub use morton::{MORTON_BITS, morton};
pub use orders::{MORTON_BATCH, Order, Orders, gather};
pub use page::page;
pub use processor::{Agreement, Processor};
pub use reference::{CITATION, PUBLISHED, Published};
pub use report::{
    Block, Ceilings, Check, CurveKind, CurveRuns, Device, HostTime, MethodEntry, RasterReport, ReadCeiling, Row,
    Sample, TITLE,
};
pub use rounding::Exact;
pub use run::{BenchRaster, Part, Watcher, bench_raster};
pub use stacks::Stack;
pub use tables::markdown;
pub use views::Viewpoint;

/// Why a measurement ends early.
#[derive(Debug, thiserror::Error)]
pub enum RasterError {
    #[error(transparent)]
    Source(#[from] SourceError),
    #[error(transparent)]
    Synth(#[from] SynthError),
    #[error("the scene has no points to measure with")]
    NoPoints,
    #[error(transparent)]
    Camera(#[from] CameraError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Methods(#[from] MethodError),
    #[error(transparent)]
    ReportDir(#[from] ReportDirError),
}
