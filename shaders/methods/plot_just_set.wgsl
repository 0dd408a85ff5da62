// A plain store and no depth: whoever writes last is shown. Wrong on purpose; no method can write
// less. Unordered: any point of a pixel may be shown.
@group(0) @binding(1) var<storage, read_write> words: array<u32>;

fn plot(pixel: u32, depth: f32, slot: u32) {
    words[2u * pixel] = slot;
}
