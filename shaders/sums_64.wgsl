// Sums of a pixel, HQS1R: one 64-bit word until 64 fragments are in it; whoever adds the 64th hands the
// word's sums over to two wider words, where all later fragments go.
//
// The published packing is 16 bits each for red, green, blue and fragments, handed over at 255. Fragments
// that looked before the hand-over still add to the word, so that with more than 65,281 threads between
// look and addition in one pixel its count starts again, and fragments are lost: an H200 holds 270,000
// threads, an MI300X 622,592. Here it is 14 bits for each colour (64 times 255 is below 16,384) and 22 for
// the count in the lowest bits, where no colour can spill: 4,194,240 threads would be needed.
//
// Words of a pixel: the first; green above red; fragments above blue.
@group(0) @binding(2) var<storage, read_write> sums: array<atomic<u64>>;

const HAND_OVER: u32 = 64u;
const COUNT_BITS: u32 = 22u;
const COUNT_MASK: u32 = 0x3fffffu;
// As in sums_32.wgsl.
const MOST_FRAGMENTS: u32 = 15u << 20u;

// Red, green, blue, fragments of a first word.
fn unpack(word: u64) -> vec4<u32> {
    let red = u32(word >> 50u);
    let green = u32(word >> 36u) & 0x3fffu;
    let blue = u32(word >> COUNT_BITS) & 0x3fffu;
    return vec4<u32>(red, green, blue, u32(word) & COUNT_MASK);
}

fn add_wide(pixel: u32, sum: vec4<u32>) {
    atomicAdd(&sums[3u * pixel + 1u], (u64(sum.y) << 32u) | u64(sum.x));
    atomicAdd(&sums[3u * pixel + 2u], (u64(sum.w) << 32u) | u64(sum.z));
}

fn add_fragment(pixel: u32, color: vec3<u32>) {
    let fragment = (u64(color.x) << 50u) | (u64(color.y) << 36u) | (u64(color.z) << COUNT_BITS) | 1lu;
    if (u32(atomicLoad(&sums[3u * pixel])) & COUNT_MASK) < HAND_OVER {
        let before = atomicAdd(&sums[3u * pixel], fragment);
        let count = u32(before) & COUNT_MASK;
        if count < HAND_OVER {
            if count == HAND_OVER - 1u {
                add_wide(pixel, unpack(before + fragment));
            }
            return;
        }
    }
    if u32(atomicLoad(&sums[3u * pixel + 2u]) >> 32u) < MOST_FRAGMENTS {
        add_wide(pixel, vec4<u32>(color, 1u));
    }
}

fn sums_of(pixel: u32) -> vec4<u32> {
    let first = unpack(atomicLoad(&sums[3u * pixel]));
    if first.w < HAND_OVER {
        return first;
    }
    let low = atomicLoad(&sums[3u * pixel + 1u]);
    let high = atomicLoad(&sums[3u * pixel + 2u]);
    return vec4<u32>(u32(low), u32(low >> 32u), u32(high), u32(high >> 32u));
}
