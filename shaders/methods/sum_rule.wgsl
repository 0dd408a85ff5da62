// Schütz and Wimmer 2019, high-quality shading: all fragments within 1 % behind the front depth of their
// pixel are averaged. The first pass, plot_depth_32.wgsl, left the front depth.
@group(0) @binding(1) var<storage, read_write> words: array<vec2<u32>>;

fn is_blended(pixel: u32, depth: f32) -> bool {
    return depth <= bitcast<f32>(words[pixel].y) * 1.01;
}

fn color_of(slot: u32) -> vec3<u32> {
    let color = load_color(slot - page.first);
    return vec3<u32>(color & 0xffu, (color >> 8u) & 0xffu, (color >> 16u) & 0xffu);
}
