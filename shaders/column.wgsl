// Colours by the keys of the bound page of a column, for pixels whose record it holds and that have a key; `blank` in
// resolve.wgsl has coloured all others. Twin: `ColumnColors::color` in src/render/column.rs.
@group(0) @binding(1) var<storage, read> words: array<vec2<u32>>;
@group(1) @binding(1) var<storage, read> keys: array<u32>;
@group(2) @binding(0) var<storage, read_write> colors: array<u32>;
// Which record each pixel shows; read only.
@group(2) @binding(1) var<storage, read_write> shown_records: array<u32>;

// Four numbers to a vector, for a uniform's arrays have no smaller step.
struct ColumnColors {
    high: array<vec4<u32>, 64>,
    low: array<vec4<u32>, 64>,
    colors: array<vec4<u32>, 64>,
}
@group(3) @binding(0) var<uniform> scale: ColumnColors;

const NONE: u32 = 0xffffffffu;
const OPAQUE: u32 = 0xff000000u;

// Where in the page the pixel's record is; beyond its length: nowhere.
fn place_of(pixel: u32) -> u32 {
    if pixel >= view.width * view.height || words[pixel].x == NONE {
        return NONE;
    }
    return shown_records[pixel] - column.first;
}

fn paint(pixel: u32, at: u32) {
    colors[pixel] = (scale.colors[at / 4u][at % 4u] & 0xffffffu) | OPAQUE;
}

@compute @workgroup_size(256)
fn by_table(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = line_index(group, groups, local);
    let at = place_of(pixel);
    if at < column.len {
        let key = keys[at];
        if key != 0u {
            let value = key - 1u;
            paint(pixel, (value + 61u * (value >> 8u)) & 0xffu);
        }
    }
}

fn small_level(key: u32) -> u32 {
    var at = 0u;
    for (var step = 128u; step > 0u; step >>= 1u) {
        let next = at + step;
        at = select(at, next, scale.low[next / 4u][next % 4u] <= key);
    }
    return at;
}

@compute @workgroup_size(256)
fn by_small_scale(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = line_index(group, groups, local);
    let at = place_of(pixel);
    if at < column.len {
        let key = keys[at];
        if key != 0u {
            paint(pixel, small_level(key));
        }
    }
}

fn wide_level(low: u32, high: u32) -> u32 {
    var at = 0u;
    for (var step = 128u; step > 0u; step >>= 1u) {
        let next = at + step;
        let least_high = scale.high[next / 4u][next % 4u];
        let least_low = scale.low[next / 4u][next % 4u];
        at = select(at, next, least_high < high || (least_high == high && least_low <= low));
    }
    return at;
}

@compute @workgroup_size(256)
fn by_wide_scale(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = line_index(group, groups, local);
    let at = place_of(pixel);
    if at < column.len {
        let low = keys[2u * at];
        let high = keys[2u * at + 1u];
        if (low | high) != 0u {
            paint(pixel, wide_level(low, high));
        }
    }
}
