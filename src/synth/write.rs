//! A scan as a LAS or LAZ file: chunks of 50,000 points made and compressed on all cores, written in order.
//!
//! Everything goes to a temporary file next to the target (`NAME.PID.part`), whose header counts no
//! points until all are written; it is then renamed. A fault removes it; a killed run leaves it behind under that
//! name, never a half file under the target's. Memory holds one chunk per core.

use std::{
    fs::{self, File},
    io::{Cursor, Seek, SeekFrom, Write},
    ops::Range,
    path::{Path, PathBuf},
    thread,
};

use laz::{
    LasZipCompressor, LasZipError, LazItemRecordBuilder, LazVlr, LazVlrBuilder,
    laszip::{ChunkTable, ChunkTableEntry},
};

use super::{
    Generator, SynthError, SynthOptions,
    header::{file_head, survey_start},
    record::{Tally, push_record, record_length},
};

/// Points per LAZ chunk, as most LAZ files have it.
const CHUNK_POINTS: u64 = 50_000;

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SynthSummary {
    pub points: u64,
    pub bytes: u64,
    /// Points per return number, from 1.
    pub points_by_return: [u64; 15],
}

/// Writes a scan to `path`, whose extension (`.las` or `.laz`) decides about compression. `progress`
/// hears the number of points written so far.
///
/// # Errors
/// As [`Generator::new`]; [`SynthError::Extension`]; [`SynthError::Io`] and [`SynthError::Compress`]
/// while writing. The target is untouched then.
pub fn write(options: &SynthOptions, path: &Path, progress: &mut dyn FnMut(u64)) -> Result<SynthSummary, SynthError> {
    let extension = path.extension().map(|e| e.to_ascii_lowercase());
    let is_laz = match extension.as_ref().and_then(|e| e.to_str()) {
        Some("las") => false,
        Some("laz") => true,
        _ => return Err(SynthError::Extension { path: path.to_owned() }),
    };
    let generator = Generator::new(options)?;
    let vlr = if is_laz { Some(laz_vlr(options).map_err(|e| compress_error(path, 0)(e))?) } else { None };

    let mut part = PartFile::create(path)?;
    let tally = write_points(&generator, options, &mut part, vlr.as_ref(), progress)?;
    let bytes = part.finish(path, &file_head(options, &tally, vlr.as_ref()).map_err(io_error(path, "writing"))?)?;
    Ok(SynthSummary { points: tally.points, bytes, points_by_return: tally.by_return })
}

fn laz_vlr(options: &SynthOptions) -> Result<LazVlr, LasZipError> {
    let items = LazItemRecordBuilder::default_for_point_format_id(options.point_format, 0)?;
    Ok(LazVlrBuilder::new(items).with_fixed_chunk_size(CHUNK_POINTS as u32).build())
}

fn io_error(path: &Path, action: &'static str) -> impl FnOnce(std::io::Error) -> SynthError {
    move |source| SynthError::Io { path: path.to_owned(), action, source }
}

fn compress_error(path: &Path, chunk: u64) -> impl FnOnce(LasZipError) -> SynthError {
    move |source| SynthError::Compress { path: path.to_owned(), chunk, source }
}

fn write_points(
    generator: &Generator,
    options: &SynthOptions,
    part: &mut PartFile,
    vlr: Option<&LazVlr>,
    progress: &mut dyn FnMut(u64),
) -> Result<Tally, SynthError> {
    let mut tally = Tally::default();
    let head = file_head(options, &tally, vlr).map_err(io_error(&part.path, "writing"))?;
    part.write(&head)?;
    if vlr.is_some() {
        // Where the chunk table will be; known at the end.
        part.write(&[0xff; ChunkTable::OFFSET_SIZE])?;
    }
    let mut table = ChunkTable::default();
    let chunks = generator.len().div_ceil(CHUNK_POINTS);
    let threads = thread::available_parallelism().map_or(1, |n| n.get()) as u64;
    let mut first = 0;
    while first < chunks {
        let wave = first..(first + threads).min(chunks);
        // One wave of chunks, a thread each; joined in order, so that the file does not depend on timing.
        let made: Vec<_> = thread::scope(|scope| {
            let workers: Vec<_> = wave
                .clone()
                .map(|chunk| {
                    let range = chunk * CHUNK_POINTS..((chunk + 1) * CHUNK_POINTS).min(generator.len());
                    scope.spawn(move || make_chunk(generator, options, vlr, range))
                })
                .collect();
            workers.into_iter().map(|worker| worker.join()).collect()
        });
        for (made, chunk) in made.into_iter().zip(wave.clone()) {
            let made = made.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            let (bytes, counted) = made.map_err(compress_error(&part.path, chunk))?;
            part.write(&bytes)?;
            table.push(ChunkTableEntry { point_count: counted.points, byte_count: bytes.len() as u64 });
            tally.merge(&counted);
            progress(tally.points);
        }
        first = wave.end;
    }
    if let Some(vlr) = vlr {
        let table_at = part.written;
        let mut bytes = Vec::new();
        table.write_to(&mut bytes, vlr).map_err(io_error(&part.path, "writing"))?;
        part.write(&bytes)?;
        part.overwrite(head.len() as u64, &table_at.to_le_bytes())?;
    }
    Ok(tally)
}

/// One chunk of points as it lies in the file.
fn make_chunk(
    generator: &Generator,
    options: &SynthOptions,
    vlr: Option<&LazVlr>,
    range: Range<u64>,
) -> Result<(Vec<u8>, Tally), LasZipError> {
    let format = options.point_format;
    let start = survey_start(options);
    let count = (range.end - range.start) as usize;
    let mut records = Vec::with_capacity(count * usize::from(record_length(format)));
    let mut tally = Tally::default();
    generator.for_each(range, |point| {
        push_record(&mut records, format, &point, start);
        tally.add(&point);
    });
    let Some(vlr) = vlr else { return Ok((records, tally)) };
    let mut compressor = LasZipCompressor::new(Cursor::new(Vec::with_capacity(records.len() / 4)), vlr.clone())?;
    compressor.compress_many(&records)?;
    compressor.done()?;
    // A stream of one chunk: the offset of its chunk table, the chunk, the table.
    let mut bytes = compressor.into_inner().into_inner();
    let (offset, _) = bytes.split_first_chunk::<8>().ok_or(LasZipError::MissingChunkTable)?;
    bytes.truncate(u64::from_le_bytes(*offset) as usize);
    bytes.drain(..ChunkTable::OFFSET_SIZE);
    Ok((bytes, tally))
}

/// The temporary file; removed when dropped unfinished.
struct PartFile {
    file: Option<File>,
    path: PathBuf,
    written: u64,
}

impl PartFile {
    fn create(target: &Path) -> Result<PartFile, SynthError> {
        let mut name = target.file_name().unwrap_or_default().to_owned();
        name.push(format!(".{}.part", std::process::id()));
        let path = target.with_file_name(name);
        let file = File::create(&path).map_err(io_error(&path, "creating"))?;
        Ok(PartFile { file: Some(file), path, written: 0 })
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), SynthError> {
        if let Some(file) = &mut self.file {
            file.write_all(bytes).map_err(io_error(&self.path, "writing"))?;
        }
        self.written += bytes.len() as u64;
        Ok(())
    }

    fn overwrite(&mut self, at: u64, bytes: &[u8]) -> Result<(), SynthError> {
        if let Some(file) = &mut self.file {
            file.seek(SeekFrom::Start(at))
                .and_then(|_| file.write_all(bytes))
                .and_then(|_| file.seek(SeekFrom::End(0)))
                .map_err(io_error(&self.path, "writing"))?;
        }
        Ok(())
    }

    /// Puts the final header in place and gives the file its name. Returns its size in bytes.
    fn finish(mut self, target: &Path, head: &[u8]) -> Result<u64, SynthError> {
        self.overwrite(0, head)?;
        // Closed before it is renamed: Windows renames no open file.
        drop(self.file.take());
        if let Err(source) = fs::rename(&self.path, target) {
            let _ = fs::remove_file(&self.path);
            return Err(SynthError::Io { path: target.to_owned(), action: "renaming the finished file", source });
        }
        Ok(self.written)
    }
}

impl Drop for PartFile {
    fn drop(&mut self) {
        if self.file.take().is_some() {
            let _ = fs::remove_file(&self.path);
        }
    }
}
