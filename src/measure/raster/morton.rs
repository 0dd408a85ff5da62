//! Morton order: sorting a billion points with little more memory than the result.
//!
//! The result, numbers of points, is first filled bucket by bucket, a bucket being all points whose codes
//! begin alike; then each bucket is sorted by whole codes, which are computed anew from the positions and
//! exist only while a thread sorts its bucket. Beside the cloud (16 bytes a point) a sort needs the result
//! (4 bytes a point) and keys of 16 bytes for the buckets being sorted: for a town of a billion points
//! under 2 GB. Where one far point stretches the box so that all others share a bucket, it is sorted by all threads
//! with keys and as much scratch, 32 bytes a point: 52 GB with the cloud and the result at a billion points.

use std::{
    sync::{
        Mutex,
        atomic::{AtomicU32, Ordering},
    },
    thread,
};

use crate::methods::parallel::{extent, fill, map, part_len, threads};

/// Bits per axis of a Morton code: three of them fill 63.
pub const MORTON_BITS: u32 = 21;

/// First bits of a code that choose a bucket: six per axis. A town fills some thousands of the buckets, so
/// that a bucket of a billion points fits a core's cache.
const BUCKET_BITS: u32 = 18;

/// Points sorted by Morton code, those of one cell as they lay.
pub fn morton(positions: &[[i32; 3]]) -> Vec<u32> {
    let Some((low, high)) = extent(positions) else { return Vec::new() };
    let shift = morton_shift(low, high);
    let code = |point: u32| morton_code(positions[point as usize], low, shift);
    // No code is larger than that of the highest corner.
    let last = morton_code(high, low, shift);
    let bits = u64::BITS - last.leading_zeros();
    let few = BUCKET_BITS.min(positions.len().ilog2() + 1);
    let below = bits.saturating_sub(few);
    let bucket = |point: u32| (code(point) >> below) as usize;
    let (mut points, ends) = partition(positions.len(), (last >> below) as usize + 1, bucket);
    // Larger buckets would keep one thread busy when the others are done.
    let large = (points.len() / (4 * threads())).max(SORT_ALONE);
    let (mut small, mut rest, mut start) = (Vec::new(), &mut points[..], 0);
    for end in ends {
        let (here, after) = rest.split_at_mut(end as usize - start);
        (rest, start) = (after, end as usize);
        if here.len() > large {
            sort_by_all(here, &code);
        } else if here.len() > 1 {
            small.push(here);
        }
    }
    let queue = Mutex::new(small.into_iter());
    thread::scope(|scope| {
        for _ in 0..threads() {
            scope.spawn(|| {
                let mut keys: Vec<Key> = Vec::new();
                // A poisoned queue is as good: its items are whole.
                let next = || queue.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).next();
                while let Some(bucket) = next() {
                    keys.clear();
                    keys.extend(bucket.iter().map(|&point| (code(point), point)));
                    keys.sort_unstable();
                    bucket.iter_mut().zip(&keys).for_each(|(slot, key)| *slot = key.1);
                }
            });
        }
    });
    points
}

/// The numbers below `len`, bucket by bucket, in each bucket ascending; and where each bucket ends.
fn partition(len: usize, buckets: usize, bucket: impl Fn(u32) -> usize + Sync) -> (Vec<u32>, Vec<u32>) {
    let part = part_len(len);
    let part_of = |i: usize| (i * part) as u32..((i + 1) * part).min(len) as u32;
    let mut counts: Vec<Vec<u32>> = map(len.div_ceil(part), |i| {
        let mut counts = vec![0; buckets];
        part_of(i).for_each(|point| counts[bucket(point)] += 1);
        counts
    });
    // From counts to where each part's points of each bucket begin.
    let (mut ends, mut at) = (vec![0; buckets], 0);
    for (bucket, end) in ends.iter_mut().enumerate() {
        for counts in &mut counts {
            at += std::mem::replace(&mut counts[bucket], at);
        }
        *end = at;
    }
    // Every slot is written once, by one thread; atomics say so without `unsafe`, and cost what plain stores do.
    let slots: Vec<AtomicU32> = (0..len).map(|_| AtomicU32::new(0)).collect();
    thread::scope(|scope| {
        for (i, mut next) in counts.into_iter().enumerate() {
            let (slots, bucket) = (&slots, &bucket);
            scope.spawn(move || {
                for point in part_of(i) {
                    let at = &mut next[bucket(point)];
                    slots[*at as usize].store(point, Ordering::Relaxed);
                    *at += 1;
                }
            });
        }
    });
    // Collected in place: as large before as after.
    (slots.into_iter().map(AtomicU32::into_inner).collect(), ends)
}

/// Sorts the points of a bucket by all threads.
fn sort_by_all(bucket: &mut [u32], code: &(impl Fn(u32) -> u64 + Sync)) {
    let points = &*bucket;
    let mut keys = fill(points.len(), |i| (code(points[i]), points[i]));
    let mut scratch = fill(keys.len(), |_| (0, 0));
    sort(&mut keys, &mut scratch, threads());
    drop(scratch);
    bucket.iter_mut().zip(&keys).for_each(|(slot, key)| *slot = key.1);
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
    use super::{
        super::orders::tests::{cloud, is_permutation},
        *,
    };

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
    }

    /// Also with all points but one in one bucket, and all on one spot.
    #[test]
    fn points_are_sorted_by_code_then_number() {
        let mut stretched = cloud(100_003, 3000);
        stretched[77] = [i32::MAX, i32::MAX, i32::MIN];
        for positions in [cloud(100_003, 5000), stretched, vec![[7, 7, 7]; 50_000], cloud(3, 9), cloud(1, 9)] {
            let (low, high) = extent(&positions).unwrap();
            let mut expected: Vec<u32> = (0..positions.len() as u32).collect();
            expected.sort_by_key(|&i| slow_code(positions[i as usize], low, morton_shift(low, high)));
            let sorted = morton(&positions);
            assert!(sorted == expected, "{} points", positions.len());
            assert!(is_permutation(&sorted));
        }
        assert!(morton(&[]).is_empty());
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
}
