//! Colours of formats 2, 3 and 5 (`RGB12`, 6 bytes): which of the six bytes changed, then each of
//! those. In version 2 green and blue are predicted by what red did.

use super::{
    super::{coder::Coder, integer::IntegerDecoder, model::Model},
    Field,
};

/// Most bytes that a colour can take, in either version.
pub(super) const MOST_BYTES: usize = super::SYMBOL_BYTES * 13;

/// Version 2.
#[derive(Debug)]
pub(super) struct Rgb12 {
    /// Red, green, blue; the lower byte of each first.
    last: [u8; 6],
    changed: Model,
    bytes: [Model; 6],
}

impl Rgb12 {
    pub(super) fn new() -> Rgb12 {
        Rgb12 { last: [0; 6], changed: Model::new(128), bytes: std::array::from_fn(|_| Model::new(256)) }
    }
}

impl Field<6> for Rgb12 {
    fn first(&mut self, record: &[u8; 6]) {
        self.last = *record;
    }

    #[inline]
    fn next(&mut self, coder: &mut Coder, bytes: &[u8], record: &mut [u8; 6]) {
        let last = self.last;
        let mut now = last;
        let changed = coder.symbol(bytes, &mut self.changed);
        // Red's lower and upper byte, then the lower bytes of green and blue, then their upper ones.
        for byte in [0, 1] {
            if changed & 1 << byte != 0 {
                now[byte] = last[byte].wrapping_add(coder.symbol(bytes, &mut self.bytes[byte]) as u8);
            }
        }
        if changed & 1 << 6 == 0 {
            now = [now[0], now[1], now[0], now[1], now[0], now[1]];
        } else {
            for half in [0, 1] {
                let [red, green, blue] = [half, 2 + half, 4 + half];
                let mut moved = i32::from(now[red]) - i32::from(last[red]);
                let mut byte = |byte: usize, moved: i32| {
                    let difference = coder.symbol(bytes, &mut self.bytes[byte]) as u8;
                    let predicted = (moved + i32::from(last[byte])).clamp(0, 255) as u8;
                    difference.wrapping_add(predicted)
                };
                if changed & 1 << green != 0 {
                    now[green] = byte(green, moved);
                }
                if changed & 1 << blue != 0 {
                    moved = (moved + i32::from(now[green]) - i32::from(last[green])) / 2;
                    now[blue] = byte(blue, moved);
                }
            }
        }
        self.last = now;
        *record = now;
    }

    fn memory_bytes(&self) -> usize {
        self.changed.memory_bytes() + self.bytes.iter().map(Model::memory_bytes).sum::<usize>()
    }
}

/// Version 1, as LASzip decodes it. (The `laz` crate, 0.13, adds the bits of a new upper byte to those
/// of the old one.)
#[derive(Debug)]
pub(super) struct OldRgb12 {
    last: [u8; 6],
    changed: Model,
    bytes: IntegerDecoder,
}

impl OldRgb12 {
    pub(super) fn new() -> OldRgb12 {
        OldRgb12 { last: [0; 6], changed: Model::new(64), bytes: IntegerDecoder::new(8, 6) }
    }
}

impl Field<6> for OldRgb12 {
    fn first(&mut self, record: &[u8; 6]) {
        self.last = *record;
    }

    fn next(&mut self, coder: &mut Coder, bytes: &[u8], record: &mut [u8; 6]) {
        let changed = coder.symbol(bytes, &mut self.changed);
        for (context, byte) in self.last.iter_mut().enumerate() {
            if changed & 1 << context != 0 {
                *byte = self.bytes.decode(coder, bytes, (*byte).into(), context as u32) as u8;
            }
        }
        *record = self.last;
    }

    fn memory_bytes(&self) -> usize {
        self.changed.memory_bytes() + self.bytes.memory_bytes()
    }
}
