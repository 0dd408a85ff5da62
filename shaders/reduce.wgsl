// A subgroup whose points all fall into one pixel draws one of them. Otherwise neighbouring threads
// compare, and of two points in one pixel only the front one is drawn. For any subgroup size.
fn put_reduced(pixel: u32, depth: f32, slot: u32) {
    if subgroupAll(pixel == subgroupBroadcastFirst(pixel)) {
        put_front(pixel, depth, slot);
        return;
    }
    let bits = bitcast<u32>(depth);
    let other_pixel = subgroupShuffleXor(pixel, 1u);
    let other_bits = subgroupShuffleXor(bits, 1u);
    let other_slot = subgroupShuffleXor(slot, 1u);
    // The neighbour may have no point in the picture, or not exist.
    let other = lane ^ 1u;
    let is_there = ((subgroupBallot(true)[other / 32u] >> (other % 32u)) & 1u) == 1u;
    let is_behind = other_bits < bits || (other_bits == bits && other_slot < slot);
    if !(is_there && other_pixel == pixel && is_behind) {
        put(pixel, depth, slot);
    }
}
