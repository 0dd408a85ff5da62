//! Decoding LAZ: from a chunk's compressed bytes to raw point records.
//!
//! ```text
//! search      a row of 16 rising numbers, searched at once
//! model       how often each symbol came
//! coder       the arithmetic decoder: bytes and models → symbols, bits
//! integer     integers from symbols and bits, by context
//! median      the running median that positions are predicted from
//! sequential  chunks of formats 0 to 5 → raw records
//! layered     chunks of formats 6 to 10 → raw records, of the fields wanted
//! own         these two, given a chunk of a file
//! reference   the laz crate's decoders: the reference, and what reads streams without chunks
//! panics      a decoder's panic becomes its chunk's fault
//! ```

use std::{fs::File, sync::Arc};

use laz::{LazItem, LazItemType};

use super::{
    chunks::{Chunk, ChunkSource, LazLayout},
    fields::Fields,
};

mod coder;
mod integer;
mod layered;
mod median;
mod model;
mod own;
mod panics;
mod reference;
mod search;
mod sequential;
#[cfg(test)]
mod tests;

use layered::LayeredDecoder;
use sequential::SequentialDecoder;

pub use panics::{DECODER_THREAD, catch, silence_decoder_panics};

/// Chunks of more bytes are read through a window, by the laz crate's decoder. LASzip's own chunks of
/// 50,000 points have less than 4 MB.
pub const MAX_CHUNK_BYTES: u64 = 32 << 20;

/// Most heap memory of one decoder with all its models made, without its chunk's bytes: 4 MiB for the
/// fields that LAS defines, and for each extra byte a model per scanner channel.
pub fn decoder_bytes(items: &[LazItem]) -> u64 {
    let extra_bytes = |item: &LazItem| match item.item_type() {
        LazItemType::Byte(n) | LazItemType::Byte14(n) => u64::from(n),
        _ => 0,
    };
    (4 << 20) + items.iter().map(extra_bytes).sum::<u64>() * 4 * 1_280
}

/// Which decoder reads LAZ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DecoderChoice {
    /// Our own, except for what only the laz crate reads: streams without chunks, chunks of more than
    /// 32 MiB.
    #[default]
    Own,
    /// The laz crate's, for comparison.
    LazCrate,
}

/// How much of a chunk's bytes to read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Share {
    /// What its first points need: of all bytes (of each layer) the first one of so many, and some.
    Start(u64),
    All,
}

/// What came of decoding.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Decoded {
    /// Records that were written.
    pub records: usize,
    pub end: End,
}

/// Why decoding stopped.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum End {
    /// The records asked for are there.
    Filled,
    /// The bytes that were loaded may not hold the next point.
    NeedsBytes,
    /// The decoder could not go on, and why.
    Fault(String),
}

/// Decodes one chunk's points in order, and can stop after any of them.
pub trait ChunkDecoder: Send {
    /// Reads the chunk's bytes. `spare` are buffers to use.
    ///
    /// # Errors
    /// If they cannot be read, or contradict themselves: in one line.
    fn load(&mut self, share: Share, spare: &mut Vec<Vec<u8>>) -> Result<(), String>;

    /// Writes the next points' raw records; only as many as asked for are there.
    fn decode(&mut self, records: &mut [u8]) -> Decoded;

    /// Gives the bytes back and keeps the state: after another [`ChunkDecoder::load`] it goes on.
    fn unload(&mut self, spare: &mut Vec<Vec<u8>>);

    /// After the last point: bytes that were not needed. Not zero if the decoder lost its way. `None`
    /// where this says nothing.
    fn unused(&self) -> Option<u64>;

    /// Heap memory of an unloaded decoder.
    fn memory_bytes(&self) -> usize;
}

/// True if chunks of a file can be decoded by decoders that are cheap to keep.
pub fn keepable(layout: &LazLayout, choice: DecoderChoice) -> bool {
    choice == DecoderChoice::Own && layout.source != ChunkSource::OneStream
}

/// A decoder for a chunk.
///
/// # Errors
/// If the items make no sense; they were checked when the layout was read.
pub fn decoder(
    file: &Arc<File>,
    layout: &LazLayout,
    record_length: usize,
    chunk: &Chunk,
    fields: Fields,
    choice: DecoderChoice,
) -> Result<Box<dyn ChunkDecoder>, String> {
    if keepable(layout, choice) && chunk.bytes <= MAX_CHUNK_BYTES {
        return Ok(if layout.is_layered() {
            Box::new(own::LayeredChunk::new(file, chunk, &layout.items, fields))
        } else {
            Box::new(own::SequentialChunk::new(file, chunk, &layout.items))
        });
    }
    Ok(Box::new(reference::LazCrateDecoder::new(file, layout, record_length, chunk, fields)?))
}
