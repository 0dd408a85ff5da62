//! Measuring: the same loading and the same frames as a viewer's, with a clock beside them. Every
//! sample is kept; tables and charts read the report.
//!
//! ```text
//! feed        points from files, or from memory
//! frames      bench-frames: does the frame time stay flat while a scene grows?
//! ingest      bench-ingest: how fast points come from a file to the screen
//! raster      bench: every way to rasterize, its speed beside its accuracy
//! converge    measure: image error against time, frames and points, while loading, at rest and in motion
//! stability   stability: where methods fail, and this program's choices do not
//! machine     what it ran on
//! stats       medians and quartiles
//! chart       line charts as SVG
//! html        tables, and the page around them
//! report_dir  a folder that holds a report and nothing else
//! ```

mod chart;
pub mod converge;
mod feed;
mod frames;
mod html;
pub mod ingest;
mod machine;
pub mod raster;
mod report_dir;
pub mod stability;
mod stats;

pub use chart::{Chart, Draw, Series};
pub use feed::{Fed, Feed};
pub use frames::{BenchError, BenchFrames, BenchFramesReport, Level, bench_frames, markdown};
pub use html::Table;
pub use machine::Machine;
pub use report_dir::{ReportDir, ReportDirError};
pub use stats::{Summary, quantile};
