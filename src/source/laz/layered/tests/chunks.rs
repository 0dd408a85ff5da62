//! Chunks to decode: out of real files, and made with the laz crate's compressor.

use std::{
    fs,
    io::{Cursor, Write},
    path::{Path, PathBuf},
};

use laz::{
    DecompressionSelection as Selection, LazItem, LazItemRecordBuilder as Items, LazVlr, las,
    laszip::ChunkTable,
    record::{LayeredPointRecordCompressor, LayeredPointRecordDecompressor, RecordCompressor, RecordDecompressor},
};

use super::super::{
    super::{DECODER_THREAD, silence_decoder_panics},
    Fields, record_length,
};

/// A chunk's bytes, what they hold, and where they are from.
pub struct Chunk {
    pub name: String,
    pub items: Vec<LazItem>,
    pub bytes: Vec<u8>,
    pub points: usize,
}

impl Chunk {
    pub fn record_length(&self) -> usize {
        record_length(&self.items)
    }

    /// The laz crate's records, as far as it gets without an error or a panic; the others are zero.
    pub fn by_laz(&self, fields: Fields) -> (Vec<u8>, usize) {
        let mut records = vec![0; self.points * self.record_length()];
        let mut good = 0;
        // What was decoded before a panic counts; decoder threads panic silently.
        silence_decoder_panics();
        let decode = || {
            let mut decoder = LayeredPointRecordDecompressor::new(Cursor::new(&self.bytes));
            decoder.set_fields_from(&self.items).unwrap();
            decoder.set_selection(selection(fields));
            for record in records.chunks_exact_mut(self.record_length()) {
                if decoder.decompress_next(record).is_err() {
                    break;
                }
                good += 1;
            }
        };
        let thread = std::thread::Builder::new().name(format!("{DECODER_THREAD}laz"));
        std::thread::scope(|scope| {
            let _ = thread.spawn_scoped(scope, decode).unwrap().join();
        });
        (records, good)
    }
}

/// Adds a field to a selection.
type Add = fn(Selection) -> Selection;

fn selection(fields: Fields) -> Selection {
    let all: [(bool, Add); 11] = [
        (fields.rgb, Selection::decompress_rgb),
        (fields.nir, Selection::decompress_nir),
        (fields.intensity, Selection::decompress_intensity),
        (fields.returns, Selection::decompress_flags),
        (fields.classification, Selection::decompress_classification),
        (fields.scan_angle, Selection::decompress_scan_angle),
        (fields.user_data, Selection::decompress_user_data),
        (fields.point_source, Selection::decompress_point_source_id),
        (fields.gps_time, Selection::decompress_gps_time),
        (fields.wave_packet, Selection::decompress_wavepacket),
        (fields.extra_bytes, Selection::decompress_extra_bytes),
    ];
    let wanted = all.into_iter().filter(|(wanted, _)| *wanted);
    wanted.fold(Selection::xy_returns_channel().decompress_z(), |selection, (_, add)| add(selection))
}

/// All fields, none, and each alone.
pub fn field_sets() -> Vec<Fields> {
    let none = Fields::NONE;
    vec![
        Fields::ALL,
        none,
        Fields { rgb: true, ..none },
        Fields { nir: true, ..none },
        Fields { intensity: true, ..none },
        Fields { returns: true, ..none },
        Fields { classification: true, ..none },
        Fields { scan_angle: true, ..none },
        Fields { user_data: true, ..none },
        Fields { point_source: true, ..none },
        Fields { gps_time: true, ..none },
        Fields { wave_packet: true, ..none },
        Fields { extra_bytes: true, ..none },
    ]
}

/// The layered chunks of the real files beside the repository, at most `most` points of each.
pub fn real(most: usize) -> Vec<Chunk> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = std::env::var_os("FIRSTLIGHT_DATA").map_or(beside, PathBuf::from);
    if !folder.is_dir() {
        // Straight to the terminal: what a passing test prints with `eprintln!` is swallowed.
        let _ = writeln!(std::io::stderr(), "SKIPPED: no real scans: {} is not there", folder.display());
        return Vec::new();
    }
    let entries = ["scans", "formats"].map(|sub| fs::read_dir(folder.join(sub)).unwrap());
    let mut paths: Vec<PathBuf> = entries.into_iter().flatten().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let chunks: Vec<Chunk> = paths.iter().flat_map(|path| file_chunks(path, most)).collect();
    assert!(chunks.len() > 10, "{} chunks", chunks.len());
    chunks
}

fn file_chunks(path: &Path, most: usize) -> Vec<Chunk> {
    let name = path.file_name().unwrap().to_string_lossy().into_owned();
    let bytes = fs::read(path).unwrap();
    if !name.ends_with(".laz") || bytes[104] & 63 < 6 {
        return Vec::new();
    }
    let u16_at = |at: usize| usize::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]));
    let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let mut at = u16_at(94);
    while u16_at(at + 18) != usize::from(LazVlr::RECORD_ID) {
        at += 54 + u16_at(at + 20);
    }
    let vlr = LazVlr::from_buffer(&bytes[at + 54..at + 54 + u16_at(at + 20)]).unwrap();
    let mut cursor = Cursor::new(&bytes);
    cursor.set_position(u32_at(96) as u64);
    let table = ChunkTable::read_from(&mut cursor, &vlr).unwrap();
    let (mut at, mut left) = (u32_at(96) + 8, u32_at(247));
    let mut chunks = Vec::new();
    for entry in &table {
        let size = if vlr.uses_variable_size_chunks() { entry.point_count as usize } else { vlr.chunk_size() as usize };
        let (points, length) = (size.min(left), entry.byte_count as usize);
        if points > 0 && u32_at(247) - left < most {
            let name = format!("{name}, chunk {}", chunks.len());
            chunks.push(Chunk { name, items: vlr.items().clone(), bytes: bytes[at..at + length].to_vec(), points });
        }
        (at, left) = (at + length, left - points);
    }
    chunks
}

/// A small generator of numbers (xorshift), the same everywhere.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, n: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % n
    }

    fn rarely(&mut self, one_in: u64) -> bool {
        self.below(one_in) == 0
    }
}

/// What to make.
#[derive(Debug, Clone, Copy)]
pub struct Recipe {
    /// 6 to 10.
    pub format: u8,
    pub version: u16,
    pub channels: u64,
    pub extra_bytes: u16,
    pub points: usize,
    pub seed: u64,
}

impl Recipe {
    fn items(&self) -> Vec<LazItem> {
        let extra = self.extra_bytes;
        match (self.format, self.version) {
            (6, 3) => Items::version_3_of::<las::Point6>(extra),
            (7, 3) => Items::version_3_of::<las::Point7>(extra),
            (8, 3) => Items::version_3_of::<las::Point8>(extra),
            (9, 3) => Items::version_3_of::<las::Point9>(extra),
            (_, 3) => Items::version_3_of::<las::Point10>(extra),
            (6, _) => Items::version_4_of::<las::Point6>(extra),
            (7, _) => Items::version_4_of::<las::Point7>(extra),
            (8, _) => Items::version_4_of::<las::Point8>(extra),
            (9, _) => Items::version_4_of::<las::Point9>(extra),
            _ => Items::version_4_of::<las::Point10>(extra),
        }
    }

    /// Records whose fields all change, at different paces, jumps included.
    pub fn records(&self) -> Vec<u8> {
        let mut random = Random(self.seed * 99_991 + 7);
        let length = record_length(&self.items());
        let mut records = Vec::new();
        let mut last = vec![0; length];
        let mut time = 200_000_000.0f64;
        let (mut x, mut y, mut z) = (1_000i32, -2_000i32, 300i32);
        let mut class = 2;
        for _ in 0..self.points {
            let far = if random.rarely(50) { 1 << 26 } else { 100 };
            x = x.wrapping_add(random.below(far) as i32 - 20);
            y = y.wrapping_sub(random.below(80) as i32);
            z += random.below(9) as i32 - 4;
            let record = &mut last;
            record[0..4].copy_from_slice(&x.to_le_bytes());
            record[4..8].copy_from_slice(&y.to_le_bytes());
            record[8..12].copy_from_slice(&z.to_le_bytes());
            record[12..14].copy_from_slice(&(random.below(3_000) as u16).to_le_bytes());
            if random.rarely(3) {
                let odd = random.rarely(20);
                let returns = if odd { random.below(16) } else { 1 + random.below(4) };
                record[14] = (returns << 4 | if odd { random.below(16) } else { 1 + random.below(returns) }) as u8;
            }
            let channel = if random.rarely(4) { random.below(self.channels) } else { u64::from(record[15] >> 4 & 3) };
            let flags = if random.rarely(30) { random.below(256) as u8 } else { record[15] };
            record[15] = flags & !0x30 | (channel as u8) << 4;
            if random.rarely(20) {
                class = random.below(40) as u8;
            }
            record[16] = class;
            if random.rarely(10) {
                record[17] = random.below(256) as u8;
                record[18..20].copy_from_slice(&(random.below(30_000) as i16 - 15_000).to_le_bytes());
                record[20..22].copy_from_slice(&(random.below(400) as u16).to_le_bytes());
            }
            // Steady, now and then by many steps, standing still, to another sequence and back.
            time += match random.below(40) {
                0 => 1e6,
                1 => -1e6,
                2 => 1e-3,
                3..10 => 0.0,
                n => 1e-5 * (1 + n % 3) as f64,
            };
            record[22..30].copy_from_slice(&time.to_le_bytes());
            for (byte, pace) in record[30..].iter_mut().zip([1, 2, 3, 4, 5].into_iter().cycle()) {
                if random.rarely(pace) {
                    *byte = byte.wrapping_add(random.below(9) as u8);
                }
            }
            if self.format >= 9 {
                let at = if self.format == 9 { 30 } else { 38 };
                let offset = random.below(1 << 20) + if random.rarely(9) { 1 << 40 } else { 0 };
                let before = u64::from_le_bytes(record[at + 1..at + 9].try_into().unwrap());
                let offset = if random.rarely(2) { before } else { offset };
                record[at + 1..at + 9].copy_from_slice(&offset.to_le_bytes());
            }
            records.extend_from_slice(record);
        }
        records
    }

    pub fn chunk(&self) -> Chunk {
        let items = self.items();
        let mut compressor = LayeredPointRecordCompressor::new(Cursor::new(Vec::new()));
        compressor.set_fields_from(&items).unwrap();
        compressor.compress_many(&self.records()).unwrap();
        compressor.done().unwrap();
        Chunk { name: format!("{self:?}"), items, bytes: compressor.into_inner().into_inner(), points: self.points }
    }
}
