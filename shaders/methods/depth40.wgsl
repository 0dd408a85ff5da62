// Depth without loss: distance along the viewing direction in whole nanometres, in integers of 128 bits
// from the integer positions. Twin: `Depth40` in src/methods/depth40.rs.
struct Depth40 {
    // Nanometres for each 1/4096 of a grid step, with 32 bits after the point.
    row_low: vec3<u32>,
    unused_a: u32,
    row_high: vec3<i32>,
    unused_b: u32,
}

@group(0) @binding(6) var<uniform> depth40: Depth40;

struct Int128 {
    high: u64,
    low: u64,
}

fn add(a: Int128, b: Int128) -> Int128 {
    let low = a.low + b.low;
    return Int128(a.high + b.high + select(0lu, 1lu, low < a.low), low);
}

fn multiply(a: u64, b: u64) -> Int128 {
    let mask = 0xfffffffflu;
    let low = (a & mask) * (b & mask);
    let cross = (a >> 32u) * (b & mask) + (low >> 32u);
    let other = (a & mask) * (b >> 32u) + (cross & mask);
    return Int128((a >> 32u) * (b >> 32u) + (cross >> 32u) + (other >> 32u), (other << 32u) | (low & mask));
}

// Two's complement.
fn multiply_signed(a: i64, b: i64) -> Int128 {
    let product = multiply(bitcast<u64>(abs(a)), bitcast<u64>(abs(b)));
    if (a < 0li) == (b < 0li) {
        return product;
    }
    return add(Int128(~product.high, ~product.low), Int128(0lu, 1lu));
}

fn nanometres(position: vec3<i32>) -> u64 {
    var sum = Int128(0lu, 0lu);
    for (var a = 0u; a < 3u; a++) {
        let eye = (i64(view.eye_high[a]) << 16u) + i64(view.eye_low[a]);
        let steps = ((i64(position[a]) - eye) << 12u) - i64(i32(view.eye_fraction[a] * 4096.0));
        let row = (i64(depth40.row_high[a]) << 32u) | i64(depth40.row_low[a]);
        sum = add(sum, multiply_signed(row, steps));
    }
    // Behind the eye by less than the rounding of `project`.
    if bitcast<i64>(sum.high) < 0li {
        return 0lu;
    }
    if (sum.high >> 32u) != 0lu {
        return 0xfffffffffffffffflu;
    }
    return (sum.high << 32u) | (sum.low >> 32u);
}

// The empty word has all bits set: no depth is that large.
const LAST_DEPTH: u64 = 0xfffffffffelu;

fn word_of(slot: u32) -> u64 {
    let depth = min(depth_code(nanometres(load_position(slot - page.first))), LAST_DEPTH);
    return (depth << 24u) | u64(load_color(slot - page.first) & 0xffffffu);
}
