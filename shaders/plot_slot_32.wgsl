// Second of two passes: of the points with the pixel's depth, which no longer changes, the smallest slot.
@group(0) @binding(1) var<storage, read_write> words: array<atomic<u32>>;

fn plot(pixel: u32, depth: f32, slot: u32) {
    if bitcast<u32>(depth) == depth_seen(pixel) {
        atomicMin(&words[2u * pixel], slot);
    }
}
