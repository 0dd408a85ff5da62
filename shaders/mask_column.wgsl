// Hides points by the keys of the bound page of a column: those whose record it holds and whose key passes not. All
// other bits stay: mask.wgsl has set them. A page without keys holds none, and hides all its records. The one test
// is the first of the rules. Twin: `MaskRules::show` in src/render/filter/rules.rs.
struct ColumnPage {
    first: u32,
    len: u32,
    unused_a: u32,
    unused_b: u32,
}
@group(3) @binding(0) var<uniform> column: ColumnPage;
@group(3) @binding(1) var<storage, read> keys: array<u32>;

// Keys of two words, the lower half first.
override IS_WIDE: bool = false;

fn hides(local: u32) -> bool {
    let at = records[local] - column.first;
    if at >= column.len {
        return false;
    }
    if IS_WIDE {
        return !is_in_range(FIRST_TEST, vec2<u32>(keys[2u * at], keys[2u * at + 1u]));
    }
    return !is_in_range(FIRST_TEST, vec2<u32>(keys[at], 0u));
}

@compute @workgroup_size(256)
fn from_span(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let first = span.first - page.first;
    let local = (first & ~31u) + line_index(group, groups, thread);
    let is_there = local < first + span.count;
    if is_there && hides(local) {
        atomicOr(&bits[thread / 32u], 1u << (thread % 32u));
    }
    workgroupBarrier();
    if is_there && thread % 32u == 0u {
        atomicOr(&hidden[local / 32u], atomicLoad(&bits[thread / 32u]));
    }
}

@compute @workgroup_size(256)
fn from_list(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let i = line_index(group, groups, thread);
    if i >= list_count.x {
        return;
    }
    let local = list[i] - page.first;
    if local < page.len && hides(local) {
        atomicOr(&hidden[local / 32u], 1u << (local % 32u));
    }
}
