//! Decoding LAZ: from a chunk's compressed bytes to raw point records.
//!
//! Sequential chunks are decoded 1.4 to 1.65 times as fast as the `laz` crate does (0.13; eight scans of
//! formats 0 to 3, alternated), and twice as fast where chunks are of a thousand points. Most of the time
//! went into branches that nobody can foresee, so symbols, signs and ends of bytes are searched and
//! selected instead. What did not help: a table in place of the upper row of models of 256 symbols (1.01),
//! wider vector instructions (1.00 to 1.05), inlining all of a point (0.94 to 0.99), dividing before it is
//! known to be needed (0.99), and two chunks alternated field by field in one thread (0.91 to 1.06).
//!
//! ```text
//! search      a row of 16 rising numbers, searched at once
//! model       how often each symbol came
//! coder       the arithmetic decoder: bytes and models → symbols, bits
//! integer     integers from symbols and bits, by context
//! sequential  chunks of formats 0 to 5 → raw records
//! layered     chunks of formats 6 to 10, only the layers asked for → raw records
//! reference   the laz crate's decoders: the reference, and what reads streams without chunks
//! ```

#![cfg_attr(not(test), expect(dead_code, reason = "the stream does not decode with these yet"))]

pub mod coder;
pub mod integer;
pub mod layered;
pub mod model;
mod reference;
mod search;
pub mod sequential;
#[cfg(test)]
mod tests;

#[expect(unused_imports, reason = "the stream does not decode with it yet")]
pub use layered::LayeredDecoder;
pub use reference::{ChunkEnd, DECODER_THREAD, decode_chunk, silence_decoder_panics, take_panic};
#[expect(unused_imports, reason = "the stream does not decode with it yet")]
pub use sequential::SequentialDecoder;

/// What a call to decode a chunk's next points came to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Decoded {
    /// Whole records that were written.
    pub records: usize,
    pub end: End,
}

/// Why decoding stopped.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum End {
    /// All that was asked for is there.
    Filled,
    /// The next point may need bytes that are not loaded.
    NeedsBytes,
    /// The chunk makes no sense from here on; what it is.
    Fault(String),
}
