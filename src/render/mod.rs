//! From points in random slots to a picture: reproject, fresh, fill, index build, resolve.
//!
//! [`Progressive`] decides what each frame draws; a [`Backend`] draws it. Every pixel is one 64-bit
//! word, depth (the bits of a positive f32) in the upper half and slot in the lower; the smallest word
//! wins, so the order in which points arrive cannot change a picture.

mod backend;
mod budget;
mod camera;
mod choice;
mod color;
mod cpu;
mod gpu;
mod progressive;
mod shading;

pub use crate::device::{PassTimes, Raster, RenderError};
pub use backend::{Backend, BackendInfo, FramePlan, Picture, Shading};
pub use budget::{BudgetController, FillBudget};
pub use camera::{Camera, CameraError, Projected, View};
pub use choice::{
    Candidate, Choice, Clock, GROUP_SIZES, MARGIN, Measured, Measurement, RasterChoice, Speed, Why, best,
};
pub use color::{FileColor, elevation_ramp};
pub use cpu::CpuBackend;
pub use gpu::{GpuBackend, ShadingUniform};
pub use progressive::{FrameReport, FrameRequest, INSERTION_POINTS, Progressive, StoreOptions};
pub use shading::EDL_GAIN;
