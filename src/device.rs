//! What whoever draws, a GPU or the processor, has in common: the ways to rasterize, the times of a
//! frame, and what can go wrong.

use serde::Serialize;

/// A way to turn points into pixels, under the name that it has in [`crate::methods::METHODS`]. All of
/// them give the same words, see [`crate::render`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Raster {
    /// Point-list draws with the depth test, then the slots of the points that passed it.
    Points,
    /// 64-bit `atomicMin` of depth and slot.
    AtomicMin,
    /// The same after a plain read of the word.
    EarlyZ,
    /// `AtomicMin` for one point of a subgroup in one pixel, or for the front one of neighbours.
    Reduce,
    /// Both.
    ReduceEarlyZ,
    /// One `AtomicMin` for each distinct pixel of a subgroup.
    Dedup,
    /// Two passes of 32-bit `atomicMin`: depth, then slot.
    TwoPass32,
    /// The kernels' twins, on the processor; no row of the table.
    Cpu,
}

impl Raster {
    /// Those that a GPU runs.
    pub const ON_GPU: [Raster; 7] = [
        Raster::Points,
        Raster::AtomicMin,
        Raster::EarlyZ,
        Raster::Reduce,
        Raster::ReduceEarlyZ,
        Raster::Dedup,
        Raster::TwoPass32,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Raster::Points => "points",
            Raster::AtomicMin => "atomic-min",
            Raster::EarlyZ => "early-z",
            Raster::Reduce => "reduce",
            Raster::ReduceEarlyZ => "reduce-early-z",
            Raster::Dedup => "dedup",
            Raster::TwoPass32 => "two-pass-32",
            Raster::Cpu => "cpu",
        }
    }
}

impl std::fmt::Display for Raster {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl Serialize for Raster {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// Which passes over the points a frame makes. Each kind has its own costs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Passes {
    /// Depths alone.
    #[default]
    Depths,
    /// Depths, then the sums of high-quality shading.
    DepthsAndSums,
    /// Sums alone; the depths stay those of the frame before.
    Sums,
}

/// Seconds that the passes of one frame took on the device.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct PassTimes {
    pub insert: f64,
    pub reproject: f64,
    pub fresh: f64,
    pub fill: f64,
    pub index: f64,
    pub resolve: f64,
    /// High-quality shading: colours of the points that were visible or are fresh.
    pub average: f64,
    /// The same of `average_points` others.
    pub average_fill: f64,
    /// The whole frame, where the device cannot tell its passes apart; the others are zero then.
    pub undivided: f64,
    /// Points that `fill` drew.
    pub fill_points: u32,
    /// Insertions of the frame.
    pub insertions: u32,
    /// Points that `average_fill` drew.
    pub average_points: u32,
    pub passes: Passes,
}

impl PassTimes {
    pub fn total(&self) -> f64 {
        let depths = self.insert + self.reproject + self.fresh + self.fill + self.index;
        depths + self.average + self.average_fill + self.resolve + self.undivided
    }
}

/// Why a backend could not do its work.
#[derive(Debug, Clone, thiserror::Error)]
pub enum RenderError {
    #[error("no GPU adapter found{0}")]
    NoAdapter(String),
    #[error("the {adapter} cannot run {method}: it lacks {missing}")]
    Unsupported { adapter: String, method: Raster, missing: String },
    #[error("{width}x{height} pixels are more than this device can hold ({limit} pixels); choose a smaller --size")]
    TooManyPixels { width: u32, height: u32, limit: u64 },
    #[error("no memory for a picture of {width}x{height} pixels ({detail})")]
    NoMemoryForPicture { width: u32, height: u32, detail: String },
    #[error(
        "no room for high-quality shading of {width}x{height} pixels ({detail}); switch it off (--hq, HQ) or choose a smaller size"
    )]
    NoMemoryForSums { width: u32, height: u32, detail: String },
    #[error("no memory to filter {points} points ({detail}); leave out --filter, --clip and --slab")]
    NoMemoryForFilter { points: u64, detail: String },
    #[error("out of memory after {stored} points ({detail}); the points so far are shown")]
    OutOfMemory { stored: u64, detail: String },
    #[error("no memory for the values to colour by ({detail}); colour by rgb, elevation or file (--color-by)")]
    NoMemoryForValues { detail: String },
    #[error("the GPU stopped working: {0}")]
    DeviceLost(String),
}
