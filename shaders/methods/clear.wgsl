// Empties the targets: `words` for all methods, `sums` for those that have more than words.
@compute @workgroup_size(256)
fn clear_words(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let pixel = line_index(group, groups, thread);
    if is_pixel(pixel) {
        words[pixel] = vec2<u32>(NONE);
        rgba[pixel] = 0u;
    }
}

@compute @workgroup_size(256)
fn clear_sums(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let pixel = line_index(group, groups, thread);
    if is_pixel(pixel) {
        sums[pixel] = vec4<u32>(0u);
        accumulators[pixel] = vec2<u32>(0u);
    }
}

// Where kernels that identify the shown point write: no point yet.
@compute @workgroup_size(256)
fn clear_shown(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let pixel = line_index(group, groups, thread);
    if is_pixel(pixel) {
        accumulators[pixel] = vec2<u32>(NONE);
    }
}
