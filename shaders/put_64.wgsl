// One 64-bit word a pixel, depth above slot: the smallest wins.
@group(0) @binding(1) var<storage, read_write> words: array<atomic<u64>>;

fn put(pixel: u32, depth: f32, slot: u32) {
    atomicMin(&words[pixel], (u64(bitcast<u32>(depth)) << 32u) | u64(slot));
}
