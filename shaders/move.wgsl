// Points enter and leave the slots of one page. Twin: `apply` in src/store/insertion.rs.
@group(0) @binding(0) var<uniform> insertion: Insertion;
// Positions (3 words a point, of which the packed encoding uses 2), attributes (2), record (1): a column after the
// other.
@group(0) @binding(1) var<storage, read> staging: array<u32>;

// Words of a position: 3, or 2 in the packed encoding.
override POSITION_WORDS: u32 = 3u;

@group(1) @binding(1) var<storage, read_write> positions: array<u32>;
@group(1) @binding(2) var<storage, read_write> attributes: array<u32>;
@group(1) @binding(3) var<storage, read_write> records: array<u32>;

@group(2) @binding(0) var<storage, read> targets: array<u32>;
@group(2) @binding(1) var<storage, read> moved_to: array<u32>;
// The evicted points on their way, in the layout of `staging`.
@group(2) @binding(2) var<storage, read_write> carried: array<u32>;

const NONE: u32 = 0xffffffffu;

// New point `i` takes its slot; the point that was there, if any, is picked up. No other new point
// has this slot, so one thread may do both.
@compute @workgroup_size(256)
fn evict(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = line_index(group, groups, local);
    if i >= insertion.new_points {
        return;
    }
    let slot = targets[i] - page.first;
    if slot >= page.len {
        return;
    }
    let capacity = insertion.staging_capacity;
    let is_taken = moved_to[i] != NONE;
    for (var word = 0u; word < POSITION_WORDS; word++) {
        if is_taken {
            carried[POSITION_WORDS * i + word] = positions[POSITION_WORDS * slot + word];
        }
        positions[POSITION_WORDS * slot + word] = staging[POSITION_WORDS * i + word];
    }
    for (var word = 0u; word < 2u; word++) {
        let at = 3u * capacity + 2u * i + word;
        if is_taken {
            carried[at] = attributes[2u * slot + word];
        }
        attributes[2u * slot + word] = staging[at];
    }
    let at = 5u * capacity + i;
    if is_taken {
        carried[at] = records[slot];
    }
    records[slot] = staging[at];
}

// The evicted points settle in the tail.
@compute @workgroup_size(256)
fn settle(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = line_index(group, groups, local);
    if i >= insertion.new_points || moved_to[i] == NONE {
        return;
    }
    let slot = moved_to[i] - page.first;
    if slot >= page.len {
        return;
    }
    let capacity = insertion.staging_capacity;
    for (var word = 0u; word < POSITION_WORDS; word++) {
        positions[POSITION_WORDS * slot + word] = carried[POSITION_WORDS * i + word];
    }
    for (var word = 0u; word < 2u; word++) {
        attributes[2u * slot + word] = carried[3u * capacity + 2u * i + word];
    }
    records[slot] = carried[5u * capacity + i];
}
