//! Where the chunks of a LAZ file are: the LASzip VLR, the chunk table (with own prefix sums, every
//! size checked against the file), and what to do when there is none.

use std::{
    fs::File,
    io::{self, Read},
    sync::atomic::{AtomicBool, Ordering},
};

use laz::{LazItem, LazItemType, LazVlr, decoders::ArithmeticDecoder, decompressors::IntegerDecompressorBuilder};

use super::{
    SourceError,
    bytes::{RangeReader, read_vec_at, u16_at, u32_at, u64_at},
    copc,
    header::Header,
};

/// LASzip's names for how points are laid out.
pub const POINT_WISE: u16 = 1;
pub const POINT_WISE_CHUNKED: u16 = 2;
pub const LAYERED_CHUNKED: u16 = 3;

/// Extra bytes per point that a sequential decoder takes: each needs a model per thread, of 1.1 kB (2.6 kB with the laz crate).
const MAX_SEQUENTIAL_EXTRA_BYTES: u16 = 8_192;

/// A count that no chunk table backs is believed up to so many points per compressed byte: a hundred
/// times what a scan of a flat floor reaches.
const MOST_POINTS_PER_BYTE: u64 = 512;

/// More items than the largest point format has.
const MAX_ITEMS: u16 = 32;

/// A run of points that can be decoded on its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chunk {
    /// File offset and length in bytes.
    pub at: u64,
    pub bytes: u64,
    /// Number within the file of its first point, and the points in it.
    pub first_point: u64,
    pub points: u64,
}

/// How the chunks were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ChunkSource {
    /// The file's chunk table.
    Table,
    /// Layered chunks carry their own sizes: walked from one to the next.
    Walked,
    /// One decoder from front to back.
    OneStream,
}

/// How a LAZ file's points are compressed, and where.
#[derive(Debug, Clone)]
pub struct LazLayout {
    pub compressor: u16,
    pub items: Vec<LazItem>,
    /// Points per chunk that the VLR states; `None` if chunks vary in size or there are none.
    pub chunk_size: Option<u32>,
    pub source: ChunkSource,
    pub chunks: Vec<Chunk>,
    /// COPC: the octree level of each chunk; else empty.
    pub levels: Vec<u8>,
    /// From this chunk on, the header counts fewer points than the chunks hold.
    pub clamped: usize,
}

impl LazLayout {
    /// True for formats 6 and up: each chunk stores its fields in separate layers.
    pub fn is_layered(&self) -> bool {
        self.items.first().is_some_and(|i| i.version() >= 3)
    }

    /// Points that the chunks hold, as far as is known.
    pub fn points(&self) -> u64 {
        self.chunks.iter().map(|c| c.points).fold(0, u64::saturating_add)
    }

    /// True if the header promises as many points of a chunk as the chunk has, so that a sequential
    /// decoder must end exactly at its end. Not known of the last chunk of fixed size, nor of a stream.
    pub fn is_exact(&self, chunk: u64) -> bool {
        self.source == ChunkSource::Table && chunk + 1 < self.chunks.len() as u64 && chunk < self.clamped as u64
    }

    /// True if nothing says where a chunk ends: decoding goes on into the next one, and gives garbage.
    pub fn ends_unknown(&self) -> bool {
        self.source == ChunkSource::OneStream && self.compressor == POINT_WISE_CHUNKED && self.chunk_size.is_none()
    }

    /// Fixed chunk sizes overstate the last chunk's points: no chunk goes beyond the header's count. If
    /// chunks hold more than that, they are not read, as records behind the last of a LAS file are not.
    fn clamp_points(&mut self, points: u64, warnings: &mut Vec<String>) {
        let last = self.chunks.len().saturating_sub(1);
        let held = |(i, chunk): (usize, &Chunk)| {
            // Of the last chunk of fixed size only its first point is certain.
            let certain = if self.chunk_size.is_some() && i == last { 1 } else { chunk.points };
            chunk.first_point.saturating_add(certain)
        };
        let held = self.chunks.iter().enumerate().map(held).max().unwrap_or(0);
        if held > points && self.source != ChunkSource::OneStream {
            warnings.push(format!("the header counts {points} points, the chunks hold {held}: the rest is not read"));
            self.clamped = self.chunks.iter().position(|c| c.first_point + c.points > points).unwrap_or(usize::MAX);
        }
        for chunk in &mut self.chunks {
            chunk.points = chunk.points.min(points.saturating_sub(chunk.first_point));
        }
    }

    /// Finds a file's chunks; how, if not by its table, is said in the warnings.
    ///
    /// # Errors
    /// If the LASzip VLR is not there or asks for what cannot be decoded, or the file cannot be read.
    pub fn read(
        header: &Header,
        file: &File,
        warnings: &mut Vec<String>,
        cancel: &AtomicBool,
    ) -> Result<LazLayout, SourceError> {
        let path = || header.path.clone();
        let vlr = header
            .all_vlrs()
            .find(|v| v.is(LazVlr::USER_ID, LazVlr::RECORD_ID))
            .ok_or_else(|| SourceError::NoLaszipVlr { path: path(), vlrs: header.vlrs.len() })?;
        let fault = |what: String| SourceError::LaszipVlr { path: path(), at: vlr.data_at, what };
        let io = |e: io::Error| super::inputs::from_io(&header.path, "read the chunk table", &e);
        let bytes = vlr.data(file, 64 << 10).map_err(io)?;
        let (compressor, chunk_size, items) = parse_vlr(&bytes, header.record_length()).map_err(fault)?;

        let mut layout = LazLayout {
            compressor,
            items,
            chunk_size,
            source: ChunkSource::OneStream,
            chunks: Vec::new(),
            levels: Vec::new(),
            clamped: usize::MAX,
        };
        let data_at = header.data_at();
        if compressor == POINT_WISE {
            layout.chunks.push(Chunk {
                at: data_at,
                bytes: header.file_length.saturating_sub(data_at),
                first_point: 0,
                points: header.points,
            });
            return Ok(layout);
        }
        let start = data_at + 8;
        match read_table(header, file, layout.chunk_size, layout.is_layered(), cancel).map_err(io)? {
            Ok(chunks) => {
                layout.source = ChunkSource::Table;
                layout.chunks = chunks;
            }
            Err(why) => {
                let how = if layout.is_layered() { "walked from chunk to chunk" } else { "read from front to back" };
                if header.points > 0 {
                    warnings.push(format!("no usable chunk table ({why}): {how} instead"));
                }
                if layout.is_layered() {
                    layout.source = ChunkSource::Walked;
                    layout.chunks = walk_layered(header, file, start, &layout.items, cancel).map_err(io)?;
                } else {
                    // Sequential chunks end where their decoder stops, so one can follow another; but
                    // without a table, nothing says how many points chunks of varying size have.
                    let bytes = header.file_length.saturating_sub(start);
                    layout.chunks.push(Chunk { at: start, bytes, first_point: 0, points: header.points });
                }
            }
        }
        layout.chunks.shrink_to_fit();
        if layout.source != ChunkSource::Table {
            for chunk in &mut layout.chunks {
                chunk.points = chunk.points.min(chunk.bytes.saturating_mul(MOST_POINTS_PER_BYTE));
            }
        }
        layout.clamp_points(header.points, warnings);
        if header.is_copc() {
            layout.levels = copc::levels(header, file, &layout.chunks).map_err(io)?;
        }
        Ok(layout)
    }
}

/// Compressor, chunk size and items from the LASzip VLR, with everything that the decoder would trust
/// checked.
pub fn parse_vlr(bytes: &[u8], record_length: usize) -> Result<(u16, Option<u32>, Vec<LazItem>), String> {
    if bytes.len() < 34 {
        return Err(format!("expected at least 34 bytes, found {}", bytes.len()));
    }
    let (compressor, coder, chunk_size, items) =
        (u16_at(bytes, 0), u16_at(bytes, 2), u32_at(bytes, 12), u16_at(bytes, 32));
    if !matches!(compressor, POINT_WISE | POINT_WISE_CHUNKED | LAYERED_CHUNKED) {
        return Err(format!("expected compressor 1, 2 or 3, found {compressor}"));
    }
    if coder != 0 {
        return Err(format!("expected coder 0 (arithmetic), found {coder}"));
    }
    if items == 0 || items > MAX_ITEMS || bytes.len() < 34 + 6 * usize::from(items) {
        return Err(format!("expected 1 to {MAX_ITEMS} items of 6 bytes, found {items} in {} bytes", bytes.len()));
    }
    let items = LazVlr::read_from(bytes).map_err(|e| e.to_string())?.items().clone();
    check_items(&items, compressor)?;
    let total: u32 = items.iter().map(|i| u32::from(i.size())).sum();
    if total as usize != record_length {
        let names: Vec<String> = items.iter().map(|i| format!("{:?} {}", i.item_type(), i.size())).collect();
        return Err(format!(
            "expected items of {record_length} bytes in total, as the header's records are, found {total} ({})",
            names.join(", ")
        ));
    }
    // Point-wise files have one chunk, whatever this field says (0 and 1 occur).
    let varies = chunk_size == 0 || chunk_size == u32::MAX || compressor == POINT_WISE;
    Ok((compressor, (!varies).then_some(chunk_size), items))
}

fn check_items(items: &[LazItem], compressor: u16) -> Result<(), String> {
    for item in items {
        let (kind, version) = (item.item_type(), item.version());
        use LazItemType as T;
        let (size, versions) = match kind {
            T::Byte(n) if n > MAX_SEQUENTIAL_EXTRA_BYTES => {
                return Err(format!("{n} extra bytes per point: at most {MAX_SEQUENTIAL_EXTRA_BYTES} are read"));
            }
            T::Byte(n) => (n, 1..=2),
            T::Point10 => (20, 1..=2),
            T::GpsTime => (8, 1..=2),
            T::RGB12 => (6, 1..=2),
            T::WavePacket13 => (29, 1..=2),
            T::Point14 => (30, 3..=4),
            T::RGB14 => (6, 3..=4),
            T::RGBNIR14 => (8, 3..=4),
            T::WavePacket14 => (29, 3..=4),
            T::Byte14(n) => (n, 3..=4),
        };
        if item.size() != size {
            return Err(format!("expected {size} bytes for item {kind:?}, found {}", item.size()));
        }
        if !versions.contains(&version) {
            let (low, high) = (versions.start(), versions.end());
            return Err(format!("expected version {low} or {high} of item {kind:?}, found {version}"));
        }
        if (version >= 3) != (compressor == LAYERED_CHUNKED) {
            return Err(format!("item {kind:?} of version {version} does not go with compressor {compressor}"));
        }
    }
    let point_first = matches!(items[0].item_type(), LazItemType::Point10 | LazItemType::Point14);
    if point_first {
        Ok(())
    } else {
        Err(format!("expected a point as the first item, found {:?}", items[0].item_type()))
    }
}

/// Reads the chunk table; the inner error says why there is none.
fn read_table(
    header: &Header,
    file: &File,
    chunk_size: Option<u32>,
    layered: bool,
    cancel: &AtomicBool,
) -> io::Result<Result<Vec<Chunk>, String>> {
    let (data_at, file_length) = (header.data_at(), header.file_length);
    let start = data_at + 8;
    let pointer_at = |at: u64| -> io::Result<Option<u64>> {
        let bytes = read_vec_at(file, at, 8)?;
        Ok((bytes.len() == 8).then(|| u64_at(&bytes, 0)))
    };
    let usable = |at: &u64| *at >= start && at.saturating_add(8) <= file_length;
    let Some(mut table_at) = pointer_at(data_at)? else {
        return Ok(Err(format!("the file ends at byte {file_length}, before the table's position")));
    };
    // A writer that could not seek back leaves −1 there and puts the position at the file's end.
    if (table_at as i64) <= data_at as i64 {
        table_at = pointer_at(file_length.saturating_sub(8))?.unwrap_or(0);
    }
    if !usable(&table_at) {
        return Ok(Err(format!("its position {} is not in the file of {file_length} bytes", table_at as i64)));
    }
    let mut reader = RangeReader::new(file, table_at, file_length);
    let mut head = [0; 8];
    reader.read_exact(&mut head)?;
    let count = u32_at(&head, 4);
    let room = table_at - start;
    let least = header.record_length() as u64;
    if u64::from(count) > room / least {
        return Ok(Err(format!("it says {count} chunks, but {room} bytes hold at most {}", room / least)));
    }
    Ok(table_entries(reader, count, chunk_size, (start, table_at), least, layered, cancel))
}

/// Decodes the table's entries; each must fit between the ones before it and the table.
fn table_entries(
    reader: RangeReader<&File>,
    count: u32,
    chunk_size: Option<u32>,
    (start, end): (u64, u64),
    least: u64,
    layered: bool,
    cancel: &AtomicBool,
) -> Result<Vec<Chunk>, String> {
    let mut chunks = Vec::new();
    if count == 0 {
        return Ok(chunks);
    }
    let broken = |i: u32, e: io::Error| format!("entry {i} of {count} cannot be read: {e}");
    let mut integers = IntegerDecompressorBuilder::new().bits(32).contexts(2).build_initialized();
    let mut decoder = ArithmeticDecoder::new(reader);
    decoder.read_init_bytes().map_err(|e| broken(0, e))?;
    let (mut points, mut bytes, mut at, mut first_point) = (0i32, 0i32, start, 0u64);
    for i in 0..count {
        if i % 4_096 == 0 && cancel.load(Ordering::Relaxed) {
            break;
        }
        if chunk_size.is_none() {
            points = integers.decompress(&mut decoder, points, 0).map_err(|e| broken(i, e))?;
        }
        bytes = integers.decompress(&mut decoder, bytes, 1).map_err(|e| broken(i, e))?;
        let chunk = Chunk {
            at,
            bytes: u64::from(bytes as u32),
            first_point,
            points: chunk_size.map_or(u64::from(points as u32), u64::from),
        };
        // A chunk starts with a whole record (and in layers, a count).
        let needed = if chunk.points == 0 { 0 } else { least + if layered { 4 } else { 0 } };
        if chunk.bytes < needed || chunk.bytes > end - at {
            return Err(format!("entry {i} of {count} says {} bytes, of {} that are left", chunk.bytes, end - at));
        }
        at += chunk.bytes;
        first_point = first_point.saturating_add(chunk.points);
        // Noise can read as millions of empty chunks.
        if chunk.points > 0 {
            chunks.push(chunk);
        }
    }
    Ok(chunks)
}

/// Finds layered chunks without a table: each says its number of points and its layers' sizes.
fn walk_layered(
    header: &Header,
    file: &File,
    start: u64,
    items: &[LazItem],
    cancel: &AtomicBool,
) -> io::Result<Vec<Chunk>> {
    let record = header.record_length() as u64;
    let mut chunks: Vec<Chunk> = Vec::new();
    let (mut at, mut first_point) = (start, 0);
    while first_point < header.points && !cancel.load(Ordering::Relaxed) {
        let left = header.file_length.saturating_sub(at);
        let Some((points, bytes)) = layered_sizes(file, at, left, record, items)? else { break };
        let points = u64::from(points);
        if points == 0 {
            break;
        }
        // A chunk that is cut off is kept: its decoder will say so.
        chunks.push(Chunk { at, bytes: bytes.min(left), first_point, points });
        if bytes >= left {
            break;
        }
        at += bytes;
        first_point += points;
    }
    Ok(chunks)
}

/// Number of points and of bytes that a layered chunk itself states; `None` if not even that is there.
pub fn layered_sizes(
    file: &File,
    at: u64,
    length: u64,
    record: u64,
    items: &[LazItem],
) -> io::Result<Option<(u32, u64)>> {
    let layers: usize = items.iter().map(layer_count).sum();
    let head = 4 + 4 * layers;
    if length < record + head as u64 {
        return Ok(None);
    }
    let bytes = read_vec_at(file, at + record, head)?;
    if bytes.len() < head {
        return Ok(None);
    }
    let layered: u64 = (0..layers).map(|i| u64::from(u32_at(&bytes, 4 + 4 * i))).sum();
    Ok(Some((u32_at(&bytes, 0), record + head as u64 + layered)))
}

/// Layers that an item has in a chunk.
pub fn layer_count(item: &LazItem) -> usize {
    match item.item_type() {
        LazItemType::Point14 => 9,
        LazItemType::RGBNIR14 => 2,
        LazItemType::Byte14(n) => usize::from(n),
        _ => 1,
    }
}
