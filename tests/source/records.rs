//! Single records, read back by their number, held to an independent reader (tests/reference/laspy_records.py) and to
//! the columns that a stream gives.

use std::{
    collections::{BTreeSet, HashMap},
    path::Path,
    sync::atomic::AtomicBool,
    time::Instant,
};

use firstlight::{
    inspect::{PointRecord, Value},
    source::{RecordError, RecordFile},
    synth::{Scene, SynthOptions, write},
};

use super::{data, read};

static NEVER: AtomicBool = AtomicBool::new(false);

fn record_of(path: &Path, record: u64) -> Result<PointRecord, RecordError> {
    PointRecord::read(path, record, &NEVER)
}

/// Equal text; or, but for coordinates, the same number in other words (1e-05 for 0.00001).
fn is_same(name: &str, found: &str, expected: &str) -> bool {
    let number = |text: &str| text.parse::<f64>().ok().map(f64::to_bits);
    found == expected
        || (!matches!(name, "x" | "y" | "z") && number(found).is_some_and(|n| Some(n) == number(expected)))
}

#[test]
fn every_field_is_that_of_an_independent_reader() {
    let Some(data) = data() else { return };
    let mut formats = BTreeSet::new();
    let (mut records, mut fields) = (0, 0);
    for line in include_str!("../reference/records.tsv").lines().filter(|line| !line.starts_with('#')) {
        let mut cells = line.split('\t');
        let (name, record) = (cells.next().unwrap(), cells.next().unwrap());
        let found = record_of(&data.join(name), record.parse().unwrap()).unwrap();
        formats.insert((found.format, name.ends_with("laz")));
        let values: HashMap<String, String> = (found.fields().into_iter())
            .map(|field| match field.value {
                Value::Number(text) | Value::Text(text) => (field.name, text),
                Value::Flag(flag) => (field.name, u8::from(flag).to_string()),
                Value::None => (field.name, String::new()),
            })
            .collect();
        for (key, expected) in cells.map(|cell| cell.split_once('=').unwrap()) {
            let value = values.get(key).unwrap_or_else(|| panic!("{name}, record {record}: no {key} in {values:?}"));
            assert!(is_same(key, value, expected), "{name}, record {record}, {key}: {value} is not {expected}");
            fields += 1;
        }
        records += 1;
    }
    assert!(records > 250 && fields > 5_000, "{records} records, {fields} fields");
    // Formats 9 and 10 of LAZ are in one file each, of format 10 with laspy.
    assert!((0..=10).all(|format| formats.contains(&(format, false))), "{formats:?}");
    assert!((0..=10).all(|format| formats.contains(&(format, true))), "{formats:?}");
    assert!(!is_same("x", "1.50", "1.5") && is_same("gps_time", "0.00001", "1e-05") && !is_same("user_data", "1", "2"));
}

/// Through chunks, streams without chunks, and items of any version: what a stream gives of each record.
#[test]
fn a_record_alone_is_the_record_of_the_stream() {
    let Some(data) = data() else { return };
    for folder in ["formats", "broken"] {
        for entry in std::fs::read_dir(data.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let Ok(all) = read(std::slice::from_ref(&path), 2) else {
                assert!(record_of(&path, 0).is_err(), "{}", path.display());
                continue;
            };
            // On one grid, positions are the stored integers.
            let points = all.in_record_order();
            let file = RecordFile::open(&path, &NEVER).unwrap();
            for at in [0, points.len() / 2, points.len().saturating_sub(1)] {
                let Some((record, position, [red, green, blue, intensity])) = points.get(at) else { continue };
                let found = PointRecord::read_from(&file, u64::from(*record), &NEVER).unwrap();
                assert_eq!((found.xyz, found.intensity), (*position, *intensity), "{} {record}", path.display());
                assert_eq!(found.rgb.unwrap_or_default(), [*red, *green, *blue], "{} {record}", path.display());
            }
            // Damaged files: what the stream leaves out cannot be read either, and one line says why.
            let promised = all.facts.files[0].points_in_header;
            if (points.len() as u64) < promised {
                let error = file.read(promised - 1, &NEVER).unwrap_err();
                assert!(matches!(error, RecordError::Damaged { .. }), "{error}");
                assert_eq!(error.to_string().lines().count(), 1);
            }
            let beyond = file.read(promised, &NEVER).unwrap_err();
            assert!(matches!(beyond, RecordError::OutOfRange { points, .. } if points == promised), "{beyond}");
        }
    }
}

#[test]
fn a_record_of_a_large_chunk_comes_at_once_and_can_be_cancelled() {
    let dir = tempfile::tempdir().unwrap();
    for (name, compress) in [("a.las", false), ("a.laz", true)] {
        let path = dir.path().join(name);
        let options = SynthOptions { points: 120_000, ..SynthOptions::new(Scene::Town) };
        write(&options, &path, &mut |_| {}).unwrap();
        let file = RecordFile::open(&path, &NEVER).unwrap();
        let started = Instant::now();
        let last_of_chunk = file.read(99_999, &NEVER).unwrap();
        let took = started.elapsed();
        let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("{name}, record 99,999: {took:.1?}\n"));
        assert_eq!(last_of_chunk.len(), 36);
        // 15 ms with optimization; the tests have less of it, and other work to do.
        assert!(took.as_secs_f64() < 0.5, "{name}: {took:?}");
        if compress {
            let cancelled = file.read(99_999, &AtomicBool::new(true)).unwrap_err();
            assert!(matches!(cancelled, RecordError::Cancelled { record: 99_999, .. }), "{cancelled}");
        }
    }
}

#[test]
fn a_file_that_became_shorter_says_so() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["a.las", "a.laz"] {
        let path = dir.path().join(name);
        let options = SynthOptions { points: 5_000, ..SynthOptions::new(Scene::Planes) };
        write(&options, &path, &mut |_| {}).unwrap();
        let file = RecordFile::open(&path, &NEVER).unwrap();
        let length = std::fs::metadata(&path).unwrap().len();
        std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(length / 2).unwrap();
        let error = file.read(4_999, &NEVER).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains("record 4999 cannot be read: "), "{error}");
        assert_eq!(error.lines().count(), 1);
    }
}
