// 8 bytes a point: the distances from the lowest corner, x in the lowest bits, y and z above. Colours
// have a buffer of their own. `local` counts from the page's first point.
//
// The bits are known when the pipeline is made, so that the compiler leaves out what no field needs. With
// IS_NEAR of project.wgsl: 514 billion points/s on an H200 with nothing in the picture, without both 375.
override bits_x: u32 = 0u;
override bits_y: u32 = 0u;
override bits_z: u32 = 0u;

@group(1) @binding(1) var<storage, read> points: array<vec2<u32>>;
@group(1) @binding(2) var<storage, read> colors: array<u32>;

// `bits` bits of the word, from bit `at` on; at most 32. A shift by 32 or more is no shift in WGSL.
fn field(word: vec2<u32>, at: u32, bits: u32) -> u32 {
    var value = word.y >> (at & 31u);
    if at < 32u {
        value = word.x >> at;
        if at > 0u {
            value |= word.y << (32u - at);
        }
    }
    return select(value & ((1u << (bits & 31u)) - 1u), value, bits >= 32u);
}

fn load_position(local: u32) -> vec3<i32> {
    let word = points[local];
    let above = vec3<u32>(field(word, 0u, bits_x), field(word, bits_x, bits_y), field(word, bits_x + bits_y, bits_z));
    // Wraps, so that a box wider than half of the integers works too.
    return page.base + bitcast<vec3<i32>>(above);
}

fn load_color(local: u32) -> u32 {
    return colors[local];
}
