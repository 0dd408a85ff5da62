//! One layer's compressed bytes, and the coder that reads them.

use super::super::coder::Coder;

/// Bytes that a coder reads when it starts.
const START_BYTES: usize = 4;

/// A layer of a chunk: its bytes, or the first of them, and how far they are read. The bytes may be
/// taken away and given back between two points; the position stays.
pub struct Layer {
    bytes: Vec<u8>,
    complete: bool,
    coder: Coder,
    started: bool,
}

impl Layer {
    pub fn new() -> Layer {
        Layer { bytes: Vec::new(), complete: false, coder: Coder::start(&[], 0), started: false }
    }

    /// Takes the layer's first bytes, in place of those that it had.
    pub fn load(&mut self, bytes: Vec<u8>, complete: bool) {
        self.bytes = bytes;
        self.complete = complete;
    }

    /// Gives the bytes away. Until others are loaded, there is no room for a point.
    pub fn unload(&mut self) -> Vec<u8> {
        self.complete = false;
        std::mem::take(&mut self.bytes)
    }

    /// Points that the loaded bytes hold for certain if none takes more than `most` bytes. With all
    /// bytes there, that is for the decoder to find out.
    pub fn room(&mut self, most: usize) -> usize {
        if !self.started {
            if !self.complete && self.bytes.len() < START_BYTES {
                return 0;
            }
            self.coder = Coder::start(&self.bytes, 0);
            self.started = true;
        }
        if self.complete { usize::MAX } else { self.bytes.len().saturating_sub(self.coder.next()) / most }
    }

    /// The coder, to be put back after use, and the bytes that it reads.
    pub fn take(&mut self) -> (Coder, &[u8]) {
        (self.coder.clone(), &self.bytes)
    }

    pub fn put_back(&mut self, coder: Coder) {
        self.coder = coder;
    }

    /// Bytes read, of a layer that starts with the coder's first four.
    pub fn read(&self) -> u64 {
        if self.started { self.coder.next() as u64 } else { 0 }
    }
}
