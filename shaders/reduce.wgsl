// A subgroup whose points all fall into one pixel plots one of them. Otherwise neighbouring threads
// compare, and of two points in one pixel only the front one is plotted. For any subgroup size; all
// threads of a subgroup call it together.
fn plot_together(fragment: Fragment, lane: u32, lanes: u32) {
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
