//! Decoding LAZ: from a chunk's compressed bytes to raw point records.
//!
//! ```text
//! reference  the laz crate's decoders: the reference, and what reads streams without chunks
//! ```

mod reference;

pub use reference::{ChunkEnd, DECODER_THREAD, decode_chunk, silence_decoder_panics, take_panic};
