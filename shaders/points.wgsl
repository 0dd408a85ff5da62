// Reads positions in the wide encoding: three 32-bit integers. points_packed.wgsl reads the other one. The
// rasterizers and the resolve pass know no more of it; move.wgsl copies the words as they are.
@group(1) @binding(1) var<storage, read> positions: array<u32>;

// `local` counts from the page's first slot.
fn load_position(local: u32) -> vec3<i32> {
    return bitcast<vec3<i32>>(vec3<u32>(positions[3u * local], positions[3u * local + 1u], positions[3u * local + 2u]));
}
