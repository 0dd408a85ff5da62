//! Red, green and blue in one layer, near infrared in another.

use super::super::coder::Coder;
use super::contexts::{Context, Contexts, Facts, Lazy, made, models_bytes, put_u16};
use super::stream::{Field, Part};

/// Red, green, blue: each byte is coded if it changed, green and blue relative to what red did.
pub struct Rgb {
    /// Where in the record.
    at: usize,
    contexts: Contexts<RgbModels, [u16; 3]>,
}

/// Which bytes changed; then the bytes, low and high, of red, green and blue.
struct RgbModels {
    changed: Lazy,
    bytes: [Lazy; 6],
}

impl Context<[u16; 3]> for RgbModels {
    fn start(_: &[u16; 3]) -> Self {
        RgbModels { changed: None, bytes: [const { None }; 6] }
    }

    fn memory_bytes(&self) -> usize {
        models_bytes(&self.bytes) + models_bytes([&self.changed])
    }
}

impl Rgb {
    pub fn new(first: &[u8], channel: usize, at: usize) -> Self {
        let value = |i: usize| u16::from_le_bytes([first[at + 2 * i], first[at + 2 * i + 1]]);
        Rgb { at, contexts: Contexts::new([value(0), value(1), value(2)], channel) }
    }
}

impl Part for Rgb {
    const MOST_BYTES: usize = 7 * 2;

    fn memory_bytes(&self) -> usize {
        self.contexts.memory_bytes()
    }
}

impl Field for Rgb {
    #[inline(always)]
    fn step(&mut self, coder: &mut Coder, bytes: &[u8], facts: Facts, record: &mut [u8]) -> bool {
        let at = self.at;
        let (models, last) = self.contexts.enter(facts.item());
        let changed = coder.symbol(bytes, made(&mut models.changed, 128));
        // The byte that is coded as `correction` if bit `which` says so: what was predicted plus that.
        let mut byte = |which: usize, before: u16, predicted: i32| -> u16 {
            if changed >> which & 1 == 0 {
                return before;
            }
            let correction = coder.symbol(bytes, made(&mut models.bytes[which], 256));
            u16::from((correction as u8).wrapping_add(predicted.clamp(0, 255) as u8))
        };
        let [red, green, blue] = last.map(|v| (v & 255, v >> 8));
        let red_low = byte(0, red.0, i32::from(red.0));
        let red_high = byte(1, red.1, i32::from(red.1));
        let red_now = red_high << 8 | red_low;
        *last = if changed & 64 == 0 {
            [red_now; 3]
        } else {
            let step = |now: u16, before: u16| i32::from(now) - i32::from(before);
            let up = step(red_low, red.0);
            let green_low = byte(2, green.0, up + i32::from(green.0));
            let up = (up + step(green_low, green.0)) / 2;
            let blue_low = byte(4, blue.0, up + i32::from(blue.0));
            let up = step(red_high, red.1);
            let green_high = byte(3, green.1, up + i32::from(green.1));
            let up = (up + step(green_high, green.1)) / 2;
            let blue_high = byte(5, blue.1, up + i32::from(blue.1));
            [red_now, green_high << 8 | green_low, blue_high << 8 | blue_low]
        };
        last.iter().enumerate().for_each(|(i, &v)| put_u16(record, at + 2 * i, v));
        true
    }
}

/// Near infrared: each byte is coded if it changed.
pub struct Nir {
    at: usize,
    contexts: Contexts<NirModels, u16>,
}

struct NirModels {
    changed: Lazy,
    bytes: [Lazy; 2],
}

impl Context<u16> for NirModels {
    fn start(_: &u16) -> Self {
        NirModels { changed: None, bytes: [const { None }; 2] }
    }

    fn memory_bytes(&self) -> usize {
        models_bytes(&self.bytes) + models_bytes([&self.changed])
    }
}

impl Nir {
    pub fn new(first: &[u8], channel: usize, at: usize) -> Self {
        Nir { at, contexts: Contexts::new(u16::from_le_bytes([first[at], first[at + 1]]), channel) }
    }
}

impl Part for Nir {
    const MOST_BYTES: usize = 3 * 2;

    fn memory_bytes(&self) -> usize {
        self.contexts.memory_bytes()
    }
}

impl Field for Nir {
    #[inline(always)]
    fn step(&mut self, coder: &mut Coder, bytes: &[u8], facts: Facts, record: &mut [u8]) -> bool {
        let at = self.at;
        let (models, last) = self.contexts.enter(facts.item());
        let changed = coder.symbol(bytes, made(&mut models.changed, 4));
        let mut value = last.to_le_bytes();
        for (i, (byte, model)) in value.iter_mut().zip(&mut models.bytes).enumerate() {
            if changed >> i & 1 != 0 {
                *byte = byte.wrapping_add(coder.symbol(bytes, made(model, 256)) as u8);
            }
        }
        *last = u16::from_le_bytes(value);
        put_u16(record, at, *last);
        true
    }
}
