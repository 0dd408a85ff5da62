//! The picture without a window: the same events and the same frames, then files.
//!
//! [`render`] takes batches from [`crate::source`], hands them to [`crate::render::Progressive`], and
//! writes the last frame as a PNG, its record numbers and depths as NPY, and a [`Report`] as JSON.
//! Outputs are checked before the work starts and get their final names only when they are complete.

mod command;
mod decorate;
mod framing;
mod outputs;
mod progress;
mod report;
mod run;
mod settings;

pub use command::command;
pub use decorate::{decorate, text_px};
pub use framing::{box_to_fit, default_camera, default_camera_of};
pub use outputs::{Destination, OutputError, Outputs, picture_sha256, write_npy_f32, write_npy_i64, write_png};
pub use progress::{ProgressStyle, grouped};
pub use report::{FileEntry, KeyEntry, LegendEntry, OutputPaths, Report, Seconds};
pub use run::{HeadlessError, Picked, make_backend, pick, render};
pub use settings::{BackendChoice, CONVERGE_FILL, COUNTED_FILL, Settings, Stop, fields_of};
