//! From raw point records to the columns of [`Attributes`].

use super::{
    bytes::u16_at,
    fields::Fields,
    layout::{RecordLayout, WavePacket},
};
use crate::scene::{Attributes, WAVE_PACKET_BYTES};

/// Appends the wanted columns of whole records. What is not wanted is not looked at: a layered decoder
/// leaves anything there.
pub fn append(records: &[u8], layout: &RecordLayout, fields: &Fields, to: &mut Attributes) {
    if fields.returns {
        if layout.extended {
            to.returns.extend(heads(records, layout).map(|r: &[u8; 20]| r[14]));
            to.flags.extend(heads(records, layout).map(|r: &[u8; 20]| r[15]));
        } else {
            // Three bits each become four; synthetic, key-point and withheld are above the class.
            to.returns.extend(heads(records, layout).map(|r: &[u8; 20]| r[14] & 7 | (r[14] & 0x38) << 1));
            to.flags.extend(heads(records, layout).map(|r: &[u8; 20]| r[15] >> 5 | r[14] & 0xc0));
        }
    }
    if fields.classification {
        let (at, mask) = if layout.extended { (16, 0xff) } else { (15, 0x1f) };
        to.classification.extend(heads(records, layout).map(|r: &[u8; 20]| r[at] & mask));
    }
    if fields.scan_angle {
        if layout.extended {
            to.scan_angle.extend(heads(records, layout).map(|r: &[u8; 20]| u16_at(r, 18).cast_signed()));
        } else {
            to.scan_angle.extend(heads(records, layout).map(|r: &[u8; 20]| i16::from(r[16].cast_signed())));
        }
    }
    if fields.user_data {
        to.user_data.extend(heads(records, layout).map(|r: &[u8; 20]| r[17]));
    }
    if fields.point_source {
        if layout.extended {
            to.point_source.extend(heads(records, layout).map(|r: &[u8; 22]| u16_at(r, 20)));
        } else {
            to.point_source.extend(heads(records, layout).map(|r: &[u8; 20]| u16_at(r, 18)));
        }
    }
    if let Some(at) = layout.gps_time_at.filter(|_| fields.gps_time) {
        to.gps_time.extend(field(records, layout, at).map(|b| f64::from_le_bytes(*b)));
    }
    if let Some(at) = layout.nir_at.filter(|_| fields.nir) {
        to.nir.extend(field(records, layout, at).map(|b| u16::from_le_bytes(*b)));
    }
    match layout.wave_packet {
        WavePacket::At(at) if fields.wave_packet => to.wave_packet.extend(field(records, layout, at).copied()),
        WavePacket::Omitted if fields.wave_packet => {
            let points = to.wave_packet.len() + records.len() / layout.length;
            to.wave_packet.resize(points, [0; WAVE_PACKET_BYTES]);
        }
        _ => {}
    }
    if fields.extra_bytes && layout.extra_bytes() > 0 {
        to.extra.reserve(records.len() / layout.length * layout.extra_bytes());
        for record in records.chunks_exact(layout.length) {
            to.extra.extend_from_slice(&record[layout.extra_at..]);
        }
    }
}

/// Bytes per point of the columns that are wanted and there.
pub fn bytes_per_point(layout: &RecordLayout, fields: &Fields) -> usize {
    let columns = [
        (fields.returns, 2),
        (fields.classification, 1),
        (fields.scan_angle, 2),
        (fields.user_data, 1),
        (fields.point_source, 2),
        (fields.gps_time && layout.gps_time_at.is_some(), 8),
        (fields.nir && layout.nir_at.is_some(), 2),
        (fields.wave_packet && layout.wave_packet != WavePacket::None, WAVE_PACKET_BYTES),
        (fields.extra_bytes, layout.extra_bytes()),
    ];
    columns.iter().filter(|(wanted, _)| *wanted).map(|(_, bytes)| bytes).sum()
}

/// The first `H` bytes of each record.
pub fn heads<'a, const H: usize>(
    records: &'a [u8],
    layout: &RecordLayout,
) -> impl ExactSizeIterator<Item = &'a [u8; H]> + Clone + use<'a, H> {
    debug_assert!(layout.length >= H);
    let records = records.chunks_exact(layout.length);
    records.map(|r| r.first_chunk().expect("a record is at least as long as its format"))
}

/// The `N` bytes of each record from `at` on.
fn field<'a, const N: usize>(
    records: &'a [u8],
    layout: &RecordLayout,
    at: usize,
) -> impl ExactSizeIterator<Item = &'a [u8; N]> + use<'a, N> {
    let records = records.chunks_exact(layout.length);
    records.map(move |r| r[at..].first_chunk().expect("a record is at least as long as its format"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Appends one record of a format, made by `change`.
    fn one(format: u8, extra: usize, change: impl Fn(&mut [u8])) -> Attributes {
        let layout = RecordLayout::new(format, extra);
        let mut record = vec![0; layout.length];
        change(&mut record);
        let mut attributes = Attributes::default();
        append(&record, &layout, &Fields::ALL, &mut attributes);
        attributes
    }

    #[test]
    fn legacy_bits_become_those_of_las_1_4() {
        let found = one(1, 0, |r| {
            // Return 2 of 5, scan direction, edge; withheld and synthetic, class 31; −7°.
            r[14..20].copy_from_slice(&[2 | 5 << 3 | 0xc0, 31 | 0x20 | 0x80, -7i8 as u8, 9, 0x34, 0x12]);
            r[20..28].copy_from_slice(&f64::NAN.to_bits().wrapping_add(5).to_le_bytes());
        });
        assert_eq!((found.returns[0], found.flags[0], found.classification[0]), (0x52, 0b1100_0101, 31));
        assert_eq!((found.scan_angle[0], found.user_data[0], found.point_source[0]), (-7, 9, 0x1234));
        assert_eq!(found.gps_time[0].to_bits(), f64::NAN.to_bits() + 5, "bits of a NaN are kept");
        assert!(found.nir.is_empty() && found.wave_packet.is_empty() && found.extra.is_empty());
    }

    #[test]
    fn extended_fields_are_where_the_format_says() {
        let found = one(10, 3, |r| (0..70).for_each(|i| r[i] = i as u8));
        assert_eq!((found.returns[0], found.flags[0], found.classification[0]), (14, 15, 16));
        assert_eq!((found.user_data[0], found.scan_angle[0], found.point_source[0]), (17, 0x1312, 0x1514));
        assert_eq!((found.gps_time[0].to_bits(), found.nir[0]), (0x1d1c_1b1a_1918_1716, 0x2524));
        assert_eq!((found.wave_packet[0][0], found.wave_packet[0][28]), (38, 66));
        assert_eq!(found.extra_of(0, 3), [67, 68, 69]);
    }

    #[test]
    fn only_wanted_columns_are_filled() {
        let layout = RecordLayout::new(10, 3);
        let records = vec![7; 2 * layout.length];
        let mut full = Attributes::default();
        append(&records, &layout, &Fields::ALL, &mut full);
        let wanted = |change: fn(&mut Fields)| {
            let mut fields = Fields::NONE;
            change(&mut fields);
            let mut found = Attributes::default();
            append(&records, &layout, &fields, &mut found);
            (found, bytes_per_point(&layout, &fields))
        };
        let none = Attributes::default;
        assert_eq!(wanted(|_| ()), (none(), 0));
        assert_eq!(wanted(|f| f.rgb = true), (none(), 0), "colours are elsewhere");
        let returns = Attributes { returns: vec![7; 2], flags: vec![7; 2], ..none() };
        assert_eq!(wanted(|f| f.returns = true), (returns, 2));
        let class = Attributes { classification: vec![7; 2], ..none() };
        assert_eq!(wanted(|f| f.classification = true), (class, 1));
        let angle = Attributes { scan_angle: full.scan_angle.clone(), ..none() };
        assert_eq!(wanted(|f| f.scan_angle = true), (angle, 2));
        assert_eq!(wanted(|f| f.user_data = true), (Attributes { user_data: vec![7; 2], ..none() }, 1));
        let source = Attributes { point_source: vec![0x707; 2], ..none() };
        assert_eq!(wanted(|f| f.point_source = true), (source, 2));
        assert_eq!(wanted(|f| f.gps_time = true), (Attributes { gps_time: full.gps_time.clone(), ..none() }, 8));
        assert_eq!(wanted(|f| f.nir = true), (Attributes { nir: vec![0x707; 2], ..none() }, 2));
        let wave = Attributes { wave_packet: vec![[7; 29]; 2], ..none() };
        assert_eq!(wanted(|f| f.wave_packet = true), (wave, 29));
        assert_eq!(wanted(|f| f.extra_bytes = true), (Attributes { extra: vec![7; 6], ..none() }, 3));
        full.clear();
        assert_eq!(full, none());

        // Left out by the writer: zeros.
        let without = layout.without_wave_packet();
        let mut found = none();
        append(&vec![7; 2 * without.length], &without, &Fields::ALL, &mut found);
        assert_eq!((found.wave_packet, found.extra), (vec![[0; 29]; 2], vec![7; 6]));
    }
}
