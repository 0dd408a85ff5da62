// Which thread of its subgroup this is.
var<private> lane: u32;
