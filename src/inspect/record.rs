//! A point record's fields, from its bytes.

use std::{
    path::{Path, PathBuf},
    sync::atomic::AtomicBool,
};

use super::{Decimal, scaled, shortest, shortest_f32};
use crate::{
    scene::{Attributes, ExtraDimension, ExtraKind, GpsClock, Number, SceneFacts, WAVE_PACKET_BYTES},
    source::{
        Fields, RecordError, RecordFile, attributes, file_of_record,
        header::Header,
        layout::{RecordLayout, WavePacket as WaveLayout},
    },
};

/// A point record with everything that the file says of it.
#[derive(Debug, Clone, PartialEq)]
pub struct PointRecord {
    pub path: PathBuf,
    /// Number of the record in the file, counted from 0.
    pub record: u64,
    /// Point record format, 0 to 10.
    pub format: u8,
    /// X, Y, Z as stored.
    pub xyz: [i32; 3],
    /// Coordinates with the digits of scale and offset.
    pub coordinates: [Decimal; 3],
    pub intensity: u16,
    pub return_number: u8,
    pub number_of_returns: u8,
    pub flags: Flags,
    pub classification: u8,
    /// As stored: degrees in formats 0 to 5, else steps of 0.006 degrees.
    pub scan_angle: i16,
    pub scan_angle_deg: Decimal,
    pub user_data: u8,
    pub point_source: u16,
    pub gps_time: Option<f64>,
    /// What the file's times count.
    pub gps_clock: GpsClock,
    pub rgb: Option<[u16; 3]>,
    pub nir: Option<u16>,
    pub wave_packet: Option<WavePacket>,
    pub extra: Vec<ExtraValue>,
    /// Extra bytes that no dimension explains.
    pub unexplained: Vec<u8>,
}

/// The bits of a record beside its returns and its class. What only formats 6 and up have is `None` in others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Flags {
    pub synthetic: bool,
    pub key_point: bool,
    pub withheld: bool,
    pub overlap: Option<bool>,
    pub scanner_channel: Option<u8>,
    /// The mirror moved from left to right.
    pub scan_direction: bool,
    pub edge_of_flight_line: bool,
}

/// Where a point's waveform is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WavePacket {
    /// Of the descriptor among the file's records; 0 means that there is none.
    pub descriptor: u8,
    /// Bytes from the start of the waveform data, and how many there are.
    pub offset: u64,
    pub size: u32,
    /// Place of this return in the waveform, picoseconds.
    pub return_point: f32,
    /// Direction of the pulse, in coordinate units per picosecond.
    pub direction: [f32; 3],
    /// The writer has left out what the format promises.
    pub is_omitted: bool,
}

/// One dimension among the extra bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtraValue {
    pub name: String,
    pub description: String,
    pub kind: ExtraKind,
    /// Its bytes, as stored.
    pub bytes: Vec<u8>,
    /// Per element: as stored, and scaled. Of bytes that mean nothing: none.
    pub elements: Vec<ExtraElement>,
}

/// One number of an extra dimension.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtraElement {
    /// As stored, in the fewest digits that read back to it.
    pub raw: String,
    /// Scaled and offset, exactly. `None` where the file marks it as no data.
    pub value: Option<String>,
    /// The file has a scale or an offset for it.
    pub is_scaled: bool,
}

impl PointRecord {
    /// Reads record `record` of a file, counted from 0.
    ///
    /// # Errors
    /// In one line, if the file cannot be read or has no such record.
    pub fn read(path: &Path, record: u64, cancel: &AtomicBool) -> Result<PointRecord, RecordError> {
        PointRecord::read_from(&RecordFile::open(path, cancel)?, record, cancel)
    }

    /// Reads the record of a scene's point by its number, as pictures and picks have it; `None` if no file has it.
    ///
    /// # Errors
    /// As [`PointRecord::read`].
    pub fn read_of_scene(
        scene: &SceneFacts,
        record: u32,
        cancel: &AtomicBool,
    ) -> Option<Result<PointRecord, RecordError>> {
        let (file, record) = file_of_record(scene, record)?;
        Some(PointRecord::read(&scene.files[file].path, record, cancel))
    }

    /// Reads record `record` of an opened file, counted from 0.
    ///
    /// # Errors
    /// As [`PointRecord::read`].
    pub fn read_from(file: &RecordFile, record: u64, cancel: &AtomicBool) -> Result<PointRecord, RecordError> {
        let bytes = file.read(record, cancel)?;
        Ok(PointRecord::of_bytes(file.header(), file.extra_dimensions(), &file.fields(), record, &bytes))
    }

    fn of_bytes(
        header: &Header,
        dimensions: &[ExtraDimension],
        fields: &Fields,
        record: u64,
        bytes: &[u8],
    ) -> PointRecord {
        let layout = &header.layout;
        let mut columns = Attributes::default();
        attributes::append(bytes, layout, fields, &mut columns);
        let word = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let xyz: [i32; 3] = std::array::from_fn(|a| {
            i32::from_le_bytes([bytes[4 * a], bytes[4 * a + 1], bytes[4 * a + 2], bytes[4 * a + 3]])
        });
        let place = |a: usize| scaled(xyz[a].into(), header.scale[a], header.offset[a]);
        let [returns, flags] = [columns.returns[0], columns.flags[0]];
        let scan_angle = columns.scan_angle[0];
        // 0.006 times a whole number, not its nearest f64.
        let step = if layout.extended { 0.006 } else { 1.0 };
        PointRecord {
            path: header.path.clone(),
            record,
            format: header.format,
            xyz,
            coordinates: [0, 1, 2].map(|a| place(a).expect("the header's reader lets no other numbers through")),
            intensity: word(12),
            return_number: returns & 15,
            number_of_returns: returns >> 4,
            flags: Flags::new(flags, layout.extended),
            classification: columns.classification[0],
            scan_angle,
            scan_angle_deg: scaled(scan_angle.into(), step, 0.0).expect("both are finite"),
            user_data: columns.user_data[0],
            point_source: columns.point_source[0],
            gps_time: columns.gps_time.first().copied(),
            gps_clock: header.gps_clock(),
            rgb: layout.rgb_at.map(|at| [word(at), word(at + 2), word(at + 4)]),
            nir: columns.nir.first().copied(),
            wave_packet: WavePacket::new(layout, columns.wave_packet.first()),
            extra: dimensions.iter().filter_map(|d| ExtraValue::new(d, &columns.extra)).collect(),
            unexplained: unexplained(dimensions, &columns.extra),
        }
    }

    /// The point's time in words, where the format has any.
    pub fn gps_moment(&self) -> Option<String> {
        self.gps_clock.text(self.gps_time?)
    }
}

impl Flags {
    /// Of a byte as formats 6 and up have it.
    fn new(bits: u8, extended: bool) -> Flags {
        let bit = |n: u8| bits & 1 << n != 0;
        Flags {
            synthetic: bit(0),
            key_point: bit(1),
            withheld: bit(2),
            overlap: extended.then(|| bit(3)),
            scanner_channel: extended.then_some(bits >> 4 & 3),
            scan_direction: bit(6),
            edge_of_flight_line: bit(7),
        }
    }
}

impl WavePacket {
    fn new(layout: &RecordLayout, bytes: Option<&[u8; WAVE_PACKET_BYTES]>) -> Option<WavePacket> {
        let bytes = bytes?;
        let word = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        let float = |at| f32::from_bits(word(at));
        Some(WavePacket {
            descriptor: bytes[0],
            offset: u64::from(word(1)) | u64::from(word(5)) << 32,
            size: word(9),
            return_point: float(13),
            direction: [float(17), float(21), float(25)],
            is_omitted: layout.wave_packet == WaveLayout::Omitted,
        })
    }
}

impl ExtraValue {
    fn new(dimension: &ExtraDimension, extra: &[u8]) -> Option<ExtraValue> {
        let bytes = dimension.raw(extra)?.to_vec();
        let elements = (0..dimension.elements).map_while(|element| ExtraElement::new(dimension, extra, element));
        Some(ExtraValue {
            name: dimension.name.clone(),
            description: dimension.description.clone(),
            kind: dimension.kind,
            bytes,
            elements: elements.collect(),
        })
    }
}

impl ExtraElement {
    fn new(dimension: &ExtraDimension, extra: &[u8], element: usize) -> Option<ExtraElement> {
        let number = dimension.number(extra, element)?;
        let raw = match (number, dimension.kind) {
            // The nearest f64 of an f32 has many digits that say nothing.
            (Number::Float(n), ExtraKind::F32) => shortest_f32(n as f32),
            (Number::Float(n), _) => shortest(n),
            (whole, _) => whole.to_string(),
        };
        let of = |values: &Option<Vec<f64>>| values.as_ref().and_then(|values| values.get(element)).copied();
        let (scale, offset) = (of(&dimension.scale), of(&dimension.offset));
        let exact = match (number, dimension.kind) {
            (Number::Float(n), ExtraKind::F32) => Decimal::from_f32(n as f32),
            (Number::Float(n), _) => Decimal::from_f64(n),
            (Number::Signed(n), _) => Some(Decimal::from_integer(n.into())),
            (Number::Unsigned(n), _) => Some(Decimal::from_integer(n.into())),
        };
        let is_scaled = scale.is_some() || offset.is_some();
        let value = dimension.value_of(extra, element).map(|nearest| {
            let factors = Decimal::from_f64(scale.unwrap_or(1.0)).zip(Decimal::from_f64(offset.unwrap_or(0.0)));
            match (is_scaled, exact.zip(factors)) {
                (false, _) => raw.clone(),
                (true, Some((number, (scale, offset)))) => number.times(&scale).plus(&offset).to_string(),
                // Not a number, or infinite.
                (true, None) => shortest(nearest),
            }
        });
        Some(ExtraElement { raw, value, is_scaled })
    }
}

/// Extra bytes behind those that the dimensions explain.
fn unexplained(dimensions: &[ExtraDimension], extra: &[u8]) -> Vec<u8> {
    let explained = dimensions.iter().map(|d| d.at + d.bytes()).max().unwrap_or(0);
    extra.get(explained..).unwrap_or_default().to_vec()
}
