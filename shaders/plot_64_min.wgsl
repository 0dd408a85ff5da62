// As plot_64.wgsl for devices that have no 64-bit atomics but minimum and maximum, such as Metal's: the
// word cannot be read first.
@group(0) @binding(1) var<storage, read_write> words: array<atomic<u64>>;

fn plot(pixel: u32, depth: f32, slot: u32) {
    atomicMin(&words[pixel], (u64(bitcast<u32>(depth)) << 32u) | u64(slot));
}
