//! Decoding LAZ chunks with the `laz` crate's record decompressors. The decoder trusts its input, so
//! sizes are checked before it starts, and its panics are caught. What was decoded before a fault is
//! kept.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom},
    sync::Arc,
};

use laz::{
    DecompressionSelection, LazItem, LazItemType,
    las::{v3, v4},
    record::{
        LayeredFieldDecompressor, LayeredPointRecordDecompressor, RecordDecompressor, SequentialPointRecordDecompressor,
    },
};

use super::{
    super::{
        bytes::{RangeReader, u32_at},
        chunks::{Chunk, LazLayout, layer_count, layered_sizes},
        fields::Fields,
    },
    ChunkDecoder, Decoded, End, Share, catch,
};

type Inner = Box<dyn RecordDecompressor<RangeReader> + Send>;

/// The laz crate's decoder of a chunk, or of a stream of chunks that follow each other. It reads
/// through a window, so that its memory does not depend on the chunk's size.
pub struct LazCrateDecoder {
    file: Arc<File>,
    items: Vec<LazItem>,
    layered: bool,
    record_length: usize,
    chunk: Chunk,
    fields: Fields,
    /// Without a table, chunks of fixed size follow each other in one stream.
    run: u64,
    left_in_run: u64,
    inner: Option<Inner>,
    /// Where the stream ended, if a panic took the decoder away.
    position: u64,
}

impl LazCrateDecoder {
    pub fn new(
        file: &Arc<File>,
        layout: &LazLayout,
        record_length: usize,
        chunk: &Chunk,
        fields: Fields,
    ) -> Result<Self, String> {
        let run = match (layout.is_layered(), layout.chunk_size) {
            (false, Some(size)) => u64::from(size),
            _ => u64::MAX,
        };
        let mut decoder = LazCrateDecoder {
            file: Arc::clone(file),
            items: layout.items.clone(),
            layered: layout.is_layered(),
            record_length,
            chunk: *chunk,
            fields,
            run,
            left_in_run: run,
            inner: None,
            position: chunk.at,
        };
        let reader = RangeReader::new(Arc::clone(file), chunk.at, decoder.end());
        decoder.inner = Some(decoder.start(reader)?);
        Ok(decoder)
    }

    fn end(&self) -> u64 {
        self.chunk.at + self.chunk.bytes
    }

    fn start(&self, reader: RangeReader) -> Result<Inner, String> {
        if !self.layered {
            let mut decoder = SequentialPointRecordDecompressor::new(reader);
            decoder.set_fields_from(&self.items).map_err(|e| e.to_string())?;
            return Ok(Box::new(decoder));
        }
        let mut decoder = LayeredPointRecordDecompressor::new(reader);
        for item in &self.items {
            add_layered(&mut decoder, item, self.fields);
        }
        decoder.set_selection(selection(self.fields));
        Ok(Box::new(decoder))
    }
}

impl ChunkDecoder for LazCrateDecoder {
    /// Only checks the sizes: the bytes are read on the way.
    fn load(&mut self, _: Share, _: &mut Vec<Vec<u8>>) -> Result<(), String> {
        if !self.layered {
            return Ok(());
        }
        let bytes = self.chunk.bytes;
        match layered_sizes(&self.file, self.chunk.at, bytes, self.record_length as u64, &self.items) {
            Err(e) => Err(e.to_string()),
            Ok(None) => Err(format!("{bytes} bytes are too few for a chunk")),
            Ok(Some((_, needed))) if needed > bytes => {
                Err(format!("its layers add up to {needed} bytes, {bytes} are there"))
            }
            Ok(_) => Ok(()),
        }
    }

    fn decode(&mut self, records: &mut [u8]) -> Decoded {
        let mut decoded = 0;
        for record in records.chunks_exact_mut(self.record_length) {
            if self.left_in_run == 0 {
                self.left_in_run = self.run;
                let reader = self.inner.take().map(|inner| inner.box_into_inner());
                match reader.map(|reader| self.start(reader)) {
                    Some(Ok(inner)) => self.inner = Some(inner),
                    Some(Err(what)) => return Decoded { records: decoded, end: End::Fault(what) },
                    None => {}
                }
            }
            let Some(inner) = &mut self.inner else {
                return Decoded { records: decoded, end: End::Fault("its decoder stopped before".into()) };
            };
            let fault = match catch(|| inner.decompress_next(record)) {
                Ok(Ok(())) => None,
                Ok(Err(e)) if e.kind() == io::ErrorKind::UnexpectedEof => Some("its compressed bytes end early".into()),
                Ok(Err(e)) => Some(e.to_string()),
                Err(panic) => {
                    // Nothing else was touched.
                    self.inner = None;
                    Some(format!("its bytes make no sense ({panic})"))
                }
            };
            if let Some(what) = fault {
                return Decoded { records: decoded, end: End::Fault(what) };
            }
            decoded += 1;
            self.left_in_run -= 1;
        }
        if let Some(inner) = &self.inner {
            self.position = inner.get().position();
        }
        Decoded { records: decoded, end: End::Filled }
    }

    fn unload(&mut self, _: &mut Vec<Vec<u8>>) {}

    fn unused(&self) -> Option<u64> {
        (!self.layered).then(|| self.end().saturating_sub(self.position))
    }

    /// Not to be kept: its models are made at once, some 500 kB for a chunk.
    fn memory_bytes(&self) -> usize {
        usize::MAX
    }
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
fn add_layered(decoder: &mut LayeredPointRecordDecompressor<'_, RangeReader>, item: &LazItem, fields: Fields) {
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
