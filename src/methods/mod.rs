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
//! Each idea with what was expected before, where that was written down, and what came out, what did not help among
//! them. On 2 cores with Mesa 22.3's lavapipe (LLVM 15, subgroups of 8), 2 M points, 1024×768, medians of 7 frames
//! alternated in one process, ratios; other work ran on the machine. What only a GPU can show is marked as open.
//!
//! * *Four points a thread, all loaded before the first is drawn* ([`PerThread::Four`]). Expected: nothing on a
//!   processor, whose caches hide no latency this way; on a GPU the gap between 65 % of the copy's bandwidth and all
//!   of it. Found: 1.1–1.4 times on lavapipe for just-set, atomic-min, early-z and two-pass-32, most on the far view
//!   (1.2–1.4); the averages 1.0–1.35, depth40 0.9–1.25, the busy loop 0.8–1.2; hardware points and the subgroup
//!   kernels take one point as before. A thread of lavapipe costs more than was thought. GPU: open.
//! * *8 bytes a point instead of 16.* Found: mostly 0.9–1.1 on lavapipe; depth40, which also reads colours from one
//!   more buffer, loses 5–15 %. GPU: open.
//! * *Skipping what is outside before the division* (a test of |x| and |y| against 1.001 times the depth in
//!   `project`). Expected: 5 % on the closeup, where most is outside. Found: no difference that two programs run in
//!   turn could tell from noise (closeup, just-set, on a busy machine: 26, 25 million points/s without, 24, 25, 30
//!   with). Left out: one more rule for the twin to share.
//! * *`reduce` and `dedup`*, with subgroups of 8. Found: reduce 0.87–1.0 of atomic-min, reduce-early-z 0.75–0.92 of
//!   early-z, dedup 0.47–0.75 of atomic-min. GPU: open; dedup's rounds are as many as distinct pixels, so that
//!   shuffled order is its worst case.
//! * *Busy loop: leaving a tie without the lock.* The paper's early-out, made exact for points of equal depth: the
//!   slot is written before the depth. Expected: stacked points of equal depth no longer queue for the lock. Found:
//!   200,000 equal points 3.2 ms instead of 16.6 (atomic-min 3.1), and no give-ups where 8 or 16 points had starved
//!   through 2²⁰ turns; no picture changed.
//! * *Busy loop: 4,096 turns are enough.* Expected. Found wrong on a processor: the operating system takes a thread
//!   off its core with the lock in hand, and a group of 256 gave up. 2²⁰ turns there.
//! * *`just-set` shows chance.* Found: with lavapipe often exactly the last point of the cloud in each pixel. It is
//!   wrong in most pixels where near points come first, and right where they come last: its accuracy depends on the
//!   order of the cloud.
//! * *`i64(u32)` in WGSL.* Expected: the number. Found: naga 30 writes `SConvert`, which extends the sign;
//!   `bitcast<i64>(u64(x))` does not. (And `u64(i32)` writes `UConvert`, which does not.)
//!
//! `hqs1r` here is the published packing, 16-16-16-16 bits handed over at 255: exact while fewer than 65,281 threads
//! are between their look at a pixel and their addition to it. A GPU that holds more threads than that (an H200:
//! 270,000) could exceed it with all points in one pixel; open whether it does. The viewer's high-quality shading does
//! not depend on that: `shaders/sums_64.wgsl` packs 14-14-14-22 bits and hands over at 64, for 4,194,240 threads.

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
