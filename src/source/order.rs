//! In which order the points of a scene are read: an early view of everything first.
//!
//! Files come in scan lines, in Morton order, or as octrees; read from front to back, most of them
//! show one corner for a long time. So a *preview* comes first: a few points from everywhere, each of
//! which is read once and never again. Then the rest, in blocks whose numbers are bit-reversed (the van
//! der Corput sequence), so that what has been read is spread evenly at any time, and block 0, where
//! octrees have their coarsest level, is the first. Several files advance side by side, each in
//! proportion to its size.
//!
//! The order depends on the files alone, not on threads.

use std::ops::Range;

use super::{
    chunks::{Chunk, LazLayout},
    laz::MAX_CHUNK_BYTES,
};
use crate::scene::BATCH_POINTS;

/// In which order points are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Order {
    /// A preview of everything, then the rest, evenly spread.
    #[default]
    PreviewFirst,
    /// From front to back, file after file.
    File,
}

/// A piece of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Task {
    /// Index of the file.
    pub file: u32,
    pub part: Part,
}

/// Part of a file, as a range of numbers; what they count, the variant says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// LAS: positions in the sequence of samples; `early` ones may be left for later.
    Samples { start: u32, end: u32, early: bool },
    /// LAS: as many records as a batch holds, between the samples: see [`FileOrder::block`].
    Block(u32),
    /// LAZ: positions in the sequence of first records, which are stored raw.
    Firsts { start: u32, end: u32 },
    /// LAZ: positions in the sequence of chunks that are started early, and kept.
    Starts { start: u32, end: u32 },
    /// LAZ: chunks to their end.
    Chunks { start: u32, end: u32 },
}

/// Records of a LAS file that are read early: `run` of them, then `rest` that are not, `count` times; all
/// behind that are rest as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Samples {
    pub run: u64,
    pub rest: u64,
    pub count: u32,
}

/// Records of one sample, and about how far the samples are apart: 3 % of the points, and 6 % of the
/// time, since each sample is a read of its own (64 of every 2,112 took 10 %; 256 of every 8,448 covered
/// less).
const SAMPLE_RUN: u64 = 128;
const SAMPLE_STRIDE: u64 = 4_224;
/// So many samples fill a batch.
const BATCH_SAMPLES: u64 = BLOCK / SAMPLE_RUN;
/// At most so many samples: two per cell of a 64×64 grid.
const MAX_SAMPLES: u64 = 8_192;
/// LAS files with fewer blocks are there before a preview would be.
const SAMPLED_BLOCKS: u64 = 8;
const BLOCK: u64 = BATCH_POINTS as u64;

impl Samples {
    fn of(points: u64) -> Option<Samples> {
        if points < SAMPLED_BLOCKS * BLOCK {
            return None;
        }
        let mut count = points / SAMPLE_STRIDE;
        if count > BATCH_SAMPLES {
            // Only full batches: what follows a smaller one is copied together to insertions.
            count = ((count + BATCH_SAMPLES / 2) / BATCH_SAMPLES * BATCH_SAMPLES).min(MAX_SAMPLES);
        }
        Some(Samples { run: SAMPLE_RUN, rest: points / count - SAMPLE_RUN, count: count as u32 })
    }

    /// Records of one sample; all samples lie wholly within the file.
    pub fn range(&self, sample: u32) -> Range<u64> {
        let start = u64::from(sample) * (self.run + self.rest);
        start..start + self.run
    }

    fn sampled(&self) -> u64 {
        self.run * u64::from(self.count)
    }

    /// Where the rest's record number `number` (counted without samples) lies in the file.
    fn rest_at(&self, number: u64) -> u64 {
        number + self.run * (number / self.rest + 1).min(u64::from(self.count))
    }

    /// The stretches of records `start..end` that are in no sample, in order.
    pub fn rest_of(&self, start: u64, end: u64) -> impl Iterator<Item = (u64, u64)> {
        let (run, stride) = (self.run, self.run + self.rest);
        let count = u64::from(self.count);
        // What lies behind the last sample is one stretch.
        (start / stride..=(end / stride).min(count)).filter_map(move |number| {
            let from = start.max(number * stride + if number < count { run } else { 0 });
            let to = end.min(if number < count { (number + 1) * stride } else { u64::MAX });
            (from < to).then_some((from, to))
        })
    }
}

/// Which chunks of a LAZ file are shown early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Preview {
    /// Every n-th chunk shows its first record; 0 for none.
    pub firsts_every: u32,
    /// Every n-th chunk is started early; 0 for none.
    pub starts_every: u32,
}

/// A start decodes one of so many of a chunk's points. The first ones take longer than the others, whose
/// models know more: 3 % of the points are 4 % of the time, so that the first whole chunk, where an octree
/// has its coarsest level, is there before 7 % of it.
pub const START_SHARE: u64 = 32;
/// Chunks with fewer points are not started early: setting up their models would cost more.
const START_POINTS: u64 = 8_192;
/// Chunks started by one task: a batch of them should soon be there, and keep many threads busy.
const STARTS: usize = 4;
/// Decoders that are kept between preview and full pass, over all files. Chunks beyond that are not
/// started early, so that nothing is ever decoded twice.
pub const MAX_KEPT: u32 = 1_024;
/// First records that are read early, per file.
const MAX_FIRSTS: u32 = 1 << 16;
/// With fewer chunks there is nothing to preview.
const PREVIEWED_CHUNKS: u32 = 4;

impl Preview {
    /// `kept`: how many decoders may be kept for this file.
    fn of(layout: &LazLayout, keepable: bool, kept: u32) -> Preview {
        let chunks = layout.chunks.len() as u32;
        if chunks < PREVIEWED_CHUNKS {
            return Preview::default();
        }
        let starts = layout.chunks.iter().any(can_start);
        let starts_every = if keepable && kept > 0 && starts { chunks.div_ceil(kept) } else { 0 };
        Preview { firsts_every: chunks.div_ceil(MAX_FIRSTS), starts_every }
    }

    /// True if the chunk's first record is shown early.
    pub fn shows_first(&self, layout: &LazLayout, chunk: usize, record_length: usize) -> bool {
        let c = &layout.chunks[chunk];
        self.firsts_every > 0
            && chunk.is_multiple_of(self.firsts_every as usize)
            && c.points > 0
            && c.bytes >= record_length as u64
    }

    /// True if the chunk is started early.
    pub fn starts(&self, layout: &LazLayout, chunk: usize) -> bool {
        self.starts_every > 0 && chunk.is_multiple_of(self.starts_every as usize) && can_start(&layout.chunks[chunk])
    }
}

fn can_start(chunk: &Chunk) -> bool {
    chunk.points >= START_POINTS && chunk.bytes <= MAX_CHUNK_BYTES
}

/// How one file is read: decided once, looked up by the workers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FileOrder {
    pub samples: Option<Samples>,
    pub preview: Preview,
    /// The sequences that tasks are positions in.
    pub sequence: Vec<u32>,
    phases: [Vec<Part>; 3],
}

impl FileOrder {
    /// A LAS file's order.
    pub fn of_records(order: Order, points: u64) -> FileOrder {
        if order == Order::File {
            let blocks = (0..points.div_ceil(BLOCK) as u32).map(Part::Block).collect();
            return FileOrder { phases: [vec![], vec![], blocks], ..Default::default() };
        }
        let samples = Samples::of(points);
        let blocks = (points - samples.map_or(0, |s| s.sampled())).div_ceil(BLOCK) as u32;
        let sequence: Vec<u32> = bit_reversed(samples.map_or(0, |s| s.count)).collect();
        let per_task = BATCH_POINTS / SAMPLE_RUN as usize;
        let early =
            ranges(sequence.len(), per_task).map(|(start, end)| Part::Samples { start, end, early: true }).collect();
        FileOrder { samples, sequence, phases: [vec![], early, in_spread_order(blocks)], ..Default::default() }
    }

    /// The records of a LAS file of so many that a block spans, samples included.
    pub fn block(&self, block: u32, points: u64) -> (u64, u64) {
        let at = |number: u64| self.samples.map_or(number, |s| s.rest_at(number)).min(points);
        let start = u64::from(block) * BLOCK;
        // Up to the last record of its own, not to the first of the next block.
        (at(start), (at(start + BLOCK - 1) + 1).min(points))
    }

    /// A LAZ file's order; `keepable` if its decoders can be kept, `kept` of them at most.
    pub fn of_chunks(order: Order, layout: &LazLayout, keepable: bool, kept: u32) -> FileOrder {
        let groups = groups(layout);
        let part = |i: u32| Part::Chunks { start: groups[i as usize].0, end: groups[i as usize].1 };
        let count = groups.len() as u32;
        if order == Order::File {
            return FileOrder { phases: [vec![], vec![], (0..count).map(part).collect()], ..Default::default() };
        }
        let octree = !layout.levels.is_empty();
        // The coarser levels of an octree are its preview.
        let preview = Preview::of(layout, keepable && !octree, kept);
        let chunks = layout.chunks.len() as u32;
        let mut firsts = Vec::new();
        if preview.firsts_every > 0 {
            let every = chunks.div_ceil(preview.firsts_every) as usize;
            firsts.extend(ranges(every, BATCH_POINTS).map(|(start, end)| Part::Firsts { start, end }));
        }
        let mut sequence = Vec::new();
        let mut starts = Vec::new();
        if preview.starts_every > 0 {
            let every = bit_reversed(chunks.div_ceil(preview.starts_every)).map(|i| i * preview.starts_every);
            sequence.extend(every.filter(|&c| preview.starts(layout, c as usize)));
            starts.extend(ranges(sequence.len(), STARTS).map(|(start, end)| Part::Starts { start, end }));
        }
        let mut order: Vec<u32> = bit_reversed(count).collect();
        if octree {
            order.sort_by_key(|&group| layout.levels[groups[group as usize].0 as usize]);
        }
        let whole = order.into_iter().map(part).collect();
        FileOrder { samples: None, preview, sequence, phases: [firsts, starts, whole] }
    }
}

/// All tasks of a scene: phase after phase, within a phase the files side by side.
pub fn schedule(order: Order, files: &mut [FileOrder]) -> Vec<Task> {
    let mut tasks = Vec::new();
    for phase in 0..3 {
        let before = tasks.len();
        for (file, parts) in files.iter_mut().map(|f| std::mem::take(&mut f.phases[phase])).enumerate() {
            let count = parts.len() as f64;
            let share = |i: usize| (i as f64 + 0.5) / count;
            tasks.extend(parts.into_iter().enumerate().map(|(i, part)| (share(i), Task { file: file as u32, part })));
        }
        if order == Order::PreviewFirst {
            // Stable: files that are equally far keep their order.
            tasks[before..].sort_by(|a: &(f64, Task), b| a.0.total_cmp(&b.0));
        }
    }
    tasks.into_iter().map(|(_, task)| task).collect()
}

/// Runs of chunks: small ones (COPC has many) of one level are put together, up to a batch.
fn groups(layout: &LazLayout) -> Vec<(u32, u32)> {
    let level = |chunk: u32| layout.levels.get(chunk as usize);
    let mut groups = Vec::new();
    let (mut start, mut points) = (0, 0u64);
    for (i, chunk) in (0u32..).zip(&layout.chunks) {
        let full = points.saturating_add(chunk.points) > BATCH_POINTS as u64;
        if i > start && (full || level(i) != level(start)) {
            groups.push((start, i));
            (start, points) = (i, 0);
        }
        points = points.saturating_add(chunk.points);
    }
    let end = layout.chunks.len() as u32;
    if end > start {
        groups.push((start, end));
    }
    groups
}

/// Blocks of a LAS file, spread evenly; the last one, which is not full, at the end (see [`Samples`]).
fn in_spread_order(blocks: u32) -> Vec<Part> {
    let last = blocks.saturating_sub(1);
    let full = bit_reversed(blocks).filter(|&block| block != last);
    full.chain((blocks > 0).then_some(last)).map(Part::Block).collect()
}

fn ranges(length: usize, per_range: usize) -> impl Iterator<Item = (u32, u32)> {
    (0..length).step_by(per_range).map(move |start| (start as u32, length.min(start + per_range) as u32))
}

/// The numbers `0..n` in the order of their bits read backwards: 0, n/2, n/4, 3n/4, … for a power of two.
pub fn bit_reversed(n: u32) -> impl Iterator<Item = u32> {
    let bits = u64::from(n).next_power_of_two().trailing_zeros();
    let reversed = move |i: u64| if bits == 0 { 0 } else { (i.reverse_bits() >> (64 - bits)) as u32 };
    (0..1u64 << bits).map(reversed).filter(move |&i| i < n)
}

#[cfg(test)]
mod tests {
    use super::{
        super::chunks::{Chunk, ChunkSource},
        *,
    };

    fn layout(points: &[u64]) -> LazLayout {
        let mut first_point = 0;
        let chunks = points
            .iter()
            .map(|&points| {
                let chunk = Chunk { at: 100 + first_point, bytes: points * 5, first_point, points };
                first_point += points;
                chunk
            })
            .collect();
        LazLayout {
            compressor: 2,
            items: vec![],
            chunk_size: None,
            source: ChunkSource::Table,
            chunks,
            levels: vec![],
            clamped: usize::MAX,
        }
    }

    #[test]
    fn bit_reversed_numbers_are_a_permutation_that_starts_at_0_and_is_spread_evenly() {
        assert_eq!(bit_reversed(8).collect::<Vec<_>>(), [0, 4, 2, 6, 1, 5, 3, 7]);
        assert_eq!(bit_reversed(5).collect::<Vec<_>>(), [0, 4, 2, 1, 3]);
        for n in [0, 1, 2, 3, 31, 32, 33, 1000] {
            let mut all: Vec<u32> = bit_reversed(n).collect();
            // However far it is, no quarter has more than its share and one in rounding.
            for done in 0..=all.len() {
                let quarter = all[..done].iter().filter(|&&i| 4 * i < n).count();
                assert!(quarter <= done.div_ceil(2).max(done / 4 + 2), "{n}: {quarter} of {done}");
            }
            all.sort_unstable();
            assert!(all.into_iter().eq(0..n));
        }
    }

    /// How often each record is read.
    fn reads(order: Order, points: u64) -> Vec<u8> {
        let mut file = FileOrder::of_records(order, points);
        let tasks = schedule(order, std::slice::from_mut(&mut file));
        let mut reads = vec![0u8; points as usize];
        let mut count = |start: u64, end: u64| reads[start as usize..end as usize].iter_mut().for_each(|n| *n += 1);
        for task in tasks {
            match task.part {
                Part::Samples { start, end, .. } => {
                    for &sample in &file.sequence[start as usize..end as usize] {
                        let range = file.samples.unwrap().range(sample);
                        count(range.start, range.end);
                    }
                }
                Part::Block(block) => {
                    let (start, end) = file.block(block, points);
                    match file.samples {
                        Some(samples) => samples.rest_of(start, end).for_each(|(a, b)| count(a, b)),
                        None => count(start, end),
                    }
                }
                other => panic!("{other:?} in a LAS file"),
            }
        }
        reads
    }

    #[test]
    fn every_record_is_read_exactly_once() {
        let batch = BATCH_POINTS as u64;
        for points in [0, 1, batch, batch + 1, 8 * batch - 1, 8 * batch, 8 * batch + 1, 600_000, 700_001, 40_000_003] {
            for order in [Order::PreviewFirst, Order::File] {
                assert!(reads(order, points).iter().all(|&n| n == 1), "{points} points, {order:?}");
            }
        }
    }

    #[test]
    fn samples_are_few_and_everywhere() {
        for points in [600_000u64, 10_000_000, 4_000_000_000] {
            let samples = Samples::of(points).unwrap();
            assert!(u64::from(samples.count) <= MAX_SAMPLES && 25 * samples.sampled() <= points, "{samples:?}");
            assert!(u64::from(samples.count) < BATCH_SAMPLES || samples.sampled().is_multiple_of(BLOCK));
            let last = samples.range(samples.count - 1);
            assert!(last.end <= points && points - last.end < 2 * samples.rest);
            // All blocks but the last fill a batch.
            let file = FileOrder::of_records(Order::PreviewFirst, points);
            for block in [0, 1, 5] {
                let (start, end) = file.block(block, points);
                assert_eq!(samples.rest_of(start, end).map(|(a, b)| b - a).sum::<u64>(), BLOCK);
            }
        }
        assert_eq!(Samples::of(500_000), None);
    }

    #[test]
    fn every_chunk_is_read_once_and_starts_are_spread() {
        let sizes: Vec<u64> = (0..3_000).map(|i| if i % 10 == 0 { 500 } else { 50_000 }).collect();
        let layout = layout(&sizes);
        for order in [Order::PreviewFirst, Order::File] {
            let mut file = FileOrder::of_chunks(order, &layout, true, MAX_KEPT);
            let tasks = schedule(order, std::slice::from_mut(&mut file));
            let mut read = vec![0; sizes.len()];
            let mut started = vec![0; sizes.len()];
            let mut full_pass = false;
            for task in tasks {
                match task.part {
                    Part::Chunks { start, end } => {
                        full_pass = true;
                        read[start as usize..end as usize].iter_mut().for_each(|n| *n += 1);
                    }
                    Part::Starts { start, end } => {
                        assert!(!full_pass);
                        for &chunk in &file.sequence[start as usize..end as usize] {
                            started[chunk as usize] += 1;
                        }
                    }
                    Part::Firsts { start, end } => assert_eq!((start, end), (0, 3_000)),
                    other => panic!("{other:?} in a LAZ file"),
                }
            }
            assert!(read.iter().all(|&n| n == 1));
            let total: u32 = started.iter().sum();
            assert!(started.iter().all(|&n| n <= 1) && total <= MAX_KEPT);
            assert_eq!(total > 800, order == Order::PreviewFirst, "{total}");
        }
    }

    #[test]
    fn small_chunks_share_a_task() {
        assert_eq!(groups(&layout(&[30_000, 30_000, 5_000, 60_000, 200_000, 1, 1])), [(0, 3), (3, 4), (4, 5), (5, 7)]);
        assert_eq!(groups(&layout(&[])), []);
    }

    #[test]
    fn files_advance_side_by_side() {
        let mut files = [
            FileOrder::of_records(Order::PreviewFirst, 65_536 * 6),
            FileOrder::of_records(Order::PreviewFirst, 65_536 * 2),
        ];
        let tasks = schedule(Order::PreviewFirst, &mut files);
        let order: Vec<u32> = tasks.iter().map(|t| t.file).collect();
        assert_eq!(order, [0, 0, 1, 0, 0, 0, 1, 0], "{tasks:?}");
    }
}
