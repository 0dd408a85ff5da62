//! Files broken on purpose: every kind of cut, impossible counts and offsets, flipped bits. Each must
//! end in a clear line, soon, with what came before the fault delivered.

use std::{
    path::PathBuf,
    time::{Duration, Instant},
};

use super::{
    Read,
    made::{As, Random, Scan},
    read,
};
use firstlight::{info::Info, source::SourceError};

/// No input here may take longer: they are all small.
const PATIENCE: Duration = Duration::from_secs(5);

/// A folder to write variants into.
struct Bench {
    dir: tempfile::TempDir,
}

impl Bench {
    fn new() -> Bench {
        Bench { dir: tempfile::tempdir().unwrap() }
    }

    fn read(&self, bytes: &[u8]) -> Result<Read, SourceError> {
        let path: PathBuf = self.dir.path().join("broken.laz");
        std::fs::write(&path, bytes).unwrap();
        let before = Instant::now();
        let result = read(std::slice::from_ref(&path), 2);
        let _ = Info::read(&path).map(|info| info.to_string());
        assert!(before.elapsed() < PATIENCE, "took {:?}", before.elapsed());
        result
    }

    /// Points read and error line.
    fn outcome(&self, bytes: &[u8]) -> (usize, String) {
        match self.read(bytes) {
            Ok(read) => (read.points(), read.error().to_owned()),
            Err(error) => (0, error.to_string()),
        }
    }
}

fn put<const N: usize>(bytes: &mut [u8], at: usize, value: [u8; N]) {
    bytes[at..at + N].copy_from_slice(&value);
}

/// File offset of the point data.
fn data_at(bytes: &[u8]) -> usize {
    u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize
}

/// File offset of the chunk table.
fn table_at(bytes: &[u8]) -> usize {
    u64::from_le_bytes(bytes[data_at(bytes)..][..8].try_into().unwrap()) as usize
}

#[test]
fn las_cut_anywhere_gives_the_whole_records_before_the_cut() {
    let bench = Bench::new();
    let scan = Scan::new(3, 100);
    let bytes = scan.bytes(As::Las);
    for length in (0..bytes.len()).step_by(13).chain([226, 227, 228]) {
        let (points, error) = bench.outcome(&bytes[..length]);
        let whole = length.saturating_sub(227) / 34;
        assert_eq!(points, whole, "cut at {length}: {error}");
        if length >= 227 {
            let expected = format!("{} of 100 points are missing, {whole} are kept: ", 100 - whole);
            assert!(error.starts_with(&expected), "{error}");
            assert!(error.ends_with(&format!("the file ends at byte {length} (in record {whole})")), "{error}");
        } else {
            assert!(error.contains("expected"), "{error}");
        }
    }
}

#[test]
fn laz_cut_anywhere_gives_points_and_a_line() {
    let bench = Bench::new();
    for format in [1, 7] {
        for how in [As::Laz(500), As::LazVarying(200)] {
            let scan = Scan::new(format, 3_000);
            let expected = scan.positions();
            let bytes = scan.bytes(how);
            let (start, table) = (data_at(&bytes), table_at(&bytes));
            let cuts = [100, 230, start - 40, start - 1, start, start + 7, start + 8, start + 30, table - 1, table];
            let spread = (0..12).map(|i| start + (bytes.len() - start) * i / 12);
            let mut most = 0;
            for cut in cuts.into_iter().chain([table + 4, table + 8, bytes.len() - 1]).chain(spread) {
                match bench.read(&bytes[..cut]) {
                    Ok(read) => {
                        let found = read.in_record_order();
                        // The last point or two of a cut stream may be garbage: the decoder reads ahead.
                        // Where the first chunk of unknown size ended, some garbage may pass for points.
                        let lost = format == 1 && how != As::Laz(500) && found.len() < 3_000;
                        let sure = if lost { 200.min(found.len()) } else { found.len() }.saturating_sub(2);
                        let right = found[..sure].iter().all(|(record, p, _)| *p == expected[*record as usize]);
                        assert!(right, "format {format} {how:?} cut at {cut}");
                        assert!(!lost || found.len() < 300, "{} points, most of them garbage", found.len());
                        if found.len() < 3_000 {
                            assert!(read.error().contains("are missing"), "{}", read.error());
                        }
                        most = most.max(found.len());
                    }
                    Err(error) => assert!(error.to_string().contains("expected"), "cut at {cut}: {error}"),
                }
            }
            // Varying chunks of the sequential kind cannot be told apart without their table.
            assert!(most == 3_000 || (format == 1 && how != As::Laz(500)), "format {format} {how:?}: {most}");
        }
    }
}

#[test]
fn impossible_numbers_in_the_header() {
    let bench = Bench::new();
    let las = Scan::new(6, 1_000).bytes(As::Las);
    let with = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = las.clone();
        change(&mut bytes);
        bench.outcome(&bytes)
    };
    let (points, error) = with(&|b| put(b, 247, (1u64 << 63).to_le_bytes()));
    assert_eq!(points, 1_000);
    assert!(error.contains("of 9223372036854775808 points are missing"), "{error}");

    let (points, error) = with(&|b| put(b, 96, u32::MAX.to_le_bytes()));
    assert!(points == 0 && error.contains("the file ends at byte"), "{error}");
    let (_, error) = with(&|b| put(b, 96, 12u32.to_le_bytes()));
    assert!(error.contains("expected the point data behind the header's 375 bytes, found offset 12"), "{error}");
    let (_, error) = with(&|b| put(b, 104, [17]));
    assert!(error.contains("expected point record format 0 to 10 in byte 104, found 17"), "{error}");
    let (_, error) = with(&|b| put(b, 105, 29u16.to_le_bytes()));
    assert!(error.contains("point record format 6 takes at least 30 bytes, the header says 29"), "{error}");
    let (_, error) = with(&|b| put(b, 24, [3, 1]));
    assert!(error.contains("expected LAS version 1.0 to 1.5 in bytes 24 and 25, found 3.1"), "{error}");
    let (_, error) = with(&|b| put(b, 104, [0x86]));
    assert!(error.contains("expected a «laszip encoded» VLR (22204) that says how, found 0 other VLRs"), "{error}");

    // LAS 1.5, absurd VLR counts, an EVLR of 2⁴⁰ bytes: all points are there.
    assert_eq!(with(&|b| put(b, 25, [5])), (1_000, String::new()));
    assert_eq!(with(&|b| put(b, 100, u32::MAX.to_le_bytes())), (1_000, String::new()));
    let evlr = |b: &mut Vec<u8>| {
        let end = b.len() as u64;
        put(b, 235, end.to_le_bytes());
        put(b, 243, u32::MAX.to_le_bytes());
        b.extend([0; 20]);
        b.extend((1u64 << 40).to_le_bytes());
        b.extend([0; 40]);
    };
    assert_eq!(with(&evlr), (1_000, String::new()));

    // Scale, offset and box: never a NaN on the grid.
    for (at, value) in [(131, 0.0), (139, f64::NAN), (155, f64::INFINITY), (179, f64::NAN), (187, -1e300)] {
        let mut bytes = las.clone();
        put(&mut bytes, at, f64::to_le_bytes(value));
        let read = bench.read(&bytes).unwrap();
        assert_eq!(read.points(), 1_000);
        assert!(read.facts.bounds.is_sane(), "{:?}", read.facts.bounds);
        assert!(read.facts.grid.scale.iter().all(|s| s.is_finite() && *s > 0.0));
        assert!(read.facts.grid.origin.iter().all(|o| o.is_finite()));
        assert!(!read.report.files[0].warnings.is_empty(), "byte {at}");
    }
}

/// LAZ with impossible counts and places: an answer or a line, never a wrong point.
#[test]
fn impossible_numbers_in_compressed_files() {
    let bench = Bench::new();
    for format in [1, 7] {
        let scan = Scan::new(format, 3_000);
        let whole = scan.bytes(As::Laz(500));
        let header = if format == 7 { 375 } else { 227 };
        let count = |b: &mut [u8], n: u64| {
            put(b, 107, (n as u32).to_le_bytes());
            if format == 7 {
                put(b, 247, n.to_le_bytes());
            }
        };
        type Change<'a> = &'a dyn Fn(&mut Vec<u8>);
        let cases: [(&str, usize, &str, Change<'_>); 7] = [
            ("2⁶³ points and more", 3_000, "are missing", &|b| count(b, (1 << 63) + u64::from(u32::MAX))),
            ("no points", 0, "", &|b| count(b, 0)),
            ("fewer points", 700, "", &|b| count(b, 700)),
            ("points past the end", 0, "are missing", &|b| put(b, 96, (u32::MAX - 1).to_le_bytes())),
            ("points in the last bytes", 0, "are missing", &|b| put(b, 96, (whole.len() as u32 - 3).to_le_bytes())),
            ("no VLR", 0, "expected a «laszip encoded» VLR", &|b| put(b, 100, 0u32.to_le_bytes())),
            ("a record of 65535 bytes", 0, "expected items of 65535 bytes", &|b| put(b, 105, u16::MAX.to_le_bytes())),
        ];
        for (name, points, line, change) in cases {
            let mut bytes = whole.clone();
            change(&mut bytes);
            let (found, error) = match bench.read(&bytes) {
                Ok(read) => (read.positions_in_order(), read.error().to_owned()),
                Err(error) => (Vec::new(), error.to_string()),
            };
            assert!(found == scan.positions()[..points], "format {format}, {name}: {} points, {error}", found.len());
            assert!(error.contains(line) && error.is_empty() == line.is_empty(), "format {format}, {name}: {error}");
        }
        // What these lead to depends on the bytes they point to: an answer or a line, soon.
        let vlr = header + 20;
        let odd: [Change<'_>; 3] =
            [&|b| put(b, vlr, u16::MAX.to_le_bytes()), &|b| put(b, vlr, 0u16.to_le_bytes()), &|b| {
                put(b, header + 54 + 12, 0u32.to_le_bytes());
            }];
        for (i, change) in odd.iter().enumerate() {
            let mut bytes = whole.clone();
            change(&mut bytes);
            let (points, error) = bench.outcome(&bytes);
            assert!(points == 3_000 || !error.is_empty(), "format {format}, {i}: {points} points and no error");
        }
    }
}

/// Lists of records that overlap, run past the end or into the points cost nothing but a warning.
#[test]
fn records_that_lie_where_they_cannot() {
    let bench = Bench::new();
    let scan = Scan { extra_bytes: 4, ..Scan::new(6, 1_000) };
    let las = scan.bytes(As::Las);
    let read = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = las.clone();
        change(&mut bytes);
        let read = bench.read(&bytes).unwrap();
        assert_eq!((read.points(), read.error()), (1_000, ""));
        assert!(read.positions_in_order() == scan.positions());
        read.report.files[0].warnings.join("; ")
    };
    assert_eq!(read(&|_| ()), "");
    // One VLR in no space at all.
    assert!(read(&|b| put(b, 100, 1u32.to_le_bytes())).contains("expected 1 VLRs, found 0: no room"));
    // EVLRs at, before and behind every border. (In the header itself, its bytes are taken for records.)
    let evlrs = |at: u64, count: u32| {
        read(&|b| {
            put(b, 235, at.to_le_bytes());
            put(b, 243, count.to_le_bytes());
        })
    };
    let end = las.len() as u64;
    for at in [end, end - 59, end + 1, u64::MAX, u64::MAX - 60, 1 << 63] {
        assert!(evlrs(at, 3).contains("expected 3 EVLRs, found 0: no room for another one"), "{at}");
    }
    for at in [1, 100, 374, 375, end / 2, end - 60] {
        assert!(!evlrs(at, u32::MAX).is_empty(), "{at}");
    }
    // Two that claim each other's bytes: the first one's length is beyond everything.
    for length in [1u64 << 40, u64::MAX, u64::MAX - 70] {
        let told = read(&|b| {
            let at = b.len() as u64;
            put(b, 235, at.to_le_bytes());
            put(b, 243, 2u32.to_le_bytes());
            for _ in 0..2 {
                let from = b.len();
                b.resize(from + 60, 0);
                put(b, from + 20, length.to_le_bytes());
            }
        });
        assert!(told.contains(&format!("EVLR 0 says {length} bytes")) && told.contains("only 60 are there"), "{told}");
    }
    // A waveform's start anywhere.
    for at in [1, 375, end - 1, end + 1, u64::MAX] {
        read(&|b| put(b, 227, at.to_le_bytes()));
    }
}

/// A few bytes of layered LAZ can stand for gigabytes of extra bytes: they are left out, with a line.
#[test]
fn too_many_extra_bytes_are_left_out() {
    let bench = Bench::new();
    for (extra_bytes, read) in [(1_024, true), (1_025, false)] {
        let scan = Scan { extra_bytes, ..Scan::new(6, 20) };
        for how in [As::Las, As::Laz(10)] {
            let found = bench.read(&scan.bytes(how)).unwrap();
            assert!(found.positions_in_order() == scan.positions() && found.error().is_empty());
            let told = found.report.files[0].warnings.join("; ");
            assert_eq!(told.is_empty(), read, "{told}");
            assert_eq!(found.batches[0].attributes.extra.is_empty(), !read);
            assert!(read || told.contains("1025 extra bytes per point are not read: expected 1024 at most"));
        }
    }
}

#[test]
fn more_points_than_record_numbers() {
    let bench = Bench::new();
    // A point-wise file can claim any number of points.
    let mut bytes = Scan::new(0, 50).bytes(As::Laz(1_000));
    let vlr_at = 227 + 54;
    put(&mut bytes, vlr_at, 1u16.to_le_bytes());
    put(&mut bytes, 107, u32::MAX.to_le_bytes());
    assert!(bench.outcome(&bytes).1.contains("are missing"));
    let path = bench.dir.path().join("broken.laz");
    let second = bench.dir.path().join("second.las");
    std::fs::write(&second, Scan::new(0, 50).bytes(As::Las)).unwrap();
    let read = read(&[path, second], 2).unwrap();
    let error = read.report.files[1].error.as_deref().unwrap();
    assert!(error.contains("50 points after 4294967295 others: a scene holds at most 4294967295"), "{error}");
}

#[test]
fn broken_chunk_tables() {
    let bench = Bench::new();
    for format in [1, 7] {
        for how in [As::Laz(500), As::LazVarying(200)] {
            let whole = Scan::new(format, 3_000).bytes(how);
            let (start, table) = (data_at(&whole), table_at(&whole));
            // Without a table, only sequential chunks of unknown size cannot be told apart.
            let all = if format == 1 && how != As::Laz(500) { 200 } else { 3_000 };
            let mut variants: Vec<(&str, Vec<u8>)> = Vec::new();
            let mut variant = |name, change: &dyn Fn(&mut Vec<u8>)| {
                let mut bytes = whole.clone();
                change(&mut bytes);
                variants.push((name, bytes));
            };
            variant("count 2³²−1", &|b| put(b, table + 4, u32::MAX.to_le_bytes()));
            variant("position past the end", &|b| put(b, start, (1u64 << 40).to_le_bytes()));
            variant("position −1, none at the end", &|b| put(b, start, (-1i64).to_le_bytes()));
            variant("position at the start", &|b| put(b, start, (start as u64 + 8).to_le_bytes()));
            variant("noise in the entries", &|b| b[table + 8..].fill(0xa5));
            for (name, bytes) in variants {
                let read = bench.read(&bytes).unwrap();
                let warnings = read.report.files[0].warnings.join("; ");
                assert!(read.points() >= all, "format {format} {how:?} {name}: {} {}", read.points(), read.error());
                assert!(!warnings.is_empty(), "format {format} {how:?} {name}");
            }
            // −1, and the position at the file's end, is what a writer to a pipe leaves: no fault at all.
            let mut piped = whole.clone();
            put(&mut piped, start, (-1i64).to_le_bytes());
            piped.extend((table as u64).to_le_bytes());
            let read = bench.read(&piped).unwrap();
            assert_eq!((read.points(), read.error(), read.report.files[0].warnings.len()), (3_000, "", 0));
        }
    }
}

#[test]
fn one_broken_chunk_does_not_take_the_others_with_it() {
    let bench = Bench::new();
    let mut bytes = Scan::new(7, 200_000).bytes(As::Laz(50_000));
    // The first layer's size in the first chunk: behind the table's position, a record and the count.
    let layer = data_at(&bytes) + 8 + 36 + 4;
    put(&mut bytes, layer, u32::MAX.to_le_bytes());
    let read = bench.read(&bytes).unwrap();
    // The broken chunk's first record is stored raw.
    assert_eq!(read.points(), 150_001);
    let records: Vec<u32> = read.in_record_order().iter().map(|p| p.0).collect();
    assert_eq!((records[0], records[1]), (0, 50_000), "record numbers stay those of the file");
    let error = read.error();
    assert!(error.starts_with("49999 of 200000 points are missing, 150001 are kept: chunk 0 (bytes "), "{error}");
    assert!(error.contains("its layers add up to"), "{error}");
}

/// Flips a few bits or bytes at random places, hundreds of times: whatever comes of it, it comes soon
/// and as a line. Where it struck the header, even an enormous claim must not cost memory.
#[test]
fn flipped_bits_never_panic_hang_or_eat_memory() {
    let bench = Bench::new();
    let mut random = Random(0x5eed);
    let mut faults = 0;
    let mut caught = 0;
    let variants = std::env::var("FIRSTLIGHT_FUZZ").map_or(60, |n| n.parse().expect("a number"));
    for (format, extra_bytes) in [(0, 0), (3, 2), (6, 0), (7, 5), (8, 0)] {
        for how in [As::Laz(300), As::LazVarying(70)] {
            let whole = Scan { extra_bytes, ..Scan::new(format, 1_000) }.bytes(how);
            for variant in 0..variants {
                let mut bytes = whole.clone();
                let start = if variant % 3 == 0 { 24 } else { data_at(&bytes) };
                for _ in 0..1 + random.below(4) {
                    let at = start + random.below((bytes.len() - start) as u64) as usize;
                    match variant % 4 {
                        0 => bytes[at] = 0xff,
                        _ => bytes[at] ^= 1 << random.below(8),
                    }
                }
                let (points, error) = bench.outcome(&bytes);
                assert!(!error.contains('\n'), "{error}");
                caught += usize::from(error.contains("its bytes make no sense"));
                faults += usize::from(points != 1_000 || !error.is_empty());
            }
        }
    }
    println!("{faults} variants had an effect, {caught} panics were caught");
    assert!(faults > 100, "only {faults} of {} variants had any effect", 10 * variants);
    if let Some(peak) = peak_memory() {
        assert!(peak < 1 << 30, "{peak} bytes at the most");
    }
}

/// Panics that are caught and reported must not be printed as well.
#[test]
fn caught_panics_are_silent() {
    let this = std::env::current_exe().unwrap();
    let test = "broken::flipped_bits_never_panic_hang_or_eat_memory";
    let output = std::process::Command::new(this).args(["--exact", test, "--nocapture"]).output().unwrap();
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && out.contains("1 passed"), "{out}{err}");
    assert!(!err.contains("panicked"), "{err}");
}

/// The most memory that this process ever had, in bytes, where the system says so.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kib| kib * 1024)
}
