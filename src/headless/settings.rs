//! What to render, validated.

use std::{path::PathBuf, time::Instant};

use super::{outputs::Outputs, progress::ProgressStyle};
use crate::{
    render::{Camera, ColorBy, FillBudget, Look, RasterChoice, StoreOptions},
    source::Fields,
    store::Encoding,
};

/// Points that a frame's fill tries on the way to the converged picture. Nobody watches, so frames may
/// be long, and the fewer, the less is spent on what each costs anyway: a budget that follows a frame
/// time of 50 ms took 98 s for 8 M points on two busy cores, this one takes 2 s on idle ones. Not more
/// either: a point list of 8 M made lavapipe take 1.9 GB, and drivers stop a GPU that works for seconds.
pub const CONVERGE_FILL: u32 = 4_000_000;

/// Points that a frame's fill tries where frames are counted, or points.
pub const COUNTED_FILL: u32 = 1_000_000;

/// Where to draw.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum BackendChoice {
    /// On a GPU; without one, on the processor.
    #[default]
    Auto,
    Gpu,
    Cpu,
}

/// When the picture is finished.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Stop {
    /// When all points are loaded and tried.
    #[default]
    Converged,
    /// After so many frames, or once the picture has converged.
    Frames(u64),
    /// When the first so many points, in the order they are read, are stored and tried.
    Points(u64),
}

impl std::fmt::Display for Stop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Stop::Converged => f.write_str("converged"),
            Stop::Frames(n) => write!(f, "frames={n}"),
            Stop::Points(n) => write!(f, "points={n}"),
        }
    }
}

/// All that [`super::render`] needs to know.
#[derive(Debug)]
pub struct Settings {
    /// Files and folders.
    pub inputs: Vec<PathBuf>,
    pub outputs: Outputs,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// By default all that the look's clipping box and slab show, from the south and above; of a slab, from across.
    pub camera: Option<Camera>,
    pub backend: BackendChoice,
    pub method: RasterChoice,
    /// How positions are stored; `None`: as is best.
    pub encoding: Option<Encoding>,
    /// Points that each frame's fill tries; by default [`CONVERGE_FILL`] or [`COUNTED_FILL`].
    pub fill: Option<u32>,
    pub look: Look,
    pub seed: u64,
    /// Points per insertion into the store.
    pub insertion_points: u32,
    pub stop: Stop,
    /// Load everything, then draw all points at once, without the progressive method.
    pub brute_force: bool,
    /// Decoder threads, and threads of the CPU backend.
    pub threads: Option<usize>,
    pub progress: ProgressStyle,
    /// Where the report's seconds start.
    pub started: Instant,
}

/// What has to be read for a look and no other; `None`: what the automatic colours depend on, file by file.
pub fn fields_of(look: &Look) -> Option<Fields> {
    let attributes = look.attributes();
    let fields = Fields::of(&attributes);
    match &look.coloring.by {
        ColorBy::Auto if attributes.is_empty() => None,
        ColorBy::Auto => Some(fields.union(Fields::COLORS)),
        ColorBy::Rgb => Some(Fields { rgb: true, ..fields }),
        ColorBy::Attribute(_) => Some(fields),
    }
}

impl Settings {
    pub(super) fn store_options(&self) -> StoreOptions {
        let mut options =
            StoreOptions { seed: self.seed, insertion_points: self.insertion_points, ..Default::default() };
        if let Stop::Points(points) = self.stop {
            options.max_points = points;
        }
        options
    }

    pub(super) fn fill_points(&self) -> u32 {
        self.fill.unwrap_or(match self.stop {
            Stop::Converged => CONVERGE_FILL,
            Stop::Frames(_) | Stop::Points(_) => COUNTED_FILL,
        })
    }

    pub(super) fn fill_budget(&self) -> FillBudget {
        // Loading for brute force needs frames, since a backend takes only so many insertions between
        // two, but nothing of what they show is used.
        FillBudget::Fixed(if self.brute_force { 0 } else { self.fill_points() })
    }
}
