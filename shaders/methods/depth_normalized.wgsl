// Depth as a depth buffer has it, after the division by w: 0 at the near plane, 1 at infinity. All that
// is nearer than the near plane is equally near. row_w.w is above 1 / (largest depth) / 4.
fn depth_bits(depth: f32) -> u32 {
    let near = 1.4901161193847656e-8 / view.row_w.w;
    return bitcast<u32>(max(1.0 - near / depth, 0.0));
}
