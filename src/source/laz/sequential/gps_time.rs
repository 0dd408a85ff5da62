//! GPS time (8 bytes): the bits of a 64-bit float, as an integer, by the difference to the last one in
//! multiples of the difference before. Version 2 follows up to four time sequences at once.

use super::{
    super::{coder::Coder, integer::IntegerDecoder, model::Model},
    Field,
};

/// Multiples up to this are symbols of their own in version 2; the ones after are −1 to −10, then
/// unchanged, then a time in full, then a switch to one of the three other sequences.
const MULTI: i32 = 500;
const MULTI_MINUS: i32 = -10;
const UNCHANGED: i32 = MULTI - MULTI_MINUS + 1;
const FULL: i32 = MULTI - MULTI_MINUS + 2;
const SYMBOLS: u32 = 516;

/// An encoder switches at most once per point; that no bytes keep a decoder busy, this is the end.
const MOST_SWITCHES: usize = 64;

/// Most bytes that a time can take, in either version.
pub(super) const MOST_BYTES: usize = (MOST_SWITCHES + 1) * super::SYMBOL_BYTES + super::INTEGER_BYTES + 8;

/// Version 2.
#[derive(Debug)]
pub(super) struct GpsTime {
    /// The sequence of the last time, and the one that was begun last.
    last: usize,
    next: usize,
    times: [i64; 4],
    differences: [i32; 4],
    /// How often in a row a multiple was beyond what symbols tell.
    extremes: [u8; 4],
    multi: Model,
    zero_difference: Model,
    time: IntegerDecoder,
}

impl GpsTime {
    pub(super) fn new() -> GpsTime {
        GpsTime {
            last: 0,
            next: 0,
            times: [0; 4],
            differences: [0; 4],
            extremes: [0; 4],
            multi: Model::new(SYMBOLS),
            zero_difference: Model::new(6),
            time: IntegerDecoder::new(32, 9),
        }
    }

    /// A time of a new sequence: its upper half as an integer, its lower half as it is.
    #[cold]
    fn begin(&mut self, coder: &mut Coder, bytes: &[u8]) {
        let pred = (self.times[self.last] >> 32) as i32;
        let high = self.time.decode(coder, bytes, pred, 8);
        self.next = (self.next + 1) & 3;
        self.times[self.next] = i64::from(high) << 32 | i64::from(coder.int(bytes));
        self.last = self.next;
        self.differences[self.last] = 0;
        self.extremes[self.last] = 0;
    }

    fn advance(&mut self, difference: i32) {
        self.times[self.last] = self.times[self.last].wrapping_add(difference.into());
    }

    /// A difference that is no good multiple: the fourth in a row is the new measure.
    fn extreme(&mut self, difference: i32) {
        self.extremes[self.last] += 1;
        if self.extremes[self.last] > 3 {
            self.differences[self.last] = difference;
            self.extremes[self.last] = 0;
        }
    }

    /// A difference in terms of the one before.
    fn multiple(&mut self, coder: &mut Coder, bytes: &[u8], multi: i32) {
        let before = self.differences[self.last];
        let mut integer = |factor: i32, context| self.time.decode(coder, bytes, before.wrapping_mul(factor), context);
        let (difference, extreme) = match multi {
            0 => (integer(0, 7), true),
            1 => {
                let difference = integer(1, 1);
                self.extremes[self.last] = 0;
                (difference, false)
            }
            2..10 => (integer(multi, 2), false),
            10..MULTI => (integer(multi, 3), false),
            MULTI => (integer(MULTI, 4), true),
            _ if MULTI - multi > MULTI_MINUS => (integer(MULTI - multi, 5), false),
            _ => (integer(MULTI_MINUS, 6), true),
        };
        if extreme {
            self.extreme(difference);
        }
        self.advance(difference);
    }
}

impl Field<8> for GpsTime {
    fn first(&mut self, record: &[u8; 8]) {
        self.times[0] = i64::from_le_bytes(*record);
    }

    fn next(&mut self, coder: &mut Coder, bytes: &[u8], record: &mut [u8; 8]) {
        for _ in 0..=MOST_SWITCHES {
            let switch;
            if self.differences[self.last] == 0 {
                match coder.symbol(bytes, &mut self.zero_difference) as i32 {
                    0 => break,
                    1 => {
                        let difference = self.time.decode(coder, bytes, 0, 0);
                        self.differences[self.last] = difference;
                        self.extremes[self.last] = 0;
                        self.advance(difference);
                        break;
                    }
                    2 => {
                        self.begin(coder, bytes);
                        break;
                    }
                    other => switch = other - 2,
                }
            } else {
                match coder.symbol(bytes, &mut self.multi) as i32 {
                    UNCHANGED => break,
                    FULL => {
                        self.begin(coder, bytes);
                        break;
                    }
                    multi if multi < UNCHANGED => {
                        self.multiple(coder, bytes, multi);
                        break;
                    }
                    other => switch = other - FULL,
                }
            }
            self.last = (self.last + switch as usize) & 3;
        }
        *record = self.times[self.last & 3].to_le_bytes();
    }

    fn memory_bytes(&self) -> usize {
        self.multi.memory_bytes() + self.zero_difference.memory_bytes() + self.time.memory_bytes()
    }
}

/// Symbols of version 1: multiples from 0 on, then a time in full, then unchanged.
const OLD_SYMBOLS: u32 = 512;
const OLD_MOST: i32 = OLD_SYMBOLS as i32 - 3;
const OLD_FULL: i32 = OLD_SYMBOLS as i32 - 2;

/// Version 1.
#[derive(Debug)]
pub(super) struct OldGpsTime {
    last: i64,
    difference: i32,
    extremes: u8,
    multi: Model,
    zero_difference: Model,
    time: IntegerDecoder,
}

impl OldGpsTime {
    pub(super) fn new() -> OldGpsTime {
        OldGpsTime {
            last: 0,
            difference: 0,
            extremes: 0,
            multi: Model::new(OLD_SYMBOLS),
            zero_difference: Model::new(3),
            time: IntegerDecoder::new(32, 6),
        }
    }

    fn multiple(&mut self, coder: &mut Coder, bytes: &[u8], multi: i32) {
        let before = self.difference;
        let (pred, context) = match multi {
            0 => (before / 4, 2),
            1 => (before, 1),
            2..10 => (before.wrapping_mul(multi), 3),
            10..50 => (before.wrapping_mul(multi), 4),
            _ => (before.wrapping_mul(multi), 5),
        };
        let difference = self.time.decode(coder, bytes, pred, context);
        match multi {
            1 => {
                self.difference = difference;
                self.extremes = 0;
            }
            0 | OLD_MOST => {
                self.extremes += 1;
                if self.extremes > 3 {
                    self.difference = difference;
                    self.extremes = 0;
                }
            }
            _ => {}
        }
        self.last = self.last.wrapping_add(difference.into());
    }
}

impl Field<8> for OldGpsTime {
    fn first(&mut self, record: &[u8; 8]) {
        self.last = i64::from_le_bytes(*record);
    }

    fn next(&mut self, coder: &mut Coder, bytes: &[u8], record: &mut [u8; 8]) {
        if self.difference == 0 {
            match coder.symbol(bytes, &mut self.zero_difference) {
                1 => {
                    self.difference = self.time.decode(coder, bytes, 0, 0);
                    self.last = self.last.wrapping_add(self.difference.into());
                }
                2 => self.last = coder.int64(bytes) as i64,
                _ => {}
            }
        } else {
            match coder.symbol(bytes, &mut self.multi) as i32 {
                OLD_FULL => self.last = coder.int64(bytes) as i64,
                multi if multi < OLD_FULL => self.multiple(coder, bytes, multi),
                _ => {}
            }
        }
        *record = self.last.to_le_bytes();
    }

    fn memory_bytes(&self) -> usize {
        self.multi.memory_bytes() + self.zero_difference.memory_bytes() + self.time.memory_bytes()
    }
}
