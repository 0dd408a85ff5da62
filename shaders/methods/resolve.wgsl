// From words to colours. `point_color` for words that name a point, page by page; the others once.
@compute @workgroup_size(256)
fn point_color(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let pixel = line_index(group, groups, thread);
    if is_pixel(pixel) && words[pixel].x != NONE {
        let local = words[pixel].x - page.first;
        if local < page.len {
            rgba[pixel] = load_color(local) | OPAQUE;
        }
    }
}

// The colour in the word itself.
@compute @workgroup_size(256)
fn word_color(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let pixel = line_index(group, groups, thread);
    if is_pixel(pixel) && any(words[pixel] != vec2<u32>(NONE)) {
        rgba[pixel] = (words[pixel].x & 0xffffffu) | OPAQUE;
    }
}

// Rounded to the nearest; black where an overflow left no fragments.
fn average(sum: vec3<u32>, count: u32) -> u32 {
    if count == 0u {
        return OPAQUE;
    }
    let mean = min((sum + count / 2u) / count, vec3<u32>(255u));
    return mean.x | (mean.y << 8u) | (mean.z << 16u) | OPAQUE;
}

@compute @workgroup_size(256)
fn average_sums(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let pixel = line_index(group, groups, thread);
    if is_pixel(pixel) && words[pixel].y != NONE {
        rgba[pixel] = average(sums[pixel].xyz, sums[pixel].w);
    }
}

// As plot_hqs1.wgsl: 18-18-18-10 bits.
@compute @workgroup_size(256)
fn average_18_bits(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let pixel = line_index(group, groups, thread);
    if is_pixel(pixel) && words[pixel].y != NONE {
        let word = accumulators[pixel];
        let green = ((word.y & 0x3fffu) << 4u) | (word.x >> 28u);
        rgba[pixel] = average(vec3<u32>(word.y >> 14u, green, (word.x >> 10u) & 0x3ffffu), word.x & 0x3ffu);
    }
}

// As plot_hqs1r.wgsl: 16 bits each, or the sums after a hand-over.
@compute @workgroup_size(256)
fn average_16_bits(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let pixel = line_index(group, groups, thread);
    if is_pixel(pixel) && words[pixel].y != NONE {
        let word = accumulators[pixel];
        if sums[pixel].w > 0u {
            rgba[pixel] = average(sums[pixel].xyz, sums[pixel].w);
        } else {
            rgba[pixel] = average(vec3<u32>(word.y >> 16u, word.y & 0xffffu, word.x >> 16u), word.x & 0xffffu);
        }
    }
}
