//! Validation and translation of WGSL without a GPU, for the test binaries that have shaders of their own.

use naga::{
    back::{hlsl, msl, pipeline_constants::process_overrides, spv},
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};

fn parse(source: &str, capabilities: Capabilities) -> Result<(naga::Module, ModuleInfo), String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    let mut validator = Validator::new(ValidationFlags::all(), capabilities);
    let info = validator.validate(&module).map_err(|error| error.emit_to_string(source))?;
    Ok((module, info))
}

pub fn validate(source: &str, capabilities: Capabilities) -> Result<naga::Module, String> {
    parse(source, capabilities).map(|(module, _)| module)
}

/// Translates to what Metal, DX12 and Vulkan take, as wgpu does there: a language may lack what WGSL has.
pub fn translate(source: &str, capabilities: Capabilities) -> Result<(), String> {
    let (module, info) = parse(source, capabilities)?;
    // At their usual values.
    let (module, info) =
        process_overrides(&module, &info, None, &Default::default()).map_err(|error| format!("overrides: {error}"))?;
    // The newest that wgpu asks for; 64-bit minima need Metal 2.4, 64-bit integers shader model 6.
    let metal = msl::Options { lang_version: (2, 4), fake_missing_bindings: true, ..Default::default() };
    msl::write_string(&module, &info, &metal, &Default::default()).map_err(|error| format!("Metal: {error}"))?;
    let dx12 =
        hlsl::Options { shader_model: hlsl::ShaderModel::V6_6, fake_missing_bindings: true, ..Default::default() };
    let (mut text, constants) = (String::new(), hlsl::PipelineOptions::default());
    hlsl::Writer::new(&mut text, &dx12, &constants)
        .write(&module, &info, None)
        .map_err(|error| format!("DX12: {error}"))?;
    let vulkan = spv::Options { lang_version: (1, 3), ..Default::default() };
    spv::write_vec(&module, &info, &vulkan, None).map_err(|error| format!("Vulkan: {error}"))?;
    Ok(())
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
