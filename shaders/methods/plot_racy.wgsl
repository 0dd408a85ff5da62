// Günther et al. 2013, Algorithm 1: compare, then write, with nothing to keep other threads out. Wrong
// on purpose. Unordered: any point of a pixel may be shown, with the depth of another.
@group(0) @binding(1) var<storage, read_write> words: array<u32>;

fn plot(pixel: u32, depth: f32, slot: u32) {
    let bits = bitcast<u32>(depth);
    if bits < words[2u * pixel + 1u] {
        words[2u * pixel + 1u] = bits;
        words[2u * pixel] = slot;
    }
}
