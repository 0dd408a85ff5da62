//! Decoding LAZ: from a chunk's compressed bytes to raw point records.
//!
//! ```text
//! search     a row of 16 rising numbers, searched at once
//! model      how often each symbol came
//! coder      the arithmetic decoder: bytes and models → symbols, bits
//! integer    integers from symbols and bits, by context
//! reference  the laz crate's decoders: the reference, and what reads streams without chunks
//! ```

pub mod coder;
pub mod integer;
pub mod model;
mod reference;
mod search;
#[cfg(test)]
mod tests;

pub use reference::{ChunkEnd, DECODER_THREAD, decode_chunk, silence_decoder_panics, take_panic};
