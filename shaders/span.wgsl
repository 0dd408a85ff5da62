// Rasterizes a range of slots, a thread for each.
@compute @workgroup_size(SPAN_GROUP)
fn from_span(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let i = span_index(group, groups, thread);
    if i < span.count {
        plot_slot(span.first + i);
    }
}
