//! Points in memory, in shuffled columns. The rules are [`Insertion`]'s; here they are followed for
//! all columns at once: each point's slot is computed once, and on all threads.

use std::{collections::TryReserveError, thread};

use super::{POINTS_PER_THREAD, threads::map_parts};
use crate::{scene::PointBatch, store::Insertion};

/// The columns, by slot.
#[derive(Default)]
pub struct PointStore {
    pub positions: Vec<[i32; 3]>,
    pub attributes: Vec<[u16; 4]>,
    pub records: Vec<u32>,
    /// One bit per slot, all zero between insertions; see [`PointStore::relocate`].
    evicted: Vec<u64>,
}

impl PointStore {
    /// Inserts `points`, renumbers the slots in `lists`, and returns the slots of the new points. If
    /// memory runs out, nothing has changed.
    pub fn insert(
        &mut self,
        insertion: &Insertion,
        points: &PointBatch,
        lists: [&mut [u32]; 2],
        threads: usize,
    ) -> Result<Vec<u32>, TryReserveError> {
        let Insertion { old, new, permutation } = *insertion;
        assert_eq!((self.records.len(), points.len()), (old as usize, new as usize));
        reserve(&mut self.positions, new as usize)?;
        reserve(&mut self.attributes, new as usize)?;
        reserve(&mut self.records, new as usize)?;
        let bit_words = (old + new).div_ceil(64) as usize;
        self.evicted.try_reserve(bit_words - self.evicted.len())?;
        self.evicted.resize(bit_words, 0);

        let split = |work: &(dyn Fn(u32) -> Option<u32> + Sync)| {
            map_parts(threads, new as usize, POINTS_PER_THREAD, |part| {
                (part.start as u32..part.end as u32).filter_map(work).collect::<Vec<u32>>()
            })
            .concat()
        };
        let targets = split(&|i| Some(permutation.apply(i)));
        let free = split(&|k| (permutation.invert(old + k) >= new).then_some(old + k));
        let mut free = free.into_iter();
        let moved_to: Vec<u32> = targets
            .iter()
            .map(|&slot| match slot < old {
                true => free.next().expect("as many free tail slots as evicted points"),
                false => u32::MAX,
            })
            .collect();

        if new as usize >= POINTS_PER_THREAD && threads > 1 {
            thread::scope(|scope| {
                scope.spawn(|| scatter(&mut self.positions, &points.positions, &targets, &moved_to));
                scope.spawn(|| scatter(&mut self.attributes, &points.colors, &targets, &moved_to));
                scatter(&mut self.records, &points.records, &targets, &moved_to);
            });
        } else {
            scatter(&mut self.positions, &points.positions, &targets, &moved_to);
            scatter(&mut self.attributes, &points.colors, &targets, &moved_to);
            scatter(&mut self.records, &points.records, &targets, &moved_to);
        }
        self.relocate(insertion, &targets, &moved_to, lists, threads);
        Ok(targets)
    }

    /// Renumbers slots as [`Insertion::relocate`] says. That look-up inverts a permutation; a full-HD
    /// picture shows two million slots, of which an insertion into a large store moves few. One bit per
    /// slot tells them apart.
    fn relocate(
        &mut self,
        insertion: &Insertion,
        targets: &[u32],
        moved_to: &[u32],
        lists: [&mut [u32]; 2],
        threads: usize,
    ) {
        let evicted = &mut self.evicted;
        for &slot in targets.iter().filter(|&&slot| slot < insertion.old) {
            evicted[slot as usize / 64] |= 1 << (slot % 64);
        }
        for list in lists {
            let evicted = &*evicted;
            let part_len = list.len().div_ceil(threads).max(POINTS_PER_THREAD);
            thread::scope(|scope| {
                let renumber = |part: &mut [u32]| {
                    for slot in part {
                        if evicted[*slot as usize / 64] >> (*slot % 64) & 1 == 1 {
                            *slot = insertion.relocate(*slot, moved_to);
                        }
                    }
                };
                let mut parts = list.chunks_mut(part_len);
                let first = parts.next();
                parts.for_each(|part| {
                    scope.spawn(move || renumber(part));
                });
                first.map(renumber);
            });
        }
        for &slot in targets {
            evicted[slot as usize / 64] = 0;
        }
    }
}

/// Makes room for `more` elements: twice what is there if memory allows, else just what is needed.
fn reserve<T>(column: &mut Vec<T>, more: usize) -> Result<(), TryReserveError> {
    column.try_reserve(more).or_else(|_| column.try_reserve_exact(more))
}

/// Moves the evicted points of a column to the tail and writes the new ones to their slots. No slot
/// is both a target and free, so the order does not matter.
fn scatter<T: Copy + Default>(column: &mut Vec<T>, new: &[T], targets: &[u32], moved_to: &[u32]) {
    column.resize(column.len() + new.len(), T::default());
    for ((&point, &slot), &to) in new.iter().zip(targets).zip(moved_to) {
        if to != u32::MAX {
            column[to as usize] = column[slot as usize];
        }
        column[slot as usize] = point;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn batch(first: u32, len: u32) -> PointBatch {
        PointBatch {
            positions: (first..first + len).map(|r| [r as i32, -(r as i32), 7]).collect(),
            colors: (first..first + len).map(|r| [r as u16; 4]).collect(),
            records: (first..first + len).collect(),
            ..Default::default()
        }
    }

    #[test]
    fn equals_the_rules_whatever_the_number_of_threads() {
        for threads in [1, 2, 3] {
            let mut store = PointStore::default();
            let mut records: Vec<u32> = Vec::new();
            let mut list: Vec<u32> = Vec::new();
            for (index, new) in [1, 2, 31, 32, 33, 255, 20_000, 256, 257, 4097, 9000].into_iter().enumerate() {
                let old = records.len() as u32;
                let insertion = Insertion::new(old, new, 5, index as u64);
                let points = batch(old, new);
                let moved_to = insertion.moved_to();
                let expected: Vec<u32> = list.iter().map(|&slot| insertion.relocate(slot, &moved_to)).collect();
                insertion.apply(&mut records, &points.records, &moved_to);
                let targets = store.insert(&insertion, &points, [&mut list, &mut []], threads).unwrap();
                assert_eq!(store.records, records);
                assert_eq!(list, expected);
                assert!(targets.iter().zip(&points.records).all(|(&slot, &r)| records[slot as usize] == r));
                list.extend(targets);
            }
            for (slot, &r) in records.iter().enumerate() {
                assert_eq!(store.positions[slot], [r as i32, -(r as i32), 7]);
                assert_eq!(store.attributes[slot], [r as u16; 4]);
            }
            let by_arrival: Vec<u32> = list.iter().map(|&slot| records[slot as usize]).collect();
            assert_eq!(by_arrival, (0..records.len() as u32).collect::<Vec<_>>(), "the list followed every point");
        }
    }
}
