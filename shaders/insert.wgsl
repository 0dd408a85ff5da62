// A batch enters the store. Twin: src/store/insertion.rs. Order of dispatches: count, scan, assign,
// link; evict for every page; settle for the pages of the tail. Nothing is left unordered.
@group(0) @binding(0) var<uniform> insertion: Insertion;
// Positions (3 words a point), attributes (2), record (1): a column after the other.
@group(0) @binding(1) var<storage, read> staging: array<u32>;

@group(1) @binding(0) var<storage, read_write> targets: array<u32>;
// For each new point: does it take a slot (bit 0), is tail slot number i free (bit 1); then the rank
// of the point among those that take one.
@group(1) @binding(1) var<storage, read_write> ranks: array<u32>;
@group(1) @binding(2) var<storage, read_write> free_slots: array<u32>;
@group(1) @binding(3) var<storage, read_write> moved_to: array<u32>;
// Sums per group of points that take a slot, and of free tail slots; then the sums before each.
@group(1) @binding(4) var<storage, read_write> sums: array<vec2<u32>>;
@group(1) @binding(5) var<storage, read_write> fresh: array<u32>;

const NONE: u32 = 0xffffffffu;

var<workgroup> scanned: array<vec2<u32>, GROUP>;

// Sums of `value` over the threads up to and including this one.
fn scan_group(local: u32, value: vec2<u32>) -> vec2<u32> {
    scanned[local] = value;
    workgroupBarrier();
    for (var step = 1u; step < GROUP; step *= 2u) {
        var sum = scanned[local];
        if local >= step {
            sum += scanned[local - step];
        }
        workgroupBarrier();
        scanned[local] = sum;
        workgroupBarrier();
    }
    return scanned[local];
}

fn flags_of(bits: u32) -> vec2<u32> {
    return vec2<u32>(bits & 1u, bits >> 1u);
}

@compute @workgroup_size(256)
fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = line_index(group, groups, local);
    var bits = 0u;
    if i < insertion.new_points {
        let slot = permute(i);
        let is_taken = slot < insertion.old_points;
        let is_free = unpermute(insertion.old_points + i) >= insertion.new_points;
        bits = select(0u, 1u, is_taken) | select(0u, 2u, is_free);
        targets[i] = slot;
        ranks[i] = bits;
    }
    let sum = scan_group(local, flags_of(bits));
    // Rows of groups may have a few too many.
    if local == GROUP - 1u && i / GROUP < arrayLength(&sums) {
        sums[i / GROUP] = sum;
    }
}

// One group.
@compute @workgroup_size(256)
fn scan(@builtin(local_invocation_index) local: u32) {
    let count = (insertion.new_points + GROUP - 1u) / GROUP;
    var before = vec2<u32>(0u);
    for (var first = 0u; first < count; first += GROUP) {
        let at = first + local;
        var value = vec2<u32>(0u);
        if at < count {
            value = sums[at];
        }
        let sum = scan_group(local, value);
        if at < count {
            sums[at] = before + sum - value;
        }
        before += scanned[GROUP - 1u];
        workgroupBarrier();
    }
}

@compute @workgroup_size(256)
fn assign(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = line_index(group, groups, local);
    var flags = vec2<u32>(0u);
    if i < insertion.new_points {
        flags = flags_of(ranks[i]);
    }
    let sum = scan_group(local, flags);
    if i < insertion.new_points {
        let rank = sums[i / GROUP] + sum - flags;
        ranks[i] = select(NONE, rank.x, flags.x == 1u);
        if flags.y == 1u {
            free_slots[rank.y] = insertion.old_points + i;
        }
    }
}

@compute @workgroup_size(256)
fn link(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = line_index(group, groups, local);
    if i < insertion.new_points {
        let rank = ranks[i];
        var slot = NONE;
        if rank != NONE {
            slot = free_slots[rank];
        }
        moved_to[i] = slot;
        fresh[insertion.fresh_before + i] = targets[i];
    }
}
