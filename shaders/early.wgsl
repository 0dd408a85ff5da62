// The early test: what a pixel showed when last looked at. Depths only ever shrink while points are drawn, so
// that an old value lets too many points pass and never too few.
//
// This is the same buffer as `words`, read without atomics. Atomic loads pass by a GPU's nearest cache;
// plain ones hit it. H200, 130 million points in random order on 2,000 pixels: 241 billion points/s
// instead of 41. It also needs no more than the atomic minimum of a device.
@group(0) @binding(2) var<storage, read_write> seen: array<vec2<u32>>;

// Of equal depths the slot decides, which may be of another word than the depth here.
fn may_win(pixel: u32, depth: f32) -> bool {
    return bitcast<u32>(depth) <= seen[pixel].y;
}
