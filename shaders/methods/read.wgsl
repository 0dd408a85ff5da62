// Reads all positions and does nothing with them: no method that looks at every point is faster. The
// comparison, which holds for one sum in four billion, keeps the compiler from leaving the read out.
@group(0) @binding(4) var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(256)
fn read_positions(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let local = line_index(group, groups, thread);
    if local < page.len {
        let word = bitcast<vec3<u32>>(load_position(local)) * vec3<u32>(0x9e3779b9u, 0x85ebca6bu, 0xc2b2ae35u);
        if (word.x ^ word.y ^ word.z) == 0x27d4eb2fu {
            atomicAdd(&counters[1], 1u);
        }
    }
}
