//! One run of the reader: everything decoded, nothing drawn.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use clap::{ValueEnum, builder::PossibleValue};
use serde::Serialize;

use crate::{
    scene::{PointBatch, SceneFacts},
    source::{self, DecoderChoice, Event, OpenOptions, Order, SourceError, SourceReport, ThreadTimes},
};

/// In which order a file's points are decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum ReadOrder {
    /// A few points from everywhere, then the rest, evenly spread: what the program does
    Preview,
    /// From front to back
    File,
}

/// Who decodes LAZ chunks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum LazDecoder {
    /// The program's own decoders, where they can
    Own,
    /// The laz crate's
    Laz,
}

/// Which fields are decoded besides the position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum FieldSet {
    /// Red, green, blue and intensity: what the automatic colours look at
    Colors,
}

/// One way to read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Way {
    /// Decoder threads; null for the reader's own choice.
    pub threads: Option<usize>,
    pub order: ReadOrder,
    /// Says nothing of files that are not compressed.
    pub decoder: LazDecoder,
    pub fields: FieldSet,
}

impl Way {
    /// The reader's own words for it.
    pub fn options(&self) -> OpenOptions {
        let order = match self.order {
            ReadOrder::Preview => Order::PreviewFirst,
            ReadOrder::File => Order::File,
        };
        let decoder = match self.decoder {
            LazDecoder::Own => DecoderChoice::Own,
            LazDecoder::Laz => DecoderChoice::LazCrate,
        };
        let FieldSet::Colors = self.fields;
        OpenOptions { threads: self.threads, order, decoder, ..Default::default() }
    }

    /// Order, decoder and fields as the command line calls them.
    pub fn words(&self) -> [String; 3] {
        let word = |value: Option<PossibleValue>| value.map_or_else(String::new, |v| v.get_name().into());
        [self.order.to_possible_value(), self.decoder.to_possible_value(), self.fields.to_possible_value()].map(word)
    }

    /// A short name, without the number of threads.
    pub fn name(&self, compressed: bool) -> String {
        let [order, decoder, fields] = self.words();
        if compressed {
            format!("{order} order, {decoder} decoder, {fields}")
        } else {
            format!("{order} order, {fields}")
        }
    }
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
    /// Most heap memory that the reader could take, by its own account.
    pub memory_bound_bytes: u64,
    pub threads: Vec<ThreadTimes>,
}

/// What a run of the reader gave.
pub struct Reading {
    pub sample: ReaderSample,
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
        memory_bound_bytes: 0,
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
                sample.memory_bound_bytes = report.memory_bound_bytes;
                sample.threads.clone_from(&report.threads);
                return Ok(Reading { sample, report });
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
