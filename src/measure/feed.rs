//! Where points come from while measuring: files, or a synthetic scan straight from memory, which no
//! disk or decoder holds up.

use std::{
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread,
};

use crossbeam_channel::{Receiver, Sender, TryRecvError, bounded};

use crate::{
    scene::{BATCH_POINTS, FileFacts, PointBatch, SceneFacts},
    source::{self, Event, Fields, OpenOptions, SourceError, Stream},
    store::Permutation,
    synth::{Generator, SynthError, SynthOptions},
};

/// Batches that each generator thread may be ahead.
const AHEAD: usize = 4;

/// Points in order, as they become ready.
pub enum Feed {
    Files(Stream),
    Synth(SynthFeed),
}

/// What came from a [`Feed`].
pub enum Fed {
    Opened(Arc<SceneFacts>),
    Batch(PointBatch),
    Ended,
    /// Nothing at the moment.
    Nothing,
}

impl Feed {
    /// `fields`: as [`OpenOptions::fields`].
    pub fn files(inputs: &[PathBuf], threads: Option<usize>, fields: Option<Fields>) -> Feed {
        Feed::Files(source::open(inputs, OpenOptions { threads, fields, ..Default::default() }))
    }

    /// # Errors
    /// As [`Generator::new`].
    pub fn synth(options: &SynthOptions, threads: Option<usize>) -> Result<Feed, SynthError> {
        Ok(Feed::Synth(SynthFeed::new(options, threads)?))
    }

    /// The next event, if there is one; waits for it if `wait`.
    ///
    /// # Errors
    /// If no file can be read.
    pub fn next(&mut self, wait: bool) -> Result<Fed, SourceError> {
        match self {
            Feed::Files(stream) => {
                let event = if wait {
                    stream.events().recv().map_err(|_| TryRecvError::Disconnected)
                } else {
                    stream.events().try_recv()
                };
                match event {
                    Ok(Event::Opened(facts)) => Ok(Fed::Opened(facts)),
                    Ok(Event::Batch(batch)) => Ok(Fed::Batch(batch)),
                    Ok(Event::Failed(error)) => Err(error),
                    Ok(Event::Finished(_)) | Err(TryRecvError::Disconnected) => Ok(Fed::Ended),
                    Err(TryRecvError::Empty) => Ok(Fed::Nothing),
                }
            }
            Feed::Synth(feed) => Ok(feed.next(wait)),
        }
    }

    /// Gives a batch's memory back.
    pub fn recycle(&self, batch: PointBatch) {
        match self {
            Feed::Files(stream) => stream.recycle(batch),
            Feed::Synth(feed) => feed.recycle(batch),
        }
    }
}

/// Threads that make a synthetic scan, each every n-th batch. The batches come in random order: the
/// scene then has its full extent from the start, and only its density grows.
pub struct SynthFeed {
    facts: Option<Arc<SceneFacts>>,
    batches: Vec<Receiver<PointBatch>>,
    /// The batch that comes next; batch `i` is made by thread `i % n`.
    next: usize,
    spent: Sender<PointBatch>,
    cancel: Arc<AtomicBool>,
    threads: Vec<thread::JoinHandle<()>>,
}

impl SynthFeed {
    fn new(options: &SynthOptions, threads: Option<usize>) -> Result<SynthFeed, SynthError> {
        let generator = Arc::new(Generator::new(options)?);
        let count = threads.unwrap_or_else(|| thread::available_parallelism().map_or(1, |n| n.get())).max(1);
        // At most 2³² points: the number of batches fits.
        let order = Permutation::new(generator.len().div_ceil(BATCH_POINTS as u64) as u32, options.seed, 0);
        let (spent, reuse) = bounded::<PointBatch>(count * AHEAD);
        let cancel = Arc::new(AtomicBool::new(false));
        let mut batches = Vec::new();
        let mut handles = Vec::new();
        for thread in 0..count {
            let (send, receive) = bounded(AHEAD);
            let (generator, reuse, cancel) = (generator.clone(), reuse.clone(), cancel.clone());
            let work = move || {
                let size = BATCH_POINTS as u64;
                for i in (0..order.len()).skip(thread).step_by(count) {
                    let first = u64::from(order.apply(i)) * size;
                    let mut batch = reuse.try_recv().unwrap_or_default();
                    generator.fill_batch(first..(first + size).min(generator.len()), &mut batch);
                    if cancel.load(Ordering::Relaxed) || send.send(batch).is_err() {
                        return;
                    }
                }
            };
            batches.push(receive);
            if let Ok(handle) = thread::Builder::new().name(format!("synth-{thread}")).spawn(work) {
                handles.push(handle);
            }
        }
        let facts = SceneFacts {
            grid: generator.grid(),
            bounds: generator.bounds(),
            files: vec![FileFacts {
                path: format!("synthetic {:?}", options.scene).to_lowercase().into(),
                first_record: 0,
                points_in_header: generator.len(),
                bounds: generator.bounds(),
                kind: "from memory".into(),
                ..Default::default()
            }],
            warnings: Vec::new(),
        };
        Ok(SynthFeed { facts: Some(Arc::new(facts)), batches, next: 0, spent, cancel, threads: handles })
    }

    fn next(&mut self, wait: bool) -> Fed {
        if let Some(facts) = self.facts.take() {
            return Fed::Opened(facts);
        }
        let from = &self.batches[self.next % self.batches.len()];
        let batch = if wait { from.recv().map_err(|_| TryRecvError::Disconnected) } else { from.try_recv() };
        match batch {
            Ok(batch) => {
                self.next += 1;
                Fed::Batch(batch)
            }
            Err(TryRecvError::Empty) => Fed::Nothing,
            Err(TryRecvError::Disconnected) => Fed::Ended,
        }
    }

    fn recycle(&self, batch: PointBatch) {
        // If the threads hold enough already, this one's memory is freed.
        let _ = self.spent.try_send(batch);
    }
}

impl Drop for SynthFeed {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
        // Threads blocked on a full channel wake when its receiver is gone.
        self.batches.clear();
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}
