//! The public header block of a LAS or LAZ file, read tolerantly: what can be worked around becomes a
//! warning, what cannot becomes a [`SourceError`]. Nothing is allocated on the header's word alone.

use std::{
    fs::File,
    io::Read,
    path::{Path, PathBuf},
};

use laz::{LazItemType, LazVlr};

use super::{
    SourceError,
    bytes::{i32_at, read_vec_at, text, u16_at, u64_at},
    chunks, extra_bytes,
    inputs::from_io,
    layout::RecordLayout,
    vlr::{self, Vlr},
};
use crate::scene::{Bounds, ExtraDimension, GpsClock};

/// Bytes of a record of each point format, without extra bytes.
pub const RECORD_LENGTHS: [u16; 11] = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];

/// Bytes of the header that LAS 1.5 defines.
const HEADER_1_5: usize = 393;
const HEADER_1_0: u64 = 227;

/// So many lists of extra bytes are read, each up to this many bytes: 341 dimensions.
const MAX_EXTRA_LISTS: usize = 64;
const MAX_EXTRA_LIST: usize = 64 << 10;

/// What LAS 1.5 adds to the header (bytes 375 to 392).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct GpsTimes {
    pub max: f64,
    pub min: f64,
    /// Millions of seconds that are taken off standard GPS time, if the global encoding's bits 0 and 6
    /// are both set.
    pub offset: u16,
}

/// A file's header and its lists of variable length records.
#[derive(Debug)]
pub struct Header {
    pub path: PathBuf,
    pub file_length: u64,
    /// The header's fields as they are in the file.
    pub raw: las::raw::Header,
    /// Point record format, 0 to 10, without the bits that mark compression.
    pub format: u8,
    pub compressed: bool,
    /// Where the fields of a record are, as they come out of the decoder.
    pub layout: RecordLayout,
    /// Points that the header promises: the 64-bit count where there is one, else the legacy count.
    pub points: u64,
    pub points_by_return: Vec<u64>,
    /// Scale and offset per axis, made usable: never zero or not finite.
    pub scale: [f64; 3],
    pub offset: [f64; 3],
    /// The header's box, as it is.
    pub bounds: Bounds,
    /// LAS 1.5 only.
    pub gps_times: Option<GpsTimes>,
    pub vlrs: Vec<Vlr>,
    pub evlrs: Vec<Vlr>,
    /// Oddities that cost nothing, one line each.
    pub warnings: Vec<String>,
}

impl Header {
    /// What the points' GPS times count, by the global encoding's bits 0 and 6.
    pub fn gps_clock(&self) -> GpsClock {
        let encoding = self.raw.global_encoding;
        match (encoding & 1, encoding >> 6 & 1, &self.gps_times) {
            (0, ..) => GpsClock::Week,
            (_, 1, Some(times)) => GpsClock::Standard { offset_secs: 1_000_000 * u64::from(times.offset) },
            _ => GpsClock::ADJUSTED,
        }
    }

    /// Opens a file and reads its header.
    pub fn read(path: &Path) -> Result<(Header, File), SourceError> {
        let (file, file_length) = open_regular(path)?;
        let io = |error| from_io(path, "read the header", &error);
        let mut bytes = read_vec_at(&file, 0, (HEADER_1_5 as u64).min(file_length) as usize).map_err(io)?;
        check_signature(path, &bytes)?;
        let found = bytes.len() as u64;
        let cut = |expected| SourceError::HeaderCut { path: path.into(), expected, found };
        if found < HEADER_1_0 {
            return Err(cut(HEADER_1_0));
        }
        let (major, minor) = (bytes[24], bytes[25]);
        if major != 1 || minor > 5 {
            return Err(SourceError::Version { path: path.into(), major, minor });
        }
        // las knows versions up to 1.4; 1.5 keeps their layout and appends to it.
        bytes[25] = minor.min(4);
        let standard = u64::from(las::Version::new(1, bytes[25]).header_size());
        if found < standard {
            return Err(cut(standard));
        }
        let mut raw = las::raw::Header::read_from(bytes.as_slice().chain(std::io::repeat(0)))
            .map_err(|e| SourceError::Io { path: path.into(), doing: "read the header", reason: e.to_string() })?;
        raw.version.minor = minor;
        raw.padding = Vec::new();

        // LASzip sets bit 7 of the format (and used bit 6 once).
        let format = raw.point_data_record_format & 0x3f;
        let compressed = raw.point_data_record_format & 0xc0 != 0;
        let Some(&expected) = RECORD_LENGTHS.get(usize::from(format)) else {
            return Err(SourceError::Format { path: path.into(), found: raw.point_data_record_format });
        };
        let found = raw.point_data_record_length;
        if found < expected {
            return Err(SourceError::RecordLength { path: path.into(), format, expected, found });
        }
        if u64::from(raw.offset_to_point_data) < standard {
            let found = raw.offset_to_point_data;
            return Err(SourceError::PointOffset { path: path.into(), header_size: raw.header_size, found });
        }

        let mut warnings = Vec::new();
        let (points, points_by_return) = counts(&raw, &mut warnings);
        let (scale, offset) = usable_transform(&raw, &mut warnings);
        let bounds = Bounds { min: [raw.min_x, raw.min_y, raw.min_z], max: [raw.max_x, raw.max_y, raw.max_z] };
        let gps_times = gps_times(&raw, &bytes, format, &mut warnings);
        let (vlrs, evlrs) = records(&file, file_length, &raw, standard, &mut warnings).map_err(io)?;
        let mut layout = RecordLayout::new(format, usize::from(found - expected));
        if compressed && wave_packet_is_omitted(&file, &layout, vlrs.iter().chain(&evlrs)) {
            // Files of format 10 from such a writer hold wave packet bytes where near infrared should be.
            let nir = if layout.nir_at.is_some() { "; near infrared may be wrong, too" } else { "" };
            warnings.push(format!(
                "the compressed records leave out the wave packet of format {format}: {} instead of {} bytes{nir}",
                layout.without_wave_packet().length,
                layout.length
            ));
            layout = layout.without_wave_packet();
        }
        let header = Header {
            path: path.into(),
            file_length,
            raw,
            format,
            compressed,
            layout,
            points,
            points_by_return,
            scale,
            offset,
            bounds,
            gps_times,
            vlrs,
            evlrs,
            warnings,
        };
        Ok((header, file))
    }

    /// Bytes of a record, as it comes out of the decoder.
    pub fn record_length(&self) -> usize {
        self.layout.length
    }

    /// File offset of the point data.
    pub fn data_at(&self) -> u64 {
        u64::from(self.raw.offset_to_point_data)
    }

    /// What the extra bytes mean, as far as the file says.
    pub fn extra_dimensions(&self, file: &File, warnings: &mut Vec<String>) -> Vec<ExtraDimension> {
        let mut lists = Vec::new();
        for vlr in self.all_vlrs().filter(|v| v.is(extra_bytes::USER_ID, extra_bytes::RECORD_ID)).take(MAX_EXTRA_LISTS)
        {
            match vlr.data(file, MAX_EXTRA_LIST) {
                Ok(list) => lists.push(list),
                Err(e) => warnings.push(format!("extra bytes: cannot read their list at byte {}: {e}", vlr.data_at)),
            }
        }
        extra_bytes::parse(&lists, self.layout.extra_bytes(), warnings)
    }

    /// e.g. "LAZ 1.4, format 7".
    pub fn kind(&self) -> String {
        let family = match (self.compressed, self.is_copc()) {
            (true, true) => "COPC",
            (true, false) => "LAZ",
            (false, _) => "LAS",
        };
        format!("{family} {}.{}, format {}", self.raw.version.major, self.raw.version.minor, self.format)
    }

    pub fn is_copc(&self) -> bool {
        self.vlrs.first().is_some_and(|v| v.is("copc", 1))
    }

    pub fn all_vlrs(&self) -> impl Iterator<Item = &Vlr> {
        self.vlrs.iter().chain(&self.evlrs)
    }
}

/// Opens a regular file; a pipe or a device would block or never end.
pub fn open_regular(path: &Path) -> Result<(File, u64), SourceError> {
    let meta = std::fs::metadata(path).map_err(|e| from_io(path, "look at the file", &e))?;
    if !meta.is_file() {
        let found = if meta.is_dir() { "a folder" } else { "a pipe or a device" };
        return Err(SourceError::NotAFile { path: path.into(), found });
    }
    let file = File::open(path).map_err(|e| from_io(path, "open the file", &e))?;
    Ok((file, meta.len()))
}

fn check_signature(path: &Path, bytes: &[u8]) -> Result<(), SourceError> {
    if bytes.starts_with(b"LASF") {
        return Ok(());
    }
    let found = match bytes.get(..bytes.len().min(4)) {
        None | Some([]) => "an empty file".to_owned(),
        Some(start) if start.iter().all(|b| b.is_ascii_graphic() || *b == b' ') => format!("«{}»", text(start)),
        Some(start) => start.iter().map(|b| format!("{b:02x}")).collect::<Vec<_>>().join(" "),
    };
    Err(SourceError::NotLas { path: path.into(), found })
}

/// The point count to believe, and the counts per return that go with it.
fn counts(raw: &las::raw::Header, warnings: &mut Vec<String>) -> (u64, Vec<u64>) {
    let legacy = u64::from(raw.number_of_point_records);
    let legacy_by_return: Vec<u64> = raw.number_of_points_by_return.iter().map(|&n| n.into()).collect();
    match raw.large_file {
        Some(large) if large.number_of_point_records != 0 => {
            let points = large.number_of_point_records;
            if legacy != 0 && legacy != points {
                warnings.push(format!("two point counts: {points} (byte 247, used) and {legacy} (byte 107, legacy)"));
            }
            (points, large.number_of_points_by_return.to_vec())
        }
        _ => (legacy, legacy_by_return),
    }
}

/// The fields that LAS 1.5 appends.
fn gps_times(raw: &las::raw::Header, bytes: &[u8], format: u8, warnings: &mut Vec<String>) -> Option<GpsTimes> {
    if raw.version.minor < 5 {
        return None;
    }
    if format < 6 {
        warnings.push(format!("LAS 1.5 has point record formats 6 to 10, found {format}; it is read all the same"));
    }
    let size = usize::from(raw.header_size);
    if size < HEADER_1_5 || bytes.len() < HEADER_1_5 {
        warnings
            .push(format!("expected a header of {HEADER_1_5} bytes in LAS 1.5, found {size}: no range of GPS times"));
        return None;
    }
    let time = |at| f64::from_bits(u64_at(bytes, at));
    Some(GpsTimes { max: time(375), min: time(383), offset: u16_at(bytes, 391) })
}

/// Scale and offset, with anything unusable replaced (and said so): a scale of zero would put all
/// points into one place, and a NaN nowhere at all.
fn usable_transform(raw: &las::raw::Header, warnings: &mut Vec<String>) -> ([f64; 3], [f64; 3]) {
    let mut scale = [raw.x_scale_factor, raw.y_scale_factor, raw.z_scale_factor];
    let mut offset = [raw.x_offset, raw.y_offset, raw.z_offset];
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let found = scale[axis];
        if !(1e-15..=1e15).contains(&found.abs()) {
            warnings.push(format!("{name} scale: expected a number that is not zero, found {found:e}; 1 is used"));
            scale[axis] = 1.0;
        }
        let found = offset[axis];
        if !found.is_finite() || found.abs() > 1e15 {
            warnings.push(format!("{name} offset: expected a coordinate, found {found:e}; 0 is used"));
            offset[axis] = 0.0;
        }
    }
    (scale, offset)
}

fn records(
    file: &File,
    file_length: u64,
    raw: &las::raw::Header,
    standard: u64,
    warnings: &mut Vec<String>,
) -> std::io::Result<(Vec<Vlr>, Vec<Vlr>)> {
    let mut start = u64::from(raw.header_size);
    if start < standard {
        warnings.push(format!("header size {start} is less than the {standard} bytes of its version; {standard} used"));
        start = standard;
    }
    let end = u64::from(raw.offset_to_point_data).min(file_length);
    let vlrs = vlr::walk(file, (start, end), raw.number_of_variable_length_records.into(), false, warnings)?;
    let evlrs = match raw.evlr {
        Some(evlr) if evlr.number_of_evlrs > 0 && evlr.start_of_first_evlr > 0 => {
            let span = (evlr.start_of_first_evlr, file_length);
            vlr::walk(file, span, evlr.number_of_evlrs.into(), true, warnings)?
        }
        _ => Vec::new(),
    };
    Ok((vlrs, evlrs))
}

/// True if LASzip's items are those of the layout without its wave packet: old versions of some writers
/// left it out, and only it.
fn wave_packet_is_omitted<'a>(file: &File, layout: &RecordLayout, mut vlrs: impl Iterator<Item = &'a Vlr>) -> bool {
    let without = layout.without_wave_packet();
    without != *layout
        && vlrs
            .find(|v| v.is(LazVlr::USER_ID, LazVlr::RECORD_ID))
            .and_then(|v| v.data(file, 64 << 10).ok())
            .and_then(|bytes| chunks::parse_vlr(&bytes, without.length).ok())
            .is_some_and(|(_, _, items)| {
                !items.iter().any(|i| matches!(i.item_type(), LazItemType::WavePacket13 | LazItemType::WavePacket14))
            })
}

/// Reads the first 12 bytes of a raw record: X, Y, Z.
pub fn xyz_at(file: &File, at: u64) -> Option<[i32; 3]> {
    let bytes = read_vec_at(file, at, 12).ok().filter(|b| b.len() == 12)?;
    Some(std::array::from_fn(|a| i32_at(&bytes, 4 * a)))
}
