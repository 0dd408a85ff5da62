// Slots in a list follow their points through an insertion. Twin: `relocate` in
// src/store/insertion.rs.
@group(0) @binding(0) var<uniform> insertion: Insertion;
@group(0) @binding(1) var<storage, read> moved_to: array<u32>;
@group(0) @binding(2) var<storage, read_write> visible: array<u32>;
@group(0) @binding(3) var<storage, read> visible_count: array<u32>;
@group(0) @binding(4) var<storage, read_write> fresh: array<u32>;

fn relocated(slot: u32) -> u32 {
    let i = unpermute(slot);
    if i < insertion.new_points {
        return moved_to[i];
    }
    return slot;
}

@compute @workgroup_size(256)
fn relocate_visible(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = line_index(group, groups, local);
    if i < visible_count[0] {
        visible[i] = relocated(visible[i]);
    }
}

@compute @workgroup_size(256)
fn relocate_fresh(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = line_index(group, groups, local);
    if i < insertion.fresh_before {
        fresh[i] = relocated(fresh[i]);
    }
}
