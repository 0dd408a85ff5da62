// Every pixel to background: all bits set, farther than any depth.
@group(0) @binding(1) var<storage, read_write> words: array<vec2<u32>>;

@compute @workgroup_size(256)
fn clear(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = line_index(group, groups, local);
    if pixel < view.width * view.height {
        words[pixel] = vec2<u32>(0xffffffffu);
    }
}
