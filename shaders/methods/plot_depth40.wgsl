// One 64-bit word a pixel: 40 bits of depth above 24 of colour. Of points that are equally deep the one
// whose colour is the smallest number is shown.
@group(0) @binding(1) var<storage, read_write> words: array<atomic<u64>>;

fn plot(pixel: u32, depth: f32, slot: u32) {
    let word = word_of(slot);
    if u32(word >> 32u) <= seen[pixel].y {
        atomicMin(&words[pixel], word);
    }
}
