//! Every shader module is valid WGSL within WebGPU's means, and every struct that the host fills has
//! the layout that the shader reads. Needs no GPU.

use std::mem::offset_of;

use firstlight::{
    gpu::shaders::{self, Shader},
    render::{ColorTablesUniform, ColumnScaleUniform, FileColor, PickWords, ShadingUniform, View},
    store::{
        Encoding,
        gpu::{InsertionUniform, PageUniform},
    },
};
use naga::valid::Capabilities;

use crate::wgsl::{capabilities, translate, validate};

#[test]
fn all_modules_are_valid() {
    let failures: Vec<_> = shaders::ALL
        .iter()
        .flat_map(|shader| [Encoding::Wide, Encoding::Packed].map(|encoding| (shader, encoding)))
        .filter_map(|(shader, encoding)| {
            let invalid = validate(&shader.source_in(encoding), capabilities(shader.needs)).err()?;
            Some(format!("{}, {}:\n{invalid}", shader.name, encoding.name()))
        })
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Metal and DX12 are not there where tests run; their languages are.
#[test]
fn all_modules_are_translated_for_every_api() {
    let failures: Vec<_> = shaders::ALL
        .iter()
        .flat_map(|shader| [Encoding::Wide, Encoding::Packed].map(|encoding| (shader, encoding)))
        .filter_map(|(shader, encoding)| {
            let failure = translate(&shader.source_in(encoding), capabilities(shader.needs)).err()?;
            Some(format!("{}, {}: {failure}", shader.name, encoding.name()))
        })
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn validation_can_fail() {
    let shader = &shaders::EARLY_Z;
    assert!(validate(&shader.source(), Capabilities::empty()).is_err(), "64-bit atomics need a capability");
    let broken = shaders::CLEAR.source().replace("vec2<u32>(0xffffffffu)", "vec2<f32>(0.0)");
    assert!(validate(&broken, Capabilities::empty()).is_err());
}

/// Names and offsets of the members of a WGSL struct, and its size.
fn layout_of(shader: &Shader, name: &str) -> (Vec<(String, u32)>, u32) {
    let module = validate(&shader.source(), capabilities(shader.needs)).expect("a valid module");
    let (_, ty) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).expect("the struct exists");
    let naga::TypeInner::Struct { members, span } = &ty.inner else { panic!("{name} is a struct") };
    (members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset)).collect(), *span)
}

macro_rules! host_layout {
    ($ty:ty: $($field:ident),+) => {
        (vec![$((stringify!($field).to_owned(), offset_of!($ty, $field) as u32)),+], size_of::<$ty>() as u32)
    };
}

/// No kernel asks for more than WebGPU promises.
#[test]
fn eight_storage_buffers_are_enough() {
    for shader in shaders::ALL {
        let module = validate(&shader.source(), capabilities(shader.needs)).expect("a valid module");
        let is_storage = |space: &naga::AddressSpace| matches!(space, naga::AddressSpace::Storage { .. });
        let count = module.global_variables.iter().filter(|(_, variable)| is_storage(&variable.space)).count();
        assert!(count <= 8, "{}: {count} storage buffers", shader.name);
    }
}

#[test]
fn host_structs_have_the_layout_of_the_shaders() {
    assert_eq!(
        layout_of(&shaders::CLEAR, "View"),
        host_layout!(View: row_x, row_y, row_w, eye_high, width, eye_low, height, eye_fraction, point_size)
    );
    assert_eq!(
        layout_of(&shaders::INSERT, "Insertion"),
        host_layout!(InsertionUniform: old_points, new_points, left_bits, right_bits, keys, fresh_before, staging_capacity, domain, shift)
    );
    assert_eq!(layout_of(&shaders::MOVE, "Page"), host_layout!(PageUniform: base, first, bits, len));
    assert_eq!(layout_of(&shaders::RESOLVE, "FileColor"), host_layout!(FileColor: first_record, kind, low, high));
    assert_eq!(layout_of(&shaders::RESOLVE, "ColorTables"), host_layout!(ColorTablesUniform: thresholds, ramp));
    assert_eq!(layout_of(&shaders::COLUMN, "ColumnColors"), host_layout!(ColumnScaleUniform: high, low, colors));
    assert_eq!(
        layout_of(&shaders::PICK, "Pick"),
        host_layout!(PickWords: width, height, x, y, reach, pixel, slot, depth, record, position_x, position_y, position_z)
    );
    assert_eq!(
        layout_of(&shaders::LIGHT, "Shading"),
        host_layout!(ShadingUniform: edl_factor, background, unused_a, unused_b)
    );
}

#[test]
fn constants_are_the_hosts() {
    let source = shaders::INSERT.source();
    assert!(source.contains(&format!("const GROUP: u32 = {}u;", firstlight::gpu::kernel::GROUP)));
    assert!(source.contains(&format!("const ROUNDS: u32 = {}u;", firstlight::store::ROUNDS)));
    let window = format!("const AVERAGED_DEPTH: f32 = {};", firstlight::render::AVERAGED_DEPTH);
    let most = format!("const MOST_FRAGMENTS: u32 = {}u << 20u;", firstlight::render::MOST_FRAGMENTS >> 20);
    let [r, g, b] = firstlight::render::NO_DATA;
    let no_data = format!("const NO_DATA: u32 = 0x{b:02x}{g:02x}{r:02x}u;");
    assert!(shaders::RESOLVE.source().contains(&no_data));
    for shader in [shaders::AVERAGE_32, shaders::AVERAGE_64] {
        assert!(shader.source().contains(&window) && shader.source().contains(&most), "{}", shader.name);
    }
}
