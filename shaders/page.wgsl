// A page holds the slots [first, first + len).
struct Page {
    first: u32,
    len: u32,
    unused_a: u32,
    unused_b: u32,
}
