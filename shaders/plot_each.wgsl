// An atomic operation for every point.
fn plot(pixel: u32, depth: f32, slot: u32) {
    put(pixel, depth, slot);
}
