// Hides points by the keys of the bound page of a column: those whose record it holds and whose key passes not. All
// other bits stay: mask.wgsl has set them. A page without keys holds none, and hides all its records. The one test
// is the first of the rules. Twin: `MaskRules::show` in src/render/filter/rules.rs.
struct ColumnPage {
    first: u32,
    len: u32,
    unused_a: u32,
    unused_b: u32,
}
@group(3) @binding(0) var<uniform> column: ColumnPage;
@group(3) @binding(1) var<storage, read> keys: array<u32>;

// Keys of two words, the lower half first.
override IS_WIDE: bool = false;

// Bits that mask.wgsl has set stay.
const KEEPS_BITS: bool = true;

fn hides(local: u32) -> bool {
    let at = records[local] - column.first;
    if at >= column.len {
        return false;
    }
    if IS_WIDE {
        return !is_in_range(FIRST_TEST, vec2<u32>(keys[2u * at], keys[2u * at + 1u]));
    }
    return !is_in_range(FIRST_TEST, vec2<u32>(keys[at], 0u));
}
