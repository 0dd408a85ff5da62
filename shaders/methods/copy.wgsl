// Copies 16 bytes at a time, four times a thread: what a kernel that reads and writes reaches. Neighbouring
// threads copy neighbouring words.
@group(0) @binding(0) var<storage, read> source: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> copied: array<vec4<u32>>;

@compute @workgroup_size(256)
fn copy_words(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let first = 4u * line_index(group, groups, 0u) + thread;
    let len = arrayLength(&source);
    for (var i = first; i < min(first + 4u * GROUP, len); i += GROUP) {
        copied[i] = source[i];
    }
}
