// Depth without loss: distance along the viewing direction in whole nanometres, in integers of 128 bits
// from the integer positions. Twin: `Depth40` in src/methods/depth40.rs.
struct Depth40 {
    // Nanometres for each 1/4096 of a grid step, with 32 bits after the point.
    row_low: vec3<u32>,
    unused_a: u32,
    row_high: vec3<i32>,
    unused_b: u32,
}

@group(0) @binding(7) var<uniform> depth40: Depth40;

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

// Two's complement: a number below zero counts as 2^64 more than it is, which is taken off again.
fn multiply_signed(a: i64, b: i64) -> Int128 {
    let product = multiply(bitcast<u64>(a), bitcast<u64>(b));
    let too_much = select(0lu, bitcast<u64>(b), a < 0li) + select(0lu, bitcast<u64>(a), b < 0li);
    return Int128(product.high - too_much, product.low);
}

fn along_axis(position: i32, eye_high: i32, eye_low: i32, fraction: f32, row_high: i32, row_low: u32) -> Int128 {
    let eye = (i64(eye_high) << 16u) + i64(eye_low);
    let steps = ((i64(position) - eye) << 12u) - i64(i32(fraction * 4096.0));
    // naga 30 extends the sign in i64(u32) when it writes SPIR-V.
    return multiply_signed((i64(row_high) << 32u) | bitcast<i64>(u64(row_low)), steps);
}

fn nanometres(position: vec3<i32>) -> u64 {
    let low = depth40.row_low;
    let high = depth40.row_high;
    let fraction = view.eye_fraction;
    let x = along_axis(position.x, view.eye_high.x, view.eye_low.x, fraction.x, high.x, low.x);
    let y = along_axis(position.y, view.eye_high.y, view.eye_low.y, fraction.y, high.y, low.y);
    let z = along_axis(position.z, view.eye_high.z, view.eye_low.z, fraction.z, high.z, low.z);
    let sum = add(add(x, y), z);
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
