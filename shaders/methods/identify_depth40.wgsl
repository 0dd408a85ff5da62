// The word names no point: the first whose word it is. Not part of a frame.
@group(0) @binding(1) var<storage, read_write> words: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read_write> shown: array<atomic<u32>>;

fn plot(pixel: u32, depth: f32, slot: u32) {
    let word = word_of(slot);
    if all(words[pixel] == vec2<u32>(u32(word), u32(word >> 32u))) {
        atomicMin(&shown[2u * pixel], slot);
    }
}
