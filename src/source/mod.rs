//! Reading: from paths to point batches.
//!
//! [`open`] returns at once; a thread of its own lists the inputs, reads the headers, and starts the
//! decoder threads. Everything arrives through one bounded channel, in an order that depends on the
//! files alone and not on thread timing: [`Event::Opened`], then batches (an early view of everything
//! first: see [`Order`]), then [`Event::Finished`]; or [`Event::Failed`] if nothing could be opened.
//!
//! ```text
//! control   what a running reader is told: to leave a file
//! inputs    files and folders → a list of files
//! header    one file's header, with its VLRs (vlr, crs, wkt, extra_bytes), read tolerantly
//! chunks    where a LAZ file's chunks are; copc: which of them are an octree's coarser levels
//! plan      which files, which grid (grid), which record numbers, which fields
//! order     in which order their points are read
//! stream    threads, and how their results get into that order
//! work      what a thread does: LAS records, LAZ chunks (laz, kept) → columns (record, attributes)
//! report    what came of it, per file and per thread
//! ```

use std::{
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread::JoinHandle,
    time::Duration,
};

use crossbeam_channel::{Receiver, Sender, bounded};

use crate::scene::{PointBatch, SceneFacts};

mod attributes;
mod bytes;
pub(crate) mod chunks;
mod control;
mod copc;
pub(crate) mod crs;
mod error;
mod extra_bytes;
mod fields;
mod grid;
pub(crate) mod header;
mod inputs;
mod kept;
mod layout;
mod laz;
mod order;
mod plan;
mod record;
mod report;
mod stream;
pub(crate) mod vlr;
mod wkt;
mod work;

pub(crate) use bytes::text;
pub use error::SourceError;
pub use fields::Fields;
pub use inputs::list as list_files;
pub use laz::DecoderChoice;
pub use order::Order;
pub use report::{FileReport, SourceReport, ThreadTimes};

/// How to read.
#[derive(Clone, Default)]
pub struct OpenOptions {
    /// Decoder threads; by default one per core, less one where there are more than two.
    pub threads: Option<usize>,
    pub order: Order,
    pub decoder: DecoderChoice,
    /// A small read that takes longer has waited for a disk that seeks (by default 2 ms): the rest of a LAS
    /// file's preview is then left for the end, and the order of the points depends on the disk.
    pub slow_read: Option<Duration>,
    /// Fields to read besides the position. `None`: what the automatic colours ([`ColorStats::rule`])
    /// depend on, file by file, and no more.
    ///
    /// [`ColorStats::rule`]: crate::scene::ColorStats::rule
    pub fields: Option<Fields>,
    /// Called after each event was sent, to wake a window that sleeps. It must not block on whatever
    /// the thread that drops the [`Stream`] holds.
    pub wake: Option<Arc<dyn Fn() + Send + Sync>>,
}

/// What arrives through [`Stream::events`].
pub enum Event {
    /// All headers are read: the grid, the bounds and the files are known.
    Opened(Arc<SceneFacts>),
    Batch(PointBatch),
    /// All files are read, as far as they could be.
    Finished(SourceReport),
    /// No input could be opened.
    Failed(SourceError),
}

/// A running reader. Dropping it stops all threads promptly and waits for them.
pub struct Stream {
    events: Receiver<Event>,
    free: Sender<PointBatch>,
    cancel: Arc<AtomicBool>,
    control: Arc<control::Control>,
    thread: Option<JoinHandle<()>>,
}

impl Stream {
    /// The events, in order. After [`Event::Finished`] or [`Event::Failed`] the channel is closed.
    pub fn events(&self) -> &Receiver<Event> {
        &self.events
    }

    /// Gives a batch's memory back to the decoders. Not needed for progress, only for speed.
    pub fn recycle(&self, batch: PointBatch) {
        // With enough spare buffers already, this one's memory goes back to the system.
        let _ = self.free.try_send(batch);
    }

    /// Stops reading one file, by its number in [`SceneFacts::files`]; the others go on. Its points that are read
    /// already still arrive, a few batches at most, and its report says that the rest is missing.
    pub fn cancel_file(&self, file: usize) {
        self.control.cancel(file);
    }

    /// What each decoder thread did until now, up to its latest batch.
    pub fn thread_times(&self) -> Vec<ThreadTimes> {
        self.control.thread_times()
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A panic there has been printed where it happened.
            let _ = thread.join();
        }
    }
}

/// Starts to read files and folders.
///
/// ```no_run
/// use firstlight::source::{Event, OpenOptions, open};
///
/// let stream = open(&["scan.laz".into()], OpenOptions::default());
/// for event in stream.events() {
///     match event {
///         Event::Opened(facts) => println!("{} points to come", facts.points_in_header()),
///         Event::Batch(batch) => stream.recycle(batch),
///         Event::Finished(report) => println!("{} points read", report.points_decoded()),
///         Event::Failed(error) => eprintln!("{error}"),
///     }
/// }
/// ```
pub fn open(inputs: &[PathBuf], options: OpenOptions) -> Stream {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = options.threads.unwrap_or(if cores > 2 { cores - 1 } else { cores }).max(1);
    let (events_ahead, spare) = stream::capacities(threads);
    let (events_to, events) = bounded(events_ahead);
    let (free, free_from) = bounded(spare);
    let cancel = Arc::new(AtomicBool::new(false));
    let control = Arc::new(control::Control::default());
    let engine = stream::Engine {
        inputs: inputs.to_vec(),
        options,
        events: events_to.clone(),
        free: free_from,
        cancel: Arc::clone(&cancel),
        control: Arc::clone(&control),
    };
    let thread = std::thread::Builder::new().name("source".into()).spawn(move || engine.run(threads));
    if let Err(error) = &thread {
        let path = inputs.first().cloned().unwrap_or_default();
        let failed = SourceError::Io { path, doing: "start a thread", reason: error.to_string() };
        // The channel is empty, so there is room.
        let _ = events_to.try_send(Event::Failed(failed));
    }
    Stream { events, free, cancel, control, thread: thread.ok() }
}
