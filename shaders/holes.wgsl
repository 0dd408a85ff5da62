// Hole filling (Rosenthal and Linsen 2008, section 4): a background pixel among the points of a surface takes the
// colour of the nearest of those around. Only the picture changes: words, and so records, depths and reprojection,
// stay. Reads pixels that show points and writes others, so that no order of threads changes anything. Twin:
// src/render/holes.rs.
@group(0) @binding(1) var<storage, read> words: array<vec2<u32>>;
@group(1) @binding(0) var<storage, read_write> picture: array<u32>;

const NONE: u32 = 0xffffffffu;
// As in src/render/holes.rs.
const REACH: i32 = 2;
const MASK: u32 = 3u;

@compute @workgroup_size(256)
fn fill_holes(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = line_index(group, groups, local);
    if pixel >= view.width * view.height || words[pixel].x != NONE {
        return;
    }
    let x = i32(pixel % view.width);
    let y = i32(pixel / view.width);
    var nearest = 3.4e38;
    var source = NONE;
    // Directions in turn, one bit each.
    var hits = 0u;
    for (var k = 0u; k < 8u; k++) {
        // Right, lower right, down, …
        var turn = array<i32, 8>(1, 1, 0, -1, -1, -1, 0, 1);
        let step = vec2<i32>(turn[k], turn[(k + 6u) % 8u]);
        for (var distance = 1; distance <= REACH; distance++) {
            let at = vec2<i32>(x, y) + step * distance;
            if at.x < 0 || at.y < 0 || at.x >= i32(view.width) || at.y >= i32(view.height) {
                break;
            }
            let other = u32(at.y) * view.width + u32(at.x);
            let word = words[other];
            if word.x == NONE {
                continue;
            }
            hits |= 1u << k;
            let depth = bitcast<f32>(word.y);
            if depth < nearest {
                nearest = depth;
                source = other;
            }
            break;
        }
    }
    // The masks: so many directions in a row without a point are the outside of a silhouette.
    let misses = ~hits & 0xffu;
    var outside = misses | (misses << 8u);
    for (var n = 1u; n < MASK; n++) {
        outside &= outside >> 1u;
    }
    if (outside & 0xffu) == 0u {
        picture[pixel] = picture[source];
    }
}
