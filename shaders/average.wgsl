// Second geometry pass of high-quality shading (Schütz and Wimmer 2019): every fragment within 1 % behind
// the front depth of its pixel enters the pixel's sums. The front point itself stays out; the resolve pass
// adds it, so that no pixel is without a colour. `add_fragment` comes from sums_*.wgsl. Integer sums:
// the order of threads changes nothing. Twin: src/render/cpu/average.rs.
@group(0) @binding(1) var<storage, read> words: array<vec2<u32>>;
// What `from_span` adds in this frame: slots [x, y) and [z, w). A list may hold some of them.
@group(0) @binding(3) var<uniform> span_slots: vec4<u32>;

struct Span {
    first: u32,
    count: u32,
    unused_a: u32,
    unused_b: u32,
}
@group(2) @binding(0) var<uniform> span: Span;
@group(2) @binding(1) var<storage, read> list: array<u32>;
// A uniform: there is no room for a ninth storage buffer.
@group(2) @binding(2) var<uniform> list_count: vec4<u32>;

// Of the bound page, see hidden.wgsl.
@group(1) @binding(4) var<storage, read> hidden: array<u32>;

// `AVERAGED_DEPTH` in src/render/shading.rs.
const AVERAGED_DEPTH: f32 = 1.01;

fn add_slot(slot: u32) {
    let local = slot - page.first;
    if local >= page.len || !is_shown(local) {
        return;
    }
    let point = project(load_position(local));
    if !point.is_inside {
        return;
    }
    var color = vec3<u32>(0u);
    var has_color = false;
    let last = min(point.corner + i32(point.size), vec2<i32>(i32(view.width), i32(view.height)));
    for (var y = max(point.corner.y, 0); y < last.y; y++) {
        for (var x = max(point.corner.x, 0); x < last.x; x++) {
            let pixel = u32(y) * view.width + u32(x);
            let word = words[pixel];
            if word.x != slot && point.depth <= far_as(bitcast<f32>(word.y), AVERAGED_DEPTH) {
                // Most points are hidden: nobody asks for their colours.
                if !has_color {
                    let packed = color_of(local);
                    color = vec3<u32>(packed & 0xffu, (packed >> 8u) & 0xffu, (packed >> 16u) & 0xffu);
                    has_color = true;
                }
                add_fragment(pixel, color);
            }
        }
    }
}

@compute @workgroup_size(256)
fn from_list(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = line_index(group, groups, local);
    if i < list_count.x {
        let slot = list[i];
        let is_in_span = (slot >= span_slots.x && slot < span_slots.y) || (slot >= span_slots.z && slot < span_slots.w);
        if !is_in_span {
            add_slot(slot);
        }
    }
}

@compute @workgroup_size(256)
fn from_span(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = line_index(group, groups, local);
    if i < span.count {
        add_slot(span.first + i);
    }
}
