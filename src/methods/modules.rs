//! The shader modules of the methods, as lists of files. Each has the encoding's way to load a point in
//! front, so that there are two of each.

use super::{Encoding, Launch};
use crate::gpu::{
    kernel::GROUP,
    shaders::{INT64_ATOMICS, INT64_MIN_MAX, with_lane},
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

const EACH: &str = wgsl!("methods/each");
const READ_FOUR: &str = wgsl!("methods/read");
const PRELUDE: [&str; 3] = [wgsl!("group"), wgsl!("project"), wgsl!("page")];

impl Kernel {
    /// The whole module for points in that encoding.
    pub fn source(&self, encoding: Encoding, launch: Launch) -> String {
        let load = match encoding {
            Encoding::Wide => [wgsl!("methods/load_wide"), ""],
            Encoding::Packed => [wgsl!("packed"), wgsl!("methods/load_packed")],
        };
        let fill_in = |&part: &&'static str| if part == EACH { launch.fill_in(EACH) } else { part.into() };
        with_lane(PRELUDE.concat() + &load.concat() + &self.parts.iter().map(fill_in).collect::<String>())
    }

    /// Workgroups for so many points or pixels.
    pub fn groups(&self, count: u32, launch: Launch) -> u32 {
        if self.parts.contains(&EACH) {
            launch.groups(count)
        } else if self.parts.contains(&READ_FOUR) {
            count.div_ceil(4 * GROUP)
        } else {
            count.div_ceil(GROUP)
        }
    }
}

macro_rules! kernel {
    ($name:ident, $entry:literal, $needs:expr, $($part:literal),+) => {
        pub static $name: Kernel =
            Kernel { name: stringify!($name), entry: $entry, parts: &[$(wgsl!($part)),+], needs: $needs };
    };
}

const NOTHING: wgpu::Features = wgpu::Features::empty();
/// 64-bit numbers, without their atomics.
const INT64: wgpu::Features = wgpu::Features::SHADER_INT64;
const MIN_IN_SUBGROUPS: wgpu::Features = INT64_MIN_MAX.union(wgpu::Features::SUBGROUP);

// One pass over the points each.
kernel!(JUST_SET, "draw", NOTHING, "methods/plot_just_set", "methods/each");
kernel!(ATOMIC_MIN, "draw", INT64_MIN_MAX, "put_64", "plot_each", "methods/each");
kernel!(EARLY_Z, "draw", INT64_MIN_MAX, "put_64", "early", "plot_early", "methods/each");
kernel!(REDUCE, "draw", MIN_IN_SUBGROUPS, "put_64", "lane", "subgroup", "reduce", "plot_reduce", "methods/each");
kernel!(
    REDUCE_EARLY_Z,
    "draw",
    MIN_IN_SUBGROUPS,
    "put_64",
    "early",
    "lane",
    "subgroup",
    "reduce",
    "plot_reduce_early",
    "methods/each"
);
kernel!(DEDUP, "draw", MIN_IN_SUBGROUPS, "put_64", "subgroup", "dedup", "methods/each");
kernel!(BUSY_LOOP, "draw", NOTHING, "methods/depth_clip", "methods/plot_busy_loop", "methods/each");
kernel!(BUSY_LOOP_N, "draw", NOTHING, "methods/depth_normalized", "methods/plot_busy_loop", "methods/each");
kernel!(RACY, "draw", NOTHING, "methods/plot_racy", "methods/each");
kernel!(DEPTH_32, "draw", NOTHING, "early", "plot_depth_32", "methods/each");
kernel!(SLOT_32, "draw", NOTHING, "early", "plot_slot_32", "methods/each");
kernel!(
    DEPTH40,
    "draw",
    INT64_MIN_MAX,
    "methods/depth40",
    "methods/depth40_uniform",
    "early",
    "methods/plot_depth40",
    "methods/each"
);
kernel!(
    DEPTH40_RANGES,
    "draw",
    INT64_MIN_MAX,
    "methods/depth40",
    "methods/depth40_ranges",
    "early",
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
    INT64,
    "methods/depth40",
    "methods/depth40_uniform",
    "methods/identify_depth40",
    "methods/each"
);
kernel!(
    IDENTIFY_DEPTH40_RANGES,
    "draw",
    INT64,
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
