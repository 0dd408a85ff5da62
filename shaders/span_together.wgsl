// Rasterizes a range of slots; the threads of a subgroup compare theirs before they touch memory.
// `plot_together` comes from reduce.wgsl or dedup.wgsl. Points of several pixels go pixel by pixel of
// their squares, all threads in step: those in one pixel there have one corner.
@compute @workgroup_size(SPAN_GROUP)
fn from_span(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32, @builtin(subgroup_invocation_id) lane: u32, @builtin(subgroup_size) lanes: u32) {
    let i = span_index(group, groups, thread);
    let slot = span.first + i;
    var point: Projected;
    if i < span.count {
        point = project_slot(slot);
    }
    let size = vec2<i32>(i32(view.width), i32(view.height));
    for (var offset = 0u; offset < view.point_size * view.point_size; offset++) {
        let at = point.corner + vec2<i32>(vec2<u32>(offset % view.point_size, offset / view.point_size));
        var fragment = Fragment(NO_PIXEL, point.depth, slot);
        if point.is_inside && all(at >= vec2<i32>(0)) && all(at < size) {
            fragment.pixel = u32(at.y) * view.width + u32(at.x);
        }
        plot_together(fragment, lane, lanes);
    }
}
