//! Every published way to turn points into pixels, behind one table, to be measured against each other.
//!
//! A [`Method`] is a row of [`METHODS`]: its kernels lie in `shaders/methods`, one a file, and share the
//! `project` of `shaders/project.wgsl` with the rest of the program. A [`Runner`] holds a [`Cloud`] on a
//! [`Gpu`] and draws or times any of them; [`twin`] holds the plain definitions of their pictures, to
//! which the tests hold the kernels. [`ceilings()`] measures what no method can exceed.
//!
//! A point is one pixel here, as in the papers, whatever [`View::point_size`](crate::render::View) says.
//!
//! # Predictions and outcomes
//!
//! Written before and after each measurement, what did not help among them.

mod ceilings;
mod cloud;
mod depth40;
mod gpu;
mod hardware;
pub mod modules;
mod pages;
mod pipelines;
mod plan;
mod runner;
mod table;
mod targets;
mod timing;
pub mod twin;

pub use ceilings::{Ceilings, ceilings};
pub use cloud::{Cloud, Encoding, Packing};
pub use depth40::Depth40;
pub use gpu::Gpu;
pub use modules::PerThread;
pub use pages::PageUniform;
pub use runner::Runner;
pub use table::{METHODS, Method, Needs, by_name};
pub use timing::FrameTime;

use crate::device::RenderError;

/// [`Drawn::point`] where no point is.
pub const NO_POINT: u32 = u32::MAX;

/// A picture that a method drew, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    pub size: [u32; 2],
    /// Place in the cloud of the point shown, or [`NO_POINT`]; for methods that blend the front point.
    pub point: Vec<u32>,
    /// Distance along the viewing direction in the file's unit, infinite where no point is.
    pub depth: Vec<f32>,
    /// All zero where no point is.
    pub rgba: Vec<[u8; 4]>,
    /// Points that the busy loop left out because their pixel stayed locked.
    pub give_ups: u64,
}

/// Why a method could not draw.
#[derive(Debug, Clone, thiserror::Error)]
pub enum MethodError {
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error("{0}")]
    Unsupported(String),
    #[error("8 bytes hold 64 bits of position, and this cloud needs {} + {} + {}; choose the wide encoding",
        .bits[0], .bits[1], .bits[2])]
    TooWide { bits: [u32; 3] },
    #[error("{positions} positions and {colors} colours: a cloud has one colour for each position")]
    Unequal { positions: usize, colors: usize },
    #[error("{0} points are more than 32 bits can number")]
    TooMany(usize),
    #[error("a picture of {0}x{1} pixels has no pixels")]
    NoPixels(u32, u32),
    #[error("the view is of {found:?} pixels, the runner of {expected:?}")]
    OtherSize { expected: [u32; 2], found: [u32; 2] },
}
