// One 64-bit word a pixel, depth above slot: the smallest wins. The plain read before it spares most
// atomic operations; a stale value only costs one.
@group(0) @binding(1) var<storage, read_write> words: array<atomic<u64>>;

fn plot(pixel: u32, depth: f32, slot: u32) {
    let word = (u64(bitcast<u32>(depth)) << 32u) | u64(slot);
    if word < atomicLoad(&words[pixel]) {
        atomicMin(&words[pixel], word);
    }
}
