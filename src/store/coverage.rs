//! Which slots were tried since the picture was last invalidated, as two cursors.
//!
//! Tried slots are `[start, high)` and, once `high` has reached the end, `[0, low)`. Insertion keeps
//! that true: a new point is drawn as it arrives, wherever it lands, and the old point that it evicts
//! moves to the tail. While `high` still climbs, the tail is ahead of it. After that, the tail that
//! grew behind `high` is tried first. So "every point was tried" is exact, also while loading.

use std::ops::Range;

/// Progress of the fill through the slots `[0, len)`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Coverage {
    start: u32,
    high: u32,
    low: u32,
}

impl Coverage {
    /// Forgets what was tried; the cursor stays where it is, so that a moving camera sees other
    /// points in each frame.
    pub fn restart(&mut self) {
        let cursor = if self.low > 0 { self.low } else { self.high };
        *self = Coverage { start: cursor, high: cursor, low: 0 };
    }

    /// Takes the next `budget` untried slots of `[0, len)`: at most two ranges, either may be empty.
    pub fn advance(&mut self, len: u32, budget: u32) -> [Range<u32>; 2] {
        let up = budget.min(len - self.high);
        let first = self.high..self.high + up;
        self.high += up;
        let wrapped = if self.high == len { (budget - up).min(self.start - self.low) } else { 0 };
        let second = self.low..self.low + wrapped;
        self.low += wrapped;
        [first, second]
    }

    /// Slots tried, of `len`.
    pub fn tried(&self) -> u32 {
        self.high - self.start + self.low
    }

    /// True if every slot of `[0, len)` was tried.
    pub fn is_complete(&self, len: u32) -> bool {
        self.tried() == len
    }

    /// Tells that `count` points entered a store of `len` and are drawn in this frame. If nothing was
    /// untried, none of the points that they evict is, and nothing has to be tried again.
    pub fn note_inserted(&mut self, len: u32, count: u32) {
        if self.is_complete(len) {
            *self = Coverage { start: 0, high: len + count, low: 0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_slot_is_tried_once() {
        let mut c = Coverage { start: 7, high: 7, low: 0 };
        let mut seen = vec![0; 20];
        let mut steps = 0;
        while !c.is_complete(20) {
            for r in c.advance(20, 6) {
                r.for_each(|s| seen[s as usize] += 1);
            }
            steps += 1;
        }
        assert_eq!(seen, vec![1; 20]);
        assert_eq!(steps, 4);
    }

    #[test]
    fn a_tail_that_grew_is_tried_before_the_wrapped_rest() {
        let mut c = Coverage { start: 5, high: 5, low: 0 };
        c.advance(10, 7); // 5..10 and 0..2
        assert_eq!(c.advance(13, 4), [10..13, 2..3]);
        assert_eq!(c.tried(), 11);
        assert!(!c.is_complete(13));
        c.advance(13, 100);
        assert!(c.is_complete(13));
    }

    #[test]
    fn points_drawn_on_arrival_need_no_fill() {
        let mut c = Coverage::default();
        c.note_inserted(0, 5);
        c.note_inserted(5, 3);
        assert!(c.is_complete(8));
        c.restart();
        c.note_inserted(8, 2);
        assert_eq!(c.tried(), 0, "the old points are untried");
        assert_eq!(c.advance(10, 100), [8..10, 0..8]);
        assert!(c.is_complete(10));
    }

    #[test]
    fn restart_goes_on_from_the_cursor() {
        let mut c = Coverage::default();
        c.advance(10, 4);
        c.restart();
        assert_eq!(c.advance(10, 3), [4..7, 0..0]);
        c.advance(10, 5); // 7..10, 0..2
        c.restart();
        assert_eq!(c.advance(10, 3), [2..5, 0..0]);
    }
}
