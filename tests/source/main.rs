//! The source room against real files, an independent reader's checksums, and files broken on purpose.

#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a test fails where it stands, and says that it is skipped"
)]

use std::{
    io::Write,
    path::{Path, PathBuf},
    sync::Arc,
};

use firstlight::{
    scene::{BATCH_POINTS, PointBatch, SceneFacts},
    source::{Event, Fields, OpenOptions, SourceError, SourceReport, Stream, open},
};

mod attributes;
mod broken;
mod checksums;
mod described;
mod made;
mod real;
mod records;
mod streams;

/// The folder of real files, if there is one.
fn data() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let found = std::env::var_os("FIRSTLIGHT_DATA").map_or(beside, PathBuf::from);
    if found.is_dir() {
        return Some(found);
    }
    // Straight to the terminal: what a passing test prints with `eprintln!` is swallowed.
    let _ =
        writeln!(std::io::stderr(), "SKIPPED: no real scans: {} is not there (set FIRSTLIGHT_DATA)", found.display());
    None
}

/// Everything that a stream gave.
struct Read {
    facts: Arc<SceneFacts>,
    batches: Vec<PointBatch>,
    report: SourceReport,
}

impl Read {
    fn points(&self) -> usize {
        self.batches.iter().map(PointBatch::len).sum()
    }

    /// Record number, position and colour of all points, by record number.
    fn in_record_order(&self) -> Vec<(u32, [i32; 3], [u16; 4])> {
        let points = self.batches.iter().flat_map(|b| {
            let columns = b.records.iter().zip(&b.positions).zip(&b.colors);
            columns.map(|((&record, &position), &color)| (record, position, color))
        });
        let mut points: Vec<_> = points.collect();
        points.sort_unstable_by_key(|p| p.0);
        points
    }

    fn positions_in_order(&self) -> Vec<[i32; 3]> {
        self.in_record_order().into_iter().map(|p| p.1).collect()
    }

    fn error(&self) -> &str {
        self.report.files[0].error.as_deref().unwrap_or("")
    }
}

/// All fields.
fn options(threads: usize) -> OpenOptions {
    OpenOptions { threads: Some(threads), fields: Some(Fields::ALL), ..Default::default() }
}

fn start(inputs: &[PathBuf], threads: usize) -> Stream {
    open(inputs, options(threads))
}

/// Reads all of the inputs, with all fields, and checks what must hold of any stream.
fn read(inputs: &[PathBuf], threads: usize) -> Result<Read, SourceError> {
    read_with(inputs, options(threads))
}

fn read_with(inputs: &[PathBuf], options: OpenOptions) -> Result<Read, SourceError> {
    let stream = open(inputs, options);
    let mut facts = None;
    let mut report = None;
    let mut batches: Vec<PointBatch> = Vec::new();
    for event in stream.events() {
        match event {
            Event::Opened(opened) => {
                assert!(facts.is_none() && batches.is_empty());
                facts = Some(opened);
            }
            Event::Batch(batch) => {
                assert!(facts.is_some() && report.is_none());
                batches.push(batch);
            }
            Event::Finished(finished) => report = Some(finished),
            Event::Failed(error) => return Err(error),
        }
    }
    let (facts, report) = (facts.expect("Opened"), report.expect("Finished"));
    for batch in &batches {
        assert!(!batch.is_empty() && batch.len() <= BATCH_POINTS);
        assert_eq!((batch.colors.len(), batch.records.len()), (batch.len(), batch.len()));
    }
    let read = Read { facts, batches, report };
    let sorted = read.in_record_order();
    assert!(sorted.is_sorted_by(|a, b| a.0 < b.0), "a record came twice");
    assert_eq!(read.points() as u64, read.report.points_decoded());
    Ok(read)
}
