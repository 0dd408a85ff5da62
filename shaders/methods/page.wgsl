// A page holds the points [first, first + len) of the cloud. `base` is the packed encoding's: the lowest
// corner of the cloud's box.
struct Page {
    base: vec3<i32>,
    first: u32,
    len: u32,
    unused_a: u32,
    unused_b: u32,
    unused_c: u32,
}

@group(1) @binding(0) var<uniform> page: Page;
