//! A single record, read back from its file by its number: nothing that the file says of it is lost on the way.

use std::{
    fs::File,
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use super::{
    DecoderChoice, SourceError,
    bytes::read_vec_at,
    chunks::{Chunk, LazLayout},
    fields::Fields,
    header::{Header, open_regular},
    laz::{self, End, Share},
    plan::{self, FilePlan, Layout},
    work::PIECE_BYTES,
};
use crate::scene::{ExtraDimension, SceneFacts};

/// Why a record cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecordError {
    #[error(transparent)]
    File(#[from] SourceError),
    #[error("{}: there is no record {record}: {}", path.display(), range(*points))]
    OutOfRange { path: PathBuf, record: u64, points: u64 },
    /// The file is damaged before or at the record, or has become shorter.
    #[error("{}: record {record} cannot be read: {what}", path.display())]
    Damaged { path: PathBuf, record: u64, what: String },
    #[error("{}: cancelled before record {record} was read", path.display())]
    Cancelled { path: PathBuf, record: u64 },
}

fn range(points: u64) -> String {
    match points {
        0 => "the file has none".into(),
        points => format!("expected 0 to {}", points - 1),
    }
}

/// A file whose records can be read one at a time, in any order. Opening it reads the header and the table of chunks;
/// whoever reads many records keeps it.
pub struct RecordFile {
    plan: FilePlan,
    file: Arc<File>,
}

impl RecordFile {
    /// # Errors
    /// As when the file is opened to be shown.
    pub fn open(path: &Path, cancel: &AtomicBool) -> Result<RecordFile, SourceError> {
        let mut plan = plan::open_file(path, Some(Fields::ALL), 0, cancel)?;
        let file = match plan.file.take() {
            Some(file) => file,
            None => Arc::new(open_regular(path)?.0),
        };
        Ok(RecordFile { plan, file })
    }

    pub fn path(&self) -> &Path {
        &self.plan.header.path
    }

    /// Records that can be asked for: those that a scene shows.
    pub fn points(&self) -> u64 {
        self.plan.points
    }

    pub(crate) fn header(&self) -> &Header {
        &self.plan.header
    }

    pub(crate) fn extra_dimensions(&self) -> &[ExtraDimension] {
        &self.plan.extra_dimensions
    }

    /// What is read of a record: all of it, but for more extra bytes than anybody has.
    pub fn fields(&self) -> Fields {
        self.plan.reader.fields
    }

    /// The bytes of record `record`, counted from 0, as they come out of the decoder. Of LAS, one read; of LAZ, the
    /// record's chunk up to it is decoded (50,000 points: 5 to 15 ms); of a LAZ file that is one stream, everything
    /// before it, until `cancel` says to stop.
    ///
    /// # Errors
    /// In one line, if there is no such record, or the file is damaged.
    pub fn read(&self, record: u64, cancel: &AtomicBool) -> Result<Vec<u8>, RecordError> {
        let path = || self.path().to_owned();
        if record >= self.plan.points {
            return Err(RecordError::OutOfRange { path: path(), record, points: self.plan.points });
        }
        let read = match &self.plan.layout {
            Layout::Las => self.read_raw(record),
            Layout::Laz(layout) => self.decode_on_thread(layout, record, cancel),
        };
        match read {
            Ok(Some(bytes)) => Ok(bytes),
            Ok(None) => Err(RecordError::Cancelled { path: path(), record }),
            Err(what) => Err(RecordError::Damaged { path: path(), record, what }),
        }
    }

    fn read_raw(&self, record: u64) -> Result<Option<Vec<u8>>, String> {
        let length = self.plan.header.record_length();
        let at = self.plan.header.data_at() + record * length as u64;
        let bytes = read_vec_at(&self.file, at, length).map_err(|e| format!("cannot read at byte {at}: {e}"))?;
        if bytes.len() < length {
            return Err(format!("the file now ends at byte {}", at + bytes.len() as u64));
        }
        Ok(Some(bytes))
    }

    /// On a decoder's thread, where a panic of the laz crate is silent and becomes a message.
    fn decode_on_thread(
        &self,
        layout: &LazLayout,
        record: u64,
        cancel: &AtomicBool,
    ) -> Result<Option<Vec<u8>>, String> {
        laz::silence_decoder_panics();
        std::thread::scope(|scope| {
            let thread = std::thread::Builder::new().name(format!("{}record", laz::DECODER_THREAD));
            let decoding = thread.spawn_scoped(scope, || laz::catch(|| self.decode(layout, record, cancel)));
            let decoding = decoding.map_err(|e| format!("cannot start a thread: {e}"))?;
            decoding
                .join()
                .unwrap_or_else(|_| Err(String::new()))
                .unwrap_or_else(|panic| Err(format!("the decoder stopped: {panic}")))
        })
    }

    fn decode(&self, layout: &LazLayout, record: u64, cancel: &AtomicBool) -> Result<Option<Vec<u8>>, String> {
        let number = layout.chunks.partition_point(|chunk| chunk.first_point + chunk.points <= record);
        let chunk = layout.chunks.get(number).ok_or("no chunk holds it")?;
        self.decode_in(layout, chunk, record - chunk.first_point, cancel)
            .map_err(|what| format!("chunk {number} (bytes {} to {}): {what}", chunk.at, chunk.at + chunk.bytes))
    }

    /// Point `wanted` of a chunk.
    fn decode_in(
        &self,
        layout: &LazLayout,
        chunk: &Chunk,
        wanted: u64,
        cancel: &AtomicBool,
    ) -> Result<Option<Vec<u8>>, String> {
        let length = self.plan.header.record_length();
        let mut decoder = laz::decoder(&self.file, layout, length, chunk, self.fields(), DecoderChoice::Own)?;
        decoder.load(Share::All, &mut Vec::new())?;
        let per_piece = (PIECE_BYTES / length).max(1) as u64;
        let mut records = vec![0; per_piece.min(wanted + 1) as usize * length];
        let mut next = 0;
        while !cancel.load(Ordering::Relaxed) {
            let count = per_piece.min(wanted + 1 - next);
            let piece = &mut records[..count as usize * length];
            let decoded = decoder.decode(piece);
            let whole = &piece[..decoded.records * length];
            let sane = if self.plan.ends_unknown() { self.plan.reader.inside_bounds(whole) } else { decoded.records };
            if sane < decoded.records {
                return Err(format!("nothing says where chunks end: no sense after {} points", next + sane as u64));
            }
            next += decoded.records as u64;
            match decoded.end {
                _ if next > wanted => return Ok(Some(whole[whole.len() - length..].to_vec())),
                End::Filled => {}
                End::NeedsBytes => return Err(format!("its compressed bytes end early, after {next} points")),
                End::Fault(what) => return Err(format!("{what}, after {next} of {} points", chunk.points)),
            }
        }
        Ok(None)
    }
}

/// Which file of a scene a record number is of, and its number there.
pub fn file_of_record(scene: &SceneFacts, record: u32) -> Option<(usize, u64)> {
    // Files without points share the first record of the one behind them, which comes last.
    let file = scene.files.partition_point(|file| file.first_record <= record).checked_sub(1)?;
    let index = u64::from(record - scene.files[file].first_record);
    (index < scene.files[file].points_in_header).then_some((file, index))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Bounds, FileFacts, Grid};

    #[test]
    fn records_are_of_the_file_that_holds_them() {
        let files = [0u64, 3, 0, 2, 0].iter().scan(0u64, |first, &points| {
            let file = FileFacts { first_record: *first as u32, points_in_header: points, ..Default::default() };
            *first += points;
            Some(file)
        });
        let grid = Grid { scale: [1.0; 3], origin: [0.0; 3] };
        let mut scene = SceneFacts { grid, bounds: Bounds::default(), files: files.collect(), warnings: vec![] };
        let found: Vec<_> = (0..6).map(|record| file_of_record(&scene, record)).collect();
        assert_eq!(found, [Some((1, 0)), Some((1, 1)), Some((1, 2)), Some((3, 0)), Some((3, 1)), None]);
        scene.files.clear();
        assert_eq!(file_of_record(&scene, 0), None);
    }
}
