//! Colours by every attribute, on every backend: each pixel has the colour of its record's value, worked out here in
//! floating point; whole columns and their pages, values that come late, and values that there are not.

use firstlight::{
    render::{
        Clip, ColorBy, ColorMap, Coloring, Filter, FrameRequest, NO_DATA, Picture, Raster, Tone, palette, table_index,
    },
    scene::{Attribute, Attributes, ExtraDimension, ExtraKind, Number, PointBatch, RecordFacts},
};

use crate::{
    backends::gpu,
    cloud::Cloud,
    convergence::{Session, covered, difference, options, request},
    values::value,
};

/// No value for those.
const UNTIMED: usize = 37;

/// The cloud's points with all attributes; each value follows from the record number.
pub fn with_attributes(cloud: &Cloud, range: std::ops::Range<usize>) -> PointBatch {
    let mut batch = cloud.batch(range.clone());
    *batch.attributes = Attributes {
        returns: range.clone().map(|k| (1 + k % 5 + 16 * (k % 7)) as u8).collect(),
        classification: range.clone().map(|k| (k * 7 % 256) as u8).collect(),
        scan_angle: range.clone().map(|k| (k as i64 * 37 % 60_000 - 30_000) as i16).collect(),
        user_data: range.clone().map(|k| (k * 13 % 256) as u8).collect(),
        point_source: range.clone().map(|k| (k * 11 % 65_536) as u16).collect(),
        gps_time: range.clone().map(|k| if k % UNTIMED == 5 { f64::NAN } else { time(k) }).collect(),
        extra: range.flat_map(extra_bytes).collect(),
        ..Default::default()
    };
    batch
}

/// Of the dimensions of [`cloud`], in their order.
fn extra_bytes(k: usize) -> Vec<u8> {
    let height = (k as i64 * 29 % 4000 - 2000) as i16;
    let shifted = (k as i64 * 31 % 20_000) as i32;
    let single = 0.1 * (k % 23) as f32;
    let id = (1i64 << 60) + (k % 11) as i64;
    [&height.to_le_bytes()[..], &shifted.to_le_bytes(), &single.to_le_bytes(), &id.to_le_bytes()].concat()
}

/// Seconds that differ in digits which no f32 has.
fn time(k: usize) -> f64 {
    302_745_223.0 + k as f64 * 1e-4
}

pub fn cloud(points: usize) -> Cloud {
    let mut cloud = Cloud::town(points);
    let height = ExtraDimension {
        name: "height".into(),
        description: String::new(),
        at: 0,
        kind: ExtraKind::I16,
        elements: 1,
        no_data: Some(vec![Number::Signed(-2000)]),
        min: None,
        max: None,
        scale: Some(vec![0.01]),
        offset: None,
    };
    let shifted = ExtraDimension {
        name: "shifted".into(),
        at: 2,
        kind: ExtraKind::I32,
        no_data: None,
        scale: Some(vec![0.1]),
        offset: Some(vec![-1000.0]),
        ..height.clone()
    };
    let plain = ExtraDimension { no_data: None, scale: None, ..height.clone() };
    let single = ExtraDimension { name: "single".into(), at: 6, kind: ExtraKind::F32, ..plain.clone() };
    let id = ExtraDimension { name: "id".into(), at: 10, kind: ExtraKind::I64, ..plain };
    cloud.facts.files[0].record = RecordFacts {
        format: 7,
        scan_angle_step: 0.006,
        has_intensities: true,
        extra_bytes: 18,
        extra_dimensions: vec![height, shifted, single, id],
        ..Default::default()
    };
    cloud
}

fn all_attributes() -> Vec<Attribute> {
    let extra = ["height", "shifted", "single"].map(|name| Attribute::Extra(name.into()));
    Attribute::NAMED.into_iter().map(|(_, attribute)| attribute).chain(extra).collect()
}

fn unlit(mut request: FrameRequest) -> FrameRequest {
    request.shading.edl_strength = 0.0;
    request
}

/// The colour of a value, by the definition; two at the border between two colours.
pub fn expected(coloring: &Coloring, attribute: &Attribute, value: Option<f64>, [low, high]: [f64; 2]) -> Vec<[u8; 3]> {
    let Some(value) = value else { return vec![NO_DATA] };
    match attribute {
        Attribute::Classification => return vec![coloring.classes.color(value as u8)],
        _ if attribute.is_categorical() => return vec![palette(table_index(value as u16))],
        _ => {}
    }
    let share = ((value - low) / (high - low)).clamp(0.0, 1.0);
    let share = if *attribute == Attribute::Intensity { share.sqrt() } else { share };
    let colors = coloring.map_in_use().colors();
    let at = share * 255.0 + 0.5;
    let near = |at: f64| colors[(at as usize).min(255)];
    [at - 1e-6, at + 1e-6].map(near).map(|[r, g, b, _]| [r, g, b]).to_vec()
}

fn assert_colors(
    picture: &Picture,
    coloring: &Coloring,
    attribute: &Attribute,
    range: [f64; 2],
    points: &PointBatch,
    cloud: &Cloud,
) {
    let file = &cloud.facts.files[0];
    for (&record, &[r, g, b, _]) in picture.records.iter().zip(&picture.rgba) {
        let Ok(record) = usize::try_from(record) else { continue };
        let value = value(attribute, points, record, file, &cloud.facts.grid);
        let colors = expected(coloring, attribute, value, range);
        assert!(
            colors.contains(&[r, g, b]),
            "{attribute} of record {record}, {value:?}: {:?} not in {colors:?}",
            [r, g, b]
        );
    }
}

#[test]
fn every_attribute_colours_every_pixel_by_its_value() {
    let cloud = cloud(30_000);
    let points = with_attributes(&cloud, 0..cloud.len());
    let request = unlit(request(&cloud, &cloud.camera(), 2, 50_000));
    for attribute in all_attributes() {
        let mut first: Option<Picture> = None;
        for mut session in Session::all(&cloud, options(4096)) {
            let mut coloring = Coloring { by: attribute.clone().into(), ..Default::default() };
            coloring.classes.set_color(7, [1, 2, 3]);
            session.progressive.carry([attribute.clone()]);
            session.progressive.set_coloring(&coloring);
            for start in (0..cloud.len()).step_by(7000) {
                session.progressive.offer(with_attributes(&cloud, start..cloud.len().min(start + 7000)));
            }
            session.progressive.end_of_input();
            let picture = session.assert_exact(&request, &attribute.to_string());
            let scale = session.progressive.scale(&attribute);
            assert_colors(&picture, &coloring, &attribute, [scale.low, scale.high], &points, &cloud);
            let mut seen: Vec<_> = picture.rgba.iter().collect();
            seen.sort_unstable();
            seen.dedup();
            let has_few = matches!(attribute, Attribute::File | Attribute::LastReturn);
            assert!(covered(&picture) > 1000 && (seen.len() > if has_few { 1 } else { 5 }), "{}", session.name);
            // Rounding may give a pixel to another point on another device, but its colour is its record's.
            match &first {
                Some(first) => {
                    let pixels = picture.records.iter().zip(&first.records).zip(picture.rgba.iter().zip(&first.rgba));
                    let wrong = pixels.filter(|((a, b), (c, d))| a == b && c != d).count();
                    assert_eq!(wrong, 0, "{}, {attribute}", session.name);
                }
                None => first = Some(picture),
            }
        }
    }
}

/// A range of the user's, another map, and values beyond both ends.
#[test]
fn a_given_range_and_map_are_used() {
    let cloud = cloud(20_000);
    let points = with_attributes(&cloud, 0..cloud.len());
    let request = unlit(request(&cloud, &cloud.camera(), 1, 50_000));
    let cases = [
        (Attribute::GpsTime, [time(4000), time(9000)]),
        (Attribute::ScanAngle, [-60.0, 10.0]),
        (Attribute::Intensity, [5000.0, 20_000.0]),
        (Attribute::UserData, [100.0, 101.0]),
        (Attribute::Elevation, [0.0, 2.0]),
        (Attribute::Extra("height".into()), [-1.0, 1.0]),
    ];
    for (attribute, range) in cases {
        let map = Some(ColorMap::Turbo);
        let coloring = Coloring { by: attribute.clone().into(), map, range: Some(range), ..Default::default() };
        for mut session in Session::all(&cloud, options(65_536)) {
            session.progressive.carry([attribute.clone()]);
            session.progressive.set_coloring(&coloring);
            session.progressive.offer(with_attributes(&cloud, 0..cloud.len()));
            session.progressive.end_of_input();
            let picture = session.assert_exact(&request, &attribute.to_string());
            assert_colors(&picture, &coloring, &attribute, range, &points, &cloud);
        }
    }
}

/// A switch in mid-load, and values by a second reader, in another order and other batches: the same picture as with
/// that colouring, and those values, from the start.
#[test]
fn a_switch_in_mid_load_comes_to_the_same() {
    let cloud = cloud(30_000);
    let request = unlit(request(&cloud, &cloud.camera(), 2, 20_000));
    for attribute in
        [Attribute::Classification, Attribute::UserData, Attribute::GpsTime, Attribute::Extra("height".into())]
    {
        let coloring = Coloring { by: attribute.clone().into(), ..Default::default() };
        let from_start = Session::all(&cloud, options(4096)).into_iter().map(|mut session| {
            session.progressive.carry([attribute.clone()]);
            session.progressive.set_coloring(&coloring);
            (0..6).for_each(|n| session.progressive.offer(with_attributes(&cloud, n * 5000..(n + 1) * 5000)));
            session.progressive.end_of_input();
            session.converge(&request, |_| ())
        });
        for (expected, mut session) in
            from_start.collect::<Vec<_>>().into_iter().zip(Session::all(&cloud, options(4096)))
        {
            (0..3).for_each(|n| session.progressive.offer(cloud.batch(n * 5000..(n + 1) * 5000)));
            session.frame(&request);
            session.progressive.set_coloring(&coloring);
            assert_eq!(session.progressive.lacking(coloring.by.attribute()), std::slice::from_ref(&attribute));
            session.progressive.begin_values(vec![attribute.clone()]);
            assert_eq!(session.progressive.lacking(coloring.by.attribute()), []);
            // Without values yet, all points are grey.
            session.frame(&request);
            let grey = session.read();
            let is_grey = |(&record, rgba): (&i64, &[u8; 4])| record < 0 || rgba[..3] == NO_DATA;
            assert!(grey.records.iter().zip(&grey.rgba).all(is_grey), "{}", session.name);
            for start in (0..30_000).step_by(3000).rev() {
                session.progressive.offer_values(&with_attributes(&cloud, start..start + 3000)).unwrap();
                if start % 9000 == 0 {
                    session.frame(&request);
                }
                if start == 12_000 {
                    (3..6).for_each(|n| session.progressive.offer(cloud.batch(n * 5000..(n + 1) * 5000)));
                    session.progressive.end_of_input();
                }
            }
            session.progressive.end_values();
            assert!(session.progressive.has_all_values(&attribute));
            let picture = session.assert_exact(&request, "switched");
            assert_eq!(difference(&expected, &picture), None, "{}, {attribute}", session.name);
            // Back and forth needs nothing more.
            session.progressive.set_coloring(&Coloring::default());
            assert!(session.frame(&request).drawn);
            assert_ne!(difference(&picture, &session.read()), None, "the comparison can fail");
            session.progressive.set_coloring(&coloring);
            assert_eq!(session.progressive.lacking(coloring.by.attribute()), []);
            let report = session.frame(&request);
            assert!(report.drawn && report.is_converged(), "switched at once");
            assert_eq!(difference(&picture, &session.read()), None, "{}", session.name);
            assert!(!session.frame(&request).drawn);
        }
    }
}

/// What was read in part and given up is read again from the start.
#[test]
fn values_given_up_are_lacking_again() {
    let cloud = cloud(10_000);
    let request = unlit(request(&cloud, &cloud.camera(), 2, 20_000));
    for mut session in Session::all(&cloud, options(4096)) {
        session.offer(&cloud, 0..cloud.len(), 5000);
        session.progressive.end_of_input();
        let by = |attribute: Attribute| Coloring { by: attribute.into(), ..Default::default() };
        session.progressive.set_coloring(&by(Attribute::GpsTime));
        session.progressive.begin_values(vec![Attribute::GpsTime]);
        session.progressive.offer_values(&with_attributes(&cloud, 0..4000)).unwrap();
        session.progressive.set_coloring(&by(Attribute::UserData));
        session.progressive.begin_values(vec![Attribute::UserData]);
        session.progressive.offer_values(&with_attributes(&cloud, 0..10_000)).unwrap();
        session.progressive.end_values();
        assert_eq!(session.progressive.lacking([&Attribute::GpsTime, &Attribute::UserData]), [Attribute::GpsTime]);
        session.progressive.set_coloring(&by(Attribute::GpsTime));
        session.progressive.begin_values(vec![Attribute::GpsTime]);
        session.progressive.offer_values(&with_attributes(&cloud, 0..10_000)).unwrap();
        session.progressive.end_values();
        assert_eq!(session.progressive.stats(&Attribute::GpsTime).unwrap().total(), 10_000 - 271, "counted once");
        let picture = session.assert_exact(&request, "gps-time");
        let scale = session.progressive.scale(&Attribute::GpsTime);
        let coloring = by(Attribute::GpsTime);
        let points = with_attributes(&cloud, 0..10_000);
        assert_colors(&picture, &coloring, &Attribute::GpsTime, [scale.low, scale.high], &points, &cloud);
    }
}

/// Another attribute joins what is being read: nothing that has come goes, of a colour or of a filter.
#[test]
fn values_stay_when_others_are_to_come_with_them() {
    let cloud = cloud(10_000);
    let request = unlit(request(&cloud, &cloud.camera(), 2, 20_000));
    let classes = Attribute::Classification;
    let filter = Filter { clauses: vec!["class=0..200".parse().unwrap()] };
    for mut session in Session::all(&cloud, options(4096)) {
        session.offer(&cloud, 0..cloud.len(), 5000);
        session.progressive.end_of_input();
        session.progressive.set_coloring(&Coloring { by: classes.clone().into(), ..Default::default() });
        session.progressive.begin_values(vec![classes.clone()]);
        session.progressive.offer_values(&with_attributes(&cloud, 0..4000)).unwrap();
        session.progressive.set_filter(&filter, &Clip::default());
        let half = session.converge(&request, |_| ());
        let shown = session.progressive.wait_for_points_shown().unwrap().unwrap();
        assert!(shown > 2500 && shown < 4000, "{}: {shown}", session.name);
        session.progressive.begin_values(vec![Attribute::GpsTime, classes.clone()]);
        // A filter whose values arrive is brought up to date twice a second.
        std::thread::sleep(std::time::Duration::from_millis(600));
        assert_eq!(difference(&half, &session.converge(&request, |_| ())), None, "{}", session.name);
        assert_eq!(session.progressive.wait_for_points_shown().unwrap(), Some(shown), "{}", session.name);
        session.progressive.offer_values(&with_attributes(&cloud, 0..10_000)).unwrap();
        session.progressive.end_values();
        assert_eq!(session.progressive.stats(&classes).unwrap().total(), 10_000, "counted once");
        assert_ne!(difference(&half, &session.assert_exact(&request, "all")), None, "the comparison can fail");
    }
}

/// Columns of pages of 64 and 1,000 records, filled by batches that straddle them, in no order.
#[test]
fn pages_of_a_column_change_nothing() {
    let cloud = cloud(10_000).in_random_order();
    let request = unlit(request(&cloud, &cloud.camera(), 1, 50_000));
    for attribute in [Attribute::Classification, Attribute::GpsTime] {
        let coloring = Coloring { by: attribute.clone().into(), ..Default::default() };
        let mut pictures = Vec::new();
        for page_records in [None, Some(64), Some(1000), Some(4097)] {
            let Some(mut backend) = gpu(Raster::EarlyZ) else { return };
            backend.columns_mut().set_page_records(page_records);
            let mut session = Session::new(format!("{page_records:?}"), Box::new(backend), &cloud.facts, options(4096));
            session.progressive.carry([attribute.clone()]);
            session.progressive.set_coloring(&coloring);
            // More batches between two frames than wait at most.
            for start in (0..10_000).step_by(250) {
                session.progressive.offer(with_attributes(&cloud, start..start + 250));
            }
            session.progressive.end_of_input();
            pictures.push(session.assert_exact(&request, "pages"));
        }
        assert!(pictures[1..].iter().all(|picture| difference(picture, &pictures[0]).is_none()), "{attribute}");
    }
}

/// Two files, of which the second has no GPS time; and an attribute that no file has.
#[test]
fn points_without_the_attribute_are_grey() {
    let mut cloud = cloud(10_000);
    let mut second = cloud.facts.files[0].clone();
    second.first_record = 6000;
    second.record.format = 2;
    second.path = "second.las".into();
    cloud.facts.files.push(second);
    let request = unlit(request(&cloud, &cloud.camera(), 1, 50_000));
    let coloring = Coloring { by: Attribute::GpsTime.into(), ..Default::default() };
    let [absence] = &coloring.absences(&cloud.facts)[..] else { panic!("one line for one file") };
    let expected = "second.las has no gps-time: its points are grey; --color-by takes rgb, intensity, elevation, \
                    classification, return-number, number-of-returns, last-return, point-source, user-data, scan-angle, \
                    file, extra:height, extra:shifted, extra:single, extra:id";
    assert_eq!(absence, expected);
    for mut session in Session::all(&cloud, options(4096)) {
        session.progressive.carry([Attribute::GpsTime]);
        session.progressive.set_coloring(&coloring);
        for start in (0..10_000).step_by(2000) {
            let mut batch = with_attributes(&cloud, start..start + 2000);
            if start >= 6000 {
                batch.file = 1;
                batch.attributes.gps_time.clear();
            }
            session.progressive.offer(batch);
        }
        session.progressive.end_of_input();
        let picture = session.assert_exact(&request, "two files");
        let has_time = |record: i64| record < 6000 && record % UNTIMED as i64 != 5;
        let pixels = picture.records.iter().zip(&picture.rgba).filter(|(record, _)| **record >= 0);
        assert!(pixels.clone().all(|(&record, rgba)| has_time(record) != (rgba[..3] == NO_DATA)), "{}", session.name);
        assert!(pixels.clone().any(|(&record, _)| record >= 6000));
        let missing = Coloring { by: "extra:none".parse().unwrap(), ..Default::default() };
        session.progressive.set_coloring(&missing);
        assert_eq!(session.progressive.lacking(missing.by.attribute()), [], "no file has it");
        session.frame(&request);
        let picture = session.read();
        let mut pixels = picture.records.iter().zip(&picture.rgba);
        assert!(pixels.all(|(&record, rgba)| record < 0 || rgba[..3] == NO_DATA));
    }
}

/// High-quality shading averages what lies in slots, and leaves columns to the front point.
#[test]
fn high_quality_goes_with_every_colour() {
    let cloud = cloud(20_000);
    let mut request = unlit(request(&cloud, &cloud.camera(), 2, 5000));
    for by in ["rgb", "intensity", "elevation", "file", "classification"] {
        let coloring =
            Coloring { by: by.parse().unwrap(), tone: Tone { gamma: 1.5, ..Tone::default() }, ..Default::default() };
        for mut session in Session::all(&cloud, options(4096)) {
            session.progressive.carry(coloring.by.attribute().cloned());
            session.progressive.set_coloring(&coloring);
            session.progressive.offer(with_attributes(&cloud, 0..cloud.len()));
            session.progressive.end_of_input();
            request.shading.high_quality = true;
            let high = session.assert_exact(&request, by);
            request.shading.high_quality = false;
            let plain = session.assert_exact(&request, by);
            assert_eq!(high.records, plain.records, "{}, {by}", session.name);
            let is_averaged = high.rgba != plain.rgba;
            assert_eq!(is_averaged, !matches!(by, "classification" | "file"), "{}, {by}", session.name);
        }
    }
}

/// Brightness, contrast and gamma of every rule that has colours of its own.
#[test]
fn tone_is_that_of_the_formula() {
    let cloud = cloud(10_000);
    let tone = Tone { brightness: 0.1, contrast: 1.3, gamma: 1.8 };
    let shown = |value: u16| ((tone.apply((f64::from(value) + 0.5) / 65_536.0) * 256.0) as usize).min(255) as u8;
    let request = unlit(request(&cloud, &cloud.camera(), 1, 50_000));
    for max in [255u16, 65_535] {
        for by in [ColorBy::Auto, ColorBy::Rgb] {
            let coloring = Coloring { by, tone, ..Default::default() };
            for mut session in Session::all(&cloud, options(65_536)) {
                session.progressive.set_coloring(&coloring);
                let mut batch = cloud.batch(0..cloud.len());
                batch.colors.iter_mut().flatten().for_each(|c| *c &= max);
                batch.stats.rgb_max &= max;
                let colors = batch.colors.clone();
                session.progressive.offer(batch);
                session.progressive.end_of_input();
                let picture = session.assert_exact(&request, "tone");
                for (&record, rgba) in picture.records.iter().zip(&picture.rgba).filter(|(record, _)| **record >= 0) {
                    let [r, g, b, _] = colors[record as usize].map(|c| shown(if max == 255 { c * 257 } else { c }));
                    assert_eq!(*rgba, [r, g, b, 255], "{}", session.name);
                }
            }
        }
    }
}
