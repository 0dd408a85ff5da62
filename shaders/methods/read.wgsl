// Reads all positions, four a thread, and does nothing with them: no method that looks at every point is
// faster. The comparison, which holds for one sum in four billion, keeps the compiler from leaving the
// reads out.
@group(0) @binding(5) var<storage, read_write> counters: array<atomic<u32>>;

fn mixed(local: u32) -> u32 {
    let word = bitcast<vec3<u32>>(load_position(min(local, page.len - 1u)));
    return word.x * 0x9e3779b9u ^ word.y * 0x85ebca6bu ^ word.z * 0xc2b2ae35u;
}

@compute @workgroup_size(256)
fn read_positions(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let first = 4u * line_index(group, groups, 0u) + thread;
    if first < page.len {
        let sum = mixed(first) + mixed(first + GROUP) + mixed(first + 2u * GROUP) + mixed(first + 3u * GROUP);
        if sum == 0x27d4eb2fu {
            atomicAdd(&counters[1], 1u);
        }
    }
}
