// One 64-bit word of 16 bits each of red, green, blue and, in the lowest, fragments, until 255 are in
// it. Whoever adds the 255th hands the sums over to the 32-bit sums of plot_hqs.wgsl; all later
// fragments go there too. No sum overflows before: 255 times 255 is below 65,536.
//
// Later fragments that looked before the hand-over still add to the word; it is no longer read. Exact
// while fewer than 65,281 threads are between their look and their addition in one pixel, where the
// count would start again.
@group(0) @binding(3) var<storage, read_write> sums: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> accumulators: array<atomic<u64>>;

const HAND_OVER: u32 = 255u;

fn add_sums(pixel: u32, color: vec3<u32>, count: u32) {
    atomicAdd(&sums[4u * pixel], color.x);
    atomicAdd(&sums[4u * pixel + 1u], color.y);
    atomicAdd(&sums[4u * pixel + 2u], color.z);
    atomicAdd(&sums[4u * pixel + 3u], count);
}

fn plot(pixel: u32, depth: f32, slot: u32) {
    if !is_blended(pixel, depth) {
        return;
    }
    let color = color_of(slot);
    if (u32(atomicLoad(&accumulators[pixel])) & 0xffffu) >= HAND_OVER {
        add_sums(pixel, color, 1u);
        return;
    }
    let fragment = (u64(color.x) << 48u) | (u64(color.y) << 32u) | (u64(color.z) << 16u) | 1lu;
    let before = atomicAdd(&accumulators[pixel], fragment);
    let count = u32(before) & 0xffffu;
    if count >= HAND_OVER {
        add_sums(pixel, color, 1u);
    } else if count == HAND_OVER - 1u {
        let full = before + fragment;
        let handed = vec3<u32>(u32(full >> 48u), u32(full >> 32u) & 0xffffu, u32(full >> 16u) & 0xffffu);
        add_sums(pixel, handed, HAND_OVER);
    }
}
