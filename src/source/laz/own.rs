//! Our decoders as [`ChunkDecoder`]s: which bytes of the file they are given.

use std::{fs::File, ops::Range, sync::Arc};

use laz::LazItem;

use super::{ChunkDecoder, Decoded, End, LayeredDecoder, SequentialDecoder, Share};
use crate::source::{bytes::read_full_at, chunks::Chunk, fields::Fields};

/// Bytes that a start reads besides its share: models that know nothing yet take more bytes per point.
const START_BYTES: u64 = 4_096;

/// A chunk's place in its file.
struct Place {
    file: Arc<File>,
    chunk: Chunk,
}

impl Place {
    /// Reads the first bytes of a range (relative to the chunk), as many as the share says; the flag is
    /// true if it is all of them.
    fn read(&self, range: Range<u64>, share: Share, spare: &mut Vec<Vec<u8>>) -> Result<(Vec<u8>, bool), String> {
        let whole = (range.end - range.start).min(self.chunk.bytes);
        let wanted = match share {
            Share::Start(of) => whole.min(whole / of + whole / (4 * of) + START_BYTES),
            Share::All => whole,
        };
        let mut bytes = spare.pop().unwrap_or_default();
        bytes.resize(wanted as usize, 0);
        let at = self.chunk.at + range.start;
        let found = read_full_at(&self.file, &mut bytes, at).map_err(|e| format!("cannot read at byte {at}: {e}"))?;
        // If the file has become shorter, these are all.
        bytes.truncate(found);
        Ok((bytes, wanted == whole || (found as u64) < wanted))
    }
}

/// A sequential chunk of a file.
pub struct SequentialChunk {
    place: Place,
    decoder: SequentialDecoder,
}

impl SequentialChunk {
    pub fn new(file: &Arc<File>, chunk: &Chunk, items: &[LazItem]) -> SequentialChunk {
        let place = Place { file: Arc::clone(file), chunk: *chunk };
        SequentialChunk { place, decoder: SequentialDecoder::new(items) }
    }
}

impl ChunkDecoder for SequentialChunk {
    fn load(&mut self, share: Share, spare: &mut Vec<Vec<u8>>) -> Result<(), String> {
        let (bytes, complete) = self.place.read(0..self.place.chunk.bytes, share, spare)?;
        self.decoder.load(bytes, complete);
        Ok(())
    }

    fn decode(&mut self, records: &mut [u8]) -> Decoded {
        self.decoder.decode(records)
    }

    fn unload(&mut self, spare: &mut Vec<Vec<u8>>) {
        spare.push(self.decoder.unload());
    }

    fn unused(&self) -> Option<u64> {
        Some(self.decoder.unused())
    }

    fn memory_bytes(&self) -> usize {
        self.decoder.memory_bytes()
    }
}

/// A layered chunk of a file.
pub struct LayeredChunk {
    place: Place,
    decoder: LayeredDecoder,
    head_bytes: usize,
    record_length: usize,
    opened: bool,
    /// Points that the chunk itself says it has, less those decoded.
    left: u64,
}

impl LayeredChunk {
    pub fn new(file: &Arc<File>, chunk: &Chunk, items: &[LazItem], fields: Fields) -> LayeredChunk {
        LayeredChunk {
            place: Place { file: Arc::clone(file), chunk: *chunk },
            decoder: LayeredDecoder::new(items, fields),
            head_bytes: LayeredDecoder::head_bytes(items),
            record_length: items.iter().map(|i| usize::from(i.size())).sum::<usize>().max(1),
            opened: false,
            left: 0,
        }
    }
}

impl ChunkDecoder for LayeredChunk {
    fn load(&mut self, share: Share, spare: &mut Vec<Vec<u8>>) -> Result<(), String> {
        if !self.opened {
            let (head, _) = self.place.read(0..self.head_bytes as u64, Share::All, spare)?;
            let opened = self.decoder.open(&head, self.place.chunk.bytes);
            spare.push(head);
            opened?;
            self.opened = true;
            self.left = self.decoder.points().into();
        }
        let layers: Vec<(usize, Range<u64>)> = self.decoder.layers().collect();
        for (layer, range) in layers {
            let (bytes, complete) = self.place.read(range, share, spare)?;
            self.decoder.load(layer, bytes, complete);
        }
        Ok(())
    }

    fn decode(&mut self, records: &mut [u8]) -> Decoded {
        let wanted = (records.len() / self.record_length) as u64;
        let there = wanted.min(self.left) as usize;
        let mut decoded = self.decoder.decode(&mut records[..there * self.record_length]);
        self.left -= decoded.records as u64;
        if decoded.end == End::Filled && (there as u64) < wanted {
            decoded.end = End::Fault(format!("it says that it has {} points", self.decoder.points()));
        }
        decoded
    }

    fn unload(&mut self, spare: &mut Vec<Vec<u8>>) {
        self.decoder.unload(spare);
    }

    fn unused(&self) -> Option<u64> {
        Some(self.decoder.unused())
    }

    fn memory_bytes(&self) -> usize {
        self.decoder.memory_bytes()
    }
}
