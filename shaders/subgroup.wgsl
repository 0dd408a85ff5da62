// What a thread of a subgroup holds. All threads stay to the end, since they exchange values: one
// without a point has no pixel.
struct Fragment {
    pixel: u32,
    depth: f32,
    slot: u32,
}

const NO_PIXEL: u32 = 0xffffffffu;
const NO_SLOT: u32 = 0xffffffffu;

// The lowest slot of the smallest depth among the threads that take part. Depths are positive: their
// bits have their order.
fn front_slot(takes_part: bool, fragment: Fragment) -> u32 {
    let bits = select(0xffffffffu, bitcast<u32>(fragment.depth), takes_part);
    let front = subgroupMin(bits);
    return subgroupMin(select(NO_SLOT, fragment.slot, takes_part && bits == front));
}
