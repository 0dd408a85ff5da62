//! The running median of LASzip's predictions, of either family of formats.

use std::hint::select_unpredictable;

/// The median of the last five numbers, roughly: which end drops out depends on the side of the median
/// that the last number fell on. It is the one that the encoder had.
#[derive(Debug, Clone, Copy)]
pub struct StreamingMedian {
    values: [i32; 5],
    high: bool,
}

impl StreamingMedian {
    pub const NEW: StreamingMedian = StreamingMedian { values: [0; 5], high: true };

    #[inline]
    pub fn get(&self) -> i32 {
        self.values[2]
    }

    /// In comes `v`, out goes the highest or the lowest; without a branch, as nobody knows which.
    #[inline]
    pub fn add(&mut self, v: i32) {
        let [a, b, c, d, e] = self.values;
        let kept = select_unpredictable(self.high, [a, b, c, d], [b, c, d, e]);
        self.high = v < c || (v == c && !self.high);
        let [a, b, c, d] = kept;
        self.values = [v.min(a), v.min(b).max(a), v.min(c).max(b), v.min(d).max(c), v.max(d)];
    }
}
