// A keyed permutation of [0, old + new): `domain` shuffled numbers (all of them, but for measuring other
// orders), then all moved on by `shift`, round the end. Twin: src/store/permutation.rs.
const ROUNDS: u32 = 8u;

struct Insertion {
    // Points in the store before, and points that enter.
    old_points: u32,
    new_points: u32,
    left_bits: u32,
    right_bits: u32,
    // One key for each round.
    keys: array<vec4<u32>, 2>,
    // Fresh slots of earlier insertions in this frame.
    fresh_before: u32,
    // Points that the columns of the staging buffer have room for.
    staging_capacity: u32,
    domain: u32,
    shift: u32,
}

fn hash(value: u32) -> u32 {
    var x = value;
    x ^= x >> 16u;
    x *= 0x7feb352du;
    x ^= x >> 15u;
    x *= 0x846ca68bu;
    return x ^ (x >> 16u);
}

fn round_key(n: u32) -> u32 {
    return insertion.keys[n / 4u][n % 4u];
}

fn low_bits(bits: u32) -> u32 {
    return (1u << bits) - 1u;
}

fn encrypt(x: u32) -> u32 {
    var left_bits = insertion.left_bits;
    var right_bits = insertion.right_bits;
    var left = x >> right_bits;
    var right = x & low_bits(right_bits);
    for (var n = 0u; n < ROUNDS; n++) {
        let mixed = left ^ (hash(right ^ round_key(n)) & low_bits(left_bits));
        left = right;
        right = mixed;
        let bits = left_bits;
        left_bits = right_bits;
        right_bits = bits;
    }
    return (left << right_bits) | right;
}

fn decrypt(x: u32) -> u32 {
    var left_bits = insertion.left_bits;
    var right_bits = insertion.right_bits;
    var left = x >> right_bits;
    var right = x & low_bits(right_bits);
    for (var n = ROUNDS; n > 0u; n--) {
        let mixed = right ^ (hash(left ^ round_key(n - 1u)) & low_bits(right_bits));
        right = left;
        left = mixed;
        let bits = left_bits;
        left_bits = right_bits;
        right_bits = bits;
    }
    return (left << right_bits) | right;
}

// Where new point `i` goes.
fn permute(i: u32) -> u32 {
    var x = i;
    if i < insertion.domain {
        x = encrypt(x);
        while x >= insertion.domain {
            x = encrypt(x);
        }
    }
    // `x + shift` may not fit 32 bits.
    let before_end = insertion.old_points + insertion.new_points - insertion.shift;
    if x < before_end {
        return x + insertion.shift;
    }
    return x - before_end;
}

// What goes to `slot`.
fn unpermute(slot: u32) -> u32 {
    var x = slot - insertion.shift;
    if slot < insertion.shift {
        x = slot + (insertion.old_points + insertion.new_points - insertion.shift);
    }
    if x < insertion.domain {
        x = decrypt(x);
        while x >= insertion.domain {
            x = decrypt(x);
        }
    }
    return x;
}
