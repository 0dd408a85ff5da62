// As each.wgsl, four points a thread: all four are loaded before the first is drawn, so that a thread
// waits for memory once. Neighbouring threads load neighbouring points.
fn draw_point(local: u32, position: vec3<i32>) {
    if local >= page.len {
        return;
    }
    let point = project(position);
    if point.is_inside {
        plot(u32(point.corner.y) * view.width + u32(point.corner.x), point.depth, page.first + local);
    }
}

@compute @workgroup_size(256)
fn draw(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let a = 4u * line_index(group, groups, 0u) + thread;
    let b = a + GROUP;
    let c = b + GROUP;
    let d = c + GROUP;
    if a >= page.len {
        return;
    }
    let last = page.len - 1u;
    let at_a = load_position(a);
    let at_b = load_position(min(b, last));
    let at_c = load_position(min(c, last));
    let at_d = load_position(min(d, last));
    draw_point(a, at_a);
    draw_point(b, at_b);
    draw_point(c, at_c);
    draw_point(d, at_d);
}
