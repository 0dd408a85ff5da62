//! Orders in which the points of a cloud lie in memory, each as a permutation: slot → point.
//!
//! Made with the processor's threads at the full size of the cloud. The standard library's threads do:
//! the one thing that a crate of parallel algorithms would add is its sort, and a merge sort that splits
//! its merges too is forty lines.

use std::thread;

use clap::ValueEnum;
use serde::Serialize;

use crate::store::Permutation;

/// Points of a batch of [`Order::ShuffledMorton`], as in Schütz, Kerbl and Wimmer 2021, section 4.
pub const MORTON_BATCH: usize = 128;

/// Bits per axis of a Morton code: three of them fill 63.
pub const MORTON_BITS: u32 = 21;

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
        let len = positions.len() as u32;
        match self {
            Order::Original => (0..len).collect(),
            Order::Morton => morton(positions),
            // What a store holds into which all points were inserted at once: slot s has point P⁻¹(s). With
            // other batches it is another permutation, as uniform.
            Order::Shuffled => {
                let permutation = Permutation::new(len, seed, 0);
                fill(positions.len(), |slot| permutation.invert(slot as u32))
            }
            Order::ShuffledMorton => {
                let sorted = morton(positions);
                let batches = sorted.len() / MORTON_BATCH;
                let permutation = Permutation::new(batches as u32, seed, 0);
                // The rest, fewer points than a batch has, stays at the end.
                fill(sorted.len(), |slot| match slot / MORTON_BATCH {
                    batch if batch < batches => {
                        sorted[permutation.invert(batch as u32) as usize * MORTON_BATCH + slot % MORTON_BATCH]
                    }
                    _ => sorted[slot],
                })
            }
        }
    }
}

/// `values[points[slot]]` for each slot.
pub fn gather<T: Copy + Default + Send + Sync>(values: &[T], points: &[u32]) -> Vec<T> {
    fill(points.len(), |slot| values[points[slot] as usize])
}

/// `value(i)` for each `i` below `len`, by all threads.
pub fn fill<T: Copy + Default + Send>(len: usize, value: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut values = vec![T::default(); len];
    let run = len.div_ceil(threads()).max(1);
    thread::scope(|scope| {
        for (chunk, slots) in values.chunks_mut(run).enumerate() {
            let value = &value;
            scope.spawn(move || slots.iter_mut().zip(chunk * run..).for_each(|(slot, i)| *slot = value(i)));
        }
    });
    values
}

pub(super) fn threads() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// The smallest and the largest coordinate per axis; `None` without points.
pub fn extent(positions: &[[i32; 3]]) -> Option<([i32; 3], [i32; 3])> {
    let first = *positions.first()?;
    let run = positions.len().div_ceil(threads()).max(1);
    let of = |points: &[[i32; 3]]| {
        points.iter().fold((first, first), |(low, high), p| {
            (std::array::from_fn(|a| low[a].min(p[a])), std::array::from_fn(|a| high[a].max(p[a])))
        })
    };
    thread::scope(|scope| {
        let parts: Vec<_> = positions.chunks(run).map(|points| scope.spawn(move || of(points))).collect();
        // A fold cannot panic.
        parts
            .into_iter()
            .filter_map(|part| part.join().ok())
            .reduce(|a, b| (std::array::from_fn(|i| a.0[i].min(b.0[i])), std::array::from_fn(|i| a.1[i].max(b.1[i]))))
    })
}

/// Points sorted by Morton code, those of one cell as they lay.
fn morton(positions: &[[i32; 3]]) -> Vec<u32> {
    let Some((low, high)) = extent(positions) else { return Vec::new() };
    let shift = morton_shift(low, high);
    let mut keys = fill(positions.len(), |i| (morton_code(positions[i], low, shift), i as u32));
    let mut scratch = keys.clone();
    sort(&mut keys, &mut scratch, threads());
    fill(keys.len(), |i| keys[i].1)
}

/// Bits that are dropped from every coordinate, so that the longest axis fits [`MORTON_BITS`] and cells are
/// cubes (of grid steps).
fn morton_shift(low: [i32; 3], high: [i32; 3]) -> u32 {
    let longest = (0..3).map(|a| high[a].abs_diff(low[a])).max().unwrap_or(0);
    (u32::BITS - longest.leading_zeros()).saturating_sub(MORTON_BITS)
}

fn morton_code(position: [i32; 3], low: [i32; 3], shift: u32) -> u64 {
    let [x, y, z] = std::array::from_fn(|a| spread(u64::from(position[a].abs_diff(low[a]) >> shift)));
    x | y << 1 | z << 2
}

/// The lowest 21 bits, two zeros between each and the next.
fn spread(x: u64) -> u64 {
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

type Key = (u64, u32);

/// Below this a thread costs more than it sorts.
const SORT_ALONE: usize = 1 << 14;

/// Merge sort by so many threads. `scratch` has the length of `keys`; its contents are lost.
fn sort(keys: &mut [Key], scratch: &mut [Key], threads: usize) {
    if threads <= 1 || keys.len() <= SORT_ALONE {
        // No two keys are equal: the point's number is in them.
        keys.sort_unstable();
        return;
    }
    let half = keys.len() / 2;
    let (left, right) = keys.split_at_mut(half);
    let (left_scratch, right_scratch) = scratch.split_at_mut(half);
    thread::scope(|scope| {
        scope.spawn(|| sort(left, left_scratch, threads / 2));
        sort(right, right_scratch, threads - threads / 2);
    });
    merge(left, right, scratch, threads);
    keys.copy_from_slice(scratch);
}

/// Merges two sorted lists; each thread has a part of the result.
fn merge(left: &[Key], right: &[Key], out: &mut [Key], threads: usize) {
    if threads > 1 && out.len() > SORT_ALONE {
        // The longer list is halved, the other cut where its middle belongs.
        let (long, short) = if left.len() >= right.len() { (left, right) } else { (right, left) };
        let (long_low, long_high) = long.split_at(long.len() / 2);
        let (short_low, short_high) = short.split_at(short.partition_point(|key| *key < long_high[0]));
        let (low, high) = out.split_at_mut(long_low.len() + short_low.len());
        thread::scope(|scope| {
            scope.spawn(|| merge(long_low, short_low, low, threads / 2));
            merge(long_high, short_high, high, threads - threads / 2);
        });
        return;
    }
    let (mut left, mut right) = (left.iter().copied().peekable(), right.iter().copied().peekable());
    for slot in out {
        let from_left = match (left.peek(), right.peek()) {
            (Some(a), Some(b)) => a < b,
            (a, _) => a.is_some(),
        };
        if let Some(key) = if from_left { left.next() } else { right.next() } {
            *slot = key;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::Insertion;

    /// Points all over a box, some of them on the same spot.
    fn cloud(len: usize, side: u32) -> Vec<[i32; 3]> {
        let mut state = 1u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) as u32 % side) as i32 - (side / 2) as i32
        };
        (0..len).map(|_| [next(), next(), next() / 8]).collect()
    }

    const ALL: [Order; 4] = [Order::Original, Order::Morton, Order::Shuffled, Order::ShuffledMorton];

    /// Every point once?
    fn is_permutation(points: &[u32]) -> bool {
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

    /// Bit by bit, from the definition.
    fn slow_code(position: [i32; 3], low: [i32; 3], shift: u32) -> u64 {
        let mut code = 0;
        for bit in 0..MORTON_BITS {
            for axis in 0..3 {
                let steps = (i64::from(position[axis]) - i64::from(low[axis])) >> shift;
                code |= ((steps >> bit & 1) as u64) << (3 * bit + axis as u32);
            }
        }
        code
    }

    #[test]
    fn morton_codes_are_those_of_the_definition() {
        let (low, high) = ([i32::MIN; 3], [i32::MAX; 3]);
        assert_eq!(morton_shift(low, high), 11);
        assert_eq!(morton_shift([0; 3], [(1 << 21) - 1, 5, 0]), 0);
        assert_eq!(morton_shift([0; 3], [1 << 21, 5, 0]), 1);
        let corners = [low, high, [0; 3], [i32::MAX, 0, i32::MIN], [-1, 1, 12345]];
        for position in corners.into_iter().chain(cloud(1000, 4_000_000_000)) {
            assert_eq!(morton_code(position, low, 11), slow_code(position, low, 11), "{position:?}");
        }
        let positions = cloud(100_003, 5000);
        let (low, high) = extent(&positions).unwrap();
        let mut expected: Vec<u32> = (0..positions.len() as u32).collect();
        expected.sort_by_key(|&i| slow_code(positions[i as usize], low, morton_shift(low, high)));
        assert_eq!(Order::Morton.points(&positions, 1), expected);
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

    #[test]
    fn any_number_of_threads_sorts_alike() {
        let keys: Vec<Key> =
            cloud(200_000, 700).iter().zip(0..).map(|(p, i)| (p[0].unsigned_abs().into(), i)).collect();
        let mut expected = keys.clone();
        expected.sort_unstable();
        for threads in [1, 2, 3, 7, 16] {
            let (mut sorted, mut scratch) = (keys.clone(), keys.clone());
            sort(&mut sorted, &mut scratch, threads);
            assert!(sorted == expected, "{threads} threads");
        }
    }

    #[test]
    fn the_extent_holds_all_points_and_no_more() {
        assert_eq!(extent(&[]), None);
        assert_eq!(extent(&[[3, -1, 7]]), Some(([3, -1, 7], [3, -1, 7])));
        let mut positions = cloud(70_000, 100);
        positions[69_999] = [i32::MIN, i32::MAX, 5];
        let (low, high) = extent(&positions).unwrap();
        assert_eq!((low[0], high[1]), (i32::MIN, i32::MAX));
    }
}
