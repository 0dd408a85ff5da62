//! Reading: from paths to point batches.
//!
//! [`open`] returns at once; a thread of its own lists the inputs, reads the headers, and starts the
//! decoder threads. Everything arrives through one bounded channel, in an order that depends on the
//! files alone and not on thread timing: [`Event::Opened`], then batches in record order, file after
//! file, then [`Event::Finished`]; or [`Event::Failed`] if nothing could be opened.

use std::{path::PathBuf, sync::Arc};

use crossbeam_channel::Receiver;

use crate::scene::{PointBatch, SceneFacts};

/// How to read.
#[derive(Clone, Default)]
pub struct OpenOptions {
    /// Decoder threads; by default one per core, less one where there are more than two.
    pub threads: Option<usize>,
    /// Called after each event was sent, to wake a window that sleeps.
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
}

impl Stream {
    pub fn events(&self) -> &Receiver<Event> {
        &self.events
    }

    /// Gives a batch's memory back to the decoders.
    pub fn recycle(&self, _batch: PointBatch) {}
}

/// Starts to read files and folders.
pub fn open(_inputs: &[PathBuf], _options: OpenOptions) -> Stream {
    let (_, events) = crossbeam_channel::bounded(1);
    Stream { events }
}

/// What was read, complete or not.
#[derive(Debug, Clone, Default, serde::Serialize)]
pub struct SourceReport {
    pub files: Vec<FileReport>,
}

/// What was read of one file.
#[derive(Debug, Clone, serde::Serialize)]
pub struct FileReport {
    pub path: PathBuf,
    pub points_in_header: u64,
    pub points_decoded: u64,
    /// Decoded points outside of the header's box.
    pub points_outside_bounds: u64,
    /// One line each: oddities that cost nothing.
    pub warnings: Vec<String>,
    /// Why points are missing, if any are.
    pub error: Option<String>,
}

/// Why an input could not be opened.
#[derive(Debug, Clone, thiserror::Error)]
pub enum SourceError {
    #[error("{0}")]
    Placeholder(String),
}
