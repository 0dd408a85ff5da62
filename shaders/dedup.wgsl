// One `plot` for each distinct pixel of a subgroup. WGSL has no partition instruction: each round, all
// threads look at the pixel of the first that is left. There are as many rounds as distinct pixels, at
// most as many as threads. All threads of a subgroup call it together.
fn plot_together(fragment: Fragment, lane: u32, lanes: u32) {
    var is_left = fragment.pixel != NO_PIXEL;
    for (var round = 0u; round < lanes; round++) {
        let left = subgroupBallot(is_left);
        if all(left == vec4<u32>(0u)) {
            break;
        }
        var word = 0u;
        while left[word] == 0u {
            word++;
        }
        let pixel = subgroupShuffle(fragment.pixel, 32u * word + firstTrailingBit(left[word]));
        let is_here = is_left && fragment.pixel == pixel;
        let front = front_slot(is_here, fragment);
        if is_here && fragment.slot == front {
            plot(fragment.pixel, fragment.depth, fragment.slot);
        }
        is_left = is_left && !is_here;
    }
}
