// Whether a point is drawn: a filter's bits, one for each slot of the bound page; `hidden` is declared where it is
// bound. Without a filter, kernels are made without the test.
override HAS_MASK: bool = false;

// `local` counts from the page's first slot.
fn is_shown(local: u32) -> bool {
    if HAS_MASK {
        return ((hidden[local / 32u] >> (local % 32u)) & 1u) == 0u;
    }
    return true;
}
