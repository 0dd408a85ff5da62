//! Validation of WGSL without a GPU, for the test binaries that have shaders of their own.

use naga::valid::{Capabilities, ValidationFlags, Validator};

pub fn validate(source: &str, capabilities: Capabilities) -> Result<naga::Module, String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    let mut validator = Validator::new(ValidationFlags::all(), capabilities);
    validator.validate(&module).map_err(|error| error.emit_to_string(source))?;
    Ok(module)
}

/// What a module may use on a device with these features.
pub fn capabilities(needs: wgpu::Features) -> Capabilities {
    [
        (wgpu::Features::SHADER_INT64, Capabilities::SHADER_INT64),
        (wgpu::Features::SHADER_INT64_ATOMIC_MIN_MAX, Capabilities::SHADER_INT64_ATOMIC_MIN_MAX),
        (wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS, Capabilities::SHADER_INT64_ATOMIC_ALL_OPS),
        (wgpu::Features::SUBGROUP, Capabilities::SUBGROUP),
    ]
    .into_iter()
    .filter(|(feature, _)| needs.contains(*feature))
    .fold(Capabilities::empty(), |all, (_, capability)| all | capability)
}
