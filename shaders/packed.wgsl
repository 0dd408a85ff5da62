// 8 bytes a position: the distances from the base, x in the lowest bits, y and z above, in as many bits as each
// needs. Twin: `Packing` in src/store/packing.rs.

// `bits` bits of the word, from bit `at` on; at most 32. Without branches: where one hangs on a uniform alone,
// lavapipe 22.3 compiles the kernel anew for each dispatch.
fn field(word: vec2<u32>, at: u32, bits: u32) -> u32 {
    let shift = at & 31u;
    // A shift by 32 is no shift in WGSL, so the upper word goes up in two steps.
    let across = (word.x >> shift) | ((word.y << 1u) << (31u - shift));
    let mask = select((1u << (bits & 31u)) - 1u, 0xffffffffu, bits >= 32u);
    return select(across, word.y >> shift, at >= 32u) & mask;
}

fn unpack_position(word: vec2<u32>, base: vec3<i32>, bits: vec3<u32>) -> vec3<i32> {
    let above = vec3<u32>(field(word, 0u, bits.x), field(word, bits.x, bits.y), field(word, bits.x + bits.y, bits.z));
    // Wraps, so that a box wider than half of the integers works too.
    return base + bitcast<vec3<i32>>(above);
}
