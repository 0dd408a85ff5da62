// 8 bytes a point, see packed.wgsl. Colours have a buffer of their own. `local` counts from the page's first point.
//
// The bits are known when the pipeline is made, so that the compiler leaves out what no field needs. With
// IS_NEAR of project.wgsl: 514 billion points/s on an H200 with nothing in the picture, without both 375.
override bits_x: u32 = 0u;
override bits_y: u32 = 0u;
override bits_z: u32 = 0u;

@group(1) @binding(1) var<storage, read> points: array<vec2<u32>>;
@group(1) @binding(2) var<storage, read> colors: array<u32>;

fn load_position(local: u32) -> vec3<i32> {
    return unpack_position(points[local], page.base, vec3<u32>(bits_x, bits_y, bits_z));
}

fn load_color(local: u32) -> u32 {
    return colors[local];
}
