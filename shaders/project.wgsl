// From an integer grid position to a pixel. Twin: `View::project` in src/render/camera.rs; nobody
// else computes a pixel.
struct View {
    row_x: vec4<f32>,
    row_y: vec4<f32>,
    row_w: vec4<f32>,
    eye_high: vec3<i32>,
    width: u32,
    eye_low: vec3<i32>,
    height: u32,
    eye_fraction: vec3<f32>,
    point_size: u32,
}

@group(0) @binding(0) var<uniform> view: View;

struct Projected {
    // Upper left pixel of the point's square; may be outside by up to point_size - 1.
    corner: vec2<i32>,
    // Distance along the viewing direction.
    depth: f32,
    is_inside: bool,
}

fn row_dot(row: vec4<f32>, d: vec3<f32>) -> f32 {
    return (row.x * d.x + row.y * d.y) + row.z * d.z;
}

// Whether no position is 2^31 steps or more from the eye, see `View::is_near`. Not a member of `view`: where a
// branch hangs on a uniform alone, lavapipe 22.3 compiles the kernel anew for each dispatch, and keeps them all.
override IS_NEAR: bool = false;

// Whole grid steps from the eye, rounded once.
fn steps_from_eye(position: vec3<i32>) -> vec3<f32> {
    if IS_NEAR {
        return vec3<f32>(position - ((view.eye_high << vec3<u32>(16u)) + view.eye_low));
    }
    // The upper and lower 16 bits are subtracted as integers: no difference overflows, and the only
    // rounding is that of the sum.
    let high = vec3<f32>((position >> vec3<u32>(16u)) - view.eye_high);
    let low = vec3<f32>((position & vec3<i32>(0xffff)) - view.eye_low);
    return high * 65536.0 + low;
}

fn project(position: vec3<i32>) -> Projected {
    var projected: Projected;
    let d = steps_from_eye(position) - view.eye_fraction;
    let depth = row_dot(view.row_w, d);
    if !(depth > 0.0) {
        return projected;
    }
    let half = 0.5 * f32(view.point_size - 1u);
    let x = (row_dot(view.row_x, d) / depth * 0.5 + 0.5) * f32(view.width) - half;
    let y = (row_dot(view.row_y, d) / depth * 0.5 + 0.5) * f32(view.height) - half;
    let edge = 1.0 - f32(view.point_size);
    if !(x >= edge && x < f32(view.width) && y >= edge && y < f32(view.height)) {
        return projected;
    }
    projected.corner = vec2<i32>(floor(vec2<f32>(x, y)));
    projected.depth = depth;
    projected.is_inside = true;
    return projected;
}
