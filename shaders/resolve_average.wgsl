// High-quality shading's colour: the mean of the front point and all fragments in the sums, rounded to
// the nearest. Twin: `average` in src/render/shading.rs.
@compute @workgroup_size(256)
fn color_average(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = line_index(group, groups, local);
    let slot = shown_slot(pixel);
    if slot < page.len {
        let front = color_of(slot);
        let sum = sums_of(pixel) + vec4<u32>(front & 0xffu, (front >> 8u) & 0xffu, (front >> 16u) & 0xffu, 1u);
        let mean = (sum.xyz + sum.w / 2u) / sum.w;
        colors[pixel] = mean.x | (mean.y << 8u) | (mean.z << 16u) | OPAQUE;
    }
}
