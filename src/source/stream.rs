//! The threads. Workers take tasks (runs of LAS records, LAZ chunks) in file order; each task has a
//! small channel of its own, and one thread empties these channels in the order of the tasks. So the
//! order of the batches does not depend on timing, and memory is bounded by the channels: a worker
//! that is ahead waits for its turn, the one whose turn it is never waits for another.

use std::{
    fs::File,
    panic::{AssertUnwindSafe, catch_unwind},
    path::PathBuf,
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use crossbeam_channel::{Receiver, SendTimeoutError, Sender, bounded};

use super::{
    Event, FileReport, OpenOptions, SourceError, SourceReport,
    bytes::read_full_at,
    header::open_regular,
    laz::{ChunkEnd, DECODER_THREAD, decode_chunk, silence_decoder_panics, take_panic},
    plan::{self, FilePlan, Layout},
    report::{Outcome, file_report},
};
use crate::scene::{BATCH_POINTS, PointBatch};

/// Events that wait for the consumer.
const EVENTS_AHEAD: usize = 4;
/// Batches of one task that wait for their turn.
const PIECES_AHEAD: usize = 2;
/// Bytes of LAS records per read.
const READ_BYTES: usize = 1 << 18;
/// How long a blocked sender waits before it looks at the cancel flag again.
const LOOK_UP: Duration = Duration::from_millis(10);

/// The threads' side of a stream.
pub struct Engine {
    pub inputs: Vec<PathBuf>,
    pub options: OpenOptions,
    pub events: Sender<Event>,
    pub free: Receiver<PointBatch>,
    pub cancel: Arc<AtomicBool>,
}

/// Capacity of the channel of events, and of the one that gives buffers back.
pub fn capacities(threads: usize) -> (usize, usize) {
    (EVENTS_AHEAD, EVENTS_AHEAD + PIECES_AHEAD * (tasks_ahead(threads) + threads))
}

/// Tasks whose results may wait for their turn, besides those that workers are busy with.
fn tasks_ahead(threads: usize) -> usize {
    threads
}

/// Part of a task's result.
enum Piece {
    Batch(PointBatch),
    End(Outcome),
}

/// A run of work: LAS records, or chunks of a LAZ file, as numbers within the file.
struct Task {
    file: usize,
    start: u64,
    end: u64,
}

/// What the workers share.
struct Shared<'a> {
    files: &'a [FilePlan],
    queue: Mutex<Queue>,
    free: &'a Receiver<PointBatch>,
    cancel: &'a AtomicBool,
}

/// The next task, and where its results are announced.
struct Queue {
    file: usize,
    next: u64,
    announce: Option<Sender<(usize, Receiver<Piece>)>>,
}

impl Engine {
    /// Reads everything; returns when it is read, or nobody wants it any more.
    pub fn run(self, threads: usize) {
        silence_decoder_panics();
        let plan = match plan::make(&self.inputs, &self.options, &self.cancel) {
            Ok(plan) => plan,
            Err(error) => {
                self.send(Event::Failed(error));
                return;
            }
        };
        if !self.send(Event::Opened(Arc::new(plan.facts))) {
            return;
        }
        let (announce, tasks) = bounded(tasks_ahead(threads));
        let shared = Shared {
            files: &plan.files,
            queue: Mutex::new(Queue { file: 0, next: 0, announce: Some(announce) }),
            free: &self.free,
            cancel: &self.cancel,
        };
        let outcomes = std::thread::scope(|scope| {
            let spawn = |n: usize| {
                let builder = std::thread::Builder::new().name(format!("{DECODER_THREAD}{n}"));
                builder.spawn_scoped(scope, || shared.work())
            };
            // Fewer threads than asked for do as well.
            let first = spawn(0);
            (1..threads).map_while(|n| spawn(n).ok()).for_each(drop);
            first.ok()?;
            self.in_order(tasks, plan.files.len())
        });
        if self.cancel.load(Ordering::Relaxed) {
            return;
        }
        let Some(outcomes) = outcomes else {
            let reason = "the system gives no more threads".to_owned();
            self.send(Event::Failed(SourceError::Io { path: PathBuf::new(), doing: "start a decoder", reason }));
            return;
        };
        let mut files: Vec<FileReport> = plan.files.iter().zip(outcomes).map(|(f, o)| file_report(f, o)).collect();
        files.extend(plan.failed);
        self.send(Event::Finished(SourceReport { files }));
    }

    /// Passes the tasks' batches on, task by task; `None` if nobody wants them.
    fn in_order(&self, tasks: Receiver<(usize, Receiver<Piece>)>, files: usize) -> Option<Vec<(u64, Outcome)>> {
        let mut outcomes: Vec<(u64, Outcome)> = (0..files).map(|_| Default::default()).collect();
        for (file, pieces) in tasks {
            let (decoded, total) = &mut outcomes[file];
            for piece in pieces {
                match piece {
                    Piece::Batch(batch) => {
                        *decoded += batch.len() as u64;
                        if !self.send(Event::Batch(batch)) {
                            return None;
                        }
                    }
                    Piece::End(outcome) => total.merge(outcome),
                }
            }
        }
        Some(outcomes)
    }

    /// Sends an event; false if the stream was dropped.
    fn send(&self, mut event: Event) -> bool {
        loop {
            if self.cancel.load(Ordering::Relaxed) {
                return false;
            }
            match self.events.send_timeout(event, LOOK_UP) {
                Ok(()) => break,
                Err(SendTimeoutError::Timeout(back)) => event = back,
                Err(SendTimeoutError::Disconnected(_)) => return false,
            }
        }
        if let Some(wake) = &self.options.wake {
            wake();
        }
        true
    }
}

impl Shared<'_> {
    /// A worker's life.
    fn work(&self) {
        let mut open: Option<(usize, File)> = None;
        while let Some((task, to)) = self.take_task() {
            let mut output = Output {
                shared: self,
                plan: &self.files[task.file],
                file: task.file,
                to,
                batch: None,
                outcome: Outcome::default(),
            };
            let result = catch_unwind(AssertUnwindSafe(|| output.decode(&task, &mut open)));
            if result.is_err() {
                output.fault(format!("the decoder stopped: {}", take_panic()));
            }
            output.finish();
        }
    }

    /// Takes the next task and announces its results, under one lock: announced in the order taken.
    fn take_task(&self) -> Option<(Task, Sender<Piece>)> {
        let mut queue = self.queue.lock().ok()?;
        if self.cancel.load(Ordering::Relaxed) {
            queue.announce = None;
        }
        let task = loop {
            let Some(plan) = self.files.get(queue.file) else {
                queue.announce = None;
                return None;
            };
            if let Some(end) = plan.task_end(queue.next) {
                let start = std::mem::replace(&mut queue.next, end);
                break Task { file: queue.file, start, end };
            }
            (queue.file, queue.next) = (queue.file + 1, 0);
        };
        let (to, from) = bounded(PIECES_AHEAD);
        queue.announce.as_ref()?.send((task.file, from)).ok()?;
        Some((task, to))
    }
}

impl FilePlan {
    /// Where the task that starts at record or chunk `start` ends; `None` behind the last one.
    fn task_end(&self, start: u64) -> Option<u64> {
        match &self.layout {
            Layout::Las => (start < self.points).then(|| self.points.min(start + BATCH_POINTS as u64)),
            Layout::Laz(layout) => {
                // Small chunks (COPC has many) are put together, up to a batch.
                let chunks = layout.chunks.get(start as usize..).filter(|c| !c.is_empty())?;
                let mut points = 0;
                let fitting = chunks.iter().take_while(|c| {
                    points += c.points;
                    points <= BATCH_POINTS as u64
                });
                Some(start + fitting.count().max(1) as u64)
            }
        }
    }
}

/// Where a task's records go.
struct Output<'a> {
    shared: &'a Shared<'a>,
    plan: &'a FilePlan,
    file: usize,
    to: Sender<Piece>,
    batch: Option<PointBatch>,
    outcome: Outcome,
}

impl Output<'_> {
    fn decode(&mut self, task: &Task, open: &mut Option<(usize, File)>) {
        if open.as_ref().is_none_or(|(number, _)| *number != task.file) {
            *open = match open_regular(&self.plan.header.path) {
                Ok((file, _)) => Some((task.file, file)),
                Err(error) => return self.fault(error.to_string()),
            };
        }
        let Some((_, file)) = open else { return };
        match &self.plan.layout {
            Layout::Las => self.decode_las(file, task),
            Layout::Laz(_) => self.decode_laz(file, task),
        }
    }

    fn decode_las(&mut self, file: &File, task: &Task) {
        let length = self.plan.header.record_length();
        let per_read = (READ_BYTES / length).max(1);
        let mut buffer = vec![0; per_read.min((task.end - task.start) as usize) * length];
        let mut next = task.start;
        while next < task.end {
            let wanted = per_read.min((task.end - next) as usize);
            let at = self.plan.header.data_at() + next * length as u64;
            let bytes = &mut buffer[..wanted * length];
            let found = match read_full_at(file, bytes, at) {
                Ok(found) => found,
                Err(error) => return self.fault(format!("cannot read at byte {at} (record {next}): {error}")),
            };
            let records = found / length;
            if !self.records(&bytes[..records * length], next) {
                return;
            }
            next += records as u64;
            if records < wanted {
                return self.fault(format!("the file now ends at byte {} (in record {next})", at + found as u64));
            }
        }
    }

    fn decode_laz(&mut self, file: &File, task: &Task) {
        let Layout::Laz(layout) = &self.plan.layout else { return };
        for number in task.start..task.end {
            let chunk = &layout.chunks[number as usize];
            let mut decoded = 0;
            let mut lost = false;
            let length = self.plan.header.record_length();
            let end = decode_chunk(file, layout, length, self.plan.reader.fields, chunk, |mut records, index| {
                if layout.ends_unknown() {
                    let sane = self.plan.reader.inside_bounds(records);
                    lost = sane < records.len() / length;
                    records = &records[..sane * length];
                }
                decoded += (records.len() / length) as u64;
                self.records(records, index) && !lost
            });
            let place = format!("chunk {number} (bytes {} to {})", chunk.at, chunk.at + chunk.bytes);
            match end {
                ChunkEnd::Complete { unused: Some(unused) } if unused > 0 && layout.is_exact(number) => {
                    self.outcome.suspects += 1;
                    let what = || format!("{place} has {unused} bytes too many and is probably damaged");
                    self.outcome.suspect.get_or_insert_with(what);
                }
                ChunkEnd::Complete { .. } => {}
                ChunkEnd::Stopped if lost => self.fault(format!(
                    "{place}: chunks of varying size, and no table that says where they end: \
                     nothing sensible after {decoded} points"
                )),
                ChunkEnd::Stopped => return,
                ChunkEnd::Fault(what) => {
                    self.fault(format!("{place}: {what}, after {decoded} of {} points", chunk.points));
                }
            }
        }
    }

    fn fault(&mut self, what: String) {
        self.outcome.faults += 1;
        self.outcome.fault.get_or_insert(what);
    }

    /// Takes raw records; false if nobody wants more.
    fn records(&mut self, mut bytes: &[u8], mut index: u64) -> bool {
        let length = self.plan.header.record_length();
        while !bytes.is_empty() {
            if self.shared.cancel.load(Ordering::Relaxed) {
                return false;
            }
            let batch = self.batch.get_or_insert_with(|| {
                let mut batch = self.shared.free.try_recv().unwrap_or_default();
                batch.clear();
                batch.file = self.file as u32;
                batch
            });
            let room = BATCH_POINTS - batch.len();
            let (now, later) = bytes.split_at(bytes.len().min(room * length));
            let odd = self.plan.reader.append(now, index as u32, batch);
            self.outcome.oddities.outside_bounds += odd.outside_bounds;
            self.outcome.oddities.beyond_grid += odd.beyond_grid;
            if batch.len() == BATCH_POINTS && !self.send() {
                return false;
            }
            index += (now.len() / length) as u64;
            bytes = later;
        }
        true
    }

    fn send(&mut self) -> bool {
        match self.batch.take() {
            Some(batch) if !batch.is_empty() => self.to.send(Piece::Batch(batch)).is_ok(),
            _ => true,
        }
    }

    fn finish(mut self) {
        if self.send() {
            // Nobody listens any more: nothing to be done about it.
            let _ = self.to.send(Piece::End(self.outcome));
        }
    }
}
