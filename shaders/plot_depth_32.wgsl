// First of two passes without 64-bit atomics: the upper half of each word, the depth.
@group(0) @binding(1) var<storage, read_write> words: array<atomic<u32>>;

fn plot(pixel: u32, depth: f32, slot: u32) {
    let bits = bitcast<u32>(depth);
    if bits < depth_seen(pixel) {
        atomicMin(&words[2u * pixel + 1u], bits);
    }
}
