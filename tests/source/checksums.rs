//! Hashes of what was read, one per attribute: see tests/reference/laspy_checksums.py.

use firstlight::scene::{Attributes, ExtraDimension, PointBatch};

use super::Read;

/// The columns of the reference, in its order.
pub const COLUMNS: [&str; 12] =
    ["color", "returns", "flags", "class", "angle", "user", "source", "time", "nir", "wave", "extra", "values"];

/// Sums up hashes of points, weighted by their number.
#[derive(Default, Clone, Copy)]
struct Sum {
    points: u64,
    sum: u64,
}

impl Sum {
    fn add(&mut self, bytes: impl IntoIterator<Item = u8>) {
        let fnv = |h: u64, b: u8| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3);
        let hash = bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, fnv);
        self.sum = self.sum.wrapping_add(hash.wrapping_mul(2 * self.points + 1));
        self.points += 1;
    }
}

/// One hash per column, in hexadecimal; «-» for a column that is empty although there are points.
pub fn checksums(read: &Read) -> [String; COLUMNS.len()] {
    let record = &read.facts.files[0].record;
    of_batches(&read.batches, &record.extra_dimensions, record.extra_bytes)
}

/// Of points in any order: they are put into that of their records.
fn of_batches(batches: &[PointBatch], dimensions: &[ExtraDimension], stride: usize) -> [String; COLUMNS.len()] {
    let mut order: Vec<(u32, usize, usize)> = Vec::new();
    for (number, batch) in batches.iter().enumerate() {
        order.extend(batch.records.iter().enumerate().map(|(i, &record)| (record, number, i)));
    }
    order.sort_unstable();
    let typed: Vec<_> = dimensions.iter().filter(|d| d.number(&vec![0; stride], 0).is_some()).collect();
    let mut sums = [Sum::default(); COLUMNS.len()];
    for (_, number, i) in order {
        let batch = &batches[number];
        let Attributes { returns, flags, classification, scan_angle, user_data, .. } = &*batch.attributes;
        let Attributes { point_source, gps_time, nir, wave_packet, .. } = &*batch.attributes;
        let position = batch.positions[i].into_iter().flat_map(i32::to_le_bytes);
        sums[0].add(position.chain(batch.colors[i].into_iter().flat_map(u16::to_le_bytes)));
        let mut column = |at: usize, bytes: Option<&[u8]>| {
            if let Some(bytes) = bytes {
                sums[at].add(bytes.iter().copied());
            }
        };
        column(1, returns.get(i..=i));
        column(2, flags.get(i..=i));
        column(3, classification.get(i..=i));
        column(4, scan_angle.get(i).map(|v| v.to_le_bytes()).as_ref().map(|b| &b[..]));
        column(5, user_data.get(i..=i));
        column(6, point_source.get(i).map(|v| v.to_le_bytes()).as_ref().map(|b| &b[..]));
        column(7, gps_time.get(i).map(|v| v.to_le_bytes()).as_ref().map(|b| &b[..]));
        column(8, nir.get(i).map(|v| v.to_le_bytes()).as_ref().map(|b| &b[..]));
        column(9, wave_packet.get(i).map(|b| &b[..]));
        let extra = batch.attributes.extra_of(i, stride);
        column(10, (!extra.is_empty()).then_some(extra));
        let values = typed.iter().flat_map(|d| (0..d.elements).map(move |e| plain_value(d, extra, e).to_le_bytes()));
        let values: Vec<u8> = values.flatten().collect();
        column(11, (!values.is_empty()).then_some(&values));
    }
    let points = sums[0].points;
    sums.map(|s| if s.points == 0 && points > 0 { "-".into() } else { format!("{:016x}", s.sum) })
}

/// The value, or, for one that means "no data", its number as if it were a value: as laspy has it.
fn plain_value(dimension: &ExtraDimension, extra: &[u8], element: usize) -> f64 {
    let plain = ExtraDimension { no_data: None, ..dimension.clone() };
    plain.value_of(extra, element).unwrap_or(f64::NAN)
}

/// A batch in which every value of every column is another one.
fn batch(n: u32) -> PointBatch {
    let attributes = Attributes {
        returns: (0..n).map(|i| i as u8).collect(),
        flags: (0..n).map(|i| i as u8 + 1).collect(),
        classification: (0..n).map(|i| i as u8 + 2).collect(),
        scan_angle: (0..n).map(|i| i as i16 - 50).collect(),
        user_data: (0..n).map(|i| i as u8 + 3).collect(),
        point_source: (0..n).map(|i| i as u16 * 300).collect(),
        gps_time: (0..n).map(|i| f64::from(i) * 0.1).collect(),
        nir: (0..n).map(|i| i as u16 * 301).collect(),
        wave_packet: (0..n).map(|i| [i as u8; 29]).collect(),
        extra: (0..2 * n).map(|i| i as u8).collect(),
    };
    PointBatch {
        positions: (0..n as i32).map(|i| [i, i * 7, -i]).collect(),
        colors: (0..n as u16).map(|i| [i, 1, 2, 3]).collect(),
        records: (0..n).collect(),
        attributes: Box::new(attributes),
        ..Default::default()
    }
}

#[test]
fn each_column_sees_its_own_changed_value_and_no_other() {
    let dimension = ExtraDimension {
        name: "x".into(),
        description: String::new(),
        at: 1,
        kind: firstlight::scene::ExtraKind::U8,
        elements: 1,
        no_data: None,
        min: None,
        max: None,
        scale: Some(vec![0.01]),
        offset: None,
    };
    let of = |batches: &[PointBatch]| of_batches(batches, std::slice::from_ref(&dimension), 2);
    let good = of(&[batch(100)]);
    type Change = fn(&mut PointBatch);
    let changes: [(&str, Change); 14] = [
        ("color", |b| b.positions[50][2] += 1),
        ("color", |b| b.colors[99][3] ^= 0x100),
        ("color", |b| b.positions.swap(10, 11)),
        ("returns", |b| b.attributes.returns[50] ^= 1),
        ("flags", |b| b.attributes.flags[0] ^= 0x80),
        ("class", |b| b.attributes.classification[99] ^= 1),
        ("angle", |b| b.attributes.scan_angle[7] += 1),
        ("user", |b| b.attributes.user_data.swap(3, 4)),
        ("source", |b| b.attributes.point_source[50] ^= 0x8000),
        ("time", |b| b.attributes.gps_time[50] = b.attributes.gps_time[50].next_up()),
        ("nir", |b| b.attributes.nir[50] += 1),
        ("wave", |b| b.attributes.wave_packet[50][28] ^= 1),
        ("extra", |b| b.attributes.extra[100] ^= 1),
        ("extra values", |b| b.attributes.extra[101] ^= 1),
    ];
    for (columns, change) in changes {
        let mut changed = batch(100);
        change(&mut changed);
        let found = of(&[changed]);
        for ((name, found), good) in COLUMNS.iter().zip(found).zip(&good) {
            assert_eq!(found != *good, columns.contains(name), "{columns}: {name}");
        }
    }
    // A column that is not there, and points in another order.
    let mut without = batch(100);
    without.attributes.nir.clear();
    assert_eq!(of(&[without])[8], "-");
    let mut turned = batch(100);
    turned.positions.reverse();
    turned.colors.reverse();
    turned.records.reverse();
    assert_eq!(of(&[turned])[0], good[0], "the order of arrival does not matter");
}
