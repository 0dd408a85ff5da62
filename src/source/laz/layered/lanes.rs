//! All lanes of a chunk, and the loop over its points that drives them: all lanes of a point, then the
//! next point.
//!
//! Measured against it over six scans: one layer of 256 points after the other, each in a tight loop
//! (0.96 to 1.02 times as fast, 1.08 on one that is hard to compress); the first layer a point ahead of
//! the others (0.98 to 1.01); its symbols in turns with those of Z and intensity (0.93 to 1.06). That
//! independent lanes would overlap in the processor was the hope; a symbol is some 120 instructions, so
//! probably too few of them fit into what it looks ahead.

use std::ops::Range;

use laz::{LazItem, LazItemType};

use super::super::super::fields::Fields;
use super::contexts::Facts;
use super::position::Position;
use super::stream::{AnyLane, Field, Lane};
use super::{color, extra, gps, point, wave};

/// The lanes of the layers that are wanted and not empty.
pub struct Lanes {
    position: Lane<Position>,
    z: Option<Lane<point::Z>>,
    classification: Option<Lane<point::Classification>>,
    flags: Option<Lane<point::Flags>>,
    intensity: Option<Lane<point::Intensity>>,
    scan_angle: Option<Lane<point::ScanAngle>>,
    user_data: Option<Lane<point::UserData>>,
    point_source: Option<Lane<point::PointSource>>,
    gps_time: Option<Lane<gps::GpsTime>>,
    rgb: Option<Lane<color::Rgb>>,
    nir: Option<Lane<color::Nir>>,
    wave_packet: Option<Lane<wave::WavePacket>>,
    extra_bytes: Vec<Lane<extra::ExtraByte>>,
}

/// Decodes a lane's point, if there is such a lane; false if its bytes ended.
#[inline(always)]
fn step<F: Field>(lane: &mut Option<Lane<F>>, facts: Facts, record: &mut [u8]) -> bool {
    lane.as_mut().is_none_or(|lane| lane.step(facts, record))
}

impl Lanes {
    /// Lanes of a chunk with this first record. `position` is where its first layer is.
    pub fn new(first: &[u8], version: u16, position: Range<u64>) -> Lanes {
        Lanes {
            position: Lane::new(0, position, Position::new(first, version)),
            z: None,
            classification: None,
            flags: None,
            intensity: None,
            scan_angle: None,
            user_data: None,
            point_source: None,
            gps_time: None,
            rgb: None,
            nir: None,
            wave_packet: None,
            extra_bytes: Vec::new(),
        }
    }

    /// Adds the lane of a layer, part `part` of an item at byte `at` of the record, if it is wanted.
    pub fn add(
        &mut self,
        (item, part, at): (&LazItem, usize, usize),
        (number, range): (usize, Range<u64>),
        fields: Fields,
        first: &[u8],
    ) {
        let channel = usize::from(first[15] >> 4 & 3);
        macro_rules! lane {
            ($field:expr) => {
                Some(Lane::new(number, range, $field))
            };
        }
        use LazItemType as T;
        match (item.item_type(), part) {
            (T::Point14, 1) => self.z = lane!(point::Z::new(first, channel)),
            (T::Point14, 2) if fields.classification => {
                self.classification = lane!(point::Classification::new(first, channel));
            }
            (T::Point14, 3) if fields.returns => self.flags = lane!(point::Flags::new(first, channel)),
            (T::Point14, 4) if fields.intensity => self.intensity = lane!(point::Intensity::new(first, channel)),
            (T::Point14, 5) if fields.scan_angle => self.scan_angle = lane!(point::ScanAngle::new(first, channel)),
            (T::Point14, 6) if fields.user_data => self.user_data = lane!(point::UserData::new(first, channel)),
            (T::Point14, 7) if fields.point_source => {
                self.point_source = lane!(point::PointSource::new(first, channel));
            }
            (T::Point14, 8) if fields.gps_time => self.gps_time = lane!(gps::GpsTime::new(first, channel)),
            (T::RGB14 | T::RGBNIR14, 0) if fields.rgb => self.rgb = lane!(color::Rgb::new(first, channel, at)),
            (T::RGBNIR14, 1) if fields.nir => self.nir = lane!(color::Nir::new(first, channel, at + 6)),
            (T::WavePacket14, _) if fields.wave_packet => {
                self.wave_packet = lane!(wave::WavePacket::new(first, channel, at));
            }
            (T::Byte14(_), byte) if fields.extra_bytes => {
                self.extra_bytes.extend(lane!(extra::ExtraByte::new(first, channel, at + byte)));
            }
            _ => {}
        }
    }

    /// All lanes, the first layer's first.
    pub fn all(&self) -> impl Iterator<Item = &dyn AnyLane> {
        fn any<F>(lane: &Option<Lane<F>>) -> Option<&dyn AnyLane>
        where
            Lane<F>: AnyLane,
        {
            lane.as_ref().map(|lane| lane as &dyn AnyLane)
        }
        let lanes: [Option<&dyn AnyLane>; 12] = [
            Some(&self.position),
            any(&self.z),
            any(&self.classification),
            any(&self.flags),
            any(&self.intensity),
            any(&self.scan_angle),
            any(&self.user_data),
            any(&self.point_source),
            any(&self.gps_time),
            any(&self.rgb),
            any(&self.nir),
            any(&self.wave_packet),
        ];
        lanes.into_iter().flatten().chain(self.extra_bytes.iter().map(|lane| lane as &dyn AnyLane))
    }

    /// All lanes, in the same order.
    pub fn all_mut(&mut self) -> impl Iterator<Item = &mut dyn AnyLane> {
        fn any<F>(lane: &mut Option<Lane<F>>) -> Option<&mut dyn AnyLane>
        where
            Lane<F>: AnyLane,
        {
            lane.as_mut().map(|lane| lane as &mut dyn AnyLane)
        }
        let lanes: [Option<&mut dyn AnyLane>; 12] = [
            Some(&mut self.position),
            any(&mut self.z),
            any(&mut self.classification),
            any(&mut self.flags),
            any(&mut self.intensity),
            any(&mut self.scan_angle),
            any(&mut self.user_data),
            any(&mut self.point_source),
            any(&mut self.gps_time),
            any(&mut self.rgb),
            any(&mut self.nir),
            any(&mut self.wave_packet),
        ];
        lanes.into_iter().flatten().chain(self.extra_bytes.iter_mut().map(|lane| lane as &mut dyn AnyLane))
    }

    /// Bytes on the heap, with its own and without the layers'.
    pub fn memory_bytes(&self) -> usize {
        size_of::<Lanes>()
            + self.extra_bytes.capacity() * size_of::<Lane<extra::ExtraByte>>()
            + self.all().map(AnyLane::memory_bytes).sum::<usize>()
    }

    /// Points that the loaded bytes of all lanes hold for certain.
    pub fn room(&mut self) -> usize {
        self.all_mut().map(AnyLane::room).min().unwrap_or(0)
    }

    /// Why the last call to [`Lanes::decode`] ended early.
    pub fn fault(&self) -> String {
        let ended = self.all().find(|lane| lane.has_ended()).map(|lane| lane.place().0);
        ended.map_or_else(
            || "its GPS times make no sense".to_owned(),
            |layer| format!("the bytes of its layer {layer} end early"),
        )
    }

    /// Decodes points into their records, which hold the first record's values: one that is not decoded
    /// keeps them. Returns their number,
    /// smaller than the records' if the bytes of a lane ended or make no sense.
    pub fn decode(&mut self, records: &mut [u8], record_length: usize) -> usize {
        let mut done = 0;
        for record in records.chunks_exact_mut(record_length) {
            let (position, coder, bytes) = self.position.parts();
            let facts = position.step(coder, bytes, record);
            let mut good = !self.position.has_ended();
            good &= step(&mut self.z, facts, record);
            good &= step(&mut self.classification, facts, record);
            good &= step(&mut self.flags, facts, record);
            good &= step(&mut self.intensity, facts, record);
            good &= step(&mut self.scan_angle, facts, record);
            good &= step(&mut self.user_data, facts, record);
            good &= step(&mut self.point_source, facts, record);
            good &= step(&mut self.gps_time, facts, record);
            good &= step(&mut self.rgb, facts, record);
            good &= step(&mut self.nir, facts, record);
            good &= step(&mut self.wave_packet, facts, record);
            for lane in &mut self.extra_bytes {
                good &= lane.step(facts, record);
            }
            if !good {
                return done;
            }
            done += 1;
        }
        done
    }
}
