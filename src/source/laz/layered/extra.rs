//! Extra bytes: each byte of the record is a layer of its own.

use super::super::coder::Coder;
use super::contexts::{Context, Contexts, Facts, Lazy, made, models_bytes};
use super::stream::{Field, Part};

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

impl Part for ExtraByte {
    const MOST_BYTES: usize = 2;

    fn memory_bytes(&self) -> usize {
        self.contexts.memory_bytes()
    }
}

impl Field for ExtraByte {
    #[inline(always)]
    fn step(&mut self, coder: &mut Coder, bytes: &[u8], facts: Facts, record: &mut [u8]) -> bool {
        let at = self.at;
        let (model, last) = self.contexts.enter(facts.item());
        *last = last.wrapping_add(coder.symbol(bytes, made(&mut model.0, 256)) as u8);
        record[at] = *last;
        true
    }
}
