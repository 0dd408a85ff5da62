//! Which fields of a record are read, and that nobody notices the others.

use firstlight::{
    scene::{ColorRule, ColorStats},
    source::{Fields, OpenOptions},
};

use super::{
    Read, data,
    made::{As, Scan},
    read_with, real,
};

fn with_fields(path: &std::path::Path, fields: Option<Fields>) -> Read {
    read_with(&[path.to_owned()], OpenOptions { fields, ..Default::default() }).unwrap()
}

fn rule(read: &Read) -> ColorRule {
    let mut stats = ColorStats::default();
    read.batches.iter().for_each(|b| stats.merge(&b.stats));
    stats.rule()
}

/// True if any intensity was read.
fn has_intensity(read: &Read) -> bool {
    read.batches.iter().any(|b| b.colors.iter().any(|c| c[3] > 0))
}

#[test]
fn automatic_fields_give_the_colours_that_all_fields_give() {
    let Some(data) = data() else { return };
    let (mut narrowed, mut kept) = (0, 0);
    for (name, _, _) in real::reference() {
        let path = data.join(name);
        let (all, automatic) = (with_fields(&path, Some(Fields::ALL)), with_fields(&path, None));
        assert_eq!(rule(&automatic), rule(&all), "{name}");
        narrowed += usize::from(has_intensity(&all) && !has_intensity(&automatic));
        kept += usize::from(has_intensity(&automatic));
        for batch in &automatic.batches {
            assert_eq!(*batch.attributes, Default::default(), "{name}: only colours were asked for");
        }
    }
    assert!(narrowed > 20 && kept > 20, "{narrowed} narrowed, {kept} not");
}

#[test]
fn intensity_is_read_where_no_sampled_record_has_a_colour() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scan.las");
    let mut bytes = Scan::new(7, 2_000).bytes(As::Las);
    std::fs::write(&path, &bytes).unwrap();
    let read = with_fields(&path, None);
    assert!(!has_intensity(&read) && matches!(rule(&read), ColorRule::Rgb8 | ColorRule::Rgb16));
    // All black but for one point that is not looked at: both are read, and the rule sees the point.
    for record in bytes[375..].chunks_exact_mut(36) {
        record[30..36].fill(0);
    }
    bytes[375 + 77 * 36 + 31] = 40;
    std::fs::write(&path, &bytes).unwrap();
    let read = with_fields(&path, None);
    assert!(has_intensity(&read) && rule(&read) == ColorRule::Rgb16);
    bytes[375 + 77 * 36 + 31] = 0;
    std::fs::write(&path, &bytes).unwrap();
    assert!(matches!(rule(&with_fields(&path, None)), ColorRule::Intensity { .. }));
}

/// Layered LAZ: each field alone is what it is among all of them, and the other columns stay empty.
#[test]
fn every_field_alone_is_what_it_is_among_all() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scan.laz");
    for (format, how) in [(3, As::Laz(300)), (7, As::Laz(300)), (8, As::LazVarying(100)), (8, As::Las)] {
        let scan = Scan { extra_bytes: 3, ..Scan::new(format, 2_000) };
        std::fs::write(&path, scan.bytes(how)).unwrap();
        let all = with_fields(&path, Some(Fields::ALL));
        let single: [fn(&mut Fields); 10] = [
            |f| f.rgb = true,
            |f| f.nir = true,
            |f| f.intensity = true,
            |f| f.returns = true,
            |f| f.classification = true,
            |f| f.scan_angle = true,
            |f| f.user_data = true,
            |f| f.point_source = true,
            |f| f.gps_time = true,
            |f| f.extra_bytes = true,
        ];
        for want in single {
            let mut fields = Fields::NONE;
            want(&mut fields);
            let one = with_fields(&path, Some(fields));
            assert_eq!(one.points(), 2_000);
            for (one, all) in one.batches.iter().zip(&all.batches) {
                assert_eq!(one.positions, all.positions, "format {format} {how:?} {fields:?}");
                let mut expected = (*all.attributes).clone();
                keep(fields.returns, &mut expected.returns);
                keep(fields.returns, &mut expected.flags);
                keep(fields.classification, &mut expected.classification);
                keep(fields.scan_angle, &mut expected.scan_angle);
                keep(fields.user_data, &mut expected.user_data);
                keep(fields.point_source, &mut expected.point_source);
                keep(fields.gps_time, &mut expected.gps_time);
                keep(fields.nir, &mut expected.nir);
                keep(fields.extra_bytes, &mut expected.extra);
                assert!(*one.attributes == expected, "format {format} {how:?} {fields:?}");
                for (one, all) in one.colors.iter().zip(&all.colors) {
                    assert_eq!(one[..3], if fields.rgb { [all[0], all[1], all[2]] } else { [0; 3] });
                    assert_eq!(one[3], if fields.intensity { all[3] } else { 0 });
                }
            }
        }
        assert!(has_intensity(&all) && !all.batches[0].attributes.extra.is_empty());
    }
}

fn keep<T>(wanted: bool, column: &mut Vec<T>) {
    if !wanted {
        column.clear();
    }
}
