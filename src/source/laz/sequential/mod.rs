//! Decoding sequential LAZ chunks (point formats 0 to 5): the first record as it is, then for each
//! point one item after the other, all through one arithmetic decoder, so that nothing can be skipped.
//!
//! [`SequentialDecoder`] holds a chunk's state, and (for a while) its bytes, or the first of them: a
//! chunk can be decoded a little, put aside without its bytes, and taken up again.
//!
//! ```text
//! point10, gps_time, rgb12, wave_packet13   the items, in versions 1 and 2
//! ```

mod gps_time;
mod point10;
mod rgb12;
#[cfg(test)]
mod tests;
mod wave_packet13;

use laz::{LazItem, LazItemType};

use super::{Decoded, End, coder::Coder, model::Model};

/// Most bytes that a symbol moves the decoder on by: its interval is at least 2^9 long.
const SYMBOL_BYTES: usize = 2;
/// The same for an integer: two symbols and 24 bits.
const INTEGER_BYTES: usize = 2 * SYMBOL_BYTES + 5;
/// What the decoder looks ahead by.
const LOOK_AHEAD: usize = 4;

/// An item of so many bytes.
trait Field<const BYTES: usize> {
    /// Takes the chunk's first record.
    fn first(&mut self, record: &[u8; BYTES]);
    /// Decodes the next one.
    fn next(&mut self, coder: &mut Coder, bytes: &[u8], record: &mut [u8; BYTES]);
    /// Bytes on the heap.
    fn memory_bytes(&self) -> usize;
}

/// An item's state.
#[derive(Debug)]
enum Item {
    Point(Box<point10::Point10>),
    OldPoint(Box<point10::OldPoint10>),
    GpsTime(Box<gps_time::GpsTime>),
    OldGpsTime(Box<gps_time::OldGpsTime>),
    Rgb(Box<rgb12::Rgb12>),
    OldRgb(Box<rgb12::OldRgb12>),
    WavePacket(Box<wave_packet13::WavePacket13>),
    ExtraBytes { last: Box<[u8]>, models: Box<[Model]> },
}

impl Item {
    /// `None` for an item that no sequential chunk has.
    fn new(item: &LazItem) -> Option<Item> {
        let old = item.version() == 1;
        Some(match item.item_type() {
            LazItemType::Point10 if old => Item::OldPoint(Box::new(point10::OldPoint10::new())),
            LazItemType::Point10 => Item::Point(Box::new(point10::Point10::new())),
            LazItemType::GpsTime if old => Item::OldGpsTime(Box::new(gps_time::OldGpsTime::new())),
            LazItemType::GpsTime => Item::GpsTime(Box::new(gps_time::GpsTime::new())),
            LazItemType::RGB12 if old => Item::OldRgb(Box::new(rgb12::OldRgb12::new())),
            LazItemType::RGB12 => Item::Rgb(Box::new(rgb12::Rgb12::new())),
            LazItemType::WavePacket13 => Item::WavePacket(Box::new(wave_packet13::WavePacket13::new())),
            LazItemType::Byte(n) => {
                Item::ExtraBytes { last: vec![0; n.into()].into(), models: (0..n).map(|_| Model::new(256)).collect() }
            }
            _ => return None,
        })
    }

    /// Bytes of a record that are this item's.
    fn bytes(&self) -> usize {
        match self {
            Item::Point(_) | Item::OldPoint(_) => 20,
            Item::GpsTime(_) | Item::OldGpsTime(_) => 8,
            Item::Rgb(_) | Item::OldRgb(_) => 6,
            Item::WavePacket(_) => 29,
            Item::ExtraBytes { last, .. } => last.len(),
        }
    }

    /// Most compressed bytes that it can take.
    fn most_bytes(&self) -> usize {
        match self {
            Item::Point(_) | Item::OldPoint(_) => point10::MOST_BYTES,
            Item::GpsTime(_) | Item::OldGpsTime(_) => gps_time::MOST_BYTES,
            Item::Rgb(_) | Item::OldRgb(_) => rgb12::MOST_BYTES,
            Item::WavePacket(_) => wave_packet13::MOST_BYTES,
            Item::ExtraBytes { last, .. } => SYMBOL_BYTES * last.len(),
        }
    }

    fn first(&mut self, record: &[u8]) {
        match self {
            Item::Point(item) => start(item.as_mut(), record),
            Item::OldPoint(item) => start(item.as_mut(), record),
            Item::GpsTime(item) => start(item.as_mut(), record),
            Item::OldGpsTime(item) => start(item.as_mut(), record),
            Item::Rgb(item) => start(item.as_mut(), record),
            Item::OldRgb(item) => start(item.as_mut(), record),
            Item::WavePacket(item) => start(item.as_mut(), record),
            Item::ExtraBytes { last, .. } => last.copy_from_slice(record),
        }
    }

    /// Decodes the next one into the front of `record`; returns the rest of it.
    #[inline]
    fn next<'r>(&mut self, coder: &mut Coder, bytes: &[u8], record: &'r mut [u8]) -> &'r mut [u8] {
        match self {
            Item::Point(item) => go_on(item.as_mut(), coder, bytes, record),
            Item::OldPoint(item) => go_on(item.as_mut(), coder, bytes, record),
            Item::GpsTime(item) => go_on(item.as_mut(), coder, bytes, record),
            Item::OldGpsTime(item) => go_on(item.as_mut(), coder, bytes, record),
            Item::Rgb(item) => go_on(item.as_mut(), coder, bytes, record),
            Item::OldRgb(item) => go_on(item.as_mut(), coder, bytes, record),
            Item::WavePacket(item) => go_on(item.as_mut(), coder, bytes, record),
            Item::ExtraBytes { last, models } => {
                let (now, rest) = record.split_at_mut(last.len());
                for ((last, now), model) in last.iter_mut().zip(now).zip(models) {
                    *last = last.wrapping_add(coder.symbol(bytes, model) as u8);
                    *now = *last;
                }
                rest
            }
        }
    }

    fn memory_bytes(&self) -> usize {
        fn boxed<const BYTES: usize>(item: &impl Field<BYTES>) -> usize {
            size_of_val(item) + item.memory_bytes()
        }
        match self {
            Item::Point(item) => boxed(item.as_ref()),
            Item::OldPoint(item) => boxed(item.as_ref()),
            Item::GpsTime(item) => boxed(item.as_ref()),
            Item::OldGpsTime(item) => boxed(item.as_ref()),
            Item::Rgb(item) => boxed(item.as_ref()),
            Item::OldRgb(item) => boxed(item.as_ref()),
            Item::WavePacket(item) => boxed(item.as_ref()),
            Item::ExtraBytes { last, models } => {
                last.len() + size_of_val(&**models) + models.iter().map(Model::memory_bytes).sum::<usize>()
            }
        }
    }
}

fn start<const BYTES: usize>(item: &mut impl Field<BYTES>, record: &[u8]) {
    if let Some(record) = record.first_chunk() {
        item.first(record);
    }
}

#[inline]
fn go_on<'r, const BYTES: usize>(
    item: &mut impl Field<BYTES>,
    coder: &mut Coder,
    bytes: &[u8],
    record: &'r mut [u8],
) -> &'r mut [u8] {
    let Some((now, rest)) = record.split_first_chunk_mut() else { return &mut [] };
    item.next(coder, bytes, now);
    rest
}

/// Decodes one sequential chunk, in as many steps as wanted.
#[derive(Debug)]
pub struct SequentialDecoder {
    items: Vec<Item>,
    record_length: usize,
    /// A point's compressed bytes are never more than this.
    most_bytes: usize,
    /// `None` before the first record.
    coder: Option<Coder>,
    /// The chunk's first bytes, or all of them.
    bytes: Vec<u8>,
    complete: bool,
    /// Why there is no going on.
    fault: Option<String>,
}

impl SequentialDecoder {
    /// A decoder for a chunk of these items (`Point10`, `GpsTime`, `RGB12`, `WavePacket13`, `Byte(n)`, of
    /// version 1 or 2; any other is a fault of the first decoding).
    pub fn new(items: &[LazItem]) -> SequentialDecoder {
        let mut fault = None;
        let mut known = Vec::with_capacity(items.len());
        for item in items {
            match Item::new(item) {
                Some(item) => known.push(item),
                None => fault = Some(format!("item {:?} is not of a sequential chunk", item.item_type())),
            }
        }
        SequentialDecoder {
            record_length: items.iter().map(|i| usize::from(i.size())).sum::<usize>().max(1),
            most_bytes: known.iter().map(Item::most_bytes).sum::<usize>() + LOOK_AHEAD,
            items: known,
            coder: None,
            bytes: Vec::new(),
            complete: false,
            fault,
        }
    }

    /// Gives it the chunk's first bytes, from its very first on, in place of what it had; `complete` if
    /// they are all the chunk has.
    pub fn load(&mut self, bytes: Vec<u8>, complete: bool) {
        self.bytes = bytes;
        self.complete = complete;
    }

    /// Takes its bytes back, for their memory. It goes on where it was once it is given some again.
    pub fn unload(&mut self) -> Vec<u8> {
        self.complete = false;
        std::mem::take(&mut self.bytes)
    }

    /// Writes the chunk's next raw records, as many as `records` has whole ones. Before a point that
    /// might not lie whole in the bytes that are loaded, it asks for more; when complete bytes end
    /// early, that is a fault, and so is every call after.
    pub fn decode(&mut self, records: &mut [u8]) -> Decoded {
        let mut done = 0;
        if let Some(fault) = &self.fault {
            return Decoded { records: 0, end: End::Fault(fault.clone()) };
        }
        let mut rest = records.chunks_exact_mut(self.record_length);
        if self.coder.is_none() {
            let Some(record) = rest.next() else { return Decoded { records: 0, end: End::Filled } };
            let Some(first) = self.bytes.get(..self.record_length).filter(|_| self.has(LOOK_AHEAD)) else {
                return self.stopped(0);
            };
            record.copy_from_slice(first);
            let mut of_item = first;
            for item in &mut self.items {
                let (now, after) = of_item.split_at(item.bytes().min(of_item.len()));
                item.first(now);
                of_item = after;
            }
            self.coder = Some(Coder::start(&self.bytes, self.record_length));
            done = 1;
        }
        let Some(coder) = &mut self.coder else { return self.stopped(done) };
        let bytes = self.bytes.as_slice();
        // Past this, a point may need bytes that are not there: of a prefix it is not begun, of a whole
        // chunk it is looked at afterwards.
        let last_start = if self.complete { bytes.len() } else { bytes.len().saturating_sub(self.most_bytes) };
        for record in rest {
            if coder.next() > last_start {
                return self.stopped(done);
            }
            let mut record = record;
            for item in &mut self.items {
                record = item.next(coder, bytes, record);
            }
            if coder.next() > bytes.len() {
                return self.stopped(done);
            }
            done += 1;
        }
        Decoded { records: done, end: End::Filled }
    }

    /// True if the first record and so many bytes more are there.
    fn has(&self, more: usize) -> bool {
        self.bytes.len() >= self.record_length + more
    }

    /// The end for want of bytes.
    fn stopped(&mut self, records: usize) -> Decoded {
        if !self.complete {
            return Decoded { records, end: End::NeedsBytes };
        }
        let fault = "its compressed bytes end early".to_owned();
        self.fault = Some(fault.clone());
        Decoded { records, end: End::Fault(fault) }
    }

    /// Bytes of the complete chunk that no point took so far: 0 after the last point of a good chunk.
    pub fn unused(&self) -> u64 {
        self.bytes.len().saturating_sub(self.coder.as_ref().map_or(0, Coder::next)) as u64
    }

    /// Bytes on the heap, the loaded bytes apart.
    pub fn memory_bytes(&self) -> usize {
        self.items.capacity() * size_of::<Item>() + self.items.iter().map(Item::memory_bytes).sum::<usize>()
    }
}
