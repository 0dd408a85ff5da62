// From the textures of points.wgsl to words.
@group(2) @binding(0) var depths: texture_depth_2d;
@group(2) @binding(1) var slots: texture_2d<u32>;

@compute @workgroup_size(256)
fn collect(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let pixel = line_index(group, groups, thread);
    if is_pixel(pixel) {
        let at = vec2<u32>(pixel % view.width, pixel / view.width);
        let depth = textureLoad(depths, at, 0);
        if depth < 1.0 {
            words[pixel] = vec2<u32>(textureLoad(slots, at, 0).x, bitcast<u32>(depth / view.row_w.w));
        }
    }
}
