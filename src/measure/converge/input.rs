//! The scan, read once: what a virtual clock and every comparison begin from.

use std::{path::PathBuf, sync::Arc, time::Duration};

use super::{ConvergeError, settings::Decoded};
use crate::{
    info::Info,
    measure::{
        feed::{Fed, Feed},
        raster::Input,
    },
    render::Progressive,
    scene::{PointBatch, SceneFacts},
    source::{self, Event, OpenOptions, Order, SourceError},
};

/// All batches in the order in which they arrive: 24 bytes per point.
pub struct Recording {
    pub facts: Arc<SceneFacts>,
    pub batches: Vec<PointBatch>,
    pub points: u64,
    /// Length of the file's unit in metres; `None` if the file does not say, or is in degrees.
    pub metres: Option<f64>,
    /// One line each: what could not be read.
    pub problems: Vec<String>,
}

/// How files are opened: the order of the points never depends on the disk.
pub fn options(order: Order, decoded: Decoded, threads: Option<usize>) -> OpenOptions {
    OpenOptions { order, fields: decoded.fields(), threads, slow_read: Some(Duration::MAX), ..Default::default() }
}

impl Recording {
    /// Reads everything.
    ///
    /// # Errors
    /// If nothing can be read, or a synthetic scene cannot be made.
    pub fn new(
        input: &Input,
        order: Order,
        decoded: Decoded,
        threads: Option<usize>,
    ) -> Result<Recording, ConvergeError> {
        let recording = match input {
            Input::Files(files) => Recording::of_files(files, options(order, decoded, threads))?,
            Input::Synth(options) => {
                let mut feed = Feed::synth(options, threads)?;
                let (mut facts, mut batches) = (None, Vec::new());
                loop {
                    match feed.next(true)? {
                        Fed::Opened(opened) => facts = Some(opened),
                        Fed::Batch(batch) => batches.push(batch),
                        Fed::Ended | Fed::Nothing => break,
                    }
                }
                if order == Order::File {
                    batches.sort_by_key(|batch| batch.records.first().copied());
                }
                // Made in metres.
                Recording::from_parts(facts.ok_or(ConvergeError::NoPoints)?, batches, Some(1.0), Vec::new())
            }
        };
        if recording.points == 0 { Err(ConvergeError::NoPoints) } else { Ok(recording) }
    }

    fn of_files(files: &[PathBuf], options: OpenOptions) -> Result<Recording, ConvergeError> {
        let stream = source::open(files, options);
        let (mut facts, mut batches): (Option<Arc<SceneFacts>>, Vec<PointBatch>) = (None, Vec::new());
        let mut problems = Vec::new();
        loop {
            match stream.events().recv() {
                Ok(Event::Opened(opened)) => facts = Some(opened),
                Ok(Event::Batch(batch)) => batches.push(batch),
                Ok(Event::Failed(error)) => return Err(error.into()),
                Ok(Event::Finished(report)) => {
                    problems.extend(report.files.into_iter().filter_map(|file| file.error));
                    break;
                }
                Err(_) => {
                    let path = files.first().cloned().unwrap_or_default();
                    let reason = "the reader ended without saying why".into();
                    return Err(SourceError::Io { path, doing: "read it", reason }.into());
                }
            }
        }
        let facts = facts.ok_or(ConvergeError::NoPoints)?;
        let first = facts.files.first().and_then(|file| Info::read(&file.path).ok());
        let metres = first.and_then(|info| info.crs.metres_per_unit());
        Ok(Recording::from_parts(facts, batches, metres, problems))
    }

    fn from_parts(
        facts: Arc<SceneFacts>,
        batches: Vec<PointBatch>,
        metres: Option<f64>,
        problems: Vec<String>,
    ) -> Recording {
        let points = batches.iter().map(|batch| batch.len() as u64).sum();
        Recording { facts, batches, points, metres, problems }
    }
}

/// Hands a recording's points out, as many at a time as are asked for.
pub struct Feeder<'a> {
    recording: &'a Recording,
    /// The next point: of this batch, at this place.
    batch: usize,
    taken: usize,
    offered: u64,
}

impl<'a> Feeder<'a> {
    pub fn new(recording: &'a Recording) -> Feeder<'a> {
        Feeder { recording, batch: 0, taken: 0, offered: 0 }
    }

    /// Points handed out so far.
    pub fn offered(&self) -> u64 {
        self.offered
    }

    /// The next points, at most `most` and of one batch; `None` at the end.
    pub fn next(&mut self, most: u64) -> Option<PointBatch> {
        let batch = self.recording.batches.get(self.batch)?;
        let end = batch.len().min(self.taken.saturating_add(usize::try_from(most).unwrap_or(usize::MAX)));
        let range = self.taken..end;
        let piece = PointBatch {
            file: batch.file,
            positions: batch.positions[range.clone()].to_vec(),
            colors: batch.colors[range.clone()].to_vec(),
            records: batch.records[range.clone()].to_vec(),
            attributes: Default::default(),
            // Those of the whole batch come with its first point, as in a viewer.
            stats: if self.taken == 0 { batch.stats.clone() } else { Default::default() },
        };
        self.offered += range.len() as u64;
        self.taken = end;
        if end == batch.len() {
            (self.batch, self.taken) = (self.batch + 1, 0);
        }
        Some(piece)
    }

    /// Offers points until `total` were, and says so if these are all.
    pub fn offer_up_to<B: crate::render::Backend>(&mut self, total: u64, progressive: &mut Progressive<B>) {
        while self.offered < total
            && let Some(piece) = self.next(total - self.offered)
        {
            progressive.offer(piece);
        }
        if self.offered == self.recording.points {
            progressive.end_of_input();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::{Scene, SynthOptions};

    #[test]
    fn pieces_are_the_whole() {
        let input = Input::Synth(SynthOptions { points: 200_000, ..SynthOptions::new(Scene::Town) });
        let by_file = Recording::new(&input, Order::File, Decoded::Colors, Some(2)).unwrap();
        let records = by_file.batches.iter().flat_map(|batch| batch.records.iter().copied());
        assert!(records.eq(0..200_000), "in the order of the file");
        let other = Recording::new(&input, Order::PreviewFirst, Decoded::Colors, Some(1)).unwrap();
        let whole: Vec<u32> = other.batches.iter().flat_map(|batch| batch.records.clone()).collect();
        for piece in [70_000, 65_536, 999] {
            let mut feeder = Feeder::new(&other);
            let mut records = Vec::new();
            while let Some(batch) = feeder.next(piece) {
                assert!(batch.positions.len() == batch.records.len() && batch.len() as u64 <= piece);
                records.extend(batch.records);
            }
            assert_eq!((records.len() as u64, feeder.offered()), (200_000, 200_000));
            assert!(records == whole);
        }
    }
}
