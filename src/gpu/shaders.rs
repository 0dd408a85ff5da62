//! The shader modules: each is a list of files, pasted together in order.

/// A named shader module.
pub struct Shader {
    pub name: &'static str,
    pub parts: &'static [&'static str],
    /// Features that it needs beyond WebGPU's.
    pub needs: wgpu::Features,
}

impl Shader {
    pub fn source(&self) -> String {
        with_lane(self.parts.concat())
    }

    pub fn module(&self, device: &wgpu::Device) -> wgpu::ShaderModule {
        device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(self.name),
            source: wgpu::ShaderSource::Wgsl(self.source().into()),
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
    "span"
);
shader!(ATOMIC_MIN, INT64_MIN_MAX, "group", "page", "project", "points", "put_64", "plot_each", "raster", "span");
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
    "span"
);
shader!(DEPTH_32, NOTHING, "group", "page", "project", "points", "seen_atomic", "plot_depth_32", "raster", "span");
shader!(SLOT_32, NOTHING, "group", "page", "project", "points", "seen_atomic", "plot_slot_32", "raster", "span");
shader!(HARDWARE, NOTHING, "page", "project", "points", "hardware");
shader!(INDEX, NOTHING, "group", "project", "index");
shader!(RESOLVE, NOTHING, "group", "page", "project", "points", "color", "resolve");
shader!(AVERAGE_32, NOTHING, "group", "page", "project", "points", "color", "sums_32", "average");
shader!(AVERAGE_64, INT64_ATOMICS, "group", "page", "project", "points", "color", "sums_64", "average");
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
shader!(COLUMN, NOTHING, "group", "project", "column_page", "column");
shader!(FILL_COLUMN, NOTHING, "group", "column_page", "fill_column");
shader!(LIGHT, NOTHING, "group", "project", "light");
shader!(COPY, NOTHING, "group", "methods/copy");

/// All modules, for the tests.
pub const ALL: [&Shader; 22] = [
    &INSERT,
    &MOVE,
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
    &INDEX,
    &RESOLVE,
    &AVERAGE_32,
    &AVERAGE_64,
    &RESOLVE_32,
    &RESOLVE_64,
    &COLUMN,
    &FILL_COLUMN,
    &LIGHT,
    &COPY,
];
