//! Where the fields of a point record are, per point record format.

use super::header::RECORD_LENGTHS;
use crate::scene::WAVE_PACKET_BYTES;

/// Byte offsets of the fields of a record. Those up to the point source id follow from `extended`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordLayout {
    /// Bytes of a record, at least as many as its fields need.
    pub length: usize,
    /// True for formats 6 and up.
    pub extended: bool,
    pub gps_time_at: Option<usize>,
    pub rgb_at: Option<usize>,
    pub nir_at: Option<usize>,
    pub wave_packet: WavePacket,
    /// Where the extra bytes start: from there on to the record's end.
    pub extra_at: usize,
}

/// Whether records hold wave packet descriptors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WavePacket {
    /// The format has none.
    None,
    At(usize),
    /// The format has them, but they are not in the file: read as zero, which means "no packet".
    Omitted,
}

impl RecordLayout {
    /// The layout of a format from 0 to 10, with `extra` bytes behind its own fields.
    pub fn new(format: u8, extra: usize) -> RecordLayout {
        let extended = format >= 6;
        let rgb_at = match format {
            2 => Some(20),
            3 | 5 => Some(28),
            7 | 8 | 10 => Some(30),
            _ => None,
        };
        let gps_time_at = match format {
            0 | 2 => None,
            1..=5 => Some(20),
            _ => Some(22),
        };
        let extra_at = usize::from(RECORD_LENGTHS[usize::from(format.min(10))]);
        RecordLayout {
            length: extra_at + extra,
            extended,
            gps_time_at,
            rgb_at,
            nir_at: matches!(format, 8 | 10).then_some(36),
            wave_packet: match format {
                4 | 5 | 9 | 10 => WavePacket::At(extra_at - WAVE_PACKET_BYTES),
                _ => WavePacket::None,
            },
            extra_at,
        }
    }

    /// The same without the wave packet, where the format has one: some writers leave it out.
    pub fn without_wave_packet(self) -> RecordLayout {
        match self.wave_packet {
            WavePacket::At(_) => RecordLayout {
                length: self.length - WAVE_PACKET_BYTES,
                wave_packet: WavePacket::Omitted,
                extra_at: self.extra_at - WAVE_PACKET_BYTES,
                ..self
            },
            _ => self,
        }
    }

    /// Extra bytes per record.
    pub fn extra_bytes(&self) -> usize {
        self.length - self.extra_at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tables of the specification: each field starts where the one before it ends.
    #[test]
    fn fields_follow_each_other() {
        for format in 0..=10 {
            let layout = RecordLayout::new(format, 7);
            let mut at = if format < 6 { 20 } else { 22 };
            let mut take = |field: Option<usize>, bytes: usize| {
                if let Some(found) = field {
                    assert_eq!(found, at, "format {format}");
                    at += bytes;
                }
            };
            take(layout.gps_time_at, 8);
            take(layout.rgb_at, 6);
            take(layout.nir_at, 2);
            let WavePacket::At(wave) = layout.wave_packet else {
                take(Some(layout.extra_at), layout.extra_bytes());
                assert_eq!((at, layout.without_wave_packet()), (layout.length, layout));
                continue;
            };
            take(Some(wave), 29);
            take(Some(layout.extra_at), 7);
            assert_eq!((at, layout.length - 7), (layout.length, RECORD_LENGTHS[usize::from(format)].into()));
            let without = layout.without_wave_packet();
            assert_eq!((without.extra_at, without.extra_bytes(), without.rgb_at), (wave, 7, layout.rgb_at));
        }
    }
}
