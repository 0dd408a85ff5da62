//! Adaptive models: how often each symbol has come so far, as the arithmetic decoder needs it.
//!
//! The numbers are those of LASzip's models to the last bit (A. Said, "Introduction to arithmetic
//! coding", HPL-2004-76); only their place in memory differs. The distribution lies in rows of 16
//! numbers of 16 bits, so that a row is searched by comparing all of it at once. Models of up to 64
//! symbols have four rows, all searched; larger ones have upper rows, which say which row it is. So there
//! is no decoder table to rebuild at each update, no bisection, whose branches nobody can predict, and no
//! other way for models of 2 symbols than for those of 64: which of them comes is as good as random, too.

use std::hint::select_unpredictable;

use super::search::{FLAT, ROW, first_above, first_above_of_four};

/// Counts are halved when their sum passes this; a distribution is in these units, too.
const TOTAL: u32 = 1 << 15;

/// A symbol that came at least once in so many times is guessed first. (A fifth, or half: 1 to 2 %
/// slower.)
const GOOD_GUESS: u32 = 3;

/// Above every value that is searched for.
const NEVER: u16 = i16::MAX as u16;

/// An adaptive model of 2 to 2,048 symbols.
#[derive(Debug, Clone)]
pub struct Model {
    /// Upper rows (the first entry of each lower row; none up to 64 symbols), lower rows (the
    /// distribution: the share of all symbols below this one), and the counts. What is no symbol's is
    /// `NEVER` (0 in counts).
    slab: Box<[[u16; ROW]]>,
    /// Where in the slab the distribution and the counts start, in rows.
    distribution: u16,
    counts: u16,
    last: u16,
    until_update: u16,
    cycle: u16,
    /// Sum of the counts at the last update, at most `TOTAL`.
    total: u16,
    /// The symbol that came most, where its share starts and ends; if that is too small for a good
    /// guess, a share of nothing.
    pub(super) guess: Share,
}

/// A symbol's part of the interval, in units of 1/32,768 of it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Share {
    pub(super) symbol: u16,
    pub(super) start: u16,
    /// `REST` for the last symbol, whose share goes on to the very end of the interval.
    pub(super) end: u16,
}

/// The end of the last symbol's share.
pub(super) const REST: u16 = 1 << 15;

impl Model {
    /// A model of so many symbols, all as likely as each other.
    pub fn new(symbols: u32) -> Model {
        let symbols = symbols.clamp(2, 2048) as usize;
        let (upper, rows) = match symbols.div_ceil(ROW) {
            1..=FLAT => (0, FLAT),
            rows => (rows.div_ceil(ROW), rows),
        };
        let mut slab = vec![[NEVER; ROW]; upper + 2 * rows].into_boxed_slice();
        let counts = slab[upper + rows..].as_flattened_mut();
        counts[..symbols].fill(1);
        counts[symbols..].fill(0);
        let mut model = Model {
            slab,
            distribution: upper as u16,
            counts: (upper + rows) as u16,
            last: symbols as u16 - 1,
            until_update: 0,
            cycle: symbols as u16,
            total: 0,
            guess: Share::default(),
        };
        model.update();
        model.cycle = (symbols as u16 + 6) >> 1;
        model.until_update = model.cycle;
        model
    }

    /// The share that holds `scaled`, a value in units of 1/32,768 of the interval.
    #[inline(always)]
    pub(super) fn find(&self, scaled: u32) -> Share {
        if scaled >= u32::from(NEVER) {
            return self.find_at_the_end(scaled);
        }
        let scaled = scaled as u16;
        let upper = usize::from(self.distribution);
        let symbol = if upper == 1 {
            let row = first_above(&self.slab[0], scaled) - 1;
            ROW * row + first_above(&self.slab[1 + row], scaled) - 1
        } else if let Some(rows) = self.slab.first_chunk()
            && upper == 0
        {
            first_above_of_four(rows, scaled) - 1
        } else {
            let row = self.slab[..upper].iter().map(|r| first_above(r, scaled)).sum::<usize>() - 1;
            ROW * row + first_above(&self.slab[upper + row], scaled) - 1
        };
        // After the last symbol's come counts, never the slab's end. Which symbol is the last one is
        // anybody's guess in a model of two.
        let distribution = &self.slab[upper..].as_flattened()[symbol..symbol + 2];
        let end = select_unpredictable(symbol == usize::from(self.last), REST, distribution[1]);
        Share { symbol: symbol as u16, start: distribution[0], end }
    }

    /// `find` for a value that no row can be searched for: one of the last two symbols.
    #[cold]
    #[inline(never)]
    fn find_at_the_end(&self, scaled: u32) -> Share {
        let distribution = self.slab[usize::from(self.distribution)..].as_flattened();
        let last = self.last;
        let start = distribution[usize::from(last)];
        if scaled >= u32::from(start) {
            Share { symbol: last, start, end: REST }
        } else {
            Share { symbol: last - 1, start: distribution[usize::from(last - 1)], end: start }
        }
    }

    /// Notes that a symbol came.
    #[inline(always)]
    pub(super) fn count(&mut self, symbol: u16) {
        let counts = self.slab[usize::from(self.counts)..].as_flattened_mut();
        // Below 2^15 plus the longest cycle, 16,432: no overflow.
        counts[usize::from(symbol)] = counts[usize::from(symbol)].wrapping_add(1);
        self.until_update -= 1;
        if self.until_update == 0 {
            self.update();
        }
    }

    /// The distribution from the counts: every few symbols at first, then less and less often.
    #[cold]
    #[inline(never)]
    fn update(&mut self) {
        let (rest, counts) = self.slab.split_at_mut(usize::from(self.counts));
        let (upper, distribution) = rest.split_at_mut(usize::from(self.distribution));
        let symbols = usize::from(self.last) + 1;
        let counts = &mut counts.as_flattened_mut()[..symbols];
        let mut total = u32::from(self.total) + u32::from(self.cycle);
        if total > TOTAL {
            total = 0;
            for count in counts.iter_mut() {
                *count = (*count + 1) >> 1;
                total += u32::from(*count);
            }
        }
        self.total = total as u16;
        // At least 2^16, so that shares grow with every symbol; times the sum, at most 2^31.
        let scale = 0x8000_0000 / total;
        let mut sum = 0;
        for (share, count) in distribution.as_flattened_mut().iter_mut().zip(counts.iter()) {
            *share = ((scale * sum) >> 16) as u16;
            sum += u32::from(*count);
        }
        for (first, row) in upper.as_flattened_mut().iter_mut().zip(distribution.iter()) {
            *first = row[0];
        }
        let most = (symbols as u32 + 6) << 3;
        self.cycle = ((5 * u32::from(self.cycle)) >> 2).min(most) as u16;
        self.until_update = self.cycle;

        let highest = counts.iter().copied().max().unwrap_or(0);
        self.guess = Share::default();
        if u32::from(highest) * GOOD_GUESS >= total {
            let symbol = counts.iter().position(|&c| c == highest).unwrap_or(0);
            let distribution = distribution.as_flattened();
            let end = if symbol + 1 == symbols { REST } else { distribution[symbol + 1] };
            self.guess = Share { symbol: symbol as u16, start: distribution[symbol], end };
        }
    }

    /// Bytes on the heap.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.slab)
    }
}

/// An adaptive model of a bit.
#[derive(Debug, Clone)]
pub struct BitModel {
    /// Share of zeros, in units of 1/8,192.
    pub(super) zero: u32,
    zeros: u32,
    total: u32,
    until_update: u32,
    cycle: u32,
}

impl Default for BitModel {
    fn default() -> BitModel {
        BitModel { zero: 1 << 12, zeros: 1, total: 2, until_update: 4, cycle: 4 }
    }
}

impl BitModel {
    /// Notes that a bit came.
    #[inline]
    pub(super) fn count(&mut self, bit: u32) {
        self.zeros += 1 - bit;
        self.until_update -= 1;
        if self.until_update == 0 {
            self.update();
        }
    }

    #[cold]
    #[inline(never)]
    fn update(&mut self) {
        self.total += self.cycle;
        if self.total > 1 << 13 {
            self.total = (self.total + 1) >> 1;
            self.zeros = (self.zeros + 1) >> 1;
            if self.zeros == self.total {
                self.total += 1;
            }
        }
        let scale = 0x8000_0000 / self.total;
        self.zero = (self.zeros * scale) >> 18;
        self.cycle = ((5 * self.cycle) >> 2).min(64);
        self.until_update = self.cycle;
    }
}

/// Models of one size, each made when it is first used: a chunk of a thousand points uses few of them.
#[derive(Debug, Clone)]
pub struct LazyModels {
    symbols: u32,
    models: Box<[Option<Box<Model>>]>,
}

impl LazyModels {
    /// So many models (at least one) of so many symbols each.
    pub fn new(models: usize, symbols: u32) -> LazyModels {
        LazyModels { symbols, models: (0..models.max(1)).map(|_| None).collect() }
    }

    /// The model of a number; beyond the last one, the last.
    #[inline]
    pub fn get(&mut self, number: u32) -> &mut Model {
        let number = (number as usize).min(self.models.len() - 1);
        let symbols = self.symbols;
        self.models[number].get_or_insert_with(|| make(symbols))
    }

    /// Bytes on the heap.
    pub fn memory_bytes(&self) -> usize {
        let made = self.models.iter().flatten().map(|m| size_of::<Model>() + m.memory_bytes());
        size_of_val(&*self.models) + made.sum::<usize>()
    }
}

#[cold]
#[inline(never)]
fn make(symbols: u32) -> Box<Model> {
    Box::new(Model::new(symbols))
}
