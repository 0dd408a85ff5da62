// From slots to colours, for the points of the bound page.
@group(0) @binding(1) var<storage, read> words: array<vec2<u32>>;

// Red in the lowest byte, alpha 255.
@group(2) @binding(0) var<storage, read_write> colors: array<u32>;
@group(2) @binding(1) var<storage, read_write> shown_records: array<u32>;

const NONE: u32 = 0xffffffffu;
const OPAQUE: u32 = 0xff000000u;

fn shown_slot(pixel: u32) -> u32 {
    if pixel >= view.width * view.height || words[pixel].x == NONE {
        return NONE;
    }
    return words[pixel].x - page.first;
}

@compute @workgroup_size(256)
fn color(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = line_index(group, groups, local);
    let slot = shown_slot(pixel);
    if slot < page.len {
        colors[pixel] = color_of(slot) | OPAQUE;
    }
}

// Which record each pixel shows, for a picture that is read back.
@compute @workgroup_size(256)
fn identify(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = line_index(group, groups, local);
    let slot = shown_slot(pixel);
    if slot < page.len {
        shown_records[pixel] = records[slot];
    }
}

// For column.wgsl: the record of each pixel, and the colour of a point without a value.
@compute @workgroup_size(256)
fn blank(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = line_index(group, groups, local);
    let slot = shown_slot(pixel);
    if slot < page.len {
        shown_records[pixel] = records[slot];
        colors[pixel] = NO_DATA | OPAQUE;
    }
}
