// Eye-dome lighting (Boucheny 2009, section 4): a pixel is darkened by neighbours nearer to the eye.
// Twin: `edl_shade` in src/render/shading.rs.
@group(0) @binding(1) var<storage, read> words: array<vec2<u32>>;

struct Shading {
    // Darkening per unit of response; 0 is none.
    edl_factor: f32,
    // Red in the lowest byte.
    background: u32,
    unused_a: u32,
    unused_b: u32,
}
@group(1) @binding(0) var<uniform> shading: Shading;
@group(1) @binding(1) var<storage, read> colors: array<u32>;
@group(1) @binding(2) var<storage, read_write> picture: array<u32>;

const NONE: u32 = 0xffffffffu;
const OPAQUE: u32 = 0xff000000u;
const EDL_LIMIT: f32 = 1e30;

@compute @workgroup_size(256)
fn light(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = line_index(group, groups, local);
    if pixel >= view.width * view.height {
        return;
    }
    let word = words[pixel];
    if word.x == NONE {
        picture[pixel] = shading.background | OPAQUE;
        return;
    }
    var color = colors[pixel];
    let depth = bitcast<f32>(word.y);
    // Not by the factor alone: where a branch hangs on a uniform and leaves less than half of a kernel, lavapipe
    // 22.3 compiles it anew for each dispatch, and keeps them all.
    if shading.edl_factor * depth > 0.0 {
        let shade = edl_shade(pixel, depth);
        let rgb = vec3<f32>(vec3<u32>(color, color >> 8u, color >> 16u) & vec3<u32>(255u));
        let lit = vec3<u32>(rgb * shade + 0.5);
        color = lit.x | (lit.y << 8u) | (lit.z << 16u) | OPAQUE;
    }
    picture[pixel] = color;
}

fn edl_shade(pixel: u32, depth: f32) -> f32 {
    let reach = i32(point_size_at(depth));
    let x = i32(pixel % view.width);
    let y = i32(pixel / view.width);
    var product = 1.0;
    for (var dy = -1; dy <= 1; dy++) {
        for (var dx = -1; dx <= 1; dx++) {
            let at = vec2<i32>(x + dx * reach, y + dy * reach);
            if at.x < 0 || at.y < 0 || at.x >= i32(view.width) || at.y >= i32(view.height) {
                continue;
            }
            let word = words[u32(at.y) * view.width + u32(at.x)];
            if word.x != NONE {
                product = min(product * max(1.0, times_as_far(depth, bitcast<f32>(word.y))), EDL_LIMIT);
            }
        }
    }
    return exp2(-shading.edl_factor * log2(product));
}
