//! The shader modules of the methods, as lists of files. Each has the encoding's way to load a point in
//! front, so that there are two of each.

use super::cloud::Encoding;
use crate::gpu::{
    kernel::GROUP,
    shaders::{INT64_ATOMICS, INT64_MIN_MAX},
};

/// An entry point of a module.
#[derive(Debug)]
pub struct Kernel {
    pub name: &'static str,
    pub entry: &'static str,
    parts: &'static [&'static str],
    /// Features that it needs beyond WebGPU's.
    pub needs: wgpu::Features,
}

macro_rules! wgsl {
    ($part:literal) => {
        include_str!(concat!("../../shaders/", $part, ".wgsl"))
    };
}

/// How many points a thread draws, for kernels whose threads know nothing of each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PerThread {
    One,
    Four,
}

const EACH: &str = wgsl!("methods/each");
const FOUR: &str = wgsl!("methods/four");
const READ_FOUR: &str = wgsl!("methods/read");
const PRELUDE: [&str; 3] = [wgsl!("group"), wgsl!("project"), wgsl!("methods/page")];

impl Kernel {
    /// The whole module for points in that encoding.
    pub fn source(&self, encoding: Encoding, per_thread: PerThread) -> String {
        let load = match encoding {
            Encoding::Wide => wgsl!("methods/load_wide"),
            Encoding::Packed => wgsl!("methods/load_packed"),
        };
        let choose = |&part: &&'static str| if part == EACH && per_thread == PerThread::Four { FOUR } else { part };
        PRELUDE.concat() + load + &self.parts.iter().map(choose).collect::<String>()
    }

    /// Threads for so many points or pixels.
    pub fn threads(&self, count: u32, per_thread: PerThread) -> u32 {
        let takes_four = self.parts.contains(&EACH) && per_thread == PerThread::Four || self.parts.contains(&READ_FOUR);
        if takes_four { count.div_ceil(4 * GROUP) * GROUP } else { count }
    }
}

macro_rules! kernel {
    ($name:ident, $entry:literal, $needs:expr, $($part:literal),+) => {
        pub static $name: Kernel =
            Kernel { name: stringify!($name), entry: $entry, parts: &[$(wgsl!($part)),+], needs: $needs };
    };
}

const NOTHING: wgpu::Features = wgpu::Features::empty();
const MIN_IN_SUBGROUPS: wgpu::Features = INT64_MIN_MAX.union(wgpu::Features::SUBGROUP);
const ALL_IN_SUBGROUPS: wgpu::Features = INT64_ATOMICS.union(wgpu::Features::SUBGROUP);

// One pass over the points each.
kernel!(JUST_SET, "draw", NOTHING, "methods/plot_just_set", "methods/each");
kernel!(ATOMIC_MIN, "draw", INT64_MIN_MAX, "plot_64_min", "methods/each");
kernel!(EARLY_Z, "draw", INT64_ATOMICS, "plot_64", "methods/each");
kernel!(REDUCE, "draw", MIN_IN_SUBGROUPS, "plot_64_min", "subgroup", "reduce", "methods/together");
kernel!(REDUCE_EARLY_Z, "draw", ALL_IN_SUBGROUPS, "plot_64", "subgroup", "reduce", "methods/together");
kernel!(DEDUP, "draw", MIN_IN_SUBGROUPS, "plot_64_min", "subgroup", "dedup", "methods/together");
kernel!(BUSY_LOOP, "draw", NOTHING, "methods/depth_clip", "methods/plot_busy_loop", "methods/each");
kernel!(BUSY_LOOP_N, "draw", NOTHING, "methods/depth_normalized", "methods/plot_busy_loop", "methods/each");
kernel!(RACY, "draw", NOTHING, "methods/plot_racy", "methods/each");
kernel!(DEPTH_32, "draw", NOTHING, "plot_depth_32", "methods/each");
kernel!(SLOT_32, "draw", NOTHING, "plot_slot_32", "methods/each");
kernel!(
    DEPTH40,
    "draw",
    INT64_ATOMICS,
    "methods/depth40",
    "methods/depth40_uniform",
    "methods/plot_depth40",
    "methods/each"
);
kernel!(
    DEPTH40_RANGES,
    "draw",
    INT64_ATOMICS,
    "methods/depth40",
    "methods/depth40_ranges",
    "methods/plot_depth40",
    "methods/each"
);
kernel!(HQS, "draw", NOTHING, "methods/sum_rule", "methods/plot_hqs", "methods/each");
kernel!(HQS_64, "draw", INT64_ATOMICS, "methods/sum_rule", "methods/plot_hqs_64", "methods/each");
kernel!(HQS1, "draw", INT64_ATOMICS, "methods/sum_rule", "methods/plot_hqs1", "methods/each");
kernel!(HQS1R, "draw", INT64_ATOMICS, "methods/sum_rule", "methods/plot_hqs1r", "methods/each");

// One thread a pixel.
kernel!(CLEAR_WORDS, "clear_words", NOTHING, "methods/targets", "methods/clear");
kernel!(CLEAR_SUMS, "clear_sums", NOTHING, "methods/targets", "methods/clear");
kernel!(CLEAR_SHOWN, "clear_shown", NOTHING, "methods/targets", "methods/clear");
kernel!(POINT_COLOR, "point_color", NOTHING, "methods/targets", "methods/resolve");
kernel!(WORD_COLOR, "word_color", NOTHING, "methods/targets", "methods/resolve");
kernel!(AVERAGE_SUMS, "average_sums", NOTHING, "methods/targets", "methods/resolve");
kernel!(AVERAGE_18_BITS, "average_18_bits", NOTHING, "methods/targets", "methods/resolve");
kernel!(AVERAGE_16_BITS, "average_16_bits", NOTHING, "methods/targets", "methods/resolve");

// For a read-back.
kernel!(DEPTH_OF_POINT, "depth_of_point", NOTHING, "methods/targets", "methods/identify");
kernel!(
    IDENTIFY_DEPTH40,
    "draw",
    INT64_ATOMICS,
    "methods/depth40",
    "methods/depth40_uniform",
    "methods/identify_depth40",
    "methods/each"
);
kernel!(
    IDENTIFY_DEPTH40_RANGES,
    "draw",
    INT64_ATOMICS,
    "methods/depth40",
    "methods/depth40_ranges",
    "methods/identify_depth40",
    "methods/each"
);

// The baseline, and a ceiling.
kernel!(POINTS, "place", NOTHING, "methods/points");
kernel!(COLLECT, "collect", NOTHING, "methods/targets", "methods/collect");
kernel!(READ, "read_positions", NOTHING, "methods/read");

/// All kernels, for the tests.
pub static ALL: [&Kernel; 31] = [
    &JUST_SET,
    &ATOMIC_MIN,
    &EARLY_Z,
    &REDUCE,
    &REDUCE_EARLY_Z,
    &DEDUP,
    &BUSY_LOOP,
    &BUSY_LOOP_N,
    &RACY,
    &DEPTH_32,
    &SLOT_32,
    &DEPTH40,
    &DEPTH40_RANGES,
    &HQS,
    &HQS_64,
    &HQS1,
    &HQS1R,
    &CLEAR_WORDS,
    &CLEAR_SUMS,
    &CLEAR_SHOWN,
    &POINT_COLOR,
    &WORD_COLOR,
    &AVERAGE_SUMS,
    &AVERAGE_18_BITS,
    &AVERAGE_16_BITS,
    &DEPTH_OF_POINT,
    &IDENTIFY_DEPTH40,
    &IDENTIFY_DEPTH40_RANGES,
    &POINTS,
    &COLLECT,
    &READ,
];
