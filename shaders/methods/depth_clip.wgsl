// Depth in clip space: the distance along the viewing direction.
fn depth_bits(depth: f32) -> u32 {
    return bitcast<u32>(depth);
}
