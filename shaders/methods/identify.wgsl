// Depth of the point that a word names, for methods that store none or another; page by page. Not part
// of a frame.
@compute @workgroup_size(256)
fn depth_of_point(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let pixel = line_index(group, groups, thread);
    if is_pixel(pixel) && words[pixel].x != NONE {
        let local = words[pixel].x - page.first;
        if local < page.len {
            words[pixel].y = bitcast<u32>(project(load_position(local)).depth);
        }
    }
}
