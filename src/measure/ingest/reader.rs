//! One run of the reader: everything decoded, nothing drawn.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

use clap::ValueEnum;
use serde::Serialize;

use crate::{
    scene::{PointBatch, SceneFacts},
    source::{self, Event, OpenOptions, SourceError, SourceReport},
};

/// In which order a file's tasks are decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum ReadOrder {
    /// As the records lie in the file
    File,
}

/// Who decodes LAZ chunks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum LazDecoder {
    /// The laz crate
    Laz,
}

/// Which fields are decoded besides the position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum FieldSet {
    /// Red, green, blue and intensity, for the automatic colours
    Colors,
}

/// One way to read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Way {
    /// Decoder threads.
    pub threads: usize,
    pub order: ReadOrder,
    /// Says nothing of files that are not compressed.
    pub decoder: LazDecoder,
    pub fields: FieldSet,
}

impl Way {
    /// The reader's own words for it.
    pub fn options(&self) -> OpenOptions {
        let (ReadOrder::File, LazDecoder::Laz, FieldSet::Colors) = (self.order, self.decoder, self.fields);
        OpenOptions { threads: Some(self.threads), wake: None }
    }

    /// A short name, without the number of threads.
    pub fn name(&self, compressed: bool) -> String {
        let word = |value: Option<clap::builder::PossibleValue>| value.map_or_else(String::new, |v| v.get_name().into());
        let mut words = vec![format!("{} order", word(self.order.to_possible_value()))];
        if compressed {
            words.push(format!("{} decoder", word(self.decoder.to_possible_value())));
        }
        words.push(word(self.fields.to_possible_value()));
        words.join(", ")
    }
}

/// What one thread of the reader did, seconds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ThreadTimes {
    pub name: String,
    pub read_secs: f64,
    pub decode_secs: f64,
    pub convert_secs: f64,
    /// Blocked on its channel.
    pub wait_secs: f64,
    pub points: u64,
    pub bytes: u64,
}

/// The reader's threads, where it tells.
fn thread_times(_report: &SourceReport) -> Vec<ThreadTimes> {
    Vec::new()
}

/// One run. Seconds count from the call that opens the file.
#[derive(Debug, Clone, Serialize)]
pub struct ReaderSample {
    /// Until all points have arrived.
    pub secs: f64,
    pub secs_to_opened: f64,
    /// Until the first batch came out of the channel; null without points.
    pub secs_to_first_batch: Option<f64>,
    pub points: u64,
    pub batches: u64,
    /// What all batches hold.
    pub batch_bytes: u64,
    /// That the receiver waited for batches: near `secs` where decoding is what takes the time.
    pub receiver_wait_secs: f64,
    pub threads: Vec<ThreadTimes>,
}

/// What a run of the reader gave.
pub struct Reading {
    pub sample: ReaderSample,
    pub facts: Arc<SceneFacts>,
    pub report: SourceReport,
}

/// Reads a file to its end and hands every batch, with the second it arrived in, to `look`.
///
/// # Errors
/// If the file cannot be opened.
pub fn read(
    path: &Path,
    way: &Way,
    mut look: impl FnMut(&SceneFacts, &PointBatch, f64),
) -> Result<Reading, SourceError> {
    let inputs: [PathBuf; 1] = [path.into()];
    let start = Instant::now();
    let stream = source::open(&inputs, way.options());
    let mut sample = ReaderSample {
        secs: 0.0,
        secs_to_opened: 0.0,
        secs_to_first_batch: None,
        points: 0,
        batches: 0,
        batch_bytes: 0,
        receiver_wait_secs: 0.0,
        threads: Vec::new(),
    };
    let mut scene = None;
    loop {
        let asked = Instant::now();
        let event = stream.events().recv();
        let secs = start.elapsed().as_secs_f64();
        sample.receiver_wait_secs += asked.elapsed().as_secs_f64();
        match (event, &scene) {
            (Ok(Event::Opened(facts)), _) => {
                sample.secs_to_opened = secs;
                scene = Some(facts);
            }
            (Ok(Event::Batch(batch)), Some(facts)) => {
                sample.secs_to_first_batch.get_or_insert(secs);
                sample.points += batch.len() as u64;
                sample.batches += 1;
                sample.batch_bytes += bytes_of(&batch);
                look(facts, &batch, secs);
                stream.recycle(batch);
            }
            (Ok(Event::Finished(report)), Some(_)) => {
                sample.secs = secs;
                sample.threads = thread_times(&report);
                let Some(facts) = scene else { unreachable!("matched above") };
                return Ok(Reading { sample, facts, report });
            }
            (Ok(Event::Failed(error)), _) => return Err(error),
            (Ok(Event::Batch(_) | Event::Finished(_)) | Err(_), _) => {
                let reason = "the reader ended without saying why".into();
                return Err(SourceError::Io { path: path.into(), doing: "read it", reason });
            }
        }
    }
}

/// Bytes in a batch's columns.
pub fn bytes_of(batch: &PointBatch) -> u64 {
    (size_of_val(&batch.positions[..]) + size_of_val(&batch.colors[..]) + size_of_val(&batch.records[..])) as u64
}
