// The hardware rasterizer. First the depth test decides each pixel's depth, then `claim` writes the
// smallest slot of that depth, so that points of equal depth give the same picture in any order of
// drawing. Points are placed, without perspective, at centres of pixels that `project` chose, so that
// the hardware's own rounding decides nothing. Depth is linear, scaled by a power of two: no bit is lost.
@group(0) @binding(1) var<storage, read_write> words: array<atomic<u32>>;

// Of the bound page, see hidden.wgsl.
@group(1) @binding(2) var<storage, read> hidden: array<u32>;

struct Vertex {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) @interpolate(flat, either) slot: u32,
    @location(1) @interpolate(flat, either) depth: f32,
    // As the depth test saw it.
    @location(2) @interpolate(flat, either) tested: f32,
}

// One instance for each pixel of the largest point's square.
@vertex
fn place(@builtin(vertex_index) slot: u32, @builtin(instance_index) instance: u32) -> Vertex {
    var vertex: Vertex;
    vertex.slot = slot;
    vertex.position = vec4<f32>(2.0, 2.0, 2.0, 1.0);
    let local = slot - page.first;
    if local >= page.len || !is_shown(local) {
        return vertex;
    }
    let point = project(load_position(local));
    let at = vec2<u32>(instance % view.point_size, instance / view.point_size);
    let pixel = point.corner + vec2<i32>(at);
    let size = vec2<i32>(i32(view.width), i32(view.height));
    if !point.is_inside || any(at >= vec2<u32>(point.size)) || any(pixel < vec2<i32>(0)) || any(pixel >= size) {
        return vertex;
    }
    let ndc = (vec2<f32>(pixel) + 0.5) / vec2<f32>(size) * 2.0 - 1.0;
    vertex.position = vec4<f32>(ndc.x, -ndc.y, point.depth * view.row_w.w, 1.0);
    vertex.depth = point.depth;
    vertex.tested = vertex.position.z;
    return vertex;
}

@group(2) @binding(0) var depths: texture_depth_2d;

@fragment
fn claim(vertex: Vertex) {
    let at = vec2<u32>(vertex.position.xy);
    if textureLoad(depths, at, 0) == vertex.tested {
        let pixel = at.y * view.width + at.x;
        atomicStore(&words[2u * pixel + 1u], bitcast<u32>(vertex.depth));
        atomicMin(&words[2u * pixel], vertex.slot);
    }
}
