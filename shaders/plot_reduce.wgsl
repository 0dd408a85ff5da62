fn plot(pixel: u32, depth: f32, slot: u32) {
    put_reduced(pixel, depth, slot);
}
