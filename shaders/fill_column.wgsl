// A batch's keys go to their records in the bound page of a column. Twin: src/render/cpu/columns.rs.
struct Staged {
    count: u32,
    // Where each part of `staged` begins.
    capacity: u32,
    unused_a: u32,
    unused_b: u32,
}
@group(0) @binding(0) var<uniform> batch: Staged;
// Record numbers, then keys: of wide ones, the lower and the upper half after each other.
@group(0) @binding(1) var<storage, read> staged: array<u32>;
@group(1) @binding(1) var<storage, read_write> keys: array<u32>;

// Where in the page the thread's record is; beyond its length: nowhere.
fn place_of(i: u32) -> u32 {
    return select(0xffffffffu, staged[i] - column.first, i < batch.count);
}

@compute @workgroup_size(256)
fn fill_small(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = line_index(group, groups, local);
    let at = place_of(i);
    if at < column.len {
        keys[at] = staged[batch.capacity + i];
    }
}

@compute @workgroup_size(256)
fn fill_wide(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = line_index(group, groups, local);
    let at = place_of(i);
    if at < column.len {
        keys[2u * at] = staged[batch.capacity + 2u * i];
        keys[2u * at + 1u] = staged[batch.capacity + 2u * i + 1u];
    }
}
