// The four sums of plot_hqs.wgsl in two 64-bit words: red below green, blue below fragments. The first
// sum to overflow, at 16.8 million fragments, adds one to its neighbour.
@group(0) @binding(3) var<storage, read_write> sums: array<atomic<u64>>;

fn plot(pixel: u32, depth: f32, slot: u32) {
    if is_blended(pixel, depth) {
        let color = color_of(slot);
        atomicAdd(&sums[2u * pixel], (u64(color.y) << 32u) | u64(color.x));
        atomicAdd(&sums[2u * pixel + 1u], (1lu << 32u) | u64(color.z));
    }
}
