//! Work on all points of a cloud by all of the processor's threads.

use std::thread;

/// Below so many items, more threads cost more than they do.
const ALONE: usize = 1 << 14;

/// Threads that the program may run at once.
pub fn threads() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// Items of a part, if so many are cut into one part for each thread.
pub fn part_len(len: usize) -> usize {
    if len <= ALONE { len.max(1) } else { len.div_ceil(threads()) }
}

/// `value(i)` for each `i` below `len`, by all threads.
pub fn fill<T: Copy + Default + Send>(len: usize, value: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut values = vec![T::default(); len];
    let part = part_len(len);
    thread::scope(|scope| {
        for (chunk, slots) in values.chunks_mut(part).enumerate() {
            let value = &value;
            scope.spawn(move || slots.iter_mut().zip(chunk * part..).for_each(|(slot, i)| *slot = value(i)));
        }
    });
    values
}

/// `value(i)` for each `i` below `len`, by all threads, for few items of much work each.
pub fn map<T: Send>(len: usize, value: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let part = len.div_ceil(threads()).max(1);
    let value = &value;
    thread::scope(|scope| {
        let parts = (0..len).step_by(part).map(|first| first..len.min(first + part));
        let parts: Vec<_> = parts.map(|part| scope.spawn(move || part.map(value).collect::<Vec<T>>())).collect();
        // A thread that panics takes the program with it, as a loop would.
        let join = |part: thread::ScopedJoinHandle<'_, Vec<T>>| {
            part.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        };
        parts.into_iter().flat_map(join).collect()
    })
}

/// The smallest and the largest coordinate per axis; `None` without points.
pub fn extent(positions: &[[i32; 3]]) -> Option<([i32; 3], [i32; 3])> {
    let first = *positions.first()?;
    let of = |points: &[[i32; 3]]| {
        points.iter().fold((first, first), |(low, high), p| {
            (std::array::from_fn(|a| low[a].min(p[a])), std::array::from_fn(|a| high[a].max(p[a])))
        })
    };
    thread::scope(|scope| {
        let parts = positions.chunks(part_len(positions.len()));
        let parts: Vec<_> = parts.map(|points| scope.spawn(move || of(points))).collect();
        // A fold cannot panic.
        parts
            .into_iter()
            .filter_map(|part| part.join().ok())
            .reduce(|a, b| (std::array::from_fn(|i| a.0[i].min(b.0[i])), std::array::from_fn(|i| a.1[i].max(b.1[i]))))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extent_holds_all_points_and_no_more() {
        assert_eq!(extent(&[]), None);
        assert_eq!(extent(&[[3, -1, 7]]), Some(([3, -1, 7], [3, -1, 7])));
        let mut positions: Vec<[i32; 3]> = (0..70_000).map(|i| [i % 97 - 40, i % 89 - 40, i % 7]).collect();
        positions[69_999] = [i32::MIN, i32::MAX, 5];
        let (low, high) = extent(&positions).unwrap_or_default();
        assert_eq!((low[0], high[1]), (i32::MIN, i32::MAX));
        assert_eq!((low[1], high[0], low[2], high[2]), (-40, 56, 0, 6));
    }

    #[test]
    fn every_item_is_filled() {
        for len in [0, 1, 2, ALONE - 1, ALONE, ALONE + 1, 3 * ALONE + 1] {
            assert!(fill(len, |i| i).into_iter().eq(0..len), "{len}");
            assert!(map(len.min(100), |i| vec![i]).into_iter().flatten().eq(0..len.min(100)), "{len}");
        }
    }
}
