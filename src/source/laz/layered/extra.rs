//! Extra bytes: each byte of the record is a layer of its own.

use super::contexts::{Block, Context, Contexts, Field, Lazy, made, models_bytes};
use super::stream::Layer;

/// One byte, coded as the difference from the last.
pub struct ExtraByte {
    at: usize,
    contexts: Contexts<ByteModel, u8>,
}

struct ByteModel(Lazy);

impl Context<u8> for ByteModel {
    fn start(_: &u8) -> Self {
        ByteModel(None)
    }

    fn memory_bytes(&self) -> usize {
        models_bytes([&self.0])
    }
}

impl ExtraByte {
    pub fn new(first: &[u8], channel: usize, at: usize) -> Self {
        ExtraByte { at, contexts: Contexts::new(first[at], channel) }
    }
}

impl Field for ExtraByte {
    fn most_bytes(&self) -> usize {
        2
    }

    fn decode(&mut self, layer: &mut Layer, block: &Block<'_>, records: &mut [u8]) -> usize {
        let at = self.at;
        self.contexts.decode(layer, block, records, |model, last, coder, bytes, _, record| {
            *last = last.wrapping_add(coder.symbol(bytes, made(&mut model.0, 256)) as u8);
            record[at] = *last;
        })
    }

    fn memory_bytes(&self) -> usize {
        self.contexts.memory_bytes()
    }
}
