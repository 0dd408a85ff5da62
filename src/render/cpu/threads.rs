//! Splitting work between threads.

use std::{ops::Range, panic::resume_unwind, thread};

/// Cuts `[0, len)` into parts of about equal length, at least `smallest` each and no more than
/// `threads`, does them side by side, and returns their results in order.
pub fn map_parts<R: Send>(
    threads: usize,
    len: usize,
    smallest: usize,
    work: impl Fn(Range<usize>) -> R + Sync,
) -> Vec<R> {
    let parts = threads.min(len / smallest).max(1);
    let part = |k: usize| work(len * k / parts..len * (k + 1) / parts);
    thread::scope(|scope| {
        let others: Vec<_> = (1..parts)
            .map(|k| {
                let part = &part;
                scope.spawn(move || part(k))
            })
            .collect();
        let mut results = vec![part(0)];
        results.extend(others.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic))));
        results
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_everything_in_order() {
        for threads in [1, 2, 3, 7] {
            for len in [0, 1, 9, 10, 11, 29, 100] {
                let parts = map_parts(threads, len, 10, |part| part);
                assert!(parts.len() <= threads);
                assert!(parts.len() == 1 || parts.iter().all(|part| part.len() >= 10));
                assert_eq!(parts.into_iter().flatten().collect::<Vec<_>>(), (0..len).collect::<Vec<_>>());
            }
        }
    }
}
