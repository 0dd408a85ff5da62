// Reads positions in the packed encoding, in the place of points.wgsl. The bits come from the page and are no
// constants of the pipeline as in methods/load_packed.wgsl: every scene has others, and compiling for each would
// keep its first picture waiting (100 ms for each kernel on an H200).
@group(1) @binding(1) var<storage, read> positions: array<vec2<u32>>;

// `local` counts from the page's first slot.
fn load_position(local: u32) -> vec3<i32> {
    return unpack_position(positions[local], page.base, page.bits);
}
