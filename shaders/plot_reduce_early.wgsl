// First the early test, which most points do not pass.
fn plot(pixel: u32, depth: f32, slot: u32) {
    if may_win(pixel, depth) {
        put_reduced(pixel, depth, slot);
    }
}
