//! What a backend must be able to do; [`super::Progressive`] decides what it does in which frame.

use std::{ops::Range, sync::Arc};

use serde::{Deserialize, Serialize};

use super::{
    choice::Choice,
    color::PointColors,
    column::{ColumnId, Keys},
    filter::MaskRules,
    pick::{Pick, PickAt, PickTicket},
    view::View,
};
use crate::{
    device::{PassTimes, Passes, Raster, RenderError},
    scene::PointBatch,
    store::{Encoding, Insertion, Packing},
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
    /// How positions are stored now.
    pub encoding: Encoding,
    /// What speaks for the method; none on the processor.
    pub choice: Option<Choice>,
}

/// All that one frame draws, in order: clear, reproject, fresh, fill, sums, index build, resolve.
#[derive(Debug, Clone)]
pub struct FramePlan {
    pub view: View,
    /// Draw no depths: those of the last frame, which had the same view, stay. Nothing was inserted since.
    pub keeps_depths: bool,
    /// Draw the slots that were visible in the last frame.
    pub reproject: bool,
    /// Draw the points inserted since the last frame.
    pub fresh: bool,
    /// Slots to draw besides.
    pub fill: [Range<u32>; 2],
    pub shading: Shading,
    pub colors: Arc<PointColors>,
    /// The second pass of high-quality shading; without, each pixel shows its front point.
    pub averaging: Option<Averaging>,
    /// Hides the points that fail these tests; none: all are shown.
    pub mask: Option<Arc<MaskRules>>,
    /// A picture for comparing while a scene converges: which slots were visible, which are fresh, and the sums stay
    /// as they were, and no method is measured. Only the words are overwritten: the next frame cannot keep them.
    pub aside: bool,
}

impl FramePlan {
    /// Number of slots in `fill`.
    pub fn fill_points(&self) -> u32 {
        self.fill.iter().map(|range| range.end - range.start).sum()
    }

    pub fn passes(&self) -> Passes {
        match (self.keeps_depths, &self.averaging) {
            (true, _) => Passes::Sums,
            (false, Some(_)) => Passes::DepthsAndSums,
            (false, None) => Passes::Depths,
        }
    }
}

/// Which points enter the sums of high-quality shading: those of their fragments that lie within 1 %
/// behind the front of their pixel, but for the front point itself, which resolve adds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Averaging {
    /// The sums begin anew; else they go on from those of the last frame.
    pub begins: bool,
    /// Also what `reproject` and `fresh` draw, as far as it is not in `slots`, so that no point counts twice.
    pub lists: bool,
    pub slots: [Range<u32>; 2],
}

impl Averaging {
    /// Number of `slots`.
    pub fn points(&self) -> u32 {
        self.slots.iter().map(|range| range.end - range.start).sum()
    }
}

/// How a device sums up colours for high-quality shading; the pictures are the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sums {
    /// Four 32-bit sums.
    Hqs,
    /// One 64-bit word, handed over to wider sums when it is full (Schütz et al. 2021).
    Hqs1r,
}

impl std::fmt::Display for Sums {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Sums::Hqs => "hqs",
            Sums::Hqs1r => "hqs1r",
        })
    }
}

/// How visible points become a picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Shading {
    /// Strength of eye-dome lighting (Boucheny 2009); 0 turns it off.
    pub edl_strength: f32,
    /// Red, green, blue where no point is.
    pub background: [u8; 3],
    /// High-quality shading (Schütz and Wimmer 2019): a pixel shows the mean colour of all points within
    /// 1 % behind its front depth. Twice the work on points; off by default.
    pub high_quality: bool,
    /// Small holes in surfaces take the colour of a point beside them.
    #[serde(default)]
    pub fill_holes: bool,
}

impl Default for Shading {
    fn default() -> Self {
        Shading { edl_strength: 0.4, background: [24, 28, 34], high_quality: false, fill_holes: false }
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

    /// How it sums up colours for high-quality shading.
    fn sums(&self) -> Sums;

    /// How positions of scenes to come are stored; `None`: as is best for the device. A backend that has but one encoding
    /// keeps it: no picture depends on it.
    fn set_encoding(&mut self, _encoding: Option<Encoding>) {}

    /// Empties the store. `points` are to be expected (a hint for the size of pages), in a box that this packing holds,
    /// if there is one; some may lie outside.
    fn reset(&mut self, points: u64, packing: Option<Packing>);

    /// Most insertions that may happen between two frames.
    fn insertions_per_frame(&self) -> usize;

    /// Makes room for pictures of this width and height. What was visible stays known.
    fn resize(&mut self, size: [u32; 2]) -> Result<(), RenderError>;

    /// Inserts a batch. Its points are *fresh* until the next frame.
    fn insert(&mut self, insertion: &Insertion, points: &PointBatch) -> Result<(), RenderError>;

    /// Puts values in their places by record number; `keys` are those of `records`, at most
    /// [`BATCH_POINTS`](crate::scene::BATCH_POINTS), each once. A column begins with its first values, and all of its
    /// keys are of one kind.
    ///
    /// # Errors
    /// [`RenderError::NoMemoryForValues`]; what was there stays.
    fn fill_column(&mut self, column: ColumnId, records: &[u32], keys: Keys<'_>) -> Result<(), RenderError>;

    /// Frees a column.
    fn drop_column(&mut self, column: ColumnId);

    /// Switches off that the lists of slots follow points which an insertion moves (or on again). For measuring
    /// what that is worth: without it, a picture loses points while a file loads.
    fn set_relocation(&mut self, on: bool);

    /// Draws a frame of `plan.view.width` × `plan.view.height` pixels.
    fn draw(&mut self, plan: &FramePlan) -> Result<(), RenderError>;

    /// Times of the latest frame that the device has finished, if it can tell; each is returned once.
    fn pass_times(&mut self) -> Option<PassTimes>;

    /// Points that the filter of the last frame shows, as soon as that is known; none without a filter.
    fn points_shown(&mut self) -> Option<u64> {
        None
    }

    /// Measures now which of its methods is the fastest, instead of between frames, if that is due.
    fn choose(&mut self) -> Result<(), RenderError> {
        Ok(())
    }

    /// Asks which point the last frame shows at a pixel. Only [`Progressive`](super::Progressive) knows whether that
    /// frame still stands. `None` if there is no such pixel, or kernels are still being compiled, for which
    /// [`Backend::wait`] waits.
    fn pick(&mut self, at: PickAt) -> Option<PickTicket>;

    /// The answer, once it is there; none of a point where none is near, or the question was given up. Never waits.
    fn picked(&mut self, ticket: PickTicket) -> Option<Option<Pick>>;

    /// Waits until the last frame is drawn.
    fn wait(&mut self) -> Result<(), RenderError>;

    /// Waits for the last frame and brings it back.
    fn read(&mut self) -> Result<Picture, RenderError>;
}

impl<B: Backend + ?Sized> Backend for Box<B> {
    fn info(&self) -> &BackendInfo {
        (**self).info()
    }
    fn sums(&self) -> Sums {
        (**self).sums()
    }
    fn set_encoding(&mut self, encoding: Option<Encoding>) {
        (**self).set_encoding(encoding);
    }
    fn reset(&mut self, points: u64, packing: Option<Packing>) {
        (**self).reset(points, packing);
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
    fn fill_column(&mut self, column: ColumnId, records: &[u32], keys: Keys<'_>) -> Result<(), RenderError> {
        (**self).fill_column(column, records, keys)
    }
    fn drop_column(&mut self, column: ColumnId) {
        (**self).drop_column(column);
    }
    fn set_relocation(&mut self, on: bool) {
        (**self).set_relocation(on);
    }
    fn draw(&mut self, plan: &FramePlan) -> Result<(), RenderError> {
        (**self).draw(plan)
    }
    fn pass_times(&mut self) -> Option<PassTimes> {
        (**self).pass_times()
    }
    fn points_shown(&mut self) -> Option<u64> {
        (**self).points_shown()
    }
    fn choose(&mut self) -> Result<(), RenderError> {
        (**self).choose()
    }
    fn pick(&mut self, at: PickAt) -> Option<PickTicket> {
        (**self).pick(at)
    }
    fn picked(&mut self, ticket: PickTicket) -> Option<Option<Pick>> {
        (**self).picked(ticket)
    }
    fn wait(&mut self) -> Result<(), RenderError> {
        (**self).wait()
    }
    fn read(&mut self) -> Result<Picture, RenderError> {
        (**self).read()
    }
}
