// Günther et al. 2013, Algorithms 2 and 3: a lock for each pixel, taken with compare-exchange; whoever
// is not in front leaves without it. WGSL promises no forward progress, so that a thread tries `spins`
// times at most and is counted when it gives up. Taking and releasing lie in one turn of the loop: a
// thread never waits for another of its subgroup.
//
// WGSL's atomics alone order nothing between addresses; here each step needs a value of the one before.
// A lock word is free when even, and is released with a value made of what the last store replaced. The
// slot is written before the depth, so that whoever reads the depth and then the slot sees the slot of
// that depth, or of a point in front of it: a thread that is behind leaves without the lock, also when
// it is equally deep.
@group(0) @binding(1) var<storage, read_write> words: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> locks: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> counters: array<atomic<u32>>;

override spins: u32 = 4096u;

fn is_behind(pixel: u32, bits: u32, slot: u32) -> bool {
    let shown = atomicLoad(&words[2u * pixel + 1u]);
    return bits > shown || (bits == shown && slot > atomicLoad(&words[2u * pixel]));
}

fn plot(pixel: u32, depth: f32, slot: u32) {
    let bits = depth_bits(depth);
    for (var spin = 0u; spin < spins; spin++) {
        if is_behind(pixel, bits, slot) {
            return;
        }
        let free = atomicLoad(&locks[2u * pixel]);
        if (free & 1u) == 0u && atomicCompareExchangeWeak(&locks[2u * pixel], free, free | 1u).exchanged {
            var last = free;
            if !is_behind(pixel, bits, slot) {
                let replaced = atomicExchange(&words[2u * pixel], slot);
                // Always so: a slot is drawn once.
                if replaced != slot {
                    last = atomicExchange(&words[2u * pixel + 1u], bits);
                }
            }
            atomicStore(&locks[2u * pixel], last << 1u);
            return;
        }
    }
    atomicAdd(&counters[0], 1u);
}
