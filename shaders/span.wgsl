// Rasterizes a range of slots, all in the bound page. A thread draws four, all loaded before the first is
// drawn, so that it waits for memory once. For what that is worth see src/methods/mod.rs.
// Neighbouring threads load neighbouring points.

// Threads in a workgroup: which number is fastest differs from device to device.
override SPAN_GROUP: u32 = 256u;

@compute @workgroup_size(SPAN_GROUP)
fn from_span(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let a = (group.y * groups.x + group.x) * 4u * SPAN_GROUP + thread;
    if a >= span.count {
        return;
    }
    let b = a + SPAN_GROUP;
    let c = b + SPAN_GROUP;
    let d = c + SPAN_GROUP;
    let last = span.count - 1u;
    let start = span.first - page.first;
    let position_a = load_position(start + a);
    let position_b = load_position(start + min(b, last));
    let position_c = load_position(start + min(c, last));
    let position_d = load_position(start + min(d, last));
    if is_shown(start + a) {
        plot_point(position_a, span.first + a);
    }
    if b <= last && is_shown(start + b) {
        plot_point(position_b, span.first + b);
    }
    if c <= last && is_shown(start + c) {
        plot_point(position_c, span.first + c);
    }
    if d <= last && is_shown(start + d) {
        plot_point(position_d, span.first + d);
    }
}
