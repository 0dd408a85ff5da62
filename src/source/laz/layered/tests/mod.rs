//! The layered decoder against the laz crate's, byte for byte: real files, made ones, in pieces, with
//! parts of the bytes, and damaged.

#![allow(clippy::unwrap_used, reason = "a test fails where it stands")]

use super::{Decoded, End, Fields, LayeredDecoder};
use chunks::{Chunk, Random, Recipe, field_sets, real};

mod chunks;

/// A decoder with the chunk open and all its layers loaded.
fn loaded(chunk: &Chunk, fields: Fields) -> LayeredDecoder {
    let mut decoder = LayeredDecoder::new(&chunk.items, fields);
    let head = LayeredDecoder::head_bytes(&chunk.items).min(chunk.bytes.len());
    decoder.open(&chunk.bytes[..head], chunk.bytes.len() as u64).unwrap();
    load(&mut decoder, chunk, |size| size);
    decoder
}

/// Loads the part of each layer that `part` says, of its bytes that are there.
fn load(decoder: &mut LayeredDecoder, chunk: &Chunk, part: impl Fn(usize) -> usize) {
    for (layer, range) in decoder.layers().collect::<Vec<_>>() {
        let bytes = &chunk.bytes[range.start as usize..range.end as usize];
        let part = part(bytes.len()).min(bytes.len());
        decoder.load(layer, bytes[..part].to_vec(), part == bytes.len());
    }
}

/// All of a chunk's records, and how it ended.
fn decoded(decoder: &mut LayeredDecoder, chunk: &Chunk) -> (Vec<u8>, Decoded) {
    let mut records = vec![0; chunk.points * chunk.record_length()];
    let end = decoder.decode(&mut records);
    (records, end)
}

/// Where two runs of records differ first: record and byte.
fn difference(chunk: &Chunk, a: &[u8], b: &[u8]) -> Option<(usize, usize)> {
    assert_eq!(a.len(), b.len());
    let at = a.iter().zip(b).position(|(a, b)| a != b)?;
    Some((at / chunk.record_length(), at % chunk.record_length()))
}

fn compare_with_laz(chunk: &Chunk, fields: Fields) {
    let (theirs, good) = chunk.by_laz(fields);
    assert_eq!(good, chunk.points, "{}", chunk.name);
    let mut decoder = loaded(chunk, fields);
    assert_eq!(decoder.points() as usize, chunk.points, "{}", chunk.name);
    let (ours, end) = decoded(&mut decoder, chunk);
    assert_eq!(end, Decoded { records: chunk.points, end: End::Filled }, "{}, {fields:?}", chunk.name);
    assert_eq!(difference(chunk, &ours, &theirs), None, "{}, {fields:?}", chunk.name);
    assert_eq!(decoder.unused(), 0, "{}, {fields:?}", chunk.name);
}

fn recipes(points: usize) -> Vec<Recipe> {
    let mut all = Vec::new();
    for format in 6..=10 {
        for version in [3, 4] {
            for channels in [1, 2, 4] {
                let extra_bytes = (u16::from(format) + version + channels as u16) % 4;
                let seed = all.len() as u64 + 1;
                all.push(Recipe { format, version, channels, extra_bytes, points, seed });
            }
        }
    }
    all
}

#[test]
fn real_chunks_decode_as_with_laz() {
    for (i, chunk) in real(60_000).iter().enumerate() {
        compare_with_laz(chunk, Fields::ALL);
        let sets = field_sets();
        // Small COPC nodes are many alike: one set each; the others all.
        if chunk.points < 2_000 {
            compare_with_laz(chunk, sets[i % sets.len()]);
        } else {
            sets.into_iter().for_each(|fields| compare_with_laz(chunk, fields));
        }
    }
}

#[test]
fn made_chunks_decode_to_what_was_written() {
    for recipe in recipes(1_500) {
        let chunk = recipe.chunk();
        let (ours, _) = decoded(&mut loaded(&chunk, Fields::ALL), &chunk);
        assert_eq!(difference(&chunk, &ours, &recipe.records()), None, "{recipe:?}");
        field_sets().into_iter().for_each(|fields| compare_with_laz(&chunk, fields));
    }
    for points in [1, 2, 3] {
        for recipe in recipes(points) {
            compare_with_laz(&recipe.chunk(), Fields::ALL);
        }
    }
}

#[test]
fn a_changed_byte_is_a_difference() {
    let recipe = recipes(700)[17];
    let chunk = recipe.chunk();
    let (ours, _) = decoded(&mut loaded(&chunk, Fields::ALL), &chunk);
    for at in [0, 5, 35, ours.len() - 1] {
        let mut changed = ours.clone();
        changed[at] ^= 1;
        let found = difference(&chunk, &ours, &changed);
        assert_eq!(found, Some((at / chunk.record_length(), at % chunk.record_length())));
    }
    // The versions differ in how other items follow the channels: read as the other, it is not the same.
    let other = Recipe { version: 7 - recipe.version, ..recipe }.chunk();
    let mistaken = Chunk { items: other.items, ..recipe.chunk() };
    let (wrong, _) = decoded(&mut loaded(&mistaken, Fields::ALL), &mistaken);
    assert!(difference(&chunk, &ours, &wrong).is_some());
    // Values that stay from the first record are not those of the file.
    let (first, _) = decoded(&mut loaded(&chunk, Fields::NONE), &chunk);
    assert!(difference(&chunk, &ours, &first).is_some());
}

/// Decodes in pieces of `piece` points, with `part` of each layer's bytes in 100 first, then ever more;
/// the bytes are taken away and put back before each piece if `away`.
fn in_pieces(chunk: &Chunk, piece: usize, part: usize, away: bool) -> Vec<u8> {
    let mut decoder = loaded(chunk, Fields::ALL);
    let mut percent = part;
    let mut spare = Vec::new();
    let mut records = vec![0; chunk.points * chunk.record_length()];
    let (mut done, mut all_at_once) = (0, 0);
    load(&mut decoder, chunk, |size| size * percent / 100);
    while done < chunk.points {
        if away {
            decoder.unload(&mut spare);
            assert!(spare.drain(..).all(|bytes| !bytes.is_empty() || percent < 100));
            let nothing = decoder.decode(&mut records[done * chunk.record_length()..][..chunk.record_length()]);
            assert!(nothing.end == End::NeedsBytes && nothing.records == 0 || done == 0);
            done += nothing.records;
            load(&mut decoder, chunk, |size| size * percent / 100);
        }
        let until = chunk.points.min(done + piece) * chunk.record_length();
        let got = decoder.decode(&mut records[done * chunk.record_length()..until]);
        done += got.records;
        match got.end {
            End::Filled => {}
            End::NeedsBytes => {
                assert!(percent < 100, "{}: asks for more than there is", chunk.name);
                all_at_once = done;
                percent = (percent * 2).min(100);
                load(&mut decoder, chunk, |size| size * percent / 100);
            }
            End::Fault(what) => panic!("{}: {what}", chunk.name),
        }
    }
    assert!(part == 100 || all_at_once > 0, "{}: the whole chunk from a part of its bytes", chunk.name);
    assert_eq!(decoder.unused(), 0);
    records
}

#[test]
fn pieces_and_parts_give_the_same_records() {
    let mut chunks: Vec<Chunk> = recipes(2_500).into_iter().step_by(4).map(|r| r.chunk()).collect();
    chunks.extend(real(1).into_iter().filter(|c| (5_000..60_000).contains(&c.points)));
    for chunk in &chunks {
        let (whole, _) = decoded(&mut loaded(chunk, Fields::ALL), chunk);
        for part in [1, 8, 50, 100] {
            for piece in [7, 1_000, 50_000] {
                let away = piece == 1_000;
                assert_eq!(difference(chunk, &in_pieces(chunk, piece, part, away), &whole), None, "{}", chunk.name);
            }
        }
        for piece in [1, 2] {
            assert_eq!(difference(chunk, &in_pieces(chunk, piece, 100, false), &whole), None, "{}", chunk.name);
        }
    }
}

#[test]
fn a_tenth_of_the_bytes_is_nearly_a_tenth_of_the_points() {
    for chunk in real(1).iter().filter(|c| c.points > 30_000) {
        let mut decoder = loaded(chunk, Fields::COLORS);
        load(&mut decoder, chunk, |size| size / 10);
        let (_, got) = decoded(&mut decoder, chunk);
        assert_eq!(got.end, End::NeedsBytes);
        assert!(got.records > chunk.points / 40, "{}: {} of {}", chunk.name, got.records, chunk.points);
    }
}

#[test]
fn only_wanted_layers_are_asked_for() {
    let recipe = Recipe { format: 8, version: 4, channels: 2, extra_bytes: 2, points: 400, seed: 3 };
    let chunk = recipe.chunk();
    let numbers = |fields| loaded(&chunk, fields).layers().map(|(number, _)| number).collect::<Vec<_>>();
    assert_eq!(numbers(Fields::ALL), (0..13).collect::<Vec<_>>());
    assert_eq!(numbers(Fields::NONE), [0, 1]);
    assert_eq!(numbers(Fields::COLORS), [0, 1, 4, 9]);
    assert_eq!(numbers(Fields { nir: true, extra_bytes: true, ..Fields::NONE }), [0, 1, 10, 11, 12]);
    // One after the other, up to the chunk's last byte.
    let ranges: Vec<_> = loaded(&chunk, Fields::ALL).layers().map(|(_, range)| range).collect();
    assert_eq!(ranges[0].start as usize, LayeredDecoder::head_bytes(&chunk.items));
    assert!(ranges.windows(2).all(|pair| pair[0].end == pair[1].start));
    assert_eq!(ranges[12].end as usize, chunk.bytes.len());
}

#[test]
fn a_decoder_is_small_and_serves_many_chunks() {
    let chunks = recipes(300).into_iter().filter(|r| r.format == 7 && r.version == 3 && r.extra_bytes == 0);
    for recipe in chunks {
        let (chunk, other) = (recipe.chunk(), Recipe { seed: 77, ..recipe }.chunk());
        let mut decoder = loaded(&chunk, Fields::COLORS);
        let before = decoder.memory_bytes();
        assert!(before < 16 << 10, "{before} bytes before the first point");
        let (_, end) = decoded(&mut decoder, &chunk);
        assert_eq!(end.end, End::Filled);
        assert!((before..1 << 20).contains(&decoder.memory_bytes()), "{}", decoder.memory_bytes());
        decoder.open(&other.bytes[..LayeredDecoder::head_bytes(&other.items)], other.bytes.len() as u64).unwrap();
        load(&mut decoder, &other, |size| size);
        let (ours, _) = decoded(&mut decoder, &other);
        assert_eq!(difference(&other, &ours, &other.by_laz(Fields::COLORS).0), None);
    }
}

#[test]
fn heads_that_make_no_sense_are_refused() {
    let chunk = Recipe { format: 7, version: 3, channels: 1, extra_bytes: 0, points: 50, seed: 1 }.chunk();
    let head = LayeredDecoder::head_bytes(&chunk.items);
    let length = chunk.bytes.len() as u64;
    let refused = |items: &[laz::LazItem], head: &[u8], length: u64| {
        let mut decoder = LayeredDecoder::new(items, Fields::ALL);
        let error = decoder.open(head, length).unwrap_err();
        let mut record = [0; 100];
        let got = decoder.decode(&mut record[..chunk.record_length()]);
        assert_eq!(got, Decoded { records: 0, end: End::Fault(error.clone()) });
        assert_eq!(decoder.layers().count(), 0);
        error
    };
    assert!(refused(&chunk.items, &chunk.bytes[..head - 1], length).contains("too few"));
    assert!(refused(&chunk.items, &chunk.bytes[..head], length - 1).contains("add up"));
    let mut bytes = chunk.bytes.clone();
    bytes[36 + 4 + 3] ^= 0x80;
    assert!(refused(&chunk.items, &bytes[..head], length).contains("add up"));
    assert!(refused(&chunk.items[1..], &chunk.bytes[..head], length).contains("item 0"));
    assert!(refused(&[], &chunk.bytes[..head], length).contains("version 0"));
    let mixed = Recipe { format: 7, version: 4, channels: 1, extra_bytes: 0, points: 1, seed: 1 }.chunk().items;
    assert!(refused(&[chunk.items[0], mixed[1]], &chunk.bytes[..head], length).contains("version 4"));
    // What lies behind the layers is not read, but seen.
    let mut decoder = LayeredDecoder::new(&chunk.items, Fields::ALL);
    decoder.open(&chunk.bytes[..head], length + 9).unwrap();
    load(&mut decoder, &chunk, |size| size);
    decoded(&mut decoder, &chunk);
    assert_eq!(decoder.unused(), 9);
}

/// What becomes of a damaged chunk: as far as laz decodes it, we decode the same.
fn survive(chunk: &Chunk, fields: Fields) -> Result<u64, String> {
    let mut decoder = LayeredDecoder::new(&chunk.items, fields);
    let head = LayeredDecoder::head_bytes(&chunk.items).min(chunk.bytes.len());
    decoder.open(&chunk.bytes[..head], chunk.bytes.len() as u64)?;
    load(&mut decoder, chunk, |size| size);
    let (ours, end) = decoded(&mut decoder, chunk);
    let (theirs, good) = chunk.by_laz(fields);
    // Laz goes on where no encoder's bytes could lead, and decodes a few points of an empty first layer.
    let first_is_empty = decoder.layers().any(|(layer, range)| layer == 0 && range.is_empty());
    let odd = first_is_empty || matches!(&end.end, End::Fault(what) if what.contains("no sense"));
    let same = end.records.min(good) * chunk.record_length();
    assert_eq!(difference(chunk, &ours[..same], &theirs[..same]), None, "{}", chunk.name);
    assert!(odd || end.records >= good, "{}: {end:?}, but laz decodes {good}", chunk.name);
    assert_eq!(end.end == End::Filled, end.records == chunk.points);
    // It stays so.
    if let End::Fault(_) = end.end {
        let again = decoder.decode(&mut vec![0; chunk.record_length()]);
        assert_eq!(again, Decoded { records: 0, end: end.end.clone() });
    }
    match end.end {
        End::Fault(what) => Err(what),
        _ => Ok(decoder.unused()),
    }
}

/// A damaged chunk read in parts comes to the same records and the same end as read at once.
fn compare_in_parts(chunk: &Chunk) {
    let mut decoder = LayeredDecoder::new(&chunk.items, Fields::ALL);
    let head = LayeredDecoder::head_bytes(&chunk.items);
    if decoder.open(&chunk.bytes[..head], chunk.bytes.len() as u64).is_err() {
        return;
    }
    let mut records = vec![0; chunk.points * chunk.record_length()];
    let mut done = 0;
    let mut end = End::NeedsBytes;
    for percent in [0, 3, 10, 40, 100] {
        load(&mut decoder, chunk, |size| size * percent / 100);
        let got = decoder.decode(&mut records[done * chunk.record_length()..]);
        (done, end) = (done + got.records, got.end);
    }
    let (whole, at_once) = decoded(&mut loaded(chunk, Fields::ALL), chunk);
    // A part may end with a fault that the whole has, too, but says so again at each call.
    assert_eq!((done, &end), (at_once.records, &at_once.end), "{}", chunk.name);
    let same = done * chunk.record_length();
    assert_eq!(difference(chunk, &records[..same], &whole[..same]), None, "{}", chunk.name);
}

#[test]
fn damaged_chunks_decode_as_far_as_with_laz() {
    let mut random = Random(12_345);
    let (mut faults, mut left, mut unseen) = (0, 0, 0);
    for recipe in recipes(600) {
        for _ in 0..25 {
            let mut chunk = recipe.chunk();
            // Not the first record's bytes: whatever they are, they are a record.
            let start = chunk.record_length() as u64;
            for _ in 0..=random.below(3) {
                let at = start + random.below(chunk.bytes.len() as u64 - start);
                chunk.bytes[at as usize] ^= 1 << random.below(8);
            }
            compare_in_parts(&chunk);
            match survive(&chunk, Fields::ALL) {
                Err(_) => faults += 1,
                Ok(0) => unseen += 1,
                Ok(_) => left += 1,
            }
        }
        // Cut anywhere, and read to the end of what is there.
        let whole = recipe.chunk();
        for _ in 0..10 {
            let cut = random.below(whole.bytes.len() as u64) as usize;
            let chunk = Chunk {
                bytes: whole.bytes[..cut].to_vec(),
                items: whole.items.clone(),
                name: String::new(),
                points: 600,
            };
            assert!(survive(&chunk, Fields::ALL).is_err());
        }
        // Random bytes all over.
        let mut chunk = recipe.chunk();
        let head = LayeredDecoder::head_bytes(&chunk.items);
        chunk.bytes[head..].iter_mut().for_each(|byte| *byte = random.below(256) as u8);
        let _ = survive(&chunk, Fields::ALL);
    }
    // The check of unused bytes is worth something: most damage that decodes is seen by it.
    assert!(faults > 100 && left > unseen, "{faults} faults, {left} with bytes left, {unseen} unseen");
}
