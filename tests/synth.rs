//! Test scans: exactly what was asked for, the same everywhere, readable by another reader.

#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a test fails where it stands, and says that it is skipped"
)]

use std::{
    fs,
    io::{Cursor, Seek, SeekFrom},
    path::Path,
};

use firstlight::{
    scene::PointBatch,
    synth::{Generator, PLANES, Scene, SynthError, SynthOptions, SynthPoint, plane_height, plane_side, write},
};
use las::raw::Header;
use laz::{LasZipDecompressor, LazVlr};

fn town(points: u64) -> SynthOptions {
    SynthOptions { points, ..SynthOptions::new(Scene::Town) }
}

/// Every valid pair of version and point format.
fn formats() -> Vec<((u8, u8), u8)> {
    let table: [(u8, &[u8]); 5] =
        [(0, &[0, 1]), (1, &[0, 1]), (2, &[0, 1, 2, 3]), (3, &[0, 1, 2, 3]), (4, &[0, 1, 2, 3, 6, 7, 8])];
    table.iter().flat_map(|(minor, formats)| formats.iter().map(|&f| ((1, *minor), f))).collect()
}

/// Header and uncompressed records of a file, read with `las` and `laz` only.
fn read(path: &Path) -> (Header, Vec<u8>) {
    let mut file = Cursor::new(fs::read(path).unwrap());
    let header = Header::read_from(&mut file).unwrap();
    let count = header.large_file.map_or(u64::from(header.number_of_point_records), |l| l.number_of_point_records);
    let bytes = count as usize * usize::from(header.point_data_record_length);
    let data = header.offset_to_point_data as usize;
    if header.point_data_record_format & 0x80 == 0 {
        let records = file.get_ref()[data..].to_vec();
        assert_eq!(records.len(), bytes, "nothing but the points follows the header");
        return (header, records);
    }
    file.seek(SeekFrom::Start(u64::from(header.header_size))).unwrap();
    let mut vlr = None;
    for _ in 0..header.number_of_variable_length_records {
        let raw = las::raw::Vlr::read_from(&mut file, false).unwrap();
        if raw.record_id == LazVlr::RECORD_ID {
            vlr = Some(LazVlr::from_buffer(&raw.data).unwrap());
        }
    }
    file.seek(SeekFrom::Start(data as u64)).unwrap();
    let mut records = vec![0; bytes];
    if count > 0 {
        LasZipDecompressor::new(file, vlr.unwrap()).unwrap().decompress_many(&mut records).unwrap();
    }
    (header, records)
}

fn position(record: &[u8]) -> [i32; 3] {
    std::array::from_fn(|a| i32::from_le_bytes(record[4 * a..4 * a + 4].try_into().unwrap()))
}

/// Asserts that header and records say what the generator says; returns the records.
fn check(options: &SynthOptions, path: &Path) -> Vec<u8> {
    let summary = write(options, path, &mut |_| {}).unwrap();
    assert_eq!(summary.points, options.points);
    assert_eq!(summary.bytes, fs::metadata(path).unwrap().len());
    let (header, records) = read(path);
    let points: Vec<SynthPoint> = Generator::new(options).unwrap().iter().collect();
    assert_eq!(points.len() as u64, options.points);
    let format = options.point_format;
    let length = usize::from(header.point_data_record_length);
    assert_eq!(records.len(), points.len() * length);
    let mut by_return = [0u64; 15];
    for (record, point) in records.chunks_exact(length).zip(&points) {
        assert_eq!(position(record), point.position);
        assert_eq!(record[12..14], point.intensity.to_le_bytes());
        let returns =
            if format < 6 { [record[14] & 7, record[14] >> 3 & 7] } else { [record[14] & 15, record[14] >> 4] };
        assert_eq!(returns, [point.return_number, point.number_of_returns]);
        by_return[usize::from(returns[0]) - 1] += 1;
        let color_at = match format {
            2 => Some(20),
            3 => Some(28),
            7 | 8 => Some(30),
            _ => None,
        };
        if let Some(at) = color_at {
            assert_eq!(record[at..at + 6], *point.rgb.map(u16::to_le_bytes).concat());
        }
    }
    if let Some(large) = header.large_file {
        assert_eq!(large.number_of_points_by_return, by_return);
    }
    let legacy: u64 = header.number_of_points_by_return.iter().map(|&n| u64::from(n)).sum();
    assert_eq!(legacy, if format < 6 { options.points } else { 0 });
    if !points.is_empty() {
        let extent = |pick: fn(i32, i32) -> i32, axis: usize| {
            let steps = points.iter().map(|p| p.position[axis]).reduce(pick).unwrap();
            f64::from(steps) * options.scale + options.grid().origin[axis]
        };
        assert_eq!([header.min_x, header.min_y, header.min_z], [0, 1, 2].map(|a| extent(i32::min, a)));
        assert_eq!([header.max_x, header.max_y, header.max_z], [0, 1, 2].map(|a| extent(i32::max, a)));
    }
    records
}

#[test]
fn every_format_and_version_reads_back_compressed_and_not() {
    let folder = tempfile::tempdir().unwrap();
    for (las_version, point_format) in formats() {
        let options = SynthOptions { las_version, point_format, ..town(2_001) };
        let plain = check(&options, &folder.path().join("a.las"));
        let packed = check(&options, &folder.path().join("a.LAZ"));
        assert!(plain == packed, "LAS {las_version:?} format {point_format}");
    }
}

#[test]
fn any_count_comes_out_exactly() {
    let folder = tempfile::tempdir().unwrap();
    for points in [0, 1, 2, 3, 5, 49_999, 50_000, 50_001, 100_001] {
        check(&town(points), &folder.path().join("a.laz"));
        let options = SynthOptions { points, point_format: 0, las_version: (1, 0), ..SynthOptions::new(Scene::Planes) };
        check(&options, &folder.path().join("a.las"));
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "no temporary file is left");
}

#[test]
fn chunks_made_in_parallel_are_those_of_a_sequential_writer() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.laz");
    let records = check(&town(150_003), &path);
    let file = fs::read(&path).unwrap();
    let data = Header::read_from(Cursor::new(&file)).unwrap().offset_to_point_data as usize;
    let items = laz::LazItemRecordBuilder::default_for_point_format_id(7, 0).unwrap();
    // The chunk table's offset counts from the start of the file, so the head goes in front here too.
    let mut expected = Cursor::new(file[..data].to_vec());
    expected.seek(SeekFrom::End(0)).unwrap();
    laz::compress_buffer(&mut expected, &records, LazVlr::from_laz_items(items)).unwrap();
    assert!(expected.into_inner() == file);
}

#[test]
fn a_point_does_not_depend_on_how_it_was_made() {
    for scene in [Scene::Town, Scene::Planes] {
        let options = SynthOptions { points: 10_007, ..SynthOptions::new(scene) };
        let generator = Generator::new(&options).unwrap();
        let all: Vec<SynthPoint> = generator.iter().collect();
        assert_eq!(all.len(), 10_007);
        for i in (0..10_007).rev().step_by(37) {
            assert_eq!(generator.point(i), all[i as usize], "{scene:?} point {i}");
        }
        for (first, count) in [(0, 1), (1, 2), (3, 6), (4_095, 3), (9_000, 1_007)] {
            let mut run = vec![SynthPoint::default(); count];
            generator.fill(first, &mut run);
            assert!(run == all[first as usize..][..count], "{scene:?} {count} points from {first}");
        }
        let again: Vec<SynthPoint> = Generator::new(&options).unwrap().iter().collect();
        assert!(again == all);
        let other: Vec<SynthPoint> = Generator::new(&SynthOptions { seed: 2, ..options }).unwrap().iter().collect();
        assert!(other != all, "another seed makes another scan");
    }
}

#[test]
fn a_batch_holds_the_points_and_what_they_say() {
    let generator = Generator::new(&town(5_000)).unwrap();
    let mut batch = PointBatch::default();
    generator.fill_batch(1_000..3_000, &mut batch);
    assert_eq!(batch.len(), 2_000);
    for (k, i) in (1_000..3_000).enumerate() {
        let point = generator.point(i);
        assert_eq!(batch.positions[k], point.position);
        assert_eq!(batch.colors[k][..3], point.rgb);
        assert_eq!(batch.colors[k][3], point.intensity);
        assert_eq!(batch.records[k], i as u32);
        assert!((batch.stats.z_min..=batch.stats.z_max).contains(&point.position[2]));
        assert!(point.rgb.iter().all(|&c| c <= batch.stats.rgb_max));
    }
    assert_eq!(batch.stats.intensity.iter().sum::<u32>(), 125);
}

#[test]
fn a_town_has_what_a_scan_has() {
    let generator = Generator::new(&town(400_000)).unwrap();
    let bounds = generator.bounds();
    let (mut classes, mut returns) = ([0u32; 32], [0u32; 5]);
    let (mut low_bytes, mut last_time) = (std::collections::HashSet::new(), -1.0);
    let mut last: Option<SynthPoint> = None;
    generator.for_each(0..400_000, |p| {
        classes[usize::from(p.classification)] += 1;
        returns[usize::from(p.return_number)] += 1;
        low_bytes.insert(p.rgb[0] & 0xff);
        assert!(p.gps_time >= last_time);
        last_time = p.gps_time;
        assert!((1..=p.number_of_returns).contains(&p.return_number));
        if let Some(before) = last.filter(|_| p.return_number > 1) {
            assert_eq!((before.return_number + 1, before.gps_time), (p.return_number, p.gps_time));
            assert!(before.position[2] > p.position[2], "later returns are lower");
            assert_eq!(before.position[..2], p.position[..2]);
        }
        last = Some(p);
        let world = generator.grid().world(p.position);
        assert!((0..3).all(|a| (bounds.min[a]..=bounds.max[a]).contains(&world[a])), "{world:?} is out of bounds");
    });
    for class in [1, 2, 3, 4, 5, 6, 9] {
        assert!(classes[class] > 200, "class {class}: {} points", classes[class]);
    }
    assert!(returns[1] > returns[2] && returns[2] > returns[3] && returns[3] > returns[4] && returns[4] > 1_000);
    assert!(low_bytes.len() > 200, "colours use all 16 bits");
}

#[test]
fn planes_lie_where_the_documentation_says() {
    let options = SynthOptions { points: 12_000, ..SynthOptions::new(Scene::Planes) };
    let mut extents = [[i32::MAX, i32::MIN]; PLANES as usize];
    for (i, p) in Generator::new(&options).unwrap().iter().enumerate() {
        let plane = i % PLANES as usize;
        assert_eq!(p.position[2], plane_height(plane as u64));
        for x in &p.position[..2] {
            extents[plane] = [extents[plane][0].min(*x), extents[plane][1].max(*x)];
        }
    }
    for (plane, [low, high]) in extents.into_iter().enumerate() {
        let side = plane_side(plane as u64);
        assert!(low >= -side / 2 && high < side / 2 && high - low > side / 100 * 99, "plane {plane}: {low} to {high}");
    }
    assert_eq!([0, 1, 2, 10].map(|p| plane_height(p + 1) - plane_height(p)), [1, 2, 4, 1_024]);
}

#[test]
fn a_shift_moves_the_records_or_the_header_and_nothing_else() {
    let home = SynthOptions { origin: [0.0; 3], scale: 0.01, ..town(3_000) };
    let far = [500_000.0, 5_000_000.0, 0.0];
    let in_header = SynthOptions { origin: far, ..home };
    let in_records = SynthOptions { origin: far, offset: Some([0.0; 3]), ..home };
    let make = |options: &SynthOptions| Generator::new(options).unwrap().iter().collect::<Vec<_>>();
    let base = make(&home);
    assert!(make(&in_header) == base, "the same records under another header offset");
    for (a, b) in base.iter().zip(make(&in_records)) {
        let shift = [50_000_000, 500_000_000, 0];
        assert_eq!(b, SynthPoint { position: [0, 1, 2].map(|k| a.position[k] + shift[k]), ..*a });
    }
    let too_fine = SynthOptions { scale: 0.001, ..in_records };
    let error = Generator::new(&too_fine).err().unwrap();
    assert!(matches!(error, SynthError::Range { axis: 'y', .. }), "{error}");
}

#[test]
fn what_cannot_be_is_refused_with_a_reason_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let valid = formats();
    for minor in 0..=5 {
        for point_format in 0..=11 {
            let options = SynthOptions { las_version: (1, minor), point_format, ..town(1) };
            let is_valid = valid.contains(&((1, minor), point_format));
            assert_eq!(options.check().is_ok(), is_valid, "LAS 1.{minor} format {point_format}");
        }
    }
    let message = |options: SynthOptions, name: &str| {
        write(&options, &folder.path().join(name), &mut |_| {}).unwrap_err().to_string()
    };
    assert!(message(SynthOptions { point_format: 9, ..town(1) }, "a.las").contains("hold waveforms"));
    assert!(message(SynthOptions { las_version: (1, 2), ..town(1) }, "a.las").contains("needs LAS 1.4"));
    let many = SynthOptions { las_version: (1, 2), point_format: 3, ..town(1 << 32) };
    assert!(message(many, "a.las").contains("--las-version 1.4"));
    assert!(message(town(1), "a.txt").contains(".las or .laz"));
    assert!(message(town(1), "nowhere/a.las").contains("creating"));
    assert!(message(SynthOptions { scale: f64::NAN, ..town(1) }, "a.las").contains("grid step"));
    assert!(message(SynthOptions { origin: [f64::NAN; 3], ..town(1) }, "a.las").contains("do not fit"));
    fs::create_dir(folder.path().join("taken.las")).unwrap();
    assert!(message(town(1), "taken.las").contains("renaming"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "only the folder made here");
}

/// Every command that `sample_data/README.md` names makes the committed file, byte for byte.
#[test]
fn sample_data_is_what_its_commands_make() {
    use clap::Parser;
    #[derive(Parser)]
    struct Command {
        #[command(flatten)]
        synth: firstlight::synth::SynthArgs,
    }
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_data");
    let readme = fs::read_to_string(samples.join("README.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut made = Vec::new();
    for line in readme.lines().filter(|line| line.trim_start().starts_with("firstlight synth ")) {
        let args = Command::parse_from(line.split_whitespace().skip(1)).synth;
        let name = args.output.file_name().unwrap().to_owned();
        let path = folder.path().join(&name);
        write(&args.options(), &path, &mut |_| {}).unwrap();
        let is_same = fs::read(&path).unwrap() == fs::read(samples.join(&name)).unwrap();
        assert!(is_same, "{name:?} differs from what its command makes");
        made.push(name);
    }
    let files = fs::read_dir(&samples).unwrap().map(|f| f.unwrap().file_name());
    let scans = files.filter(|f| [".las", ".laz"].iter().any(|e| f.to_string_lossy().ends_with(e)));
    assert_eq!(scans.count(), made.len(), "every sample has its command");
    assert!(made.len() >= 3);
}
