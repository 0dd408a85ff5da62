// One 64-bit word: 18 bits each of red, green and blue, 10 of fragments in the lowest. Wrong beyond
// 1,023 fragments in a pixel, where the count starts again and carries into blue.
@group(0) @binding(4) var<storage, read_write> accumulators: array<atomic<u64>>;

fn plot(pixel: u32, depth: f32, slot: u32) {
    if is_blended(pixel, depth) {
        let color = color_of(slot);
        atomicAdd(&accumulators[pixel], (u64(color.x) << 46u) | (u64(color.y) << 28u) | (u64(color.z) << 10u) | 1lu);
    }
}
