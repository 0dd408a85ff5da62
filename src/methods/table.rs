//! The methods, one row each.

use std::fmt;

use super::{
    Encoding,
    modules::Kernel,
    plan::{Plan, Rule, Step, plans},
};

/// A way to rasterize points. A row of [`METHODS`].
#[derive(Debug)]
pub struct Method {
    pub name: &'static str,
    /// What it does, in a line.
    pub what: &'static str,
    /// Where it is described.
    pub source: &'static str,
    /// What a device must have.
    pub needs: Needs,
    /// How its picture is wrong, for those that are here to show an upper bound or a failure.
    pub wrong_on_purpose: Option<&'static str>,
    /// Averages fragments instead of showing one point in each pixel.
    pub blends: bool,
    pub(super) plan: &'static Plan,
}

impl Method {
    /// The compute kernels of its geometry passes, in order; none for hardware draws.
    pub fn kernels(&self) -> Vec<&'static Kernel> {
        let of = |step: &Step| match *step {
            Step::Points(kernel) => Some(kernel),
            Step::Draw => None,
        };
        self.plan.geometry.iter().filter_map(of).collect()
    }

    /// Bytes of the cloud that a frame must read: all positions in each geometry pass; where colours lie apart,
    /// also those that a pass looks up, at most one for each point in the frustum.
    pub fn bytes(&self, encoding: Encoding, points: u64, fragments: u64) -> u64 {
        let looks_up = matches!(self.plan.rule, Rule::Depth40 { .. } | Rule::Average(_));
        let colors = if encoding == Encoding::Packed && looks_up { 4 * fragments } else { 0 };
        self.plan.geometry.len() as u64 * points * encoding.bytes() + colors
    }
}

/// What a method asks of a device; prints as a list in words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Needs {
    /// Features beyond WebGPU's.
    pub features: wgpu::Features,
    /// Storage buffers that a vertex shader reads, and draws.
    pub draws: bool,
}

const INT64: wgpu::Features = crate::gpu::shaders::INT64_MIN_MAX;
const INT64_ALL: wgpu::Features = crate::gpu::shaders::INT64_ATOMICS;

impl Needs {
    const NOTHING: Needs = Needs { features: wgpu::Features::empty(), draws: false };
    const INT64_MIN: Needs = Needs { features: INT64, draws: false };
    const INT64_ALL: Needs = Needs { features: INT64_ALL, draws: false };
    const DRAWS: Needs = Needs { features: wgpu::Features::empty(), draws: true };

    const fn and_subgroups(self) -> Needs {
        Needs { features: self.features.union(wgpu::Features::SUBGROUP), draws: self.draws }
    }

    /// What is left when a device has `features`, and draws.
    pub fn missing(self, features: wgpu::Features, can_draw: bool) -> Needs {
        Needs { features: self.features.difference(features), draws: self.draws && !can_draw }
    }
}

impl fmt::Display for Needs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all_64 = wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS;
        let min_64 = wgpu::Features::SHADER_INT64 | wgpu::Features::SHADER_INT64_ATOMIC_MIN_MAX;
        let words = [
            (self.features.contains(all_64), "64-bit atomics"),
            (!self.features.contains(all_64) && self.features.intersects(min_64), "64-bit atomic minimum"),
            (self.features.contains(wgpu::Features::SUBGROUP), "subgroups"),
            (self.draws, "storage buffers in vertex shaders"),
        ];
        let words: Vec<_> = words.iter().filter(|(is_needed, _)| *is_needed).map(|(_, word)| *word).collect();
        f.write_str(if words.is_empty() { "nothing beyond WebGPU" } else { "" })?;
        f.write_str(&words.join(", "))
    }
}

const PAPER_2019: &str = "Schütz and Wimmer 2019, Rendering Point Clouds with Compute Shaders";
const PAPER_2021: &str =
    "Schütz, Kerbl and Wimmer 2021, Rendering Point Clouds with Compute Shaders and Vertex Order Optimization";
const PAPER_2013_LOOP: &str =
    "Günther et al. 2013, A GPGPU-based Pipeline for Accelerated Rendering of Point Clouds, Algorithms 2 and 3";
const PAPER_2013_RACE: &str =
    "Günther et al. 2013, A GPGPU-based Pipeline for Accelerated Rendering of Point Clouds, Algorithm 1";

const fn row(
    name: &'static str,
    what: &'static str,
    source: &'static str,
    needs: Needs,
    plan: &'static Plan,
) -> Method {
    Method { name, what, source, needs, wrong_on_purpose: None, blends: false, plan }
}

/// All methods, the baseline first.
pub const METHODS: &[Method] = &[
    row("points", "hardware point list with a depth test: the baseline", PAPER_2021, Needs::DRAWS, &plans::POINTS),
    Method {
        wrong_on_purpose: Some("no depth test: shows whichever point was written last"),
        ..row("just-set", "plain store, no depth: the upper bound", PAPER_2021, Needs::NOTHING, &plans::JUST_SET)
    },
    row("atomic-min", "64-bit atomicMin of depth and point", PAPER_2019, Needs::INT64_MIN, &plans::ATOMIC_MIN),
    row("early-z", "atomic-min after a plain read of the depth", PAPER_2021, Needs::INT64_MIN, &plans::EARLY_Z),
    row(
        "reduce",
        "atomic-min of one point for a subgroup in one pixel, else of the front one of neighbours",
        PAPER_2021,
        Needs::INT64_MIN.and_subgroups(),
        &plans::REDUCE,
    ),
    row("reduce-early-z", "early-z, then reduce", PAPER_2021, Needs::INT64_MIN.and_subgroups(), &plans::REDUCE_EARLY_Z),
    row(
        "dedup",
        "one atomic-min for each distinct pixel of a subgroup",
        PAPER_2021,
        Needs::INT64_MIN.and_subgroups(),
        &plans::DEDUP,
    ),
    row(
        "busy-loop",
        "a lock for each pixel, depth in clip space (CL_c); bounded spins, give-ups counted",
        PAPER_2013_LOOP,
        Needs::NOTHING,
        &plans::BUSY_LOOP,
    ),
    row(
        "busy-loop-n",
        "busy-loop with normalized depth (CL_n), which tells far points apart less well",
        PAPER_2013_LOOP,
        Needs::NOTHING,
        &plans::BUSY_LOOP_N,
    ),
    Method {
        wrong_on_purpose: Some("the depth test is not thread-safe: points behind others are shown"),
        ..row("racy", "compare, then write, unprotected", PAPER_2013_RACE, Needs::NOTHING, &plans::RACY)
    },
    row(
        "two-pass-32",
        "a pass for the depth, a pass for the point, 32-bit atomics",
        "the fallback where 64-bit atomics lack",
        Needs::NOTHING,
        &plans::TWO_PASS_32,
    ),
    row(
        "depth40",
        "40 bits of depth, 1 mm everywhere, above 24 of colour",
        PAPER_2019,
        Needs::INT64_MIN,
        &plans::DEPTH40,
    ),
    row(
        "depth40-ranges",
        "depth40 with 1 nm to 10 m, 1 µm to 10 km, 1 mm beyond",
        PAPER_2019,
        Needs::INT64_MIN,
        &plans::DEPTH40_RANGES,
    ),
    Method {
        blends: true,
        ..row(
            "hqs",
            "average of all within 1 % of the front, four 32-bit sums",
            PAPER_2019,
            Needs::NOTHING,
            &plans::HQS,
        )
    },
    Method { blends: true, ..row("hqs-64", "hqs with two 64-bit sums", PAPER_2021, Needs::INT64_ALL, &plans::HQS_64) },
    Method {
        blends: true,
        ..row(
            "hqs1",
            "hqs with one 64-bit sum, 18-18-18-10 bits; wrong beyond 1,023 fragments in a pixel",
            PAPER_2021,
            Needs::INT64_ALL,
            &plans::HQS1,
        )
    },
    Method {
        blends: true,
        ..row(
            "hqs1r",
            "hqs with one 64-bit sum, 16-16-16-16 bits, handed over at 255 fragments",
            PAPER_2021,
            Needs::INT64_ALL,
            &plans::HQS1R,
        )
    },
];

/// The method of that name in [`METHODS`].
pub fn by_name(name: &str) -> Option<&'static Method> {
    METHODS.iter().find(|method| method.name == name)
}
