//! Decoding LAZ chunks with the `laz` crate's record decompressors. The decoder trusts its input, so
//! sizes are checked before it starts, and its panics are caught. What was decoded before a fault is
//! kept.

use std::{
    cell::RefCell,
    fs::File,
    io::{self, Read, Seek, SeekFrom},
    panic::{AssertUnwindSafe, catch_unwind},
    sync::Once,
};

use laz::{
    DecompressionSelection, LazItem, LazItemType,
    las::{v3, v4},
    record::{
        LayeredFieldDecompressor, LayeredPointRecordDecompressor, RecordDecompressor, SequentialPointRecordDecompressor,
    },
};

use super::super::{
    bytes::{RangeReader, u32_at},
    chunks::{Chunk, LazLayout, layer_count, layered_sizes},
    fields::Fields,
};

/// Decoded bytes between two looks at the cancel flag: a few hundred to a few thousand points, about a
/// millisecond.
const PIECE_BYTES: usize = 64 << 10;

/// Threads whose names start so panic silently: their panics are caught and reported.
pub const DECODER_THREAD: &str = "decode-";

/// How decoding one chunk ended.
#[derive(Debug, PartialEq)]
pub enum ChunkEnd {
    /// All its points are decoded. For chunks of one stream, `unused` are the bytes that the decoder
    /// left: not zero if it lost its way, or if the header counts fewer points than the chunk has.
    Complete { unused: Option<u64> },
    /// The receiver wants no more.
    Stopped,
    /// The decoder could not go on.
    Fault(String),
}

/// Decodes a chunk's points from the first on. `emit` takes pieces of raw records with the number (in
/// the file) of their first, and says whether to go on.
pub fn decode_chunk(
    file: &File,
    layout: &LazLayout,
    record_length: usize,
    fields: Fields,
    chunk: &Chunk,
    mut emit: impl FnMut(&[u8], u64) -> bool,
) -> ChunkEnd {
    if chunk.points == 0 {
        return ChunkEnd::Complete { unused: None };
    }
    let end = chunk.at + chunk.bytes;
    let mut reader = RangeReader::new(file, chunk.at, end);
    if layout.is_layered() {
        match layered_sizes(file, chunk.at, chunk.bytes, record_length as u64, &layout.items) {
            Err(e) => return ChunkEnd::Fault(e.to_string()),
            Ok(None) => return ChunkEnd::Fault(format!("{} bytes are too few for a chunk", chunk.bytes)),
            Ok(Some((_, needed))) if needed > chunk.bytes => {
                return ChunkEnd::Fault(format!("its layers add up to {needed} bytes, {} are there", chunk.bytes));
            }
            Ok(_) => {}
        }
    }
    // Without a table, chunks of fixed size follow each other in one stream.
    let run = match (layout.is_layered(), layout.chunk_size) {
        (false, Some(size)) => u64::from(size),
        _ => u64::MAX,
    };
    let per_piece = (PIECE_BYTES / record_length).max(1) as u64;
    let mut buffer = vec![0; per_piece as usize * record_length];
    let mut done = 0;
    while done < chunk.points {
        let mut decoder = match decoder(reader, layout, fields) {
            Ok(decoder) => decoder,
            Err(what) => return ChunkEnd::Fault(what),
        };
        let run_end = chunk.points.min(done.saturating_add(run));
        while done < run_end {
            let wanted = per_piece.min(run_end - done) as usize * record_length;
            let (decoded, fault) = decode_piece(decoder.as_mut(), &mut buffer[..wanted], record_length);
            if decoded > 0 && !emit(&buffer[..decoded * record_length], chunk.first_point + done) {
                return ChunkEnd::Stopped;
            }
            done += decoded as u64;
            if let Some(what) = fault {
                return ChunkEnd::Fault(what);
            }
        }
        reader = decoder.box_into_inner();
    }
    ChunkEnd::Complete { unused: (!layout.is_layered()).then(|| end.saturating_sub(reader.position())) }
}

type Decoder<'f> = Box<dyn RecordDecompressor<RangeReader<'f>> + 'f>;

/// Fills a buffer with records; returns how many are good, and what stopped it, if anything did.
fn decode_piece(
    decoder: &mut (dyn RecordDecompressor<RangeReader<'_>> + '_),
    buffer: &mut [u8],
    record_length: usize,
) -> (usize, Option<String>) {
    let mut decoded = 0;
    // After a panic the decoder is dropped, and nothing else was touched.
    let result = catch_unwind(AssertUnwindSafe(|| -> io::Result<()> {
        for record in buffer.chunks_exact_mut(record_length) {
            decoder.decompress_next(record)?;
            decoded += 1;
        }
        Ok(())
    }));
    let fault = match result {
        Ok(Ok(())) => None,
        Ok(Err(e)) if e.kind() == io::ErrorKind::UnexpectedEof => Some("its compressed bytes end early".to_owned()),
        Ok(Err(e)) => Some(e.to_string()),
        Err(_) => Some(format!("its bytes make no sense ({})", take_panic())),
    };
    (decoded, fault)
}

fn decoder<'f>(reader: RangeReader<'f>, layout: &LazLayout, fields: Fields) -> Result<Decoder<'f>, String> {
    if !layout.is_layered() {
        let mut decoder = SequentialPointRecordDecompressor::new(reader);
        decoder.set_fields_from(&layout.items).map_err(|e| e.to_string())?;
        return Ok(Box::new(decoder));
    }
    let mut decoder = LayeredPointRecordDecompressor::new(reader);
    for item in &layout.items {
        add_layered(&mut decoder, item, fields);
    }
    decoder.set_selection(selection(fields));
    Ok(Box::new(decoder))
}

/// The layers that the fields need.
fn selection(fields: Fields) -> DecompressionSelection {
    let mut all = DecompressionSelection::xy_returns_channel().decompress_z();
    let mut add = |wanted: bool, with: fn(DecompressionSelection) -> DecompressionSelection| {
        if wanted {
            all = with(all);
        }
    };
    add(fields.rgb, DecompressionSelection::decompress_rgb);
    add(fields.nir, DecompressionSelection::decompress_nir);
    add(fields.intensity, DecompressionSelection::decompress_intensity);
    add(fields.returns, DecompressionSelection::decompress_flags);
    add(fields.classification, DecompressionSelection::decompress_classification);
    add(fields.scan_angle, DecompressionSelection::decompress_scan_angle);
    add(fields.user_data, DecompressionSelection::decompress_user_data);
    add(fields.point_source, DecompressionSelection::decompress_point_source_id);
    add(fields.gps_time, DecompressionSelection::decompress_gps_time);
    add(fields.wave_packet, DecompressionSelection::decompress_wavepacket);
    add(fields.extra_bytes, DecompressionSelection::decompress_extra_bytes);
    all
}

/// Adds an item's field decoders; fields that nobody asked for are stepped over.
fn add_layered(decoder: &mut LayeredPointRecordDecompressor<'_, RangeReader<'_>>, item: &LazItem, fields: Fields) {
    use LazItemType as T;
    let skip = |size: usize, layers: usize| Skip { size, layers, bytes: 0 };
    let v3 = item.version() == 3;
    match item.item_type() {
        T::Point14 if v3 => decoder.add_field_decompressor(v3::LasPoint6Decompressor::default()),
        T::Point14 => decoder.add_field_decompressor(v4::LasPoint6Decompressor::default()),
        T::RGB14 | T::RGBNIR14 => {
            match (fields.rgb, v3) {
                (true, true) => decoder.add_field_decompressor(v3::LasRGBDecompressor::default()),
                (true, false) => decoder.add_field_decompressor(v4::LasRGBDecompressor::default()),
                _ => decoder.add_field_decompressor(skip(6, 1)),
            }
            match (item.item_type() == T::RGBNIR14, fields.nir, v3) {
                (true, true, true) => decoder.add_field_decompressor(v3::LasNIRDecompressor::default()),
                (true, true, false) => decoder.add_field_decompressor(v4::LasNIRDecompressor::default()),
                (true, false, _) => decoder.add_field_decompressor(skip(2, 1)),
                _ => {}
            }
        }
        T::WavePacket14 if fields.wave_packet && v3 => {
            decoder.add_field_decompressor(v3::LasWavepacketDecompressor::default());
        }
        T::WavePacket14 if fields.wave_packet => {
            decoder.add_field_decompressor(v4::LasWavepacketDecompressor::default());
        }
        T::Byte14(n) if fields.extra_bytes && v3 => {
            decoder.add_field_decompressor(v3::LasExtraByteDecompressor::new(n.into()));
        }
        T::Byte14(n) if fields.extra_bytes => {
            decoder.add_field_decompressor(v4::LasExtraByteDecompressor::new(n.into()));
        }
        _ => decoder.add_field_decompressor(skip(usize::from(item.size()), layer_count(item))),
    }
}

/// A field whose layers are stepped over: no models are built, nothing is read but the sizes.
struct Skip {
    size: usize,
    layers: usize,
    bytes: u64,
}

impl<R: Read + Seek> LayeredFieldDecompressor<R> for Skip {
    fn size_of_field(&self) -> usize {
        self.size
    }

    fn set_selection(&mut self, _: DecompressionSelection) {}

    fn init_first_point(&mut self, src: &mut R, first_point: &mut [u8], _: &mut usize) -> io::Result<()> {
        src.read_exact(first_point)
    }

    fn decompress_field_with(&mut self, _: &mut [u8], _: &mut usize) -> io::Result<()> {
        Ok(())
    }

    fn read_layers_sizes(&mut self, src: &mut R) -> io::Result<()> {
        self.bytes = 0;
        for _ in 0..self.layers {
            let mut size = [0; 4];
            src.read_exact(&mut size)?;
            self.bytes += u64::from(u32_at(&size, 0));
        }
        Ok(())
    }

    fn read_layers(&mut self, src: &mut R) -> io::Result<()> {
        src.seek(SeekFrom::Current(self.bytes as i64)).map(|_| ())
    }
}

thread_local! {
    /// What the last panic on this thread said, and where.
    static LAST_PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}

/// The words of the last panic that was caught on this (decoder) thread.
pub fn take_panic() -> String {
    LAST_PANIC.take()
}

/// Keeps decoder threads from printing the panics that are caught and reported anyway; all other
/// threads keep the hook that was there.
pub fn silence_decoder_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if std::thread::current().name().is_some_and(|n| n.starts_with(DECODER_THREAD)) {
                let what = info.payload_as_str().unwrap_or("panic");
                let line = info.location().map(|l| {
                    let file = l.file().rsplit(['/', '\\']).next().unwrap_or_default();
                    format!(" in {file}:{}", l.line())
                });
                LAST_PANIC.set(format!("{what}{}", line.unwrap_or_default()));
            } else {
                before(info);
            }
        }));
    });
}
