// Shows the resolved picture in the window, pixel for pixel.

struct Frame {
    size: vec2<u32>,
    // Shown where the window is larger than the picture; packed as in `picture`.
    background: u32,
    // 1 if the target turns linear values into sRGB on its own.
    target_is_srgb: u32,
}

// Red in the lowest byte, then green, blue, alpha; row by row from the top.
@group(0) @binding(0) var<storage, read> picture: array<u32>;
@group(0) @binding(1) var<uniform> frame: Frame;

@vertex
fn blit_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    // One triangle that covers the viewport.
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4<f32>(corner * 2.0 - 1.0, 0.0, 1.0);
}

fn linear_from_srgb(srgb: vec3<f32>) -> vec3<f32> {
    let high = pow((srgb + 0.055) / 1.055, vec3<f32>(2.4));
    return select(high, srgb / 12.92, srgb <= vec3<f32>(0.04045));
}

@fragment
fn blit_fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(position.xy);
    var packed = frame.background;
    if all(pixel < frame.size) {
        packed = picture[pixel.y * frame.size.x + pixel.x];
    }
    let srgb = unpack4x8unorm(packed).rgb;
    if frame.target_is_srgb == 1u {
        return vec4<f32>(linear_from_srgb(srgb), 1.0);
    }
    return vec4<f32>(srgb, 1.0);
}
