//! The shader modules: each is a list of files, pasted together in order.

use crate::store::Encoding;

/// A named shader module.
pub struct Shader {
    pub name: &'static str,
    pub parts: &'static [&'static str],
    /// Features that it needs beyond WebGPU's.
    pub needs: wgpu::Features,
}

/// How positions are read in the wide encoding, and what takes its place in the packed one.
const POINTS: &str = include_str!("../../shaders/points.wgsl");
const POINTS_PACKED: [&str; 2] =
    [include_str!("../../shaders/packed.wgsl"), include_str!("../../shaders/points_packed.wgsl")];

impl Shader {
    /// Whether it reads positions: then there are two of it, one for each [`Encoding`].
    pub fn reads_positions(&self) -> bool {
        self.parts.contains(&POINTS)
    }

    /// The module; one that reads positions does so in the wide encoding.
    pub fn source(&self) -> String {
        self.source_in(Encoding::Wide)
    }

    /// The module for positions in this encoding.
    pub fn source_in(&self, encoding: Encoding) -> String {
        let parts = self.parts.iter().map(|&part| match encoding {
            Encoding::Packed if part == POINTS => POINTS_PACKED.concat(),
            _ => part.to_owned(),
        });
        with_lane(parts.collect())
    }

    /// A module that reads no positions.
    pub fn module(&self, device: &wgpu::Device) -> wgpu::ShaderModule {
        debug_assert!(!self.reads_positions(), "{} is for one encoding: `module_in`", self.name);
        self.module_in(device, Encoding::Wide)
    }

    /// The module for positions in this encoding.
    pub fn module_in(&self, device: &wgpu::Device, encoding: Encoding) -> wgpu::ShaderModule {
        device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(self.name),
            source: wgpu::ShaderSource::Wgsl(self.source_in(encoding).into()),
        })
    }
}

/// Where `lane.wgsl` is a part, entry points that know their thread set the lane first.
pub fn with_lane(source: String) -> String {
    if !source.contains("var<private> lane") {
        return source;
    }
    let thread = "@builtin(local_invocation_index) thread: u32";
    let lane = "@builtin(subgroup_invocation_id) own_lane: u32";
    source.replace(&format!("{thread}) {{\n"), &format!("{thread}, {lane}) {{\n    lane = own_lane;\n"))
}

const NOTHING: wgpu::Features = wgpu::Features::empty();
const SUBGROUP: wgpu::Features = wgpu::Features::SUBGROUP;
/// 64-bit minimum and maximum.
pub const INT64_MIN_MAX: wgpu::Features =
    wgpu::Features::SHADER_INT64.union(wgpu::Features::SHADER_INT64_ATOMIC_MIN_MAX);
/// All 64-bit atomics, loads among them.
pub const INT64_ATOMICS: wgpu::Features = INT64_MIN_MAX.union(wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS);

macro_rules! shader {
    ($name:ident, $needs:expr, $($part:literal),+) => {
        pub const $name: Shader = Shader {
            name: stringify!($name),
            parts: &[$(include_str!(concat!("../../shaders/", $part, ".wgsl"))),+],
            needs: $needs,
        };
    };
}

shader!(INSERT, NOTHING, "group", "permutation", "insert");
shader!(MOVE, NOTHING, "group", "permutation", "page", "move");
shader!(WIDEN, NOTHING, "group", "page", "packed", "points_packed", "widen");
shader!(RELOCATE, NOTHING, "group", "permutation", "relocate");
shader!(CLEAR, NOTHING, "group", "project", "clear");
shader!(
    EARLY_Z,
    INT64_MIN_MAX,
    "group",
    "page",
    "project",
    "points",
    "put_64",
    "early",
    "plot_early",
    "raster",
    "hidden",
    "span"
);
shader!(
    ATOMIC_MIN,
    INT64_MIN_MAX,
    "group",
    "page",
    "project",
    "points",
    "put_64",
    "plot_each",
    "raster",
    "hidden",
    "span"
);
shader!(
    REDUCE,
    INT64_MIN_MAX.union(SUBGROUP),
    "group",
    "page",
    "project",
    "points",
    "put_64",
    "lane",
    "subgroup",
    "reduce",
    "plot_reduce",
    "raster",
    "hidden",
    "span"
);
shader!(
    REDUCE_EARLY_Z,
    INT64_MIN_MAX.union(SUBGROUP),
    "group",
    "page",
    "project",
    "points",
    "put_64",
    "early",
    "lane",
    "subgroup",
    "reduce",
    "plot_reduce_early",
    "raster",
    "hidden",
    "span"
);
shader!(
    DEDUP,
    INT64_MIN_MAX.union(SUBGROUP),
    "group",
    "page",
    "project",
    "points",
    "put_64",
    "subgroup",
    "dedup",
    "raster",
    "hidden",
    "span"
);
shader!(
    DEPTH_32,
    NOTHING,
    "group",
    "page",
    "project",
    "points",
    "seen_atomic",
    "plot_depth_32",
    "raster",
    "hidden",
    "span"
);
shader!(
    SLOT_32,
    NOTHING,
    "group",
    "page",
    "project",
    "points",
    "seen_atomic",
    "plot_slot_32",
    "raster",
    "hidden",
    "span"
);
shader!(HARDWARE, NOTHING, "page", "project", "points", "hidden", "hardware");
shader!(MASK, NOTHING, "group", "page", "points", "mask_rules", "mask", "mask_write");
shader!(MASK_COLUMN, NOTHING, "group", "page", "mask_rules", "mask_column", "mask_write");
shader!(INDEX, NOTHING, "group", "project", "index");
shader!(RESOLVE, NOTHING, "group", "page", "project", "points", "color", "resolve");
shader!(AVERAGE_32, NOTHING, "group", "page", "project", "points", "color", "sums_32", "hidden", "average");
shader!(AVERAGE_64, INT64_ATOMICS, "group", "page", "project", "points", "color", "sums_64", "hidden", "average");
shader!(RESOLVE_32, NOTHING, "group", "page", "project", "points", "color", "resolve", "sums_32", "resolve_average");
shader!(
    RESOLVE_64,
    INT64_ATOMICS,
    "group",
    "page",
    "project",
    "points",
    "color",
    "resolve",
    "sums_64",
    "resolve_average"
);
shader!(PICK, NOTHING, "page", "points", "pick");
shader!(COLUMN, NOTHING, "group", "project", "column_page", "column");
shader!(FILL_COLUMN, NOTHING, "group", "column_page", "fill_column");
shader!(LIGHT, NOTHING, "group", "project", "light");
shader!(HOLES, NOTHING, "group", "project", "holes");
shader!(COPY, NOTHING, "group", "methods/copy");

/// All modules, for the tests.
pub const ALL: [&Shader; 27] = [
    &INSERT,
    &MOVE,
    &WIDEN,
    &RELOCATE,
    &CLEAR,
    &EARLY_Z,
    &ATOMIC_MIN,
    &REDUCE,
    &REDUCE_EARLY_Z,
    &DEDUP,
    &DEPTH_32,
    &SLOT_32,
    &HARDWARE,
    &MASK,
    &MASK_COLUMN,
    &INDEX,
    &RESOLVE,
    &AVERAGE_32,
    &AVERAGE_64,
    &RESOLVE_32,
    &RESOLVE_64,
    &PICK,
    &COLUMN,
    &FILL_COLUMN,
    &LIGHT,
    &HOLES,
    &COPY,
];
