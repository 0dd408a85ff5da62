//! Incremental insertion: a batch of `b` points enters `n` shuffled ones so that all `n + b` slots
//! hold points in uniformly random order, without holes. Twin of `shaders/insert.wgsl`.
//!
//! 1. New point `i` gets slot `P(i)`, `P` a permutation of `[0, n + b)`.
//! 2. An old point whose slot is taken moves to a free slot of the tail `[n, n + b)`: the `k`-th
//!    taken one, in order of `i`, to the `k`-th free slot, in order of slots.
//! 3. `moved_to[i]` remembers where the point went that `i` evicted.

use super::permutation::{Permutation, SlotOrder};

/// Most points that a backend takes as one insertion: 24 MiB on their way, 16 times that in a ring.
pub const MAX_INSERTION_POINTS: u32 = 1 << 20;

/// One batch entering the store: `new` points on `old` ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Insertion {
    pub old: u32,
    pub new: u32,
    pub permutation: Permutation,
}

impl Insertion {
    /// The `index`-th insertion of a store with this `seed`.
    pub fn new(old: u32, new: u32, seed: u64, index: u64) -> Insertion {
        Insertion::in_order(SlotOrder::Shuffled, old, new, seed, index)
    }

    /// The same in another order than the shuffled one, for measuring what the shuffle is worth.
    pub fn in_order(order: SlotOrder, old: u32, new: u32, seed: u64, index: u64) -> Insertion {
        Insertion { old, new, permutation: Permutation::in_order(order, old, new, seed, index) }
    }

    /// For each new point the slot where the old point went that it evicted; `u32::MAX` if it evicted
    /// none.
    pub fn moved_to(&self) -> Vec<u32> {
        let mut free = (self.old..self.old + self.new).filter(|&s| self.permutation.invert(s) >= self.new);
        (0..self.new)
            .map(|i| {
                if self.permutation.apply(i) < self.old {
                    free.next().expect("as many free tail slots as evicted points")
                } else {
                    u32::MAX
                }
            })
            .collect()
    }

    /// Performs the insertion on a column of the store. `moved_to` is [`Insertion::moved_to`].
    pub fn apply<T: Copy + Default>(&self, column: &mut Vec<T>, new: &[T], moved_to: &[u32]) {
        assert_eq!((column.len(), new.len()), (self.old as usize, self.new as usize));
        column.resize((self.old + self.new) as usize, T::default());
        for (i, (&point, &to)) in new.iter().zip(moved_to).enumerate() {
            let slot = self.permutation.apply(i as u32);
            if to != u32::MAX {
                column[to as usize] = column[slot as usize];
            }
            column[slot as usize] = point;
        }
    }

    /// The slot, after this insertion, of the point that was in `slot < old` before it. Twin of
    /// `shaders/relocate.wgsl`.
    pub fn relocate(&self, slot: u32, moved_to: &[u32]) -> u32 {
        let i = self.permutation.invert(slot);
        if i < self.new { moved_to[i as usize] } else { slot }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_every_point_and_relocates() {
        let mut column: Vec<u32> = Vec::new();
        let mut next = 0;
        for (index, new) in [1, 1, 5, 31, 32, 33, 255, 1, 257, 4097, 3].into_iter().enumerate() {
            let before = column.clone();
            let insertion = Insertion::new(column.len() as u32, new, 11, index as u64);
            let moved_to = insertion.moved_to();
            insertion.apply(&mut column, &(next..next + new).collect::<Vec<_>>(), &moved_to);
            for (slot, &point) in before.iter().enumerate() {
                assert_eq!(column[insertion.relocate(slot as u32, &moved_to) as usize], point);
            }
            for i in 0..new {
                assert_eq!(column[insertion.permutation.apply(i) as usize], next + i);
            }
            next += new;
            let mut sorted = column.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..next).collect::<Vec<_>>(), "dense, nothing lost");
        }
    }
}
