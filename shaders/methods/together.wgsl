// As each.wgsl; `plot_together` comes from reduce.wgsl or dedup.wgsl.
@compute @workgroup_size(256)
fn draw(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32, @builtin(subgroup_invocation_id) lane: u32, @builtin(subgroup_size) lanes: u32) {
    let local = line_index(group, groups, thread);
    var fragment = Fragment(NO_PIXEL, 0.0, NO_SLOT);
    if local < page.len {
        let point = project(load_position(local));
        if point.is_inside {
            fragment = Fragment(u32(point.corner.y) * view.width + u32(point.corner.x), point.depth, page.first + local);
        }
    }
    plot_together(fragment, lane, lanes);
}
