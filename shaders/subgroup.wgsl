// Points of a subgroup that meet in one pixel. Only the threads take part that come here at the same time.
const NO_SLOT: u32 = 0xffffffffu;

// Draws the front one of all points here, which are of one pixel: of the smallest depth, whose bits have
// their order, the lowest slot.
fn put_front(pixel: u32, depth: f32, slot: u32) {
    let bits = bitcast<u32>(depth);
    let front = subgroupMin(bits);
    if slot == subgroupMin(select(NO_SLOT, slot, bits == front)) {
        put(pixel, depth, slot);
    }
}
