// The tests of a filter, and where its bits are. Twin: src/render/filter/rules.rs.
@group(1) @binding(2) var<storage, read> attributes: array<vec2<u32>>;
@group(1) @binding(3) var<storage, read> records: array<u32>;
// One bit for each slot of the bound page.
@group(1) @binding(4) var<storage, read_write> hidden: array<atomic<u32>>;

// The number of tests in the first of four words; for each test its kind, a direction, its first range and how many
// there are, in eight words; then the ranges: the lowest and the highest key, each with its lower half first.
@group(0) @binding(0) var<storage, read> rules: array<u32>;
@group(0) @binding(1) var<storage, read_write> hidden_points: atomic<u32>;

struct Span {
    first: u32,
    count: u32,
    unused_a: u32,
    unused_b: u32,
}
@group(2) @binding(0) var<uniform> span: Span;
@group(2) @binding(1) var<storage, read> list: array<u32>;
@group(2) @binding(2) var<uniform> list_count: vec4<u32>;

const FIRST_TEST: u32 = 4u;
const RULE_WORDS: u32 = 8u;
const RANGE_WORDS: u32 = 4u;
const HIGHEST_BIT: u32 = 0x80000000u;

// 64-bit numbers: the lower half, then the upper.

fn is_at_most(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.y < b.y || (a.y == b.y && a.x <= b.x);
}

fn sum(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2<u32>(low, a.y + b.y + select(0u, 1u, low < a.x));
}

// Whether a key lies in one of the test's ranges: if in any, then in the last that begins at or before it.
fn is_in_range(test: u32, key: vec2<u32>) -> bool {
    let ranges = FIRST_TEST + RULE_WORDS * rules[0] + RANGE_WORDS * rules[test + 4u];
    var low = 0u;
    var high = rules[test + 5u];
    while low < high {
        let middle = (low + high) / 2u;
        let at = ranges + RANGE_WORDS * middle;
        if is_at_most(vec2<u32>(rules[at], rules[at + 1u]), key) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    if low == 0u {
        return false;
    }
    let at = ranges + RANGE_WORDS * (low - 1u);
    return is_at_most(key, vec2<u32>(rules[at + 2u], rules[at + 3u]));
}

var<workgroup> bits: array<atomic<u32>, 8>;
