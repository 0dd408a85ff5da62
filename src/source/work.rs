//! A decoder thread's work: from a task to batches. LAS records are parsed straight out of positioned
//! reads; LAZ chunks go through a [`ChunkDecoder`]; both become columns in recycled batches.

use std::{
    fs::File,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Instant,
};

use crossbeam_channel::{Receiver, Sender};

use super::{
    bytes::read_full_at,
    chunks::{Chunk, LazLayout},
    control::Control,
    header::open_regular,
    kept::{Kept, Started},
    laz::{self, ChunkDecoder, DecoderChoice, End, Share},
    order::{Part, START_SHARE, Task},
    plan::{FilePlan, Layout},
    report::{Outcome, ThreadTimes},
};
use crate::scene::{BATCH_POINTS, PointBatch};

/// Bytes of LAS records per read: with the columns made of them they stay in a core's cache.
pub const READ_BYTES: usize = 1 << 18;

/// Decoded bytes between two looks at the cancel flag: a few hundred to a few thousand points, about a
/// millisecond.
pub const PIECE_BYTES: usize = 64 << 10;

/// A read of a few kilobytes that takes longer than this has waited for a disk that seeks: then most
/// samples are left for the end, when the blocks between them are read and they are in memory. From
/// memory it takes a microsecond, from an SSD a tenth of this.
pub const SLOW_READ_SECS: f64 = 2e-3;
/// Samples after which that is judged; a busy machine may hold up one or two of them.
const TRIED_SAMPLES: u32 = 12;

/// Part of a task's result.
pub enum Piece {
    Batch(PointBatch),
    End(Outcome),
}

/// What all workers share.
pub struct Shared<'a> {
    pub files: &'a [FilePlan],
    pub decoder: DecoderChoice,
    pub slow_read_secs: f64,
    pub kept: Kept,
    pub free: &'a Receiver<PointBatch>,
    pub cancel: &'a AtomicBool,
    pub control: &'a Control,
}

impl Shared<'_> {
    /// Nobody wants anything any more, or nothing of this file.
    fn cancelled(&self, file: u32) -> bool {
        self.cancel.load(Ordering::Relaxed) || self.control.is_cancelled(file as usize)
    }
}

/// One thread's state, kept from task to task.
pub struct Worker<'a> {
    shared: &'a Shared<'a>,
    pub times: ThreadTimes,
    /// Raw records.
    records: Vec<u8>,
    /// Buffers for compressed bytes.
    spare: Vec<Vec<u8>>,
    /// The last file opened; only for files that the plan does not hold open.
    opened: Option<(u32, Arc<File>)>,
}

/// Where one task's points go.
struct Output<'a> {
    to: Sender<Piece>,
    plan: &'a FilePlan,
    file: u32,
    batch: Option<PointBatch>,
    outcome: Outcome,
    /// Nobody wants more.
    stopped: bool,
}

impl<'a> Worker<'a> {
    pub fn new(shared: &'a Shared<'a>, name: String) -> Worker<'a> {
        Worker {
            shared,
            times: ThreadTimes { name, ..Default::default() },
            records: Vec::new(),
            spare: Vec::new(),
            opened: None,
        }
    }

    /// Does one task and sends its result; returns what it left for later.
    pub fn work(&mut self, task: Task, to: Sender<Piece>) -> Option<Task> {
        let plan = &self.shared.files[task.file as usize];
        let preview = matches!(task.part, Part::Samples { .. } | Part::Firsts { .. } | Part::Starts { .. });
        let before = self.times.busy_secs();
        let outcome = Outcome::default();
        let mut output = Output { to, plan, file: task.file, batch: None, outcome, stopped: false };
        if self.shared.control.is_cancelled(task.file as usize) {
            // A thread that is in the middle of a chunk may wait for its start.
            self.give_up(task, plan);
            self.times.wait_secs += output.finish();
            return None;
        }
        let result = laz::catch(|| match self.file(task.file, plan) {
            Ok(file) => self.part(&file, task.part, &mut output),
            Err(error) => {
                output.fault(0, error);
                self.give_up(task, plan);
                None
            }
        });
        let left = result.unwrap_or_else(|panic| {
            output.fault(0, format!("the decoder stopped: {panic}"));
            None
        });
        self.times.wait_secs += output.finish();
        if preview {
            self.times.preview_secs += self.times.busy_secs() - before;
        }
        self.shared.control.publish(&self.times);
        left.map(|part| Task { file: task.file, part })
    }

    /// Says of a task's chunks that they could not be started.
    fn give_up(&self, task: Task, plan: &FilePlan) {
        let (Part::Starts { start, end }, Layout::Laz(layout)) = (task.part, &plan.layout) else { return };
        for &chunk in &plan.order.sequence[start as usize..end as usize] {
            let sent = sent_first(plan, layout, chunk as usize);
            self.shared.kept.put((task.file, chunk), sent, 0, None);
        }
    }

    /// Keeps no more memory of buffers than a chunk has bytes: a layer's buffer grows to the largest one
    /// that it ever held.
    fn trim_spare(&mut self, chunk: &Chunk) {
        let mut left = chunk.bytes.max(PIECE_BYTES as u64) as usize;
        self.spare.retain(|buffer| {
            let fits = buffer.capacity() <= left;
            left -= if fits { buffer.capacity() } else { 0 };
            fits
        });
    }

    fn file(&mut self, number: u32, plan: &FilePlan) -> Result<Arc<File>, String> {
        if let Some(file) = &plan.file {
            return Ok(Arc::clone(file));
        }
        match &self.opened {
            Some((opened, file)) if *opened == number => Ok(Arc::clone(file)),
            _ => {
                let (file, _) = open_regular(&plan.header.path).map_err(|e| e.to_string())?;
                let file = Arc::new(file);
                self.opened = Some((number, Arc::clone(&file)));
                Ok(file)
            }
        }
    }

    fn part(&mut self, file: &Arc<File>, part: Part, output: &mut Output<'_>) -> Option<Part> {
        let plan = output.plan;
        let order = &plan.order;
        match (part, &plan.layout) {
            (Part::Samples { start, end, early }, Layout::Las) => {
                let samples = order.samples?;
                let mut slow = 0;
                for position in start..end {
                    let range = samples.range(order.sequence[position as usize]);
                    let before = self.times.read_secs;
                    self.records(file, (range.start, range.end), output, |from, to| Some((from, to)).into_iter());
                    slow += u32::from(self.times.read_secs - before > self.shared.slow_read_secs);
                    let done = position + 1 - start;
                    if early && done >= TRIED_SAMPLES && 2 * slow > done && position + 1 < end {
                        return Some(Part::Samples { start: position + 1, end, early: false });
                    }
                }
            }
            (Part::Block(block), Layout::Las) => {
                let span = order.block(block, plan.points);
                match order.samples {
                    Some(samples) => self.records(file, span, output, |a, b| samples.rest_of(a, b)),
                    None => self.records(file, span, output, |a, b| Some((a, b)).into_iter()),
                }
            }
            (Part::Firsts { start, end }, Layout::Laz(layout)) => {
                for position in start..end {
                    self.first(file, layout, (position * order.preview.firsts_every) as usize, output);
                }
            }
            (Part::Starts { start, end }, Layout::Laz(layout)) => {
                for &chunk in &order.sequence[start as usize..end as usize] {
                    let first = sent_first(plan, layout, chunk as usize);
                    let chunk_facts = &layout.chunks[chunk as usize];
                    let target = chunk_facts.points / START_SHARE;
                    let mut run = Run { chunk: chunk_facts, next: 0, skip: first, end: target };
                    // Whatever happens, the full pass must learn what was sent.
                    let decoder = laz::catch(|| self.start(file, layout, &mut run, output)).ok().flatten();
                    self.shared.kept.put((output.file, chunk), first, run.next, decoder);
                }
            }
            (Part::Chunks { start, end }, Layout::Laz(layout)) => {
                for chunk in start..end {
                    self.rest_of_chunk(file, layout, chunk, output);
                }
            }
            _ => {}
        }
        None
    }

    /// Reads LAS records `start..end` and takes the stretches of them that `wanted` names.
    fn records<I: Iterator<Item = (u64, u64)>>(
        &mut self,
        file: &File,
        (start, end): (u64, u64),
        output: &mut Output<'_>,
        wanted: impl Fn(u64, u64) -> I,
    ) {
        let length = output.plan.header.record_length();
        let per_read = (READ_BYTES / length).max(1) as u64;
        let mut next = start;
        while next < end && !output.stopped {
            let count = per_read.min(end - next) as usize;
            let at = output.plan.header.data_at() + next * length as u64;
            if self.records.len() < count * length {
                self.records.resize(count * length, 0);
            }
            let began = Instant::now();
            let found = read_full_at(file, &mut self.records[..count * length], at);
            self.times.read_secs += began.elapsed().as_secs_f64();
            let found = match found {
                Ok(found) => found,
                Err(error) => return output.fault(next, format!("cannot read at byte {at} (record {next}): {error}")),
            };
            self.times.bytes += found as u64;
            let there = next + (found / length) as u64;
            for (from, to) in wanted(next, there) {
                let bytes = &self.records[(from - next) as usize * length..(to - next) as usize * length];
                output.append(self.shared, &mut self.times, bytes, from);
            }
            if there < next + count as u64 {
                let what = format!("the file now ends at byte {} (in record {there})", at + found as u64);
                return output.fault(there, what);
            }
            next = there;
        }
    }

    /// A chunk's first record is stored raw.
    fn first(&mut self, file: &File, layout: &LazLayout, number: usize, output: &mut Output<'_>) {
        let length = output.plan.header.record_length();
        if !output.plan.order.preview.shows_first(layout, number, length) || output.stopped {
            return;
        }
        let chunk = &layout.chunks[number];
        self.records.resize(self.records.len().max(length), 0);
        let began = Instant::now();
        let found = read_full_at(file, &mut self.records[..length], chunk.at);
        self.times.read_secs += began.elapsed().as_secs_f64();
        // If it cannot be read, neither can the chunk, and that will be said.
        if found.is_ok_and(|found| found == length) {
            output.append(self.shared, &mut self.times, &self.records[..length], chunk.first_point);
        }
    }

    /// Decodes a chunk's first points; gives the decoder if it can go on. Faults are left to the full
    /// pass, which meets them again.
    fn start(
        &mut self,
        file: &Arc<File>,
        layout: &LazLayout,
        run: &mut Run<'_>,
        output: &mut Output<'_>,
    ) -> Option<Box<dyn ChunkDecoder>> {
        let mut decoder = self.decoder(file, layout, run.chunk, output.plan).ok()?;
        self.load(decoder.as_mut(), Share::Start(START_SHARE), run.chunk).ok()?;
        let fault = self.decode(decoder.as_mut(), run, output);
        decoder.unload(&mut self.spare);
        self.trim_spare(run.chunk);
        fault.is_none().then_some(decoder)
    }

    fn decoder(
        &self,
        file: &Arc<File>,
        layout: &LazLayout,
        chunk: &Chunk,
        plan: &FilePlan,
    ) -> Result<Box<dyn ChunkDecoder>, String> {
        laz::decoder(file, layout, plan.header.record_length(), chunk, plan.reader.fields, self.shared.decoder)
    }

    /// Decodes what the preview has not shown of a chunk.
    fn rest_of_chunk(&mut self, file: &Arc<File>, layout: &LazLayout, number: u32, output: &mut Output<'_>) {
        if output.stopped || self.shared.cancelled(output.file) {
            return;
        }
        let plan = output.plan;
        let chunk = &layout.chunks[number as usize];
        let place = || format!("chunk {number} (bytes {} to {})", chunk.at, chunk.at + chunk.bytes);
        let Started { sent, decoder } = if plan.order.preview.starts(layout, number as usize) {
            match self.shared.kept.take((output.file, number), self.shared.cancel) {
                Some(started) => started,
                None => return,
            }
        } else {
            Started { sent: sent_first(plan, layout, number as usize), decoder: None }
        };
        if chunk.points == 0 {
            return;
        }
        let mut run = Run { chunk, next: 0, skip: sent, end: chunk.points };
        let decoder = match decoder {
            Some(decoder) => {
                run.next = sent;
                Ok(decoder)
            }
            None => self.decoder(file, layout, chunk, plan),
        };
        let fault = match decoder {
            Err(what) => Some(what),
            Ok(mut decoder) => match self.load(decoder.as_mut(), Share::All, chunk) {
                Err(what) => Some(what),
                Ok(()) => {
                    let fault = self.decode(decoder.as_mut(), &mut run, output);
                    if let Some(unused) = decoder.unused().filter(|&n| n > 0)
                        && run.next == chunk.points
                        && layout.is_exact(number.into())
                    {
                        output.suspect(number.into(), || {
                            format!("{} has {unused} bytes too many and is probably damaged", place())
                        });
                    }
                    decoder.unload(&mut self.spare);
                    self.trim_spare(chunk);
                    fault
                }
            },
        };
        if let Some(what) = fault {
            let (done, points) = (run.next.max(sent), chunk.points);
            output.fault(number.into(), format!("{}: {what}, after {done} of {points} points", place()));
        }
    }

    fn load(&mut self, decoder: &mut dyn ChunkDecoder, share: Share, chunk: &Chunk) -> Result<(), String> {
        let began = Instant::now();
        let loaded = decoder.load(share, &mut self.spare);
        self.times.read_secs += began.elapsed().as_secs_f64();
        if share == Share::All {
            self.times.bytes += chunk.bytes;
        }
        loaded
    }

    /// Decodes a run of a chunk's points; says what went wrong, if anything did.
    fn decode(&mut self, decoder: &mut dyn ChunkDecoder, run: &mut Run<'_>, output: &mut Output<'_>) -> Option<String> {
        let length = output.plan.header.record_length();
        let per_piece = (PIECE_BYTES / length).max(1) as u64;
        while run.next < run.end && !output.stopped && !self.shared.cancelled(output.file) {
            let wanted = per_piece.min(run.end - run.next) as usize * length;
            self.records.resize(self.records.len().max(wanted), 0);
            let began = Instant::now();
            let decoded = decoder.decode(&mut self.records[..wanted]);
            self.times.decode_secs += began.elapsed().as_secs_f64();
            let first = run.next;
            run.next += decoded.records as u64;
            let skip = (run.skip.saturating_sub(first) as usize).min(decoded.records);
            let bytes = &self.records[skip * length..decoded.records * length];
            // Where nothing says where a chunk ends, garbage follows: the header's box tells.
            let sane = if output.plan.ends_unknown() { output.plan.reader.inside_bounds(bytes) } else { usize::MAX };
            let kept = sane.min(bytes.len() / length);
            output.append(
                self.shared,
                &mut self.times,
                &bytes[..kept * length],
                run.chunk.first_point + first + skip as u64,
            );
            if kept < bytes.len() / length {
                run.next = first + (skip + kept) as u64;
                return Some(
                    "chunks of varying size, and no table that says where they end: no sense after that".into(),
                );
            }
            match decoded.end {
                End::Filled => {}
                End::NeedsBytes => return None,
                End::Fault(what) => return Some(what),
            }
        }
        None
    }
}

/// A run of a chunk's points: from `next` to `end`, of which those before `skip` were sent before.
struct Run<'a> {
    chunk: &'a Chunk,
    next: u64,
    skip: u64,
    end: u64,
}

/// Points of a chunk that were sent as its raw first record.
fn sent_first(plan: &FilePlan, layout: &LazLayout, chunk: usize) -> u64 {
    u64::from(plan.order.preview.shows_first(layout, chunk, plan.header.record_length()))
}

impl Output<'_> {
    /// Notes a fault at a record or chunk.
    fn fault(&mut self, at: u64, what: String) {
        self.outcome.note_fault(at, what);
    }

    fn suspect(&mut self, at: u64, what: impl FnOnce() -> String) {
        self.outcome.note_suspect(at, what);
    }

    /// Takes raw records; `index` is the first one's number within the file.
    fn append(&mut self, shared: &Shared<'_>, times: &mut ThreadTimes, mut bytes: &[u8], mut index: u64) {
        let length = self.plan.header.record_length();
        while !bytes.is_empty() && !self.stopped {
            if shared.cancelled(self.file) {
                self.stopped = true;
                return;
            }
            let began = Instant::now();
            let file = self.file;
            let batch = self.batch.get_or_insert_with(|| {
                let mut batch = shared.free.try_recv().unwrap_or_default();
                batch.clear();
                batch.file = file;
                batch
            });
            let room = BATCH_POINTS - batch.len();
            let (now, later) = bytes.split_at(bytes.len().min(room * length));
            let odd = self.plan.reader.append(now, index as u32, batch);
            let full = batch.len() == BATCH_POINTS;
            times.convert_secs += began.elapsed().as_secs_f64();
            times.points += (now.len() / length) as u64;
            self.outcome.oddities.outside_bounds += odd.outside_bounds;
            self.outcome.oddities.beyond_grid += odd.beyond_grid;
            if full {
                times.wait_secs += self.send();
                shared.control.publish(times);
            }
            index += (now.len() / length) as u64;
            bytes = later;
        }
    }

    /// Sends the batch; returns the seconds spent waiting for room.
    fn send(&mut self) -> f64 {
        let Some(batch) = self.batch.take().filter(|batch| !batch.is_empty()) else { return 0.0 };
        let began = Instant::now();
        self.stopped |= self.to.send(Piece::Batch(batch)).is_err();
        began.elapsed().as_secs_f64()
    }

    /// Sends what is left; returns the seconds spent waiting.
    fn finish(mut self) -> f64 {
        let mut waited = self.send();
        let began = Instant::now();
        // Nobody listens any more: nothing to be done about it.
        let _ = self.to.send(Piece::End(self.outcome));
        waited += began.elapsed().as_secs_f64();
        waited
    }
}
