// What the kernels that look at pixels, not at points, see of the targets.
@group(0) @binding(1) var<storage, read_write> words: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> sums: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> accumulators: array<vec2<u32>>;
// Red in the lowest byte; 0 where there is no point.
@group(0) @binding(6) var<storage, read_write> rgba: array<u32>;

const NONE: u32 = 0xffffffffu;
const OPAQUE: u32 = 0xff000000u;

fn is_pixel(pixel: u32) -> bool {
    return pixel < view.width * view.height;
}
