//! The source room against real files, an independent reader's checksums, and files broken on purpose.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use firstlight::{
    scene::{BATCH_POINTS, PointBatch, SceneFacts},
    source::{Event, OpenOptions, SourceError, SourceReport, Stream, open},
};

/// The folder of real files, if there is one.
fn data() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let found = std::env::var_os("FIRSTLIGHT_DATA").map_or(beside, PathBuf::from);
    if found.is_dir() {
        return Some(found);
    }
    eprintln!("SKIPPED: no real scans: {} is not there (set FIRSTLIGHT_DATA)", found.display());
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

    fn error(&self) -> &str {
        self.report.files[0].error.as_deref().unwrap_or("")
    }
}

fn start(inputs: &[PathBuf], threads: usize) -> Stream {
    open(inputs, OpenOptions { threads: Some(threads), wake: None })
}

/// Reads all of the inputs and checks what must hold of any stream.
fn read(inputs: &[PathBuf], threads: usize) -> Result<Read, SourceError> {
    let stream = start(inputs, threads);
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
    let mut next = 0;
    for batch in &batches {
        assert!(!batch.is_empty() && batch.len() <= BATCH_POINTS);
        assert_eq!((batch.colors.len(), batch.records.len()), (batch.len(), batch.len()));
        for &record in &batch.records {
            assert!(record >= next, "record {record} after {next}");
            next = record + 1;
        }
    }
    let read = Read { facts, batches, report };
    assert_eq!(read.points() as u64, read.report.points_decoded());
    Ok(read)
}

/// The reference's hash: see tests/reference/laspy_checksums.py.
fn checksum(batches: &[PointBatch]) -> u64 {
    let mut sum = 0u64;
    let mut weight = 1u64;
    for batch in batches {
        for (position, color) in batch.positions.iter().zip(&batch.colors) {
            let bytes = position.iter().flat_map(|p| p.to_le_bytes()).chain(color.iter().flat_map(|c| c.to_le_bytes()));
            let hash = bytes.fold(0xcbf2_9ce4_8422_2325, |h: u64, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
            sum = sum.wrapping_add(hash.wrapping_mul(weight));
            weight = weight.wrapping_add(2);
        }
    }
    sum
}

/// Lines of the reference: file, points, hash.
fn reference() -> Vec<(&'static str, usize, u64)> {
    let lines = include_str!("reference/checksums.tsv").lines().filter(|l| !l.starts_with('#'));
    lines
        .map(|line| {
            let mut fields = line.split('\t');
            let mut field = || fields.next().expect("three columns");
            (field(), field().parse().unwrap(), u64::from_str_radix(field(), 16).unwrap())
        })
        .collect()
}

#[test]
fn every_point_is_what_an_independent_reader_says() {
    let Some(data) = data() else { return };
    let mut faults = Vec::new();
    for (name, points, hash) in reference() {
        let read = match read(&[data.join(name)], 2) {
            Ok(read) => read,
            Err(error) => {
                faults.push(format!("{error}"));
                continue;
            }
        };
        if (read.points(), checksum(&read.batches)) != (points, hash) || !read.error().is_empty() {
            faults.push(format!("{name}: {} of {points} points, {}", read.points(), read.error()));
        }
        let file = &read.report.files[0];
        for warning in &file.warnings {
            println!("{name}: {warning}");
        }
    }
    assert!(faults.is_empty(), "{} files differ:\n{}", faults.len(), faults.join("\n"));
    assert!(reference().len() > 70);
}

#[test]
fn show_broken() {
    let Some(data) = data() else { return };
    let mut names: Vec<_> = fs::read_dir(data.join("broken")).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    for path in names {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        match read(&[path], 2) {
            Ok(read) => {
                println!("{name}: {} points, E {}, W {:#?}", read.points(), read.error(), read.report.files[0].warnings)
            }
            Err(e) => println!("{name}: FAILED {e}"),
        }
    }
}
