// Rasterizes slots of a list whose points lie in the bound page; `from_span`, in span.wgsl, does those of a
// range. `plot` comes from plot_*.wgsl. Twin: src/render/cpu.
struct Span {
    first: u32,
    count: u32,
    unused_a: u32,
    unused_b: u32,
}

@group(2) @binding(0) var<uniform> span: Span;
@group(2) @binding(1) var<storage, read> list: array<u32>;
@group(2) @binding(2) var<uniform> list_count: vec4<u32>;

// Of the bound page, see hidden.wgsl.
@group(1) @binding(2) var<storage, read> hidden: array<u32>;

fn plot_point(position: vec3<i32>, slot: u32) {
    let point = project(position);
    if !point.is_inside {
        return;
    }
    let last = min(point.corner + i32(point.size), vec2<i32>(i32(view.width), i32(view.height)));
    for (var y = max(point.corner.y, 0); y < last.y; y++) {
        for (var x = max(point.corner.x, 0); x < last.x; x++) {
            plot(u32(y) * view.width + u32(x), point.depth, slot);
        }
    }
}

@compute @workgroup_size(256)
fn from_list(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = line_index(group, groups, local);
    if i < list_count.x {
        let slot = list[i];
        if slot - page.first < page.len && is_shown(slot - page.first) {
            plot_point(load_position(slot - page.first), slot);
        }
    }
}
