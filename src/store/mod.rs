//! The shuffled point buffer: how batches enter it ([`Insertion`]), in which slots
//! ([`Permutation`]), and which of them a picture has tried ([`Coverage`]). Invariant: after every
//! insertion the slots `[0, n)` hold all points received so far, in uniformly random order, dense.
//!
//! Here are the rules and their plain Rust form; the kernels that follow them on the GPU, and the
//! pages that hold the points there, are in `gpu`.

mod coverage;
pub mod gpu;
mod insertion;
mod packing;
mod permutation;

pub use coverage::Coverage;
pub use insertion::{Insertion, MAX_INSERTION_POINTS};
pub use packing::{Encoding, Packing, TooWide};
pub use permutation::{Permutation, ROUNDS, SlotOrder};
