// A page holds the slots [first, first + len). `base` and `bits` are the packed encoding's, see packed.wgsl.
struct Page {
    base: vec3<i32>,
    first: u32,
    bits: vec3<u32>,
    len: u32,
}

@group(1) @binding(0) var<uniform> page: Page;
