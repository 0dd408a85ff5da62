//! What is said of files: versions, flags, extra bytes, counts, coordinate systems.

use firstlight::{
    info::Info,
    scene::{ExtraKind, GpsClock, Number},
};

use super::{
    data,
    made::{As, Scan},
    read,
};

fn put<const N: usize>(bytes: &mut [u8], at: usize, value: [u8; N]) {
    bytes[at..at + N].copy_from_slice(&value);
}

fn info(bytes: &[u8]) -> Info {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scan.las");
    std::fs::write(&path, bytes).unwrap();
    Info::read(&path).unwrap()
}

/// Puts bytes between the header and what follows it, and makes both offsets right.
fn insert(bytes: &mut Vec<u8>, at: usize, what: &[u8]) {
    let data_at = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) + what.len() as u32;
    put(bytes, 96, data_at.to_le_bytes());
    bytes.splice(at..at, what.iter().copied());
}

/// A variable length record.
fn vlr(user_id: &str, record_id: u16, body: &[u8]) -> Vec<u8> {
    let mut vlr = vec![0, 0];
    vlr.extend(user_id.as_bytes());
    vlr.resize(18, 0);
    vlr.extend(record_id.to_le_bytes());
    vlr.extend((body.len() as u16).to_le_bytes());
    vlr.resize(54, 0);
    vlr.extend(body);
    vlr
}

/// Inserts a record as the first one of a LAS 1.2 or 1.4 file.
fn add_vlr(bytes: &mut Vec<u8>, user_id: &str, record_id: u16, body: &[u8]) {
    let header = usize::from(u16::from_le_bytes([bytes[94], bytes[95]]));
    insert(bytes, header, &vlr(user_id, record_id, body));
    let count = u32::from_le_bytes(bytes[100..104].try_into().unwrap()) + 1;
    put(bytes, 100, count.to_le_bytes());
}

/// LAS 1.5: 18 bytes more, and flags.
fn as_1_5(mut bytes: Vec<u8>) -> Vec<u8> {
    put(&mut bytes, 24, [1, 5]);
    put(&mut bytes, 94, 393u16.to_le_bytes());
    let mut more = Vec::new();
    more.extend(431_999.5f64.to_le_bytes());
    more.extend(0.25f64.to_le_bytes());
    more.extend(1_300u16.to_le_bytes());
    insert(&mut bytes, 375, &more);
    bytes
}

#[test]
fn las_1_5_is_read_and_described() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scan.laz");
    for how in [As::Las, As::Laz(300)] {
        let scan = Scan::new(7, 1_000);
        let mut bytes = as_1_5(scan.bytes(how));
        if how != As::Las {
            // The chunk table moved along.
            let data_at = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize;
            let table = u64::from_le_bytes(bytes[data_at..data_at + 8].try_into().unwrap()) + 18;
            put(&mut bytes, data_at, table.to_le_bytes());
        }
        put(&mut bytes, 6, 0b101_1001u16.to_le_bytes());
        put(&mut bytes, 255, 1_000u64.to_le_bytes());
        std::fs::write(&path, &bytes).unwrap();
        let read = read(std::slice::from_ref(&path), 2).unwrap();
        assert_eq!((read.points(), read.error(), read.report.files[0].warnings.len()), (1_000, "", 0), "{how:?}");
        assert!(read.positions_in_order() == scan.positions(), "{how:?}");
        let info = Info::read(&path).unwrap();
        let times = info.gps_times.unwrap();
        assert_eq!((times.max, times.min, times.offset), (431_999.5, 0.25, 1_300));
        let told = &info.global_encoding;
        assert!(told.standard_gps_time && told.offset_gps_time && told.synthetic_returns && told.crs_is_wkt);
        assert!(!told.waveforms_inside && !told.waveforms_beside);
        let text = info.to_string();
        assert!(text.contains("encoding   89 (offset GPS time, synthetic returns, CRS is WKT)"), "{text}");
        assert!(
            text.contains("gps time   0.25 to 431999.5, offset 1300 million s (2021-03-17 07:06:22.25 UTC to "),
            "{text}"
        );
        assert_eq!(info.gps_clock, Some(GpsClock::Standard { offset_secs: 1_300_000_000 }));
        assert_eq!(info.warnings, [""; 0]);
    }
}

#[test]
fn a_1_5_header_that_is_too_short_or_of_an_old_format_is_said() {
    let mut short = Scan::new(6, 10).bytes(As::Las);
    put(&mut short, 24, [1, 5]);
    let warnings = info(&short).warnings.join("; ");
    assert!(warnings.contains("expected a header of 393 bytes in LAS 1.5, found 375"), "{warnings}");
    let mut old = as_1_5(Scan::new(6, 10).bytes(As::Las));
    put(&mut old, 104, [1]);
    let warnings = info(&old).warnings.join("; ");
    assert!(warnings.contains("LAS 1.5 has point record formats 6 to 10, found 1"), "{warnings}");
    assert_eq!(info(&Scan::new(6, 10).bytes(As::Las)).gps_times, None);
}

#[test]
fn counts_by_return_that_do_not_add_up_are_said() {
    let mut bytes = Scan::new(6, 10).bytes(As::Las);
    put(&mut bytes, 255, 7u64.to_le_bytes());
    put(&mut bytes, 263, 3u64.to_le_bytes());
    assert_eq!(info(&bytes).warnings, [""; 0]);
    put(&mut bytes, 263, 2u64.to_le_bytes());
    assert_eq!(info(&bytes).warnings, ["the counts by return add up to 9, not to 10 points"]);
    put(&mut bytes, 263, u64::MAX.to_le_bytes());
    assert_eq!(info(&bytes).warnings.len(), 1, "no overflow");
}

#[test]
fn larger_headers_and_padding_before_the_points_are_stepped_over() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scan.las");
    let scan = Scan::new(3, 100);
    let mut bytes = scan.bytes(As::Las);
    add_vlr(&mut bytes, "somebody", 7, b"hello");
    insert(&mut bytes, 227 + 59, &[0xdd; 2]);
    put(&mut bytes, 94, 300u16.to_le_bytes());
    insert(&mut bytes, 227, &[0xaa; 73]);
    std::fs::write(&path, &bytes).unwrap();
    let read = read(std::slice::from_ref(&path), 1).unwrap();
    assert_eq!((&read.batches[0].positions, read.error()), (&scan.positions(), ""));
    assert_eq!(read.report.files[0].warnings, [""; 0]);
    let info = Info::read(&path).unwrap();
    assert_eq!((info.vlrs[0].user_id.as_str(), info.vlrs[0].at, info.header_bytes), ("somebody", 354, 300));
}

#[test]
fn what_follows_the_points_is_not_taken_for_points() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scan.las");
    let told = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        let read = read(std::slice::from_ref(&path), 1).unwrap();
        (read.points(), read.report.files[0].warnings.join("; "))
    };
    for format in [4, 5, 9, 10] {
        let mut bytes = Scan::new(format, 100).bytes(As::Las);
        let (record, is_new) = (Scan::new(format, 100).record_length(), format > 5);
        if !is_new {
            // LAS 1.3 has eight bytes more than 1.2: where the waveform packets start.
            put(&mut bytes, 24, [1, 3]);
            put(&mut bytes, 94, 235u16.to_le_bytes());
            insert(&mut bytes, 227, &[0; 8]);
        }
        let end = bytes.len() as u64;
        put(&mut bytes, 227, end.to_le_bytes());
        bytes.extend([0x77; 1_000]);
        assert_eq!(told(&bytes), (100, String::new()), "format {format}");
        // The same without saying that these are packets: as if there were more points.
        let mut silent = bytes.clone();
        put(&mut silent, 227, 0u64.to_le_bytes());
        let expected = format!("the file has room for {}", 100 + 1_000 / record);
        assert!(told(&silent).1.contains(&expected), "format {format}: {}", told(&silent).1);
        // Packets that start within the points.
        let mut within = bytes.clone();
        put(&mut within, 227, (end - record as u64).to_le_bytes());
        let (points, warning) = told(&within);
        assert!(points == 100 && warning.contains("counts 100 points, 99 fit before"), "format {format}: {warning}");
    }
}

#[test]
fn extra_bytes_are_listed() {
    let Some(data) = data() else { return };
    let info = Info::read(&data.join("scans/pdal-las_with_several_extra_byte_bloc.laz")).unwrap();
    let names: Vec<_> = info.points.extra_dimensions.iter().map(|d| (d.name.as_str(), d.kind, d.at)).collect();
    assert_eq!(names, [("Deviation", ExtraKind::U16, 0), ("confidence", ExtraKind::U8, 2)]);
    let text = info.to_string();
    assert!(text.contains("extra      «Deviation» u16 at byte 0"), "{text}");
    let json: serde_json::Value = serde_json::to_value(&info).unwrap();
    assert_eq!(json["points"]["extra_dimensions"][1]["name"], "confidence");
    assert_eq!(json["points"]["extra_dimensions"][1]["kind"], "u8");

    // An array, scale, no data: a list made here, on two extra bytes less than it explains.
    let mut entry = vec![0; 192];
    (entry[2], entry[3]) = (14, 0b1001);
    entry[4..8].copy_from_slice(b"pair");
    put(&mut entry, 40, (-1i64).to_le_bytes());
    put(&mut entry, 48, (-2i64).to_le_bytes());
    put(&mut entry, 112, 0.5f64.to_le_bytes());
    put(&mut entry, 120, 0.25f64.to_le_bytes());
    entry[160..163].copy_from_slice(b"why");
    let list = [entry.clone(), entry].concat();
    let mut bytes = Scan { extra_bytes: 6, ..Scan::new(3, 10) }.bytes(As::Las);
    add_vlr(&mut bytes, "LASF_Spec", 4, &list);
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scan.las");
    std::fs::write(&path, bytes).unwrap();
    let read = read(std::slice::from_ref(&path), 1).unwrap();
    let record = &read.facts.files[0].record;
    assert_eq!((record.extra_bytes, record.extra_dimensions.len(), record.format), (6, 1, 3));
    let pair = &record.extra_dimensions[0];
    assert_eq!(pair.no_data, Some(vec![Number::Signed(-1), Number::Signed(-2)]));
    let attributes = &read.batches[0].attributes;
    for i in 0..10 {
        let extra = attributes.extra_of(i, 6);
        let number = i16::from_le_bytes([extra[2], extra[3]]);
        assert_eq!(pair.value_of(extra, 1), Some(f64::from(number) * 0.25));
    }
    let warnings = read.report.files[0].warnings.join("; ");
    assert!(warnings.contains("dimension 1 «pair» ends at byte 8 of the 6 that a record has"), "{warnings}");
    let text = Info::read(&path).unwrap().to_string();
    assert!(text.contains("«pair» i16 × 2 at byte 0, no data -1 -2, scale 0.5 0.25: why"), "{text}");
}

#[test]
fn files_in_different_systems_are_named_once() {
    let Some(data) = data() else { return };
    let open = |names: &[&str]| {
        let paths: Vec<_> = names.iter().map(|n| data.join("formats").join(n)).collect();
        read(&paths, 2).unwrap().facts.warnings.join("; ")
    };
    let (utm_15, oregon) = ("pdal-1.2_1.las", "laspy-autzen_geo_proj.las");
    assert_eq!(open(&[utm_15, "pdal-1.2_3.las", "pdal-1.0_0.las"]), "");
    let mixed = open(&[utm_15, oregon]);
    assert!(mixed.starts_with("the files have different coordinate systems: "), "{mixed}");
    assert!(mixed.contains("pdal-1.2_1.las says projected EPSG:26915, ") && mixed.contains("EPSG:2994"), "{mixed}");
    let soft = open(&["las-rs-one-point.las", utm_15]);
    assert!(soft.starts_with("the files may have different coordinate systems: "), "{soft}");
    assert_eq!(open(&[utm_15]), "");
}
