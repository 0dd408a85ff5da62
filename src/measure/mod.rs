//! Measuring: the same loading and the same frames as a viewer's, with a clock beside them. Every
//! sample is kept; tables and charts read the report.

mod feed;
mod frames;

pub use feed::{Fed, Feed};
pub use frames::{BenchError, BenchFrames, BenchFramesReport, Level, bench_frames, markdown};
