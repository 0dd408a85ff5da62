//! The shader modules: each is a list of files, pasted together in order.

/// A named shader module.
pub struct Shader {
    pub name: &'static str,
    pub parts: &'static [&'static str],
    /// Needs 64-bit integers and atomics.
    pub needs_int64: bool,
}

impl Shader {
    pub fn source(&self) -> String {
        self.parts.concat()
    }

    pub fn module(&self, device: &wgpu::Device) -> wgpu::ShaderModule {
        device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(self.name),
            source: wgpu::ShaderSource::Wgsl(self.source().into()),
        })
    }
}

macro_rules! shader {
    ($name:ident, $needs_int64:expr, $($part:literal),+) => {
        pub const $name: Shader = Shader {
            name: stringify!($name),
            parts: &[$(include_str!(concat!("../../shaders/", $part, ".wgsl"))),+],
            needs_int64: $needs_int64,
        };
    };
}

shader!(INSERT, false, "group", "permutation", "insert");
shader!(MOVE, false, "group", "permutation", "page", "move");
shader!(RELOCATE, false, "group", "permutation", "relocate");
shader!(CLEAR, false, "group", "project", "clear");
shader!(RASTER_64, true, "group", "page", "project", "points", "plot_64", "raster");
shader!(RASTER_DEPTH_32, false, "group", "page", "project", "points", "plot_depth_32", "raster");
shader!(RASTER_SLOT_32, false, "group", "page", "project", "points", "plot_slot_32", "raster");
shader!(HARDWARE, false, "page", "project", "points", "hardware");
shader!(INDEX, false, "group", "project", "index");
shader!(RESOLVE, false, "group", "page", "project", "points", "resolve");
shader!(LIGHT, false, "group", "project", "light");

/// All modules, for the tests.
pub const ALL: [&Shader; 11] = [
    &INSERT,
    &MOVE,
    &RELOCATE,
    &CLEAR,
    &RASTER_64,
    &RASTER_DEPTH_32,
    &RASTER_SLOT_32,
    &HARDWARE,
    &INDEX,
    &RESOLVE,
    &LIGHT,
];
