//! What is asked of [`super::Progressive`], and what it says of each frame.

use serde::Serialize;

use super::{backend::Shading, budget::FillBudget, view::View};
#[cfg(doc)]
use crate::store::MAX_INSERTION_POINTS;
use crate::store::SlotOrder;

/// Points that enter the store at a time. Larger ones cost fewer look-ups per visible point and
/// second, smaller ones show sooner: at 65,536 a LAZ file is seen after its first two chunks.
pub const INSERTION_POINTS: u32 = 65_536;

/// Slots are 32-bit numbers, and the last one means "no point".
pub const MAX_POINTS: u64 = u32::MAX as u64;

/// How the store is to be filled; fixes the slot of every point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StoreOptions {
    pub seed: u64,
    /// Points per insertion, 1 to [`MAX_INSERTION_POINTS`]. A scene's last one may be smaller, and its first
    /// one is its first batch, so that something shows at once.
    pub insertion_points: u32,
    /// Store no more than this many points.
    pub max_points: u64,
    /// Anything but shuffled is for measuring what the shuffle is worth.
    pub order: SlotOrder,
}

impl Default for StoreOptions {
    fn default() -> Self {
        let order = SlotOrder::default();
        StoreOptions { seed: 1, insertion_points: INSERTION_POINTS, max_points: MAX_POINTS, order }
    }
}

/// When a frame draws what the last one showed. A viewer always does; the others are what that is measured
/// against.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Reprojection {
    #[default]
    Always,
    /// Unless the view changed: the picture begins anew whenever the camera moves.
    WhileStill,
    /// Every frame is a new sample of the points, and stays one: a still picture never converges.
    Never,
}

/// What a frame is to show.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameRequest {
    pub view: View,
    pub fill: FillBudget,
    pub shading: Shading,
}

/// What a frame did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct FrameReport {
    /// False if nothing had changed, so that nothing was drawn.
    pub drawn: bool,
    pub points_stored: u64,
    /// Points that were tried since the view last changed; all of them: the picture has converged.
    pub points_tried: u64,
    /// False while ties between points of equal depth may stand that slots since renumbered decided;
    /// a full cycle after loading settles them.
    pub settled: bool,
    /// Points that the fill tried in this frame.
    pub fill: u32,
    /// High-quality shading is asked for.
    pub high_quality: bool,
    /// Points whose colours the averages of high-quality shading hold, counted once the depths are those of
    /// all points; all of them: the averages are final.
    pub points_averaged: u64,
}

impl FrameReport {
    /// The picture equals that of all points stored.
    pub fn is_converged(&self) -> bool {
        let is_averaged = !self.high_quality || self.points_averaged == self.points_stored;
        self.has_all_depths() && is_averaged
    }

    /// The nearest point of each pixel is that of all points stored.
    pub fn has_all_depths(&self) -> bool {
        self.settled && self.points_tried == self.points_stored
    }
}
