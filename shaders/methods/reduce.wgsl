// A subgroup whose points all fall into one pixel plots one of them. Otherwise neighbouring threads
// compare, and of two points in one pixel only the front one is plotted. For any subgroup size.
@compute @workgroup_size(256)
fn draw(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32, @builtin(subgroup_invocation_id) lane: u32, @builtin(subgroup_size) lanes: u32) {
    let fragment = fragment_of(line_index(group, groups, thread));
    let is_shown = fragment.pixel != NO_PIXEL;
    let pixel = subgroupMin(fragment.pixel);
    if subgroupAll(!is_shown || fragment.pixel == pixel) {
        if front_slot(is_shown, fragment) == fragment.slot && is_shown {
            plot(fragment.pixel, fragment.depth, fragment.slot);
        }
        return;
    }
    let other_pixel = subgroupShuffleXor(fragment.pixel, 1u);
    let other_bits = subgroupShuffleXor(bitcast<u32>(fragment.depth), 1u);
    let other_slot = subgroupShuffleXor(fragment.slot, 1u);
    let bits = bitcast<u32>(fragment.depth);
    // A subgroup of an odd size has a thread without a neighbour.
    let has_other = (lane ^ 1u) < lanes && other_pixel == fragment.pixel;
    let is_behind = has_other && (other_bits < bits || (other_bits == bits && other_slot < fragment.slot));
    if is_shown && !is_behind {
        plot(fragment.pixel, fragment.depth, fragment.slot);
    }
}
