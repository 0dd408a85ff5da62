//! The threads. Workers take tasks in the order of the plan; each task has a small channel of its own,
//! and one thread empties these channels in the order of the tasks. So the order of the batches does not
//! depend on timing, and memory is bounded by the channels: a worker
//! that is ahead waits for its turn, the one whose turn it is never waits for another.

use std::{
    path::PathBuf,
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use crossbeam_channel::{Receiver, SendTimeoutError, Sender, bounded};

use super::{
    Event, FileReport, OpenOptions, SourceError, SourceReport, ThreadTimes,
    control::Control,
    kept::{self, Kept},
    laz::{DECODER_THREAD, silence_decoder_panics},
    order::Task,
    plan::{self, FilePlan},
    report::{Outcome, file_report},
    work::{Piece, SLOW_READ_SECS, Shared, Worker},
};
use crate::scene::{BATCH_POINTS, PointBatch};

/// Events that wait for the consumer.
const EVENTS_AHEAD: usize = 4;
/// Batches of one task that wait for their turn.
const PIECES_AHEAD: usize = 2;
/// How long a blocked sender waits before it looks at the cancel flag again.
const LOOK_UP: Duration = Duration::from_millis(10);

/// The threads' side of a stream.
pub struct Engine {
    pub inputs: Vec<PathBuf>,
    pub options: OpenOptions,
    pub events: Sender<Event>,
    pub free: Receiver<PointBatch>,
    pub cancel: Arc<AtomicBool>,
    pub control: Arc<Control>,
}

/// Capacity of the channel of events, and of the one that gives buffers back.
pub fn capacities(threads: usize) -> (usize, usize) {
    (EVENTS_AHEAD, EVENTS_AHEAD + PIECES_AHEAD * (tasks_ahead(threads) + threads))
}

/// Tasks whose results may wait for their turn, besides those that workers are busy with.
fn tasks_ahead(threads: usize) -> usize {
    threads
}

/// The tasks that are left.
struct Queue<'a> {
    tasks: std::slice::Iter<'a, Task>,
    /// Put off until all others are done.
    later: Vec<Task>,
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
        self.control.set_files(plan.files.len());
        let memory_bound_bytes = memory_bound(&plan.files, threads);
        if !self.send(Event::Opened(Arc::new(plan.facts))) {
            return;
        }
        let (announce, announced) = bounded(tasks_ahead(threads));
        let queue = Mutex::new(Queue { tasks: plan.tasks.iter(), later: Vec::new() });
        let shared = Shared {
            files: &plan.files,
            decoder: self.options.decoder,
            slow_read_secs: self.options.slow_read.map_or(SLOW_READ_SECS, |d| d.as_secs_f64()),
            kept: Kept::default(),
            free: &self.free,
            cancel: &self.cancel,
            control: &self.control,
        };
        let result = std::thread::scope(|scope| {
            let spawn = |n: usize| {
                let name = format!("{DECODER_THREAD}{n}");
                let builder = std::thread::Builder::new().name(name.clone());
                let (announce, worker) = (announce.clone(), Worker::new(&shared, name));
                let (queue, cancel) = (&queue, &self.cancel);
                builder.spawn_scoped(scope, move || work(worker, queue, announce, cancel))
            };
            // Fewer threads than asked for do as well.
            let first = spawn(0).ok()?;
            let workers: Vec<_> = std::iter::once(first).chain((1..threads).map_while(|n| spawn(n).ok())).collect();
            // The workers' copies tell when all is announced.
            drop(announce);
            let outcomes = self.in_order(announced, plan.files.len());
            let times: Vec<ThreadTimes> = workers.into_iter().filter_map(|w| w.join().ok()).collect();
            Some((outcomes, times))
        });
        if self.cancel.load(Ordering::Relaxed) {
            return;
        }
        let Some((outcomes, threads)) = result else {
            let reason = "the system gives no more threads".to_owned();
            self.send(Event::Failed(SourceError::Io { path: PathBuf::new(), doing: "start a decoder", reason }));
            return;
        };
        let outcomes = outcomes.into_iter().flatten();
        let reports = plan.files.iter().zip(outcomes).enumerate();
        let mut files: Vec<FileReport> =
            reports.map(|(i, (file, outcome))| file_report(file, outcome, self.control.is_cancelled(i))).collect();
        files.extend(plan.failed);
        self.send(Event::Finished(SourceReport { files, threads, memory_bound_bytes }));
    }

    /// Passes the tasks' batches on, task by task; `None` if nobody wants them.
    fn in_order(&self, tasks: Receiver<(u32, Receiver<Piece>)>, files: usize) -> Option<Vec<(u64, Outcome)>> {
        let mut outcomes: Vec<(u64, Outcome)> = (0..files).map(|_| Default::default()).collect();
        for (file, pieces) in &tasks {
            if !self.pass_on(pieces, &mut outcomes[file as usize]) {
                // What is announced must be taken until the last worker has gone: a channel keeps its
                // messages when its receiver is dropped, and with them the other ends of channels that
                // workers may be blocked on.
                tasks.iter().for_each(drop);
                return None;
            }
        }
        Some(outcomes)
    }

    /// Passes one task's batches on; false if nobody wants them.
    fn pass_on(&self, pieces: Receiver<Piece>, (decoded, total): &mut (u64, Outcome)) -> bool {
        for piece in pieces {
            match piece {
                Piece::Batch(batch) => {
                    *decoded += batch.len() as u64;
                    if !self.send(Event::Batch(batch)) {
                        return false;
                    }
                }
                Piece::End(outcome) => total.merge(outcome),
            }
        }
        true
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

/// Where the tasks' results are announced, in the order of the tasks.
type Announce = Sender<(u32, Receiver<Piece>)>;

/// A worker's life; returns how it spent its time.
fn work(mut worker: Worker<'_>, queue: &Mutex<Queue<'_>>, announce: Announce, cancel: &AtomicBool) -> ThreadTimes {
    loop {
        let began = Instant::now();
        let Some((task, to)) = take_task(queue, &announce, cancel) else { return worker.times };
        worker.times.wait_secs += began.elapsed().as_secs_f64();
        let left = worker.work(task, to);
        if let (Some(left), Ok(mut queue)) = (left, queue.lock()) {
            queue.later.push(left);
        }
    }
}

/// Takes the next task and announces its results, under one lock: announced in the order taken.
fn take_task(queue: &Mutex<Queue<'_>>, announce: &Announce, cancel: &AtomicBool) -> Option<(Task, Sender<Piece>)> {
    let mut queue = queue.lock().ok()?;
    if cancel.load(Ordering::Relaxed) {
        return None;
    }
    let task = queue.tasks.next().copied().or_else(|| queue.later.pop())?;
    let (to, from) = bounded(PIECES_AHEAD);
    announce.send((task.file, from)).ok()?;
    Some((task, to))
}

/// Most heap memory that reading takes: batches on their way and spare ones, the threads' buffers, the
/// decoders that are kept, and the lists of chunks and tasks.
fn memory_bound(files: &[FilePlan], threads: usize) -> u64 {
    let (ahead, spare) = capacities(threads);
    // Waiting in the tasks' channels, being filled, waiting for the consumer, being sent, and spare.
    let batches = PIECES_AHEAD * (tasks_ahead(threads) + threads) + threads + ahead + 1 + spare;
    let batch = files.iter().map(|f| f.reader.bytes_per_point()).max().unwrap_or(0) * BATCH_POINTS;
    let per_thread = files.iter().map(FilePlan::thread_bytes).max().unwrap_or(0);
    let kept = if files.iter().any(FilePlan::keeps_decoders) { kept::BOUND_BYTES } else { 0 };
    let lists: u64 = files.iter().map(FilePlan::list_bytes).sum();
    (batches * batch) as u64 + threads as u64 * per_thread + kept + lists
}
