// A page of a column holds the keys of records [first, first + len).
struct ColumnPage {
    first: u32,
    len: u32,
    unused_a: u32,
    unused_b: u32,
}
@group(1) @binding(0) var<uniform> column: ColumnPage;
