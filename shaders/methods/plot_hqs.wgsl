// Four 32-bit sums: red, green, blue, fragments. Exact to 16.8 million fragments in a pixel.
@group(0) @binding(3) var<storage, read_write> sums: array<atomic<u32>>;

fn plot(pixel: u32, depth: f32, slot: u32) {
    if is_blended(pixel, depth) {
        let color = color_of(slot);
        atomicAdd(&sums[4u * pixel], color.x);
        atomicAdd(&sums[4u * pixel + 1u], color.y);
        atomicAdd(&sums[4u * pixel + 2u], color.z);
        atomicAdd(&sums[4u * pixel + 3u], 1u);
    }
}
