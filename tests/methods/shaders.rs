//! Every kernel is valid WGSL in both encodings and needs no more than it says, and every struct that
//! the host fills has the layout that the shaders read. Needs no GPU.

use std::mem::offset_of;

use firstlight::{
    methods::{
        Depth40, Encoding, Launch, METHODS,
        modules::{self, Kernel},
    },
    render::View,
    store::gpu::PageUniform,
};
use naga::valid::Capabilities;

use crate::wgsl::{capabilities, translate, validate};

const ENCODINGS: [Encoding; 2] = [Encoding::Wide, Encoding::Packed];

#[test]
fn all_kernels_are_valid_in_both_encodings() {
    let mut failures = Vec::new();
    for kernel in modules::ALL {
        for (encoding, launch) in ENCODINGS.iter().flat_map(|&e| [(e, Launch::PLAIN), (e, Launch::tuned(e))]) {
            match validate(&kernel.source(encoding, launch), capabilities(kernel.needs)) {
                Err(error) => failures.push(format!("{} {encoding:?}:\n{error}", kernel.name)),
                Ok(module) => {
                    if let Err(error) = translate(&kernel.source(encoding, launch), capabilities(kernel.needs)) {
                        failures.push(format!("{} {encoding:?}: {error}", kernel.name));
                    }
                    assert!(
                        module.entry_points.iter().any(|entry| entry.name == kernel.entry),
                        "{} has an entry point {}",
                        kernel.name,
                        kernel.entry
                    );
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// A kernel that says that it needs a feature is not valid without it; so the table asks for no more
/// than the kernels use.
#[test]
fn kernels_need_what_they_say() {
    for kernel in modules::ALL {
        for (feature, capability) in [
            (wgpu::Features::SHADER_INT64, Capabilities::SHADER_INT64),
            (wgpu::Features::SUBGROUP, Capabilities::SUBGROUP),
        ] {
            if kernel.needs.contains(feature) {
                let less = capabilities(kernel.needs) - capability;
                assert!(
                    validate(&kernel.source(Encoding::Wide, Launch::PLAIN), less).is_err(),
                    "{} without {capability:?}",
                    kernel.name
                );
            }
        }
    }
}

#[test]
fn the_table_needs_what_its_kernels_need() {
    let needs = |name: &str| firstlight::methods::by_name(name).map(|method| method.needs.to_string());
    assert_eq!(needs("just-set").as_deref(), Some("nothing beyond WebGPU"));
    assert_eq!(needs("reduce").as_deref(), Some("64-bit atomic minimum, subgroups"));
    assert_eq!(needs("hqs1r").as_deref(), Some("64-bit atomics"));
    assert_eq!(needs("points").as_deref(), Some("storage buffers in vertex shaders"));
    for method in METHODS {
        for kernel in method.kernels() {
            assert_eq!(method.needs.features & kernel.needs, kernel.needs, "{}: {}", method.name, kernel.name);
        }
        let all = method.kernels().iter().fold(wgpu::Features::empty(), |all, kernel| all | kernel.needs);
        assert_eq!(all, method.needs.features, "{} asks for what none of its kernels needs", method.name);
    }
}

#[test]
fn names_are_unique() {
    for (index, method) in METHODS.iter().enumerate() {
        assert!(METHODS[index + 1..].iter().all(|other| other.name != method.name), "{}", method.name);
        assert_eq!(firstlight::methods::by_name(method.name).map(|found| found.name), Some(method.name));
    }
    assert!(firstlight::methods::by_name("atomic_min").is_none());
}

/// Names and offsets of the members of a WGSL struct, and its size.
fn layout_of(kernel: &Kernel, name: &str) -> (Vec<(String, u32)>, u32) {
    let module =
        validate(&kernel.source(Encoding::Packed, Launch::PLAIN), capabilities(kernel.needs)).expect("a valid module");
    let (_, ty) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).expect("the struct exists");
    let naga::TypeInner::Struct { members, span } = &ty.inner else { panic!("{name} is a struct") };
    (members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset)).collect(), *span)
}

macro_rules! host_layout {
    ($ty:ty: $($field:ident),+) => {
        (vec![$((stringify!($field).to_owned(), offset_of!($ty, $field) as u32)),+], size_of::<$ty>() as u32)
    };
}

#[test]
fn host_structs_have_the_layout_of_the_shaders() {
    let kernel = &modules::DEPTH40;
    assert_eq!(layout_of(kernel, "Page"), host_layout!(PageUniform: base, first, bits, len));
    assert_eq!(layout_of(kernel, "Depth40"), host_layout!(Depth40: row_low, unused_a, row_high, unused_b));
    assert_eq!(
        layout_of(kernel, "View"),
        host_layout!(View: row_x, row_y, row_w, eye_high, width, eye_low, height, eye_fraction, point_size)
    );
}
