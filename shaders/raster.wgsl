// Rasterizes slots of a list whose points lie in the bound page; `from_span`, in span.wgsl and
// span_together.wgsl, does those of a range. `plot` comes from plot_*.wgsl. Twin: src/render/cpu.
struct Span {
    first: u32,
    count: u32,
    unused_a: u32,
    unused_b: u32,
}

@group(2) @binding(0) var<uniform> span: Span;
@group(2) @binding(1) var<storage, read> list: array<u32>;
@group(2) @binding(2) var<storage, read> list_count: array<u32>;

// Threads in a workgroup of `from_span`: which number is fastest differs from device to device.
override SPAN_GROUP: u32 = 256u;

// As `line_index`.
fn span_index(group: vec3<u32>, groups: vec3<u32>, thread: u32) -> u32 {
    return (group.y * groups.x + group.x) * SPAN_GROUP + thread;
}

// Nowhere if the page doesn't hold the slot.
fn project_slot(slot: u32) -> Projected {
    var point: Projected;
    let local = slot - page.first;
    if local < page.len {
        point = project(load_position(local));
    }
    return point;
}

fn plot_slot(slot: u32) {
    let point = project_slot(slot);
    if !point.is_inside {
        return;
    }
    let last = min(point.corner + i32(view.point_size), vec2<i32>(i32(view.width), i32(view.height)));
    for (var y = max(point.corner.y, 0); y < last.y; y++) {
        for (var x = max(point.corner.x, 0); x < last.x; x++) {
            plot(u32(y) * view.width + u32(x), point.depth, slot);
        }
    }
}

@compute @workgroup_size(256)
fn from_list(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = line_index(group, groups, local);
    if i < list_count[0] {
        plot_slot(list[i]);
    }
}
