//! The columns of a batch that no picture needs: read where they are asked for.

/// Attributes of a run of points, besides position, colour and intensity. A column has one entry per
/// point, or is empty: it was not asked for, or the file's format does not have it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Attributes {
    /// Return number (from 1; lower four bits) and number of returns of the pulse (upper four bits).
    pub returns: Vec<u8>,
    /// Bits as in byte 15 of LAS 1.4's formats: 0 synthetic, 1 key-point, 2 withheld, 3 overlap, 4 and 5
    /// the scanner channel, 6 the scan direction, 7 the edge of a flight line. Formats 0 to 5 have
    /// neither overlap (there it is class 12) nor channel.
    pub flags: Vec<u8>,
    /// ASPRS class; 0 to 31 in formats 0 to 5.
    pub classification: Vec<u8>,
    /// In steps of [`RecordFacts::scan_angle_step`](super::RecordFacts::scan_angle_step) degrees.
    pub scan_angle: Vec<i16>,
    pub user_data: Vec<u8>,
    /// Point source id: usually the flight line.
    pub point_source: Vec<u16>,
    /// Seconds, of the week or "adjusted standard" (the header says which); bit for bit as in the file.
    pub gps_time: Vec<f64>,
    /// Near infrared.
    pub nir: Vec<u16>,
    /// Wave packet descriptors as in the file: index (1 byte), offset (8), size (4), return point (4),
    /// x(t), y(t), z(t) (4 each), little-endian. All zero: no wave packet.
    pub wave_packet: Vec<[u8; WAVE_PACKET_BYTES]>,
    /// Raw extra bytes, [`RecordFacts::extra_bytes`](super::RecordFacts::extra_bytes) of them per point.
    pub extra: Vec<u8>,
}

/// Bytes of a wave packet descriptor.
pub const WAVE_PACKET_BYTES: usize = 29;

impl Attributes {
    /// Empties all columns and keeps their memory.
    pub fn clear(&mut self) {
        let Attributes {
            returns,
            flags,
            classification,
            scan_angle,
            user_data,
            point_source,
            gps_time,
            nir,
            wave_packet,
            extra,
        } = self;
        for bytes in [returns, flags, classification, user_data, extra] {
            bytes.clear();
        }
        point_source.clear();
        nir.clear();
        scan_angle.clear();
        gps_time.clear();
        wave_packet.clear();
    }

    /// Bytes in all columns.
    pub fn bytes(&self) -> u64 {
        // By name, as in `clear`: a new column has to be counted here.
        let Attributes {
            returns,
            flags,
            classification,
            scan_angle,
            user_data,
            point_source,
            gps_time,
            nir,
            wave_packet,
            extra,
        } = self;
        let single = [returns, flags, classification, user_data, extra];
        let other = [
            size_of_val(&scan_angle[..]),
            size_of_val(&point_source[..]),
            size_of_val(&gps_time[..]),
            size_of_val(&nir[..]),
            size_of_val(&wave_packet[..]),
        ];
        (single.iter().map(|column| column.len()).sum::<usize>() + other.iter().sum::<usize>()) as u64
    }

    /// The extra bytes of point `i` of the batch; empty if there are none.
    pub fn extra_of(&self, i: usize, bytes_per_point: usize) -> &[u8] {
        self.extra.get(i * bytes_per_point..(i + 1) * bytes_per_point).unwrap_or_default()
    }
}
