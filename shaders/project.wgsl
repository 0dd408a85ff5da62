// From an integer grid position to a pixel. Twin: `View::project` in src/render/view.rs; nobody
// else computes a pixel.
// Each number is told at `View` in src/render/view.rs.
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
    // Upper left pixel of the point's square; may be outside by up to size - 1.
    corner: vec2<i32>,
    // Distance along the viewing direction.
    depth: f32,
    // Width of the square.
    size: u32,
    is_inside: bool,
}

// What hangs on the view is selected: lavapipe 22.3 compiles a kernel anew for each dispatch where a branch does.
fn is_orthographic() -> bool {
    return view.row_x.w > 0.0;
}

// Pixels of a point's width at a depth.
fn point_size_at(depth: f32) -> u32 {
    let sized = u32(clamp(view.row_y.w / depth + 0.5, 1.0, f32(view.point_size)));
    return select(view.point_size, sized, view.row_y.w > 0.0 && !is_orthographic());
}

// How many times as far as `front` something at `depth` counts as; see `View::times_as_far`.
fn times_as_far(depth: f32, front: f32) -> f32 {
    return select(depth / front, 1.0 + (depth - front) / view.row_y.w, is_orthographic());
}

// The depth that counts as `times` as far as `front`.
fn far_as(front: f32, times: f32) -> f32 {
    return select(front * times, front + view.row_y.w * (times - 1.0), is_orthographic());
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
    let depth = row_dot(view.row_w, d) + view.row_x.w;
    if !(depth > 0.0) {
        return projected;
    }
    let divisor = select(depth, 1.0, is_orthographic());
    let size = point_size_at(depth);
    let half = 0.5 * f32(size - 1u);
    let x = (row_dot(view.row_x, d) / divisor * 0.5 + 0.5) * f32(view.width) - half;
    let y = (row_dot(view.row_y, d) / divisor * 0.5 + 0.5) * f32(view.height) - half;
    let edge = 1.0 - f32(size);
    if !(x >= edge && x < f32(view.width) && y >= edge && y < f32(view.height)) {
        return projected;
    }
    projected.corner = vec2<i32>(floor(vec2<f32>(x, y)));
    projected.depth = depth;
    projected.size = size;
    projected.is_inside = true;
    return projected;
}
