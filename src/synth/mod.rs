//! Test scans from nothing: files to show, to test and to measure with, on a machine that has no data.
//!
//! A [`Generator`] knows point `i` of a scene without knowing those before it, so that points can be
//! made in any order, in parallel, and without a file; [`write()`] streams them into a LAS or LAZ file. A scan is
//! the same to the last bit on every platform: chance comes from integer hashes, and coordinates from basic IEEE
//! arithmetic. Scenes are built in metres around (0, 0); [`SynthOptions::origin`] moves them elsewhere,
//! by default to where UTM coordinates are large.
//!
//! ```
//! use firstlight::synth::{Generator, Scene, SynthOptions};
//! let options = SynthOptions { points: 1_000, ..SynthOptions::new(Scene::Town) };
//! let generator = Generator::new(&options)?;
//! assert_eq!(generator.iter().nth(500), Some(generator.point(500)));
//! # Ok::<(), firstlight::synth::SynthError>(())
//! ```

mod args;
mod generator;
mod header;
mod noise;
mod options;
mod planes;
mod record;
mod town;
mod write;

pub use args::{SynthArgs, run};
pub use generator::{Generator, SynthPoint};
pub use options::{Scene, SynthError, SynthOptions};
pub use planes::{PLANE_COLORS, PLANES, plane_height, plane_side};
pub use write::{SynthSummary, write};
