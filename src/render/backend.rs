//! What a backend must be able to do; [`super::Progressive`] decides what it does in which frame.

use std::ops::Range;

use serde::Serialize;

use super::{camera::View, choice::Choice, color::FileColor};
use crate::{
    device::{PassTimes, Raster, RenderError},
    scene::PointBatch,
    store::Insertion,
};

/// Who draws.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BackendInfo {
    /// e.g. "NVIDIA H200", "llvmpipe (LLVM 15.0.6, 256 bits)", "2 processor threads".
    pub adapter: String,
    /// "vulkan", "metal", "dx12" or "cpu".
    pub api: String,
    pub driver: String,
    pub method: Raster,
    /// What speaks for the method; none on the processor.
    pub choice: Option<Choice>,
}

/// All that one frame draws, in order: clear, reproject, fresh, fill, index build, resolve.
#[derive(Debug, Clone)]
pub struct FramePlan {
    pub view: View,
    /// Draw the slots that were visible in the last frame.
    pub reproject: bool,
    /// Draw the points inserted since the last frame.
    pub fresh: bool,
    /// Slots to draw besides.
    pub fill: [Range<u32>; 2],
    pub shading: Shading,
    /// Colour rule of each file, in order of their first records.
    pub files: Vec<FileColor>,
}

/// How visible points become a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shading {
    /// Strength of eye-dome lighting (Boucheny 2009); 0 turns it off.
    pub edl_strength: f32,
    /// Red, green, blue where no point is.
    pub background: [u8; 3],
}

impl Default for Shading {
    fn default() -> Self {
        Shading { edl_strength: 0.4, background: [24, 28, 34] }
    }
}

/// A frame brought back from the backend; row by row from the top, `width * height` each.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    pub rgba: Vec<[u8; 4]>,
    /// Record number of the point that the pixel shows, −1 for background.
    pub records: Vec<i64>,
    /// Distance along the viewing direction in the file's unit, +∞ for background.
    pub depth: Vec<f32>,
}

/// Stores points and draws frames.
pub trait Backend {
    fn info(&self) -> &BackendInfo;

    /// Empties the store. `points` are to be expected (a hint for the size of pages).
    fn reset(&mut self, points: u64);

    /// Most insertions that may happen between two frames.
    fn insertions_per_frame(&self) -> usize;

    /// Makes room for pictures of this width and height. What was visible stays known.
    fn resize(&mut self, size: [u32; 2]) -> Result<(), RenderError>;

    /// Inserts a batch. Its points are *fresh* until the next frame.
    fn insert(&mut self, insertion: &Insertion, points: &PointBatch) -> Result<(), RenderError>;

    /// Draws a frame of `plan.view.width` × `plan.view.height` pixels.
    fn draw(&mut self, plan: &FramePlan) -> Result<(), RenderError>;

    /// Times of the latest frame that the device has finished, if it can tell; each is returned once.
    fn pass_times(&mut self) -> Option<PassTimes>;

    /// Measures now which of its methods is the fastest, instead of between frames, if that is due.
    fn choose(&mut self) -> Result<(), RenderError> {
        Ok(())
    }

    /// Waits until the last frame is drawn.
    fn wait(&mut self) -> Result<(), RenderError>;

    /// Waits for the last frame and brings it back.
    fn read(&mut self) -> Result<Picture, RenderError>;
}

impl<B: Backend + ?Sized> Backend for Box<B> {
    fn info(&self) -> &BackendInfo {
        (**self).info()
    }
    fn reset(&mut self, points: u64) {
        (**self).reset(points);
    }
    fn insertions_per_frame(&self) -> usize {
        (**self).insertions_per_frame()
    }
    fn resize(&mut self, size: [u32; 2]) -> Result<(), RenderError> {
        (**self).resize(size)
    }
    fn insert(&mut self, insertion: &Insertion, points: &PointBatch) -> Result<(), RenderError> {
        (**self).insert(insertion, points)
    }
    fn draw(&mut self, plan: &FramePlan) -> Result<(), RenderError> {
        (**self).draw(plan)
    }
    fn pass_times(&mut self) -> Option<PassTimes> {
        (**self).pass_times()
    }
    fn choose(&mut self) -> Result<(), RenderError> {
        (**self).choose()
    }
    fn wait(&mut self) -> Result<(), RenderError> {
        (**self).wait()
    }
    fn read(&mut self) -> Result<Picture, RenderError> {
        (**self).read()
    }
}
