// The slots visible in this frame, each once, and the arguments of the indirect draw and dispatch
// that reproject them in the next. The order of the list is left open: sort before comparing. Twin:
// src/render/cpu.
@group(0) @binding(1) var<storage, read> words: array<vec2<u32>>;

@group(1) @binding(0) var<storage, read_write> visible: array<u32>;
struct Arguments {
    // Arguments of draw_indexed_indirect. The number of instances is the host's to write.
    index_count: atomic<u32>,
    instance_count: u32,
    first_index: u32,
    base_vertex: u32,
    first_instance: u32,
    unused: array<u32, 3>,
    // Arguments of dispatch_workgroups_indirect.
    groups_x: u32,
    groups_y: u32,
    groups_z: u32,
}
@group(1) @binding(1) var<storage, read_write> arguments: Arguments;

const NONE: u32 = 0xffffffffu;
const MAX_GROUPS: u32 = 65535u;

var<workgroup> group_count: atomic<u32>;
var<workgroup> group_first: u32;

// True if no pixel before this one, in raster order, shows the same slot. A point's pixels lie within
// a square of its size, so only those around have to be looked at; the nearest rows first, where it mostly is.
fn is_first(x: i32, y: i32, word: vec2<u32>) -> bool {
    let reach = i32(point_size_at(bitcast<f32>(word.y))) - 1;
    for (var row = y; row >= max(y - reach, 0); row--) {
        let end = select(min(x + reach, i32(view.width) - 1), x - 1, row == y);
        for (var column = max(x - reach, 0); column <= end; column++) {
            if words[u32(row) * view.width + u32(column)].x == word.x {
                return false;
            }
        }
    }
    return true;
}

@compute @workgroup_size(256)
fn build(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = line_index(group, groups, local);
    var slot = NONE;
    if pixel < view.width * view.height {
        let word = words[pixel];
        // A background pixel has depth bits that no point has; slot NONE is never given to a point.
        if word.x != NONE && is_first(i32(pixel % view.width), i32(pixel / view.width), word) {
            slot = word.x;
        }
    }
    var rank = 0u;
    if slot != NONE {
        rank = atomicAdd(&group_count, 1u);
    }
    workgroupBarrier();
    if local == 0u {
        group_first = atomicAdd(&arguments.index_count, atomicLoad(&group_count));
    }
    workgroupBarrier();
    if slot != NONE {
        visible[group_first + rank] = slot;
    }
}

// One thread.
@compute @workgroup_size(1)
fn finish() {
    let groups = (atomicLoad(&arguments.index_count) + GROUP - 1u) / GROUP;
    let rows = (groups + MAX_GROUPS - 1u) / MAX_GROUPS;
    arguments.groups_x = (groups + max(rows, 1u) - 1u) / max(rows, 1u);
    arguments.groups_y = rows;
    arguments.groups_z = 1u;
}
