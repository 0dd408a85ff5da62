// An atomic operation only where the early test leaves a chance.
fn plot(pixel: u32, depth: f32, slot: u32) {
    if may_win(pixel, depth) {
        put(pixel, depth, slot);
    }
}
