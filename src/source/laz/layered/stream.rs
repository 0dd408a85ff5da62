//! A layer's compressed bytes, the coder that reads them, and the decoder of its field: a lane.

use std::ops::Range;

use super::super::coder::Coder;
use super::contexts::Facts;

/// Bytes that a coder reads when it starts.
const START_BYTES: usize = 4;

/// What a layer's bytes mean.
pub trait Part {
    /// The most bytes that one point takes: two per symbol, and those of the raw bits.
    const MOST_BYTES: usize;

    /// Bytes on the heap.
    fn memory_bytes(&self) -> usize;
}

/// A layer behind the first: a field that depends on the first layer, and on no other.
pub trait Field: Part {
    /// Decodes the next point's field into its record; false if no encoder wrote that.
    fn step(&mut self, coder: &mut Coder, bytes: &[u8], facts: Facts, record: &mut [u8]) -> bool;
}

/// What can be done with a lane of any field.
pub trait AnyLane {
    /// Its number among the chunk's layers, and where it is, from the chunk's start.
    fn place(&self) -> (usize, Range<u64>);

    /// Takes the layer's first bytes, in place of those that it had.
    fn load(&mut self, bytes: Vec<u8>, complete: bool);

    /// Gives the bytes away. Until others are loaded, there is no room for a point.
    fn unload(&mut self) -> Vec<u8>;

    /// Points that the loaded bytes hold for certain; all, if they are complete: whether that is true is
    /// for the decoder to find out.
    fn room(&mut self) -> usize;

    /// True if what was decoded last was not all there.
    fn has_ended(&self) -> bool;

    /// Bytes of the layer that are not read yet.
    fn unread(&self) -> u64;

    /// Bytes on the heap, without the layer's.
    fn memory_bytes(&self) -> usize;
}

/// A layer of a chunk: its bytes, or the first of them, how far they are read, and its decoder. The
/// bytes may be taken away and given back between two points; the position stays.
pub struct Lane<F> {
    number: usize,
    range: Range<u64>,
    field: F,
    bytes: Vec<u8>,
    complete: bool,
    coder: Coder,
    started: bool,
}

impl<F> Lane<F> {
    pub fn new(number: usize, range: Range<u64>, field: F) -> Self {
        Lane { number, range, field, bytes: Vec::new(), complete: false, coder: Coder::default(), started: false }
    }

    /// The decoder, with what it reads.
    #[inline(always)]
    pub fn parts(&mut self) -> (&mut F, &mut Coder, &[u8]) {
        (&mut self.field, &mut self.coder, &self.bytes)
    }
}

impl<F: Part> AnyLane for Lane<F> {
    fn place(&self) -> (usize, Range<u64>) {
        (self.number, self.range.clone())
    }

    fn load(&mut self, bytes: Vec<u8>, complete: bool) {
        self.bytes = bytes;
        self.complete = complete;
    }

    fn unload(&mut self) -> Vec<u8> {
        self.complete = false;
        std::mem::take(&mut self.bytes)
    }

    fn room(&mut self) -> usize {
        if !self.started {
            if !self.complete && self.bytes.len() < START_BYTES {
                return 0;
            }
            self.coder = Coder::start(&self.bytes, 0);
            self.started = true;
        }
        if self.complete { usize::MAX } else { self.bytes.len().saturating_sub(self.coder.next()) / F::MOST_BYTES }
    }

    #[inline(always)]
    fn has_ended(&self) -> bool {
        self.coder.next() > self.bytes.len()
    }

    fn unread(&self) -> u64 {
        // Without a second point, the coder never started: what it would have read then counts as read.
        let read = if self.started { self.coder.next() } else { START_BYTES } as u64;
        (self.range.end - self.range.start).saturating_sub(read)
    }

    fn memory_bytes(&self) -> usize {
        self.field.memory_bytes()
    }
}

impl<F: Field> Lane<F> {
    /// Decodes the next point's field; false if the bytes ended before, or make no sense.
    #[inline(always)]
    pub fn step(&mut self, facts: Facts, record: &mut [u8]) -> bool {
        self.field.step(&mut self.coder, &self.bytes, facts, record) & !self.has_ended()
    }
}
