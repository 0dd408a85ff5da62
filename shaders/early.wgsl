// The early test: what a pixel showed when last looked at.
//
// This is the same buffer as `words`, read without atomics. Atomic loads pass by a GPU's nearest cache;
// plain ones hit it. H200, 130 million points in random order on 2,000 pixels: 241 billion points/s
// instead of 41. It also needs no more than the atomic minimum of a device.
//
// WGSL calls a plain read beside an atomic operation a race, and WebGPU forbids to bind one buffer twice
// where one is written; native devices do what follows. Only 32 bits are compared, which are written at
// once, and which only ever shrink between a clearing and the next, in other dispatches: an old value,
// or two reads made one by the compiler, let too many points pass and never too few, and those are
// decided by the atomic minimum. Methods for devices without 64-bit atomics, a browser's, go without,
// see seen_atomic.wgsl.
@group(0) @binding(2) var<storage, read_write> seen: array<vec2<u32>>;

fn depth_seen(pixel: u32) -> u32 {
    return seen[pixel].y;
}

// Of equal depths the slot decides, which may be of another word than the depth here.
fn may_win(pixel: u32, depth: f32) -> bool {
    return bitcast<u32>(depth) <= depth_seen(pixel);
}
