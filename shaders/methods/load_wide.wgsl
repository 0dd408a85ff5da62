// 16 bytes a point: three 32-bit integers and the colour. `local` counts from the page's first point.
@group(1) @binding(1) var<storage, read> points: array<vec4<u32>>;

fn load_position(local: u32) -> vec3<i32> {
    return bitcast<vec3<i32>>(points[local].xyz);
}

fn load_color(local: u32) -> u32 {
    return points[local].w;
}
