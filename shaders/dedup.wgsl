// One atomic operation for each distinct pixel of a subgroup. WGSL has no partition instruction: each
// round, the threads look at the pixel of the first that is left. There are as many rounds as distinct
// pixels, at most as many as threads.
fn plot(pixel: u32, depth: f32, slot: u32) {
    var is_left = true;
    while is_left {
        if pixel == subgroupBroadcastFirst(pixel) {
            put_front(pixel, depth, slot);
            is_left = false;
        }
    }
}
