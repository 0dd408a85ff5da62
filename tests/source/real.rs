//! Real files: every point, against an independent reader's checksums; every broken file's outcome.

use firstlight::info::Info;

use super::{
    checksums::{COLUMNS, checksums},
    data, read,
};

/// Lines of the reference: file, points, and a hash per column.
pub fn reference() -> Vec<(&'static str, usize, Vec<&'static str>)> {
    let text = include_str!("../reference/checksums.tsv");
    let mut lines = text.lines().map(|line| line.split('\t').collect::<Vec<_>>());
    assert_eq!(lines.next().unwrap()[2..], COLUMNS);
    lines.map(|line| (line[0], line[1].parse().unwrap(), line[2..].to_vec())).collect()
}

#[test]
fn every_point_is_what_an_independent_reader_says() {
    let Some(data) = data() else { return };
    let mut faults = Vec::new();
    // Files that have a column, by column.
    let mut seen = [0; COLUMNS.len()];
    for (name, points, hashes) in reference() {
        let read = match read(&[data.join(name)], 2) {
            Ok(read) => read,
            Err(error) => {
                faults.push(format!("{error}"));
                continue;
            }
        };
        if read.points() != points || !read.error().is_empty() {
            faults.push(format!("{name}: {} of {points} points, {}", read.points(), read.error()));
        }
        // An empty file has no columns, whatever its format.
        for (i, (found, expected)) in checksums(&read).into_iter().zip(hashes).enumerate().filter(|_| points > 0) {
            if found != expected {
                faults.push(format!("{name}: {} is {found}, not {expected}", COLUMNS[i]));
            }
            seen[i] += usize::from(expected != "-");
        }
        let file = &read.report.files[0];
        for warning in &file.warnings {
            println!("{name}: {warning}");
        }
    }
    assert!(faults.is_empty(), "{} files differ:\n{}", faults.len(), faults.join("\n"));
    assert!(reference().len() > 70);
    // Not least near infrared, wave packets, and extra bytes without and with a meaning.
    assert!(seen.iter().all(|&files| files >= 5), "{seen:?}");
}

/// File, points that are delivered, and part of the error (of the file, or of opening it) or, after a
/// «~», of a warning.
const BROKEN: [(&str, usize, &str); 15] = [
    ("laszip-broken_coder.laz", 0, "expected coder 0 (arithmetic), found 15"),
    ("laszip-broken_size.laz", 0, "expected version 1 or 2 of item Point10, found 6"),
    ("pasture-10_points_format_10.laz", 10, "~leave out the wave packet of format 10: 38 instead of 67 bytes"),
    ("pasture-10_points_format_9.laz", 10, "~leave out the wave packet of format 9: 30 instead of 59 bytes"),
    ("pdal-1.2-no-points.las", 0, "expected 1065 records of 34 bytes from byte 229 on, the file ends at byte 229"),
    ("pdal-2-2-2-2.laz", 0, "expected a header of 227 bytes, the file ends at byte 4"),
    ("pdal-bad-geotiff-keys.las", 10, ""),
    ("pdal-bad_vlr_count.las", 10, "~expected 3 VLRs, found 2"),
    ("pdal-garbage_nVariableLength.las", 718, "1 of 719 points are missing, 718 are kept"),
    ("pdal-gps-time-nan.las", 1, ""),
    ("pdal-hextest.las", 8, ""),
    ("pdal-lots_of_vlr.las", 1, ""),
    ("pdal-no-points.las", 0, ""),
    ("pdal-simple-laszip-compressor-version-1.2r0.laz", 1065, ""),
    ("pdal-spurious.las", 1065, "~1 of 1065 points lie outside of the header's box"),
];

#[test]
fn every_broken_file_has_its_expected_outcome() {
    let Some(data) = data() else { return };
    for (name, points, expected) in BROKEN {
        let (found, error, warnings) = match read(&[data.join("broken").join(name)], 2) {
            Ok(read) => (read.points(), read.error().to_owned(), read.report.files[0].warnings.join("; ")),
            Err(error) => (0, error.to_string(), String::new()),
        };
        assert_eq!(found, points, "{name}: {error}");
        match expected.strip_prefix('~') {
            Some(warning) => assert!(error.is_empty() && warnings.contains(warning), "{name}: {error} {warnings}"),
            None if expected.is_empty() => assert_eq!(error, "", "{name}"),
            None => assert!(error.contains(expected), "{name}: {error}"),
        }
        assert!(!error.contains('\n') && !warnings.contains('\n'), "{name}: more than one line");
    }
}

/// Records without their wave packet decode to those of the uncompressed twin that has it. Two things
/// differ, and did so before they were compressed (LASzip decodes the same, where the file calls itself
/// format 6 or 8): scan angles were rounded down, and near infrared was taken from the record's last two
/// bytes, which are those of the wave packet's z(t).
#[test]
fn left_out_wave_packets_cost_nothing_else() {
    let Some(data) = data() else { return };
    for format in [9, 10] {
        let whole = read(&[data.join(format!("formats/pasture-10_points_format_{format}.las"))], 1).unwrap();
        let without = read(&[data.join(format!("broken/pasture-10_points_format_{format}.laz"))], 1).unwrap();
        let (whole, without) = (&whole.batches[0], &without.batches[0]);
        assert_eq!(whole.positions, without.positions);
        assert_eq!(whole.colors, without.colors);
        assert!(whole.attributes.wave_packet.iter().all(|w| w.iter().any(|&b| b != 0)));
        let mut expected = (*whole.attributes).clone();
        expected.wave_packet = vec![[0; 29]; 10];
        assert_eq!(expected.scan_angle, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
        expected.scan_angle = vec![0, 1, 2, 2, 4, 5, 5, 7, 8, 9];
        if format == 10 {
            assert_eq!(expected.nir, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
            expected.nir = whole.attributes.wave_packet.iter().map(|w| u16::from_le_bytes([w[27], w[28]])).collect();
        }
        assert_eq!(*without.attributes, expected, "format {format}");
    }
}

/// The same bytes, one of them changed, must not pass for the whole.
#[test]
fn a_damaged_scan_is_noticed() {
    let Some(data) = data() else { return };
    let mut bytes = std::fs::read(data.join("scans/pdal-autzen_trim.laz")).unwrap();
    let at = bytes.len() / 2;
    bytes[at] ^= 0x55;
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("damaged.laz");
    std::fs::write(&path, bytes).unwrap();
    let read = read(&[path], 2).unwrap();
    let file = &read.report.files[0];
    assert!(file.error.is_some() || file.warnings.iter().any(|w| w.contains("damaged")), "{file:?}");
}

#[test]
fn info_describes_every_file() {
    let Some(data) = data() else { return };
    for (name, points, _) in reference() {
        let info = Info::read(&data.join(name)).unwrap();
        assert_eq!(info.points.count, points as u64, "{name}");
        if let Some(laz) = &info.laz {
            let in_chunks: u64 = laz.chunks.iter().map(|c| c.points).sum();
            assert_eq!(in_chunks, points as u64, "{name}");
        }
        assert!(serde_json::to_string(&info).unwrap().len() > 500);
        assert!(info.to_string().lines().count() > 10);
    }
    let info = Info::read(&data.join("formats/las-rs-32-1-472-150-76.laz")).unwrap();
    assert_eq!((info.crs.projected_epsg, info.crs.vertical_epsg), (Some(25832), Some(5941)));
    let info = Info::read(&data.join("scans/pdal-autzen_trim_7.las")).unwrap();
    assert!(info.crs.wkt.unwrap().starts_with("PROJCS[\"NAD_1983_HARN_Lambert_Confor"));
    for (name, _, _) in BROKEN {
        // An error or an answer, but never a panic.
        let _ = Info::read(&data.join("broken").join(name)).map(|info| info.to_string());
    }
}
