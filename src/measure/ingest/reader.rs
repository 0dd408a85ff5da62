//! One run of the reader: everything decoded, nothing drawn.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use clap::{ValueEnum, builder::PossibleValue};
use serde::Serialize;

use crate::{
    measure::machine::processor_secs,
    scene::{PointBatch, SceneFacts},
    source::{self, DecoderChoice, Event, Fields, OpenOptions, Order, SourceError, SourceReport, ThreadTimes},
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
    /// What the automatic colours need, file by file: what the program does
    Auto,
    /// Nothing
    Xyz,
    /// Red, green, blue and intensity
    Colors,
    /// All that the file has
    All,
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
        let fields = match self.fields {
            FieldSet::Auto => None,
            FieldSet::Xyz => Some(Fields::NONE),
            FieldSet::Colors => Some(Fields::COLORS),
            FieldSet::All => Some(Fields::ALL),
        };
        OpenOptions { threads: self.threads, order, decoder, fields, ..Default::default() }
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
            format!("{order} order, {decoder} decoder, {fields} fields")
        } else {
            format!("{order} order, {fields} fields")
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
    /// Processor time of all threads, in hundredths; null where the system does not tell.
    pub processor_secs: Option<f64>,
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

/// Processor time below this is too coarse in hundredths.
const LEAST_PROCESSOR_SECS: f64 = 0.2;

impl ReaderSample {
    /// Processor time, where hundredths of a second tell enough.
    pub fn counted_secs(&self) -> Option<f64> {
        self.processor_secs.filter(|&secs| secs >= LEAST_PROCESSOR_SECS)
    }
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
    let processor = processor_secs();
    let start = Instant::now();
    let stream = source::open(&inputs, way.options());
    let mut sample = ReaderSample {
        secs: 0.0,
        secs_to_opened: 0.0,
        secs_to_first_batch: None,
        processor_secs: None,
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
                sample.batch_bytes += batch.bytes();
                look(facts, &batch, secs);
                stream.recycle(batch);
            }
            (Ok(Event::Finished(report)), Some(_)) => {
                sample.secs = secs;
                sample.processor_secs = processor.zip(processor_secs()).map(|(before, after)| after - before);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_columns_of_a_batch_are_counted() {
        let mut batch = PointBatch { positions: vec![[0; 3]; 2], colors: vec![[0; 4]; 2], ..Default::default() };
        batch.records = vec![0; 2];
        assert_eq!(batch.bytes(), 2 * (12 + 8 + 4));
        batch.attributes.gps_time = vec![0.0; 2];
        batch.attributes.extra = vec![0; 6];
        assert_eq!(batch.bytes(), 2 * (12 + 8 + 4 + 8 + 3));
    }

    #[test]
    fn field_sets_are_what_they_are_called() {
        let way = |fields| Way { threads: None, order: ReadOrder::File, decoder: LazDecoder::Laz, fields };
        assert_eq!(way(FieldSet::Auto).options().fields, None);
        assert_eq!(way(FieldSet::Xyz).options().fields, Some(Fields::NONE));
        assert_eq!(way(FieldSet::All).name(true), "file order, laz decoder, all fields");
        assert_eq!(way(FieldSet::All).name(false), "file order, all fields");
    }
}
