//! GPS time, coded where the first layer says that it changed: as a multiple of the last difference,
//! in one of four sequences that take turns (several flight lines or scanners in one file).

use super::super::{coder::Coder, integer::IntegerDecoder};
use super::contexts::{Context, Contexts, Facts, Lazy, made, models_bytes};
use super::stream::{Field, Part};

/// Symbols of the model that is used after a difference: 0: another difference, 1 to 499: its multiple,
/// 500: more, 501 to 510: minus the symbol's excess over 500, …
const MORE: i32 = 500;
const LESS: i32 = -10;
/// … 511: a whole new time, 512 to 514: another sequence.
const NEW_TIME: i32 = MORE - LESS + 1;
const SYMBOLS: u32 = NEW_TIME as u32 + 4;

/// Changes of sequence at one point. An encoder makes one; only damaged bytes could go on for long.
const MOST_SWITCHES: usize = 32;

pub struct GpsTime(Contexts<Sequences, u64>);

/// The sequences of a scanner channel.
struct Sequences {
    current: usize,
    newest: usize,
    times: [i64; 4],
    differences: [i32; 4],
    /// Differences in a row that were no small multiple of the last one.
    extremes: [i32; 4],
    multiple: Lazy,
    no_difference: Lazy,
    integers: IntegerDecoder,
}

impl Context<u64> for Sequences {
    fn start(last: &u64) -> Self {
        Sequences {
            current: 0,
            newest: 0,
            times: [*last as i64, 0, 0, 0],
            differences: [0; 4],
            extremes: [0; 4],
            multiple: None,
            no_difference: None,
            integers: IntegerDecoder::new(32, 9),
        }
    }

    fn memory_bytes(&self) -> usize {
        models_bytes([&self.multiple, &self.no_difference]) + self.integers.memory_bytes()
    }
}

impl Sequences {
    /// The next time that differs from the last; `None` after changes of sequence without end.
    fn next(&mut self, coder: &mut Coder, bytes: &[u8]) -> Option<i64> {
        for _ in 0..MOST_SWITCHES {
            let now = self.current & 3;
            let difference = self.differences[now];
            if difference == 0 {
                match coder.symbol(bytes, made(&mut self.no_difference, 5)) {
                    0 => {
                        self.differences[now] = self.integers.decode(coder, bytes, 0, 0);
                        self.times[now] = self.times[now].wrapping_add(i64::from(self.differences[now]));
                        self.extremes[now] = 0;
                    }
                    1 => self.new_sequence(coder, bytes),
                    other => {
                        self.current = (now + other as usize - 1) & 3;
                        continue;
                    }
                }
                return Some(self.times[self.current & 3]);
            }
            let symbol = coder.symbol(bytes, made(&mut self.multiple, SYMBOLS)) as i32;
            if symbol > NEW_TIME {
                self.current = (now + (symbol - NEW_TIME) as usize) & 3;
                continue;
            }
            if symbol == NEW_TIME {
                self.new_sequence(coder, bytes);
                return Some(self.times[self.current & 3]);
            }
            let (factor, context) = match symbol {
                0 => (0, 7),
                1 => (1, 1),
                2..=9 => (symbol, 2),
                10..MORE => (symbol, 3),
                MORE => (MORE, 4),
                _ if MORE - symbol > LESS => (MORE - symbol, 5),
                _ => (LESS, 6),
            };
            let found = self.integers.decode(coder, bytes, factor.wrapping_mul(difference), context);
            match factor {
                1 => self.extremes[now] = 0,
                0 | MORE | LESS => {
                    self.extremes[now] += 1;
                    if self.extremes[now] > 3 {
                        self.differences[now] = found;
                        self.extremes[now] = 0;
                    }
                }
                _ => {}
            }
            self.times[now] = self.times[now].wrapping_add(i64::from(found));
            return Some(self.times[now]);
        }
        None
    }

    /// A time too far from all sequences: its high half is coded, its low half is raw.
    fn new_sequence(&mut self, coder: &mut Coder, bytes: &[u8]) {
        let high = (self.times[self.current & 3] >> 32) as i32;
        let high = self.integers.decode(coder, bytes, high, 8);
        self.newest = (self.newest + 1) & 3;
        self.times[self.newest] = i64::from(high) << 32 | i64::from(coder.int(bytes));
        self.current = self.newest;
        self.differences[self.current] = 0;
        self.extremes[self.current] = 0;
    }
}

impl GpsTime {
    pub fn new(first: &[u8], channel: usize) -> Self {
        let mut time = [0; 8];
        time.copy_from_slice(&first[22..30]);
        GpsTime(Contexts::new(u64::from_le_bytes(time), channel))
    }
}

impl Part for GpsTime {
    /// A symbol for each change of sequence, and either an integer or a new time.
    const MOST_BYTES: usize = 2 * MOST_SWITCHES + 2 * 2 + 3 + 4;

    fn memory_bytes(&self) -> usize {
        self.0.memory_bytes()
    }
}

impl Field for GpsTime {
    #[inline(always)]
    fn step(&mut self, coder: &mut Coder, bytes: &[u8], facts: Facts, record: &mut [u8]) -> bool {
        let (sequences, last) = self.0.enter(facts.point());
        if facts.time_changed() {
            let Some(time) = sequences.next(coder, bytes) else { return false };
            *last = time as u64;
        }
        record[22..30].copy_from_slice(&last.to_le_bytes());
        true
    }
}
