// Which points of the bound page a filter hides: one bit for each slot, from integers alone. `from_span` does all
// slots of a range and those before it in its first word, `from_list` those of a list, among others that stay.
// Twin: `MaskRules::show` in src/render/filter/rules.rs.
@group(1) @binding(2) var<storage, read> attributes: array<vec2<u32>>;
@group(1) @binding(3) var<storage, read> records: array<u32>;
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

fn magnitude(a: u32) -> u32 {
    return select(a, 0u - a, a >= HIGHEST_BIT);
}

// Of two numbers with signs.
fn product(a: u32, b: u32) -> vec2<u32> {
    let x = magnitude(a);
    let y = magnitude(b);
    let low = (x & 0xffffu) * (y & 0xffffu);
    let cross = (x >> 16u) * (y & 0xffffu) + (low >> 16u);
    let middle = (x & 0xffffu) * (y >> 16u) + (cross & 0xffffu);
    let high = (x >> 16u) * (y >> 16u) + (cross >> 16u) + (middle >> 16u);
    let positive = vec2<u32>((middle << 16u) | (low & 0xffffu), high);
    let negative = sum(~positive, vec2<u32>(1u, 0u));
    return select(positive, negative, ((a ^ b) & HIGHEST_BIT) != 0u);
}

fn key_of(test: u32, local: u32) -> vec2<u32> {
    switch rules[test] {
        case 0u, 1u, 2u: {
            return vec2<u32>(bitcast<u32>(load_position(local)[rules[test]]) ^ HIGHEST_BIT, 0u);
        }
        case 3u: {
            let p = bitcast<vec3<u32>>(load_position(local));
            let x = product(rules[test + 1u], p.x);
            let dot = sum(sum(x, product(rules[test + 2u], p.y)), product(rules[test + 3u], p.z));
            return vec2<u32>(dot.x, dot.y ^ HIGHEST_BIT);
        }
        case 4u: {
            return vec2<u32>(attributes[local].y >> 16u, 0u);
        }
        default: {
            return vec2<u32>(records[local], 0u);
        }
    }
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

// `local` counts from the page's first slot.
fn passes(local: u32) -> bool {
    for (var t = 0u; t < rules[0]; t++) {
        let test = FIRST_TEST + RULE_WORDS * t;
        if !is_in_range(test, key_of(test, local)) {
            return false;
        }
    }
    return true;
}

var<workgroup> bits: array<atomic<u32>, 8>;

@compute @workgroup_size(256)
fn from_span(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let first = span.first - page.first;
    let local = (first & ~31u) + line_index(group, groups, thread);
    let is_there = local < first + span.count;
    if is_there && !passes(local) {
        atomicOr(&bits[thread / 32u], 1u << (thread % 32u));
    }
    workgroupBarrier();
    if is_there && thread % 32u == 0u {
        atomicStore(&hidden[local / 32u], atomicLoad(&bits[thread / 32u]));
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
    if passes(local) {
        atomicAnd(&hidden[local / 32u], ~bit);
    } else {
        atomicOr(&hidden[local / 32u], bit);
    }
}

// Adds up the bits.
@compute @workgroup_size(256)
fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let word = line_index(group, groups, thread);
    if word < arrayLength(&hidden) {
        atomicAdd(&bits[0], countOneBits(atomicLoad(&hidden[word])));
    }
    workgroupBarrier();
    if thread == 0u {
        atomicAdd(&hidden_points, atomicLoad(&bits[0]));
    }
}
