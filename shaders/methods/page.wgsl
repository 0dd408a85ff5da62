// A page holds the points [first, first + len) of the cloud. The rest is the packed encoding's: the
// lowest corner of the cloud's box, and bits per axis.
struct Page {
    base: vec3<i32>,
    first: u32,
    bits: vec3<u32>,
    len: u32,
}

@group(1) @binding(0) var<uniform> page: Page;
