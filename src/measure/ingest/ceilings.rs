//! What no reader can exceed, measured between the readers' own runs: reading the same bytes without
//! looking at them, and copying as many bytes as the batches hold from memory to memory.

use std::{
    cell::Cell,
    fs::File,
    hint::black_box,
    io::{self, Read, Seek, SeekFrom},
    ops::Range,
    path::Path,
    sync::atomic::AtomicBool,
    sync::{
        Barrier,
        atomic::{AtomicU64, Ordering},
    },
    thread,
    time::Instant,
};

use crate::source::{
    SourceError,
    chunks::LazLayout,
    header::{Header, open_regular},
};

/// Bytes per read: more gave nothing, and less costs calls.
const BLOCK: u64 = 4 << 20;

/// Bytes that each thread copies from and to, over and over: more than a processor's own cache, so
/// that the ceiling is that of memory, as batches are new to the cache of the core that takes them.
const COPY_BUFFER: u64 = 64 << 20;

/// Where a file's points are.
#[derive(Debug, Clone, PartialEq)]
pub struct PointData {
    /// e.g. "LAZ 1.4, format 7".
    pub kind: String,
    pub compressed: bool,
    pub file_bytes: u64,
    /// Bytes from the first point to the last.
    pub range: Range<u64>,
}

impl PointData {
    /// # Errors
    /// If the header, or the LASzip VLR, cannot be understood.
    pub fn find(path: &Path) -> Result<PointData, SourceError> {
        let (header, file) = Header::read(path)?;
        let start = header.data_at().min(header.file_length);
        let end = if header.compressed {
            // The reader says what is wrong with the table; here only the extent counts.
            let layout = LazLayout::read(&header, &file, &mut Vec::new(), &AtomicBool::new(false))?;
            layout.chunks.iter().map(|chunk| chunk.at.saturating_add(chunk.bytes)).max().unwrap_or(start)
        } else {
            start.saturating_add(header.points.saturating_mul(header.record_length() as u64))
        };
        Ok(PointData {
            kind: header.kind(),
            compressed: header.compressed,
            file_bytes: header.file_length,
            range: start..end.clamp(start, header.file_length),
        })
    }

    pub fn bytes(&self) -> u64 {
        self.range.end - self.range.start
    }
}

/// Seconds to read a range of a file, block after block, by as many threads as the reader has.
///
/// # Errors
/// If the file cannot be read, or has become shorter.
pub fn read_alone(path: &Path, range: &Range<u64>, threads: usize) -> io::Result<f64> {
    let next = AtomicU64::new(range.start);
    let files: Vec<File> = (0..threads.max(1))
        .map(|_| open_regular(path).map(|(file, _)| file).map_err(|error| io::Error::other(error.to_string())))
        .collect::<io::Result<_>>()?;
    let (secs, results) = timed(files, |mut file, ready| {
        let mut buffer = vec![1; BLOCK as usize];
        ready();
        loop {
            let at = next.fetch_add(BLOCK, Ordering::Relaxed);
            if at >= range.end {
                return Ok(());
            }
            let block = &mut buffer[..(range.end - at).min(BLOCK) as usize];
            file.seek(SeekFrom::Start(at))?;
            file.read_exact(block)?;
            black_box(&mut *block);
        }
    });
    results.into_iter().collect::<io::Result<Vec<()>>>()?;
    Ok(secs)
}

/// Seconds to copy so many bytes from memory to memory, shared among threads.
pub fn copy_memory(bytes: u64, threads: usize) -> f64 {
    let shares: Vec<u64> = share(bytes, threads.max(1));
    let (secs, _) = timed(shares, |mut left, ready| {
        let size = left.min(COPY_BUFFER) as usize;
        // Written to, so that the system has given all pages before the clock starts.
        let (from, mut to) = (vec![1u8; size], vec![2u8; size]);
        ready();
        while left > 0 {
            let now = left.min(size as u64);
            to[..now as usize].copy_from_slice(&black_box(&from)[..now as usize]);
            black_box(&mut to);
            left -= now;
        }
    });
    secs
}

fn share(bytes: u64, threads: usize) -> Vec<u64> {
    let n = threads as u64;
    (0..n).map(|i| bytes * (i + 1) / n - bytes * i / n).collect()
}

/// Runs a thread per input. The time is from when the first goes on behind `ready.wait()`, which all
/// come to, until the last is done, by the threads' own clocks: on a busy machine, this thread may be
/// woken when all is over.
fn timed<I: Send, T: Send>(inputs: Vec<I>, work: impl Fn(I, &dyn Fn()) -> T + Sync) -> (f64, Vec<T>) {
    let barrier = Barrier::new(inputs.len());
    let run = |input| {
        let begun = Cell::new(Instant::now());
        let ready = || {
            barrier.wait();
            begun.set(Instant::now());
        };
        let result = work(input, &ready);
        (begun.get(), Instant::now(), result)
    };
    let outcomes: Vec<_> = thread::scope(|scope| {
        let running: Vec<_> = inputs.into_iter().map(|input| scope.spawn(|| run(input))).collect();
        running.into_iter().filter_map(|thread| thread.join().ok()).collect()
    });
    let begun = outcomes.iter().map(|outcome| outcome.0).min();
    let ended = outcomes.iter().map(|outcome| outcome.1).max();
    let secs = begun.zip(ended).map_or(0.0, |(begun, ended)| (ended - begun).as_secs_f64());
    (secs, outcomes.into_iter().map(|outcome| outcome.2).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::{self, Scene, SynthOptions};

    #[test]
    fn shares_add_up() {
        for (bytes, threads) in [(0, 1), (10, 3), (7, 8), (1 << 40, 5)] {
            let shares = share(bytes, threads);
            assert_eq!((shares.len(), shares.iter().sum::<u64>()), (threads, bytes));
        }
    }

    #[test]
    fn the_points_of_a_file_are_found_and_a_cut_one_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.las");
        let options = SynthOptions { points: 1000, ..SynthOptions::new(Scene::Planes) };
        synth::write(&options, &path, &mut |_| {}).unwrap();
        let data = PointData::find(&path).unwrap();
        assert!(!data.compressed && data.kind.starts_with("LAS"));
        assert_eq!(data.bytes() % 1000, 0);
        assert_eq!(data.range.end, data.file_bytes, "nothing follows the points");
        assert!(read_alone(&path, &data.range, 3).unwrap() > 0.0);
        let beyond = data.range.start..data.range.end + 1;
        assert!(read_alone(&path, &beyond, 1).is_err(), "a byte that is not there is not read");

        let compressed = folder.path().join("a.laz");
        synth::write(&options, &compressed, &mut |_| {}).unwrap();
        let laz = PointData::find(&compressed).unwrap();
        assert!(laz.compressed && laz.bytes() < data.bytes());
        assert!(laz.range.end < laz.file_bytes, "the chunk table follows the points");
    }

    #[test]
    fn twice_the_bytes_take_longer_to_copy() {
        let least = |bytes| (0..5).map(|_| copy_memory(bytes, 1)).fold(f64::INFINITY, f64::min);
        assert!(least(256 << 20) > least(16 << 20));
        assert!(copy_memory(0, 2) < 1.0);
    }
}
