// Writes the bits of what `hides` says of slots, counted from the page's first. `from_span` does all slots of a range and
// those before it in its first word, `from_list` those of a list, among others that stay.
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
        let word = atomicLoad(&bits[thread / 32u]);
        if KEEPS_BITS {
            atomicOr(&hidden[local / 32u], word);
        } else {
            atomicStore(&hidden[local / 32u], word);
        }
    }
}

@compute @workgroup_size(256)
fn from_list(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let i = line_index(group, groups, thread);
    if i >= list_count.x {
        return;
    }
    let local = list[i] - page.first;
    if local >= page.len {
        return;
    }
    let bit = 1u << (local % 32u);
    if hides(local) {
        atomicOr(&hidden[local / 32u], bit);
    } else if !KEEPS_BITS {
        atomicAnd(&hidden[local / 32u], ~bit);
    }
}
