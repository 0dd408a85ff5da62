// One thread for each point of the bound page; `plot` comes from plot_*.wgsl.
@compute @workgroup_size(256)
fn draw(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let local = line_index(group, groups, thread);
    if local >= page.len {
        return;
    }
    let point = project(load_position(local));
    if point.is_inside {
        plot(u32(point.corner.y) * view.width + u32(point.corner.x), point.depth, page.first + local);
    }
}
