//! Orders in which the points of a cloud lie in memory, each as a permutation: slot → point.
//!
//! Made with the processor's threads at the full size of the cloud; the cloud itself is not moved. The standard
//! library's threads do: the one thing that a crate of parallel algorithms would add is its sort, and sorting by
//! buckets, which needs less memory, is a hundred lines ([`morton`](super::morton)).

use std::{borrow::Cow, cell::OnceCell};

use clap::ValueEnum;
use serde::Serialize;

use super::morton::morton;
use crate::{methods::parallel::fill, store::Permutation};

/// Points of a batch of [`Order::ShuffledMorton`], as in Schütz, Kerbl and Wimmer 2021, section 4.
pub const MORTON_BATCH: usize = 128;

/// How the points of a cloud lie in memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// As they lie in the file
    Original,
    /// Along a Morton curve, 21 bits per axis
    Morton,
    /// Uniformly random, by the permutation that fills the viewer's store
    Shuffled,
    /// Morton order in batches of 128 points, the batches shuffled
    ShuffledMorton,
}

impl Order {
    /// As the command line calls it.
    pub fn name(self) -> &'static str {
        match self {
            Order::Original => "original",
            Order::Morton => "morton",
            Order::Shuffled => "shuffled",
            Order::ShuffledMorton => "shuffled-morton",
        }
    }

    /// Which point lies in each slot. At most 2³² − 1 points, as everywhere.
    pub fn points(self, positions: &[[i32; 3]], seed: u64) -> Vec<u32> {
        let orders = Orders::new(positions);
        let points = orders.points(self, seed).map(Cow::into_owned);
        points.unwrap_or_else(|| (0..positions.len() as u32).collect())
    }
}

/// The orders of one cloud; what two of them share is made once.
pub struct Orders<'a> {
    positions: &'a [[i32; 3]],
    morton: OnceCell<Vec<u32>>,
}

impl<'a> Orders<'a> {
    pub fn new(positions: &'a [[i32; 3]]) -> Orders<'a> {
        Orders { positions, morton: OnceCell::new() }
    }

    fn morton(&self) -> &[u32] {
        self.morton.get_or_init(|| morton(self.positions))
    }

    /// Which point lies in each slot; `None` for all as they are.
    pub fn points(&self, order: Order, seed: u64) -> Option<Cow<'_, [u32]>> {
        let len = self.positions.len();
        match order {
            Order::Original => None,
            Order::Morton => Some(self.morton().into()),
            // What a store holds into which all points were inserted at once: slot s has point P⁻¹(s). With
            // other batches it is another permutation, as uniform. A slot costs a few rounds of hashing,
            // however many there are.
            Order::Shuffled => {
                let permutation = Permutation::new(len as u32, seed, 0);
                Some(fill(len, |slot| permutation.invert(slot as u32)).into())
            }
            Order::ShuffledMorton => {
                let sorted = self.morton();
                let batches = len / MORTON_BATCH;
                let permutation = Permutation::new(batches as u32, seed, 0);
                // The rest, fewer points than a batch has, stays at the end.
                let point = |slot: usize| match slot / MORTON_BATCH {
                    batch if batch < batches => {
                        sorted[permutation.invert(batch as u32) as usize * MORTON_BATCH + slot % MORTON_BATCH]
                    }
                    _ => sorted[slot],
                };
                Some(fill(len, point).into())
            }
        }
    }
}

/// `values[points[slot]]` for each slot.
pub fn gather<T: Copy + Default + Send + Sync>(values: &[T], points: &[u32]) -> Vec<T> {
    fill(points.len(), |slot| values[points[slot] as usize])
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::store::Insertion;

    /// Points all over a box, some of them on the same spot.
    pub fn cloud(len: usize, side: u32) -> Vec<[i32; 3]> {
        let mut state = 1u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) as u32 % side) as i32 - (side / 2) as i32
        };
        (0..len).map(|_| [next(), next(), next() / 8]).collect()
    }

    const ALL: [Order; 4] = [Order::Original, Order::Morton, Order::Shuffled, Order::ShuffledMorton];

    /// Every point once?
    pub fn is_permutation(points: &[u32]) -> bool {
        let mut seen = vec![false; points.len()];
        points.iter().all(|&p| seen.get_mut(p as usize).is_some_and(|seen| !std::mem::replace(seen, true)))
    }

    #[test]
    fn every_order_has_every_point_once() {
        for len in [0, 1, 2, 127, 128, 129, 256, 4097, 100_003] {
            let positions = cloud(len, 1000);
            for order in ALL {
                assert!(is_permutation(&order.points(&positions, 7)), "{order:?} of {len}");
            }
        }
        assert!(!is_permutation(&[0, 1, 1]) && !is_permutation(&[0, 3, 1]), "the test can fail");
    }

    #[test]
    fn shuffled_is_what_an_insertion_makes() {
        let positions = cloud(5000, 100);
        let insertion = Insertion::new(0, 5000, 3, 0);
        let mut store: Vec<u32> = Vec::new();
        insertion.apply(&mut store, &(0..5000).collect::<Vec<_>>(), &insertion.moved_to());
        assert_eq!(Order::Shuffled.points(&positions, 3), store);
        assert_ne!(Order::Shuffled.points(&positions, 4), store, "another seed, another order");
    }

    #[test]
    fn shuffled_morton_keeps_batches_whole() {
        let positions = cloud(128 * 40 + 5, 300);
        let (sorted, mixed) = (Order::Morton.points(&positions, 9), Order::ShuffledMorton.points(&positions, 9));
        let batches = |points: &[u32]| points.chunks(MORTON_BATCH).map(<[u32]>::to_vec).collect::<Vec<_>>();
        let (mut a, mut b) = (batches(&sorted), batches(&mixed));
        assert_ne!(a, b);
        assert_eq!(a.last(), b.last(), "the rest stays");
        a.sort();
        b.sort();
        assert_eq!(a, b);
    }
}
