//! Every published way to turn points into pixels, behind one table, to be measured against each other.
//!
//! A [`Method`] is a row of [`METHODS`]: its kernels lie in `shaders/methods`, one a file, and share the
//! `project` of `shaders/project.wgsl` with the rest of the program. A [`Runner`] holds a [`Cloud`] on a
//! [`Gpu`] and draws or times any of them; [`twin`] holds the plain definitions of their pictures, to
//! which the tests hold the kernels. [`Runner::draw_paced`] draws a first frame that can be left when it takes too long;
//! [`ceilings()`] measures what no method can exceed.
//!
//! A point is one pixel here, as in the papers, whatever [`View::point_size`](crate::render::View) says.
//!
//! # Predictions and outcomes
//!
//! Each idea with what was expected before, and what came out, what did not help among them. On an H200 through
//! Vulkan: 130 million points of the town at 1920×1080, 16 bytes a point, medians of 15 frames alternated in one run, billion
//! points/s as closeup / overview / far. There, only reading and projecting the points is 285 / 274 / 274 (4.4 to 4.6
//! TB/s), and 8 bytes a point 447 / 397 / 398.
//!
//! * *The early test with a plain read* (`shaders/early.wgsl`). Expected: points of few pixels find them in the nearest
//!   cache, twice the speed for the far view. Found: shuffled 191 / 109 / 241 where atomic loads gave 190 / 106 / 41. And
//!   a device needs no 64-bit atomic loads for it.
//! * *Four points a thread, all loaded before the first is drawn* ([`Launch`]). Expected: what is missing between 65 % of
//!   the copy's bandwidth and all of it. Found: in the file's order 235 / 134 / 58 instead of 213 / 82 / 28, shuffled 190 / 106 /
//!   41 instead of 166 / 106 / 41. Eight are level, and for 8 bytes a point 5 % better. On lavapipe 1.1–1.4 times.
//! * *Blocks of points from 1,024 places in turn* (`is_spread`). Expected: in the file's order, points of neighbouring pixels no
//!   longer run at the same time and queue for them. Found: 231 / 198 / 240 instead of 236 / 139 / 99. Shuffled: level.
//! * *The early test first, then `reduce` among those that passed.* Expected: fewer atomic operations where neighbours share
//!   a pixel. Found: with blocks spread 231 / 204 / 252 in the file's order, 236 / 199 / 259 in shuffled Morton order; shuffled, the
//!   closeup pays 4 % and nothing is won.
//! * *Neighbouring points in one thread, merged before the test.* Found: 209 / 189 / 224, worse: its loads are not side by side.
//! * *Looking up all four pixels before the first test.* Found: 124 / 121 / 79, worse by 5–20 %.
//! * *Depths in a plane of their own, 4 bytes a pixel.* Expected: 5 % in shuffled order, from more hits. Found: 167 / 108 /
//!   250 shuffled, and 219 / 158 in shuffled Morton order where 235 / 191 were: two atomic operations for each winner.
//! * *Fully shuffled, the overview's 109 is the second cache's limit*, not the memory's: every point fetches a sector of
//!   32 bytes. 8 bytes a point make it 119, no more. In a picture of 480×270, whose words fit the nearest cache, 193 and 245. A
//!   plane of 16-bit depths would fit no better than a picture of half the size (118). Left as it is: 60 % of the
//!   copy's speed was aimed at, 40 % reached.
//! * *The eye's position subtracted once* ([`View::is_near`](crate::render::View::is_near)). Expected: nothing where memory limits, 10 %
//!   for 8 bytes a point. Found: 231 / 211 / 276 (file's order) and 255 / 290 instead of 230 / 225 for the overview's and far view's 8
//!   bytes, together with:
//! * *Fields of the packed encoding known to the compiler.* Found: with nothing in the picture 514 instead of 375, both
//!   ideas together; the second alone was not timed warm.
//! * *8 bytes a point instead of 16* was to be 1.8 times as fast: 1.9 with nothing in the picture (545, 285), 1.7 for the closeup, 1.2–1.4
//!   otherwise, where the arithmetic of the projection limits (398 with no picture to write to).
//! * *One division instead of two, the picture's size folded in.* Found: 2–5 % for the overview. Left out: it changes
//!   which pixel one point in 10,000 falls into. *Integers to floats by their bits* instead of by conversion: nothing.
//! * *Two packed points in one load.* Found: 0.85–1.25, better only without blocks spread.
//! * *Bounds checks off*: `ShaderRuntimeChecks` takes `unsafe`, which this crate forbids. Where the driver checks bounds
//!   itself (`robustBufferAccess2`), as here, naga writes none.
//!
//! On 2 cores with Mesa 22.3's lavapipe (LLVM 15, subgroups of 8), 2 M points, 1024×768, medians of 7 frames alternated in one
//! process, ratios; other work ran on the machine.
//!
//! * *8 bytes a point instead of 16.* Found: mostly 0.9–1.1; depth40, which also reads colours from one more buffer,
//!   loses 5–15 %.
//! * *Skipping what is outside before the division* (a test of |x| and |y| against 1.001 times the depth in
//!   `project`). Expected: 5 % on the closeup, where most is outside. Found: no difference from noise; on the H200 187 instead of 184. Left
//!   out: one more rule for the twin to share.
//! * *`reduce` and `dedup`*, with subgroups of 8. Found: reduce 0.87–1.0 of atomic-min, dedup 0.47–0.75.
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
mod launch;
pub mod modules;
mod paced;
mod pages;
pub(crate) mod parallel;
mod pipelines;
mod plan;
mod runner;
mod table;
mod targets;
mod timing;
pub mod twin;

pub use crate::store::{Encoding, Packing, TooWide};
pub use ceilings::{Ceilings, Copies, ceilings};
pub use cloud::{Arranged, Cloud};
pub use depth40::Depth40;
pub use gpu::Gpu;
pub use launch::Launch;
pub use paced::{Abandoned, Paced};
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
    #[error(transparent)]
    TooWide(#[from] TooWide),
    #[error("{positions} positions and {colors} colours: a cloud has one colour for each position")]
    Unequal { positions: usize, colors: usize },
    #[error("{0} points are more than 32 bits can number")]
    TooMany(usize),
    #[error("a picture of {0}x{1} pixels has no pixels")]
    NoPixels(u32, u32),
    #[error("the view is of {found:?} pixels, the runner of {expected:?}")]
    OtherSize { expected: [u32; 2], found: [u32; 2] },
}
