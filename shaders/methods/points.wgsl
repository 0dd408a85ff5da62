// Hardware point lists with the depth test, the baseline. Points are placed, without perspective, at
// centres of pixels that `project` chose, so that the hardware's own rounding decides nothing. Depth is
// linear, scaled by a power of two: no bit is lost. Of equal depths the first drawn stays.
struct Vertex {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat, either) slot: u32,
}

@vertex
fn place(@builtin(vertex_index) local: u32) -> Vertex {
    var vertex = Vertex(vec4<f32>(2.0, 2.0, 2.0, 1.0), page.first + local);
    let point = project(load_position(local));
    if point.is_inside {
        let size = vec2<f32>(f32(view.width), f32(view.height));
        let ndc = (vec2<f32>(point.corner) + 0.5) / size * 2.0 - 1.0;
        vertex.position = vec4<f32>(ndc.x, -ndc.y, point.depth * view.row_w.w, 1.0);
    }
    return vertex;
}

@fragment
fn shade(vertex: Vertex) -> @location(0) u32 {
    return vertex.slot;
}
