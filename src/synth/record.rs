//! A point as the bytes of a LAS record, and what the header has to say of many.

use super::SynthPoint;

/// Known to formats 6 and above only.
const BRIDGE_DECK: u8 = 17;
const GROUND: u8 = 2;

/// Bytes per record of a point format.
pub(super) fn record_length(format: u8) -> u16 {
    match format {
        0 => 20,
        1 => 28,
        2 => 26,
        3 => 34,
        6 => 30,
        7 => 36,
        _ => 38,
    }
}

/// Appends a point's record; fields that the format lacks are dropped. `start` is the survey's GPS time.
#[inline]
pub(super) fn push_record(out: &mut Vec<u8>, format: u8, point: &SynthPoint, start: f64) {
    let mut record = [0u8; 38];
    let mut at = 0;
    let mut put = |bytes: &[u8]| {
        record[at..at + bytes.len()].copy_from_slice(bytes);
        at += bytes.len();
    };
    for x in point.position {
        put(&x.to_le_bytes());
    }
    put(&point.intensity.to_le_bytes());
    let flags = u8::from(point.scan_direction) << 6 | u8::from(point.edge_of_flight_line) << 7;
    if format < 6 {
        put(&[point.return_number | point.number_of_returns << 3 | flags]);
        put(&[if point.classification == BRIDGE_DECK { GROUND } else { point.classification }]);
        put(&[(f64::from(point.scan_angle) * 0.006) as i8 as u8, 0]);
        put(&point.point_source.to_le_bytes());
    } else {
        put(&[point.return_number | point.number_of_returns << 4, flags, point.classification, 0]);
        put(&point.scan_angle.to_le_bytes());
        put(&point.point_source.to_le_bytes());
    }
    if !matches!(format, 0 | 2) {
        put(&(start + point.gps_time).to_le_bytes());
    }
    if matches!(format, 2 | 3 | 7 | 8) {
        for c in point.rgb {
            put(&c.to_le_bytes());
        }
    }
    if format == 8 {
        put(&point.nir.to_le_bytes());
    }
    out.extend_from_slice(&record[..at]);
}

/// What the header says of its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Tally {
    pub points: u64,
    /// Points per return number, from 1.
    pub by_return: [u64; 15],
    /// Smallest and largest record integers; turned inside out without points.
    pub low: [i32; 3],
    pub high: [i32; 3],
}

impl Default for Tally {
    fn default() -> Tally {
        Tally { points: 0, by_return: [0; 15], low: [i32::MAX; 3], high: [i32::MIN; 3] }
    }
}

impl Tally {
    #[inline]
    pub fn add(&mut self, point: &SynthPoint) {
        self.points += 1;
        self.by_return[usize::from(point.return_number) - 1] += 1;
        for axis in 0..3 {
            self.low[axis] = self.low[axis].min(point.position[axis]);
            self.high[axis] = self.high[axis].max(point.position[axis]);
        }
    }

    pub fn merge(&mut self, other: &Tally) {
        self.points += other.points;
        for (a, b) in self.by_return.iter_mut().zip(other.by_return) {
            *a += b;
        }
        for axis in 0..3 {
            self.low[axis] = self.low[axis].min(other.low[axis]);
            self.high[axis] = self.high[axis].max(other.high[axis]);
        }
    }
}
