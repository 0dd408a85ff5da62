//! Integers as LASzip codes them: the difference to a prediction, as the number of its bits (by
//! context), then its up to eight highest bits (by number of bits), then the rest as it is.
//!
//! Bit for bit the `laz` crate's `IntegerDecompressor`, but models are made when they are first used:
//! a chunk's set-up costs next to nothing, where making all of them costs 0.3 to 0.5 ms.

use std::hint::select_unpredictable;

use super::{
    coder::Coder,
    model::{BitModel, LazyModels, Model},
};

/// Bits of a difference that a model is kept of.
const MODELLED: u32 = 8;

/// Decodes one column of integers.
#[derive(Debug, Clone)]
pub struct IntegerDecoder {
    bits: u32,
    /// Bits of the last difference.
    k: u32,
    /// Models of `k`, one per context.
    lengths: LazyModels,
    /// For a difference of 0 or 1.
    one: BitModel,
    /// Models of the highest bits, for `k` from 1.
    high: Box<[Option<Box<Model>>]>,
}

impl IntegerDecoder {
    /// Integers of `bits` bits (8, 16, 32; values of fewer than 32 wrap around), with so many contexts.
    pub fn new(bits: u32, contexts: usize) -> IntegerDecoder {
        let bits = bits.clamp(1, 32);
        IntegerDecoder {
            bits,
            k: 0,
            lengths: LazyModels::new(contexts, bits + 1),
            one: BitModel::default(),
            high: (0..bits).map(|_| None).collect(),
        }
    }

    /// Bits of the difference that was decoded last: 0 to 32.
    #[inline]
    pub fn k(&self) -> u32 {
        self.k
    }

    /// The next integer.
    #[inline]
    pub fn decode(&mut self, coder: &mut Coder, bytes: &[u8], pred: i32, context: u32) -> i32 {
        let k = coder.symbol(bytes, self.lengths.get(context));
        self.k = k;
        let difference = match k {
            0 => coder.bit(bytes, &mut self.one) as i32,
            32.. => i32::MIN,
            _ => {
                let high = coder.symbol(bytes, model_of(&mut self.high, k));
                let c = if k <= MODELLED {
                    high
                } else {
                    let low = k - MODELLED;
                    high << low | coder.bits(bytes, low)
                };
                // [0, 2^k) stands for what has just k bits: [1 − 2^k, −2^(k−1)] and (2^(k−1), 2^k].
                let c = c as i32;
                c.wrapping_add(select_unpredictable(c >= 1 << (k - 1), 1, 1i32.wrapping_sub(1 << k)))
            }
        };
        let real = pred.wrapping_add(difference);
        // Selected, not branched on: signs are as good as random.
        let range = 1i32.checked_shl(self.bits).unwrap_or(0);
        let above = select_unpredictable(real >= range, range.wrapping_neg(), 0);
        real.wrapping_add(select_unpredictable(real < 0, range, above))
    }

    /// Bytes on the heap.
    pub fn memory_bytes(&self) -> usize {
        let high = self.high.iter().flatten().map(|m| size_of::<Model>() + m.memory_bytes());
        self.lengths.memory_bytes() + size_of_val(&*self.high) + high.sum::<usize>()
    }
}

#[inline]
fn model_of(models: &mut [Option<Box<Model>>], k: u32) -> &mut Model {
    let place = (k as usize - 1).min(models.len() - 1);
    models[place].get_or_insert_with(|| make(k))
}

#[cold]
#[inline(never)]
fn make(k: u32) -> Box<Model> {
    Box::new(Model::new(1 << k.min(MODELLED)))
}
