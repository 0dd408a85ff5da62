//! Sequential chunks against the `laz` crate's decoder: made ones of all items in both versions, real
//! files, in pieces, from parts of their bytes, and damaged.

use std::{
    io::{Cursor, Write},
    path::Path,
    sync::atomic::AtomicBool,
};

use laz::{
    LazItem, LazVlr,
    compressors::IntegerCompressorBuilder,
    encoders::ArithmeticEncoder,
    models::ArithmeticModelBuilder,
    record::{
        RecordCompressor, RecordDecompressor, SequentialPointRecordCompressor, SequentialPointRecordDecompressor,
    },
};

use super::{
    super::{
        super::{chunks::LazLayout, header::Header},
        DECODER_THREAD, silence_decoder_panics,
    },
    Decoded, End, SequentialDecoder,
};

/// xorshift: the same numbers everywhere.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % n
    }
}

const POINT: (u16, u16) = (6, 20);
const TIME: (u16, u16) = (7, 8);
const RGB: (u16, u16) = (8, 6);
const WAVE: (u16, u16) = (9, 29);

/// Items of a LASzip VLR, of any order and version.
fn items(version: u16, kinds: &[(u16, u16)]) -> Vec<LazItem> {
    let mut vlr = vec![0; 32];
    vlr.extend((kinds.len() as u16).to_le_bytes());
    for (kind, size) in kinds {
        [*kind, *size, version].iter().for_each(|n| vlr.extend(n.to_le_bytes()));
    }
    LazVlr::read_from(vlr.as_slice()).expect("items that laz knows").items().clone()
}

/// Every point format's items with some extra bytes, and an order of its own.
fn all_kinds() -> Vec<Vec<(u16, u16)>> {
    vec![
        vec![POINT],
        vec![POINT, (0, 1)],
        vec![POINT, TIME],
        vec![POINT, RGB, (0, 3)],
        vec![POINT, TIME, RGB],
        vec![POINT, TIME, WAVE],
        vec![POINT, TIME, RGB, WAVE, (0, 40)],
        vec![POINT, (0, 2), WAVE, RGB, TIME],
    ]
}

fn record_length(items: &[LazItem]) -> usize {
    items.iter().map(|i| usize::from(i.size())).sum()
}

/// Records that walk and jump, each field in its own way.
fn records(items: &[LazItem], points: usize, seed: u64) -> Vec<u8> {
    let mut random = Random(seed * 7_919 + 1);
    let length = record_length(items);
    let mut records = vec![0u8; points * length];
    let (mut xyz, mut time, mut wave) = ([500_000i32, 4_000_000, 1_000], 300_000.0f64, 1_000u64);
    for (i, record) in records.chunks_exact_mut(length).enumerate() {
        let mut at = 0;
        for item in items {
            let field = &mut record[at..at + usize::from(item.size())];
            at += field.len();
            match (u16::from(item.item_type()), item.version()) {
                (6, _) => {
                    for (axis, p) in xyz.iter_mut().enumerate() {
                        let reach = [30, 5_000, 1 << 22]
                            [usize::from(random.below(50) == 0) + usize::from(random.below(900) == 0)];
                        *p += (random.below(2 * reach) as i32 - reach as i32) >> axis;
                        field[4 * axis..][..4].copy_from_slice(&p.to_le_bytes());
                    }
                    let returns = 1 + random.below(3) * random.below(2);
                    let number = 1 + random.below(returns);
                    field[12] = random.below(200) as u8;
                    field[13] = random.below(3) as u8;
                    field[14] =
                        (number | returns << 3 | (i as u64 / 500 % 2) << 6 | u64::from(i % 499 == 0) << 7) as u8;
                    field[15] = [2, 2, 2, 5, 6][random.below(5) as usize];
                    field[16] = (i / 100 % 50) as u8 ^ 0xf0;
                    field[17] = if random.below(20) == 0 { random.below(256) as u8 } else { 7 };
                    field[18] = (i / 1_000) as u8;
                    field[19] = random.below(300).saturating_sub(298) as u8;
                }
                (7, _) => {
                    time += [0.0, 1e-5, 1e-5, 2e-5, 7e-4, 0.03, -5e-4, 30.0][random.below(8) as usize];
                    let jump = if random.below(700) == 0 { random.below(5) as f64 * 1e8 } else { 0.0 };
                    field.copy_from_slice(&(time + jump).to_le_bytes());
                }
                (8, version) => {
                    for (c, half) in field.iter_mut().enumerate() {
                        // laz's version 1 goes wrong over upper bytes: see `old_colors_…`.
                        let upper = c % 2 == 1 && version == 1;
                        *half = if upper { 9 } else { (i / 3 + c * random.below(6) as usize) as u8 };
                    }
                    if random.below(6) == 0 && version == 2 {
                        field.copy_within(0..2, 2);
                        field.copy_within(0..2, 4);
                    }
                }
                (9, _) => {
                    field[0] = random.below(2) as u8;
                    wave = match random.below(30) {
                        0 => random.below(1 << 40),
                        1..=9 => wave + random.below(500),
                        10..=19 => wave,
                        _ => wave + 256,
                    };
                    field[1..9].copy_from_slice(&wave.to_le_bytes());
                    field[9..13].copy_from_slice(&256u32.to_le_bytes());
                    for float in field[13..].chunks_exact_mut(4) {
                        float.copy_from_slice(&(random.below(1_000) as f32 * 1e-4).to_le_bytes());
                    }
                }
                _ => field.iter_mut().for_each(|b| *b = (random.below(4) * random.below(90)) as u8),
            }
        }
    }
    records
}

fn compressed(items: &Vec<LazItem>, records: &[u8]) -> Vec<u8> {
    let mut compressor = SequentialPointRecordCompressor::new(Cursor::new(Vec::new()));
    compressor.set_fields_from(items).expect("sequential items");
    compressor.compress_many(records).expect("memory");
    compressor.done().expect("memory");
    compressor.into_inner().into_inner()
}

/// What the laz crate makes of a chunk: records up to its first error or panic.
fn by_laz(items: &Vec<LazItem>, bytes: &[u8], points: usize) -> Vec<u8> {
    let mut out = Vec::new();
    // What was decoded before a panic counts; decoder threads panic silently.
    silence_decoder_panics();
    let decode = || {
        let mut decoder = SequentialPointRecordDecompressor::new(Cursor::new(bytes));
        decoder.set_fields_from(items).expect("sequential items");
        let mut record = vec![0; record_length(items)];
        for _ in 0..points {
            if decoder.decompress_next(&mut record).is_err() {
                break;
            }
            out.extend_from_slice(&record);
        }
    };
    let thread = std::thread::Builder::new().name(format!("{DECODER_THREAD}laz"));
    std::thread::scope(|scope| {
        let _ = thread.spawn_scoped(scope, decode).expect("a thread").join();
    });
    out
}

/// All of a chunk at once: records, how it ended, and bytes that were left.
fn at_once(items: &[LazItem], bytes: &[u8], points: usize) -> (Vec<u8>, End, u64) {
    let mut decoder = SequentialDecoder::new(items);
    decoder.load(bytes.to_vec(), true);
    let mut out = vec![0; points * record_length(items)];
    let Decoded { records, end } = decoder.decode(&mut out);
    out.truncate(records * record_length(items));
    (out, end, decoder.unused())
}

/// A chunk in pieces of so many points, with ever more of its bytes loaded, and all of them only when
/// the decoder asks for more than the shares give.
fn in_steps(items: &[LazItem], bytes: &[u8], points: usize, piece: usize, shares: &[f64]) -> Vec<u8> {
    let length = record_length(items);
    let mut decoder = SequentialDecoder::new(items);
    let mut out = vec![0; points * length];
    let mut done = 0;
    let mut shares = shares.iter();
    while done < points {
        let some = shares.next().map_or(bytes.len(), |s| (bytes.len() as f64 * s) as usize);
        decoder.load(bytes[..some].to_vec(), some == bytes.len());
        while done < points {
            let wanted = piece.min(points - done);
            let got = decoder.decode(&mut out[done * length..(done + wanted) * length]);
            done += got.records;
            match got.end {
                End::Filled => assert_eq!(got.records, wanted),
                End::NeedsBytes => break,
                End::Fault(what) => panic!("{what} after {done} points of {points}"),
            }
        }
        assert_eq!(decoder.unload().len(), some);
    }
    out
}

#[test]
fn all_items_of_both_versions() {
    for version in [1, 2] {
        for (n, kinds) in all_kinds().into_iter().enumerate() {
            let items = items(version, &kinds);
            for points in [1, 2, 17, 9_000] {
                let records = records(&items, points, n as u64);
                let bytes = compressed(&items, &records);
                assert!(by_laz(&items, &bytes, points) == records, "{kinds:?} {version}: laz itself");
                let (got, end, unused) = at_once(&items, &bytes, points);
                assert!(got == records, "{kinds:?}, version {version}, {points} points");
                assert_eq!((end, unused), (End::Filled, 0));
            }
        }
    }
}

#[test]
fn one_point_too_many_is_a_fault() {
    let items = items(2, &[POINT, TIME]);
    let records = records(&items, 100, 1);
    let bytes = compressed(&items, &records);
    let (got, end, _) = at_once(&items, &bytes, 400);
    assert!(got.len() >= records.len() && got.len() < 400 * 28 && got.starts_with(&records));
    assert!(matches!(end, End::Fault(_)), "{end:?}");
    // And it stays one.
    let mut decoder = SequentialDecoder::new(&items);
    decoder.load(bytes[..30].to_vec(), true);
    assert!(matches!(decoder.decode(&mut [0; 28]).end, End::Fault(_)));
    decoder.load(bytes, true);
    assert!(matches!(decoder.decode(&mut [0; 28]).end, End::Fault(_)));
}

#[test]
fn pieces_and_parts_of_the_bytes_give_the_same() {
    for (version, kinds) in [(2, vec![POINT, TIME, RGB, (0, 2)]), (1, vec![POINT, TIME, WAVE])] {
        let items = items(version, &kinds);
        let records = records(&items, 5_000, 3);
        let bytes = compressed(&items, &records);
        for piece in [1, 2, 7, 50_000] {
            for shares in [&[][..], &[0.01], &[0.08], &[0.5], &[0.0, 0.0001, 0.01, 0.08, 0.5, 0.500_1, 0.99]] {
                assert!(in_steps(&items, &bytes, 5_000, piece, shares) == records, "{kinds:?} {piece} {shares:?}");
            }
        }
    }
}

#[test]
fn a_prefix_gives_points_and_asks_for_more() {
    let items = items(2, &[POINT, TIME]);
    let records = records(&items, 20_000, 5);
    let bytes = compressed(&items, &records);
    let mut decoder = SequentialDecoder::new(&items);
    decoder.load(bytes[..bytes.len() / 10].to_vec(), false);
    let mut out = vec![0; records.len()];
    let got = decoder.decode(&mut out);
    assert_eq!(got.end, End::NeedsBytes);
    assert!((1_500..2_050).contains(&got.records), "{}", got.records);
    // Without any bytes it asks, too; a chunk that ends there would be a fault.
    assert_eq!(decoder.unload().len(), bytes.len() / 10);
    assert_eq!(decoder.decode(&mut out), Decoded { records: 0, end: End::NeedsBytes });
    assert_eq!(SequentialDecoder::new(&items).decode(&mut []), Decoded { records: 0, end: End::Filled });
}

/// A wrong byte must not go unnoticed: not by the decoder, but by what compares its records.
#[test]
fn a_changed_byte_gives_other_records() {
    let items = items(2, &[POINT, TIME, RGB]);
    let records = records(&items, 3_000, 9);
    let bytes = compressed(&items, &records);
    for at in [10, 40, bytes.len() / 3, bytes.len() - 40] {
        let mut bytes = bytes.clone();
        bytes[at] ^= 4;
        assert!(at_once(&items, &bytes, 3_000).0 != records, "byte {at}");
    }
}

/// Version 1 of colours as LASzip's encoder writes it, which is not as the laz crate does.
#[test]
fn old_colors_with_upper_bytes() {
    let items = items(1, &[POINT, RGB]);
    let mut random = Random(77);
    let colors: Vec<[u8; 6]> = (0..4_000)
        .map(|i| {
            std::array::from_fn(|c| if random.below(3) == 0 { random.below(256) as u8 } else { (i / 50 + c) as u8 })
        })
        .collect();
    let mut bytes = vec![0; 20];
    bytes.extend(colors[0]);
    let mut encoder = ArithmeticEncoder::new(Cursor::new(Vec::new()));
    let integers = |bits, contexts| IntegerCompressorBuilder::new().bits(bits).contexts(contexts).build_initialized();
    let (mut dx, mut dy, mut z) = (integers(32, 1), integers(32, 20), integers(32, 20));
    let model = |symbols| ArithmeticModelBuilder::new(symbols).with_compression(true).build();
    let (mut point_changed, mut changed, mut halves) = (model(64), model(64), integers(8, 6));
    for pair in colors.windows(2) {
        // The points stay where they are.
        for integers in [&mut dx, &mut dy, &mut z] {
            integers.compress(&mut encoder, 0, 0, 0).expect("memory");
        }
        encoder.encode_symbol(&mut point_changed, 0).expect("memory");
        let differ = (0..6).fold(0, |sum, c| sum | u32::from(pair[0][c] != pair[1][c]) << c);
        encoder.encode_symbol(&mut changed, differ).expect("memory");
        for c in (0..6).filter(|c| differ & 1 << c != 0) {
            halves.compress(&mut encoder, pair[0][c].into(), pair[1][c].into(), c as u32).expect("memory");
        }
    }
    encoder.done().expect("memory");
    bytes.extend(encoder.into_inner().into_inner());
    let (got, end, unused) = at_once(&items, &bytes, colors.len());
    assert_eq!((end, unused), (End::Filled, 0));
    assert!(got.chunks_exact(26).map(|r| &r[20..]).eq(colors.iter().map(|c| &c[..])));
}

#[test]
fn damaged_chunks_give_what_laz_gives_and_never_panic() {
    let mut random = Random(41);
    let (mut same, mut cut) = (0, 0);
    for round in 0..400 {
        let kinds = &all_kinds()[round % 8];
        let items = items(1 + (round / 8 % 2) as u16, kinds);
        let points = 1_500;
        let mut bytes = compressed(&items, &records(&items, points, round as u64));
        for _ in 0..=random.below(4) {
            let at = record_length(&items) as u64 + random.below((bytes.len() - record_length(&items)) as u64);
            bytes[at as usize] ^= 1 << random.below(8);
        }
        if round % 3 == 0 {
            bytes.truncate(random.below(bytes.len() as u64) as usize);
        }
        let (ours, end, _) = at_once(&items, &bytes, points);
        assert_eq!(matches!(end, End::Fault(_)), ours.len() < points * record_length(&items));
        // Old colours differ from laz on purpose.
        if items.iter().all(|i| i.version() == 2 || u16::from(i.item_type()) != RGB.0) {
            let theirs = by_laz(&items, &bytes, points);
            assert!(ours.starts_with(&theirs), "round {round}");
            same += usize::from(ours.len() == theirs.len());
            cut += usize::from(ours.len() < points * record_length(&items));
        }
    }
    // Neither is all of it panics or whole chunks.
    assert!(same > 100 && cut > 50, "{same} the same, {cut} cut");
}

#[test]
fn noise_ends_soon() {
    let mut random = Random(43);
    for round in 0..200 {
        let kinds = &all_kinds()[round % 8];
        let items = items(1 + (round / 8 % 2) as u16, kinds);
        let fill = [0, 0xff, 0x55][round % 3];
        let bytes: Vec<u8> = (0..3_000).map(|_| if round < 24 { fill } else { random.below(256) as u8 }).collect();
        let (got, _, _) = at_once(&items, &bytes, 20_000);
        assert_eq!(got.len() % record_length(&items), 0);
    }
}

#[test]
fn memory_is_counted_and_little_at_first() {
    let items = items(2, &[POINT, TIME, RGB]);
    let records = records(&items, 5_000, 2);
    let mut decoder = SequentialDecoder::new(&items);
    let before = decoder.memory_bytes();
    // The laz crate makes 770 models of 2.6 kB of the flags, classes and user data alone.
    assert!(before < 40_000, "{before} bytes");
    decoder.load(compressed(&items, &records), true);
    let _ = decoder.decode(&mut vec![0; records.len()]);
    assert!(decoder.memory_bytes() > before + 20_000, "{} bytes", decoder.memory_bytes());
}

/// Every real file of these formats.
#[test]
fn real_files_are_decoded_as_laz_decodes_them() {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let data = std::env::var_os("FIRSTLIGHT_DATA").map_or(beside, Into::into);
    if !data.is_dir() {
        let _ = writeln!(
            std::io::stderr(),
            "SKIPPED: no real scans: {} is not there (set FIRSTLIGHT_DATA)",
            data.display()
        );
        return;
    }
    let (mut files, mut formats) = (0, [0; 6]);
    for folder in ["scans", "formats", "broken"] {
        for entry in std::fs::read_dir(data.join(folder)).expect("a folder").flatten() {
            let path = entry.path();
            if path.extension().is_none_or(|e| e != "laz") {
                continue;
            }
            let Ok((header, file)) = Header::read(&path) else { continue };
            let Ok(layout) = LazLayout::read(&header, &file, &mut Vec::new(), &AtomicBool::new(false)) else {
                continue;
            };
            if layout.is_layered() || layout.ends_unknown() {
                continue;
            }
            let all = std::fs::read(&path).expect("a file");
            for (n, chunk) in layout.chunks.iter().enumerate().filter(|c| c.1.points > 0).take(4) {
                let bytes = &all[chunk.at as usize..][..chunk.bytes as usize];
                let points = chunk.points.min(50_000) as usize;
                let theirs = by_laz(&layout.items, bytes, points);
                let (ours, _, unused) = at_once(&layout.items, bytes, points);
                assert!(ours == theirs, "{} chunk {n}", path.display());
                if points as u64 == chunk.points && ours.len() == points * header.record_length() {
                    assert!(unused == 0 || !layout.is_exact(n as u64), "{} chunk {n}: {unused}", path.display());
                }
                if n == 0 && ours.len() == points * header.record_length() {
                    let stepped = in_steps(&layout.items, bytes, points, 999, &[0.01, 0.08, 0.5]);
                    assert!(stepped == theirs, "{} in steps", path.display());
                }
            }
            files += 1;
            formats[usize::from(header.format).min(5)] += 1;
        }
    }
    assert!(files >= 20 && formats.iter().all(|&n| n > 0), "{files} files, by format {formats:?}");
}
