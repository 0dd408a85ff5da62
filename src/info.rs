//! What a file says of itself, for `firstlight info`: header, variable length records, coordinate
//! system, counts per return and per chunk. No point is decoded.

use std::{
    fmt::{self, Display, Formatter},
    path::{Path, PathBuf},
    sync::atomic::AtomicBool,
};

use las::point::Format;
use serde::Serialize;

use crate::{
    scene::{ExtraDimension, GpsClock},
    source::{
        SourceError,
        chunks::{ChunkSource, LazLayout},
        crs::Crs,
        header::{GpsTimes, Header, RECORD_LENGTHS},
        text,
        vlr::Vlr,
    },
};

/// Chunks that the text lists; JSON lists all of them.
const CHUNKS_IN_TEXT: usize = 8;

/// All that is known of a file without decoding its points.
#[derive(Debug, Clone, Serialize)]
pub struct Info {
    pub path: PathBuf,
    /// Size of the file in bytes.
    pub file_bytes: u64,
    /// e.g. "LAZ 1.4, format 7".
    pub kind: String,
    pub version: String,
    pub system_identifier: String,
    pub generating_software: String,
    /// Day of the year (from 1) and year; zeros if the file doesn't say.
    pub created_day: u16,
    pub created_year: u16,
    pub file_source_id: u16,
    pub global_encoding: GlobalEncoding,
    pub guid: String,
    pub header_bytes: u16,
    /// File offset of the point data, in bytes.
    pub point_data_at: u64,
    pub points: PointInfo,
    /// As in the header, in the unit of the coordinate system.
    pub scale: [f64; 3],
    pub offset: [f64; 3],
    pub min: [f64; 3],
    pub max: [f64; 3],
    /// What GPS times count; `None` if the points have none.
    pub gps_clock: Option<GpsClock>,
    /// Range of GPS times, and their offset, where the header says them (LAS 1.5).
    pub gps_times: Option<GpsTimes>,
    pub crs: Crs,
    /// File offset of the waveform packets in the file, if there are any.
    pub waveforms_at: Option<u64>,
    pub vlrs: Vec<VlrInfo>,
    pub evlrs: Vec<VlrInfo>,
    /// How the points are compressed; `None` for LAS.
    pub laz: Option<LazInfo>,
    /// Oddities of the header, one line each.
    pub warnings: Vec<String>,
}

/// The header's flags.
#[derive(Debug, Clone, Serialize)]
pub struct GlobalEncoding {
    pub bits: u16,
    /// GPS time is "adjusted standard" time; else seconds of the week.
    pub standard_gps_time: bool,
    pub waveforms_inside: bool,
    pub waveforms_beside: bool,
    pub synthetic_returns: bool,
    pub crs_is_wkt: bool,
    /// LAS 1.5: with `standard_gps_time`, the header's offset is taken off as well.
    pub offset_gps_time: bool,
}

/// Point records, as the header describes them.
#[derive(Debug, Clone, Serialize)]
pub struct PointInfo {
    pub format: u8,
    /// Bytes of a record, and how many of them the format does not explain.
    pub record_bytes: u16,
    pub extra_bytes: u16,
    pub has_gps_time: bool,
    pub has_color: bool,
    pub has_near_infrared: bool,
    pub has_waveform: bool,
    /// The header's count, and its counts by return number (from 1; 5 numbers, 15 from LAS 1.4 on).
    pub count: u64,
    pub by_return: Vec<u64>,
    /// Degrees per step of the scan angle.
    pub scan_angle_step: f64,
    /// What the extra bytes mean, as far as the file says.
    pub extra_dimensions: Vec<ExtraDimension>,
}

/// One variable length record.
#[derive(Debug, Clone, Serialize)]
pub struct VlrInfo {
    pub user_id: String,
    pub record_id: u16,
    pub description: String,
    /// File offset and length in bytes of the contents.
    pub at: u64,
    pub bytes: u64,
}

/// How a LAZ file is compressed.
#[derive(Debug, Clone, Serialize)]
pub struct LazInfo {
    /// LASzip's compressor number and what it means.
    pub compressor: u16,
    pub compressor_name: &'static str,
    pub items: Vec<LazItemInfo>,
    /// Points per chunk; `None` if it varies.
    pub chunk_size: Option<u32>,
    pub chunks_found_by: ChunkSource,
    pub chunks: Vec<ChunkInfo>,
}

/// A group of fields that is compressed together.
#[derive(Debug, Clone, Serialize)]
pub struct LazItemInfo {
    pub name: String,
    pub bytes: u16,
    pub version: u16,
}

/// A run of points that can be decoded on its own.
#[derive(Debug, Clone, Serialize)]
pub struct ChunkInfo {
    pub at: u64,
    pub bytes: u64,
    pub points: u64,
}

impl Info {
    /// Reads a file's header, records and chunk table.
    ///
    /// # Errors
    ///
    /// The file cannot be read, or is no LAS file. What is wrong with the compression is only a warning.
    pub fn read(path: &Path) -> Result<Info, SourceError> {
        let (mut header, file) = Header::read(path)?;
        let mut warnings = std::mem::take(&mut header.warnings);
        let laz = header.compressed.then(|| LazLayout::read(&header, &file, &mut warnings, &AtomicBool::new(false)));
        let laz = laz.and_then(|read| read.map_err(|e| warnings.push(e.to_string())).ok());
        let crs = Crs::read(&file, header.all_vlrs()).map_err(|e| SourceError::Io {
            path: path.into(),
            doing: "read the coordinate system",
            reason: e.to_string(),
        })?;
        let extra_dimensions = header.extra_dimensions(&file, &mut warnings);
        let by_return = header.points_by_return.iter().fold(0, |sum: u64, &n| sum.saturating_add(n));
        if by_return != header.points {
            warnings.push(format!("the counts by return add up to {by_return}, not to {} points", header.points));
        }
        let raw = &header.raw;
        let format = Format::new(header.format).unwrap_or_default();
        Ok(Info {
            path: path.into(),
            file_bytes: header.file_length,
            kind: header.kind(),
            version: raw.version.to_string(),
            system_identifier: text(&raw.system_identifier),
            generating_software: text(&raw.generating_software),
            created_day: raw.file_creation_day_of_year,
            created_year: raw.file_creation_year,
            file_source_id: raw.file_source_id,
            global_encoding: GlobalEncoding::new(raw.global_encoding),
            guid: guid(&raw.guid),
            header_bytes: raw.header_size,
            point_data_at: header.data_at(),
            points: PointInfo {
                format: header.format,
                record_bytes: raw.point_data_record_length,
                extra_bytes: raw.point_data_record_length - RECORD_LENGTHS[usize::from(header.format)],
                has_gps_time: format.has_gps_time,
                has_color: format.has_color,
                has_near_infrared: format.has_nir,
                has_waveform: format.has_waveform,
                count: header.points,
                by_return: header.points_by_return.clone(),
                scan_angle_step: if header.layout.extended { 0.006 } else { 1.0 },
                extra_dimensions,
            },
            scale: [raw.x_scale_factor, raw.y_scale_factor, raw.z_scale_factor],
            offset: [raw.x_offset, raw.y_offset, raw.z_offset],
            min: header.bounds.min,
            max: header.bounds.max,
            gps_clock: format.has_gps_time.then(|| header.gps_clock()),
            gps_times: header.gps_times,
            crs,
            waveforms_at: raw.start_of_waveform_data_packet_record,
            vlrs: header.vlrs.iter().map(VlrInfo::new).collect(),
            evlrs: header.evlrs.iter().map(VlrInfo::new).collect(),
            laz: laz.map(|l| LazInfo::new(&l)),
            warnings,
        })
    }
}

impl GlobalEncoding {
    fn new(bits: u16) -> Self {
        let bit = |n: u16| bits & 1 << n != 0;
        GlobalEncoding {
            bits,
            standard_gps_time: bit(0),
            waveforms_inside: bit(1),
            waveforms_beside: bit(2),
            synthetic_returns: bit(3),
            crs_is_wkt: bit(4),
            offset_gps_time: bit(6),
        }
    }

    fn words(&self) -> String {
        let words = [
            (self.standard_gps_time && !self.offset_gps_time, "standard GPS time"),
            (self.standard_gps_time && self.offset_gps_time, "offset GPS time"),
            (!self.standard_gps_time && self.offset_gps_time, "GPS time of the week, with an offset flag"),
            (self.waveforms_inside, "waveforms inside"),
            (self.waveforms_beside, "waveforms in a .wdp file"),
            (self.synthetic_returns, "synthetic returns"),
            (self.crs_is_wkt, "CRS is WKT"),
        ];
        let words: Vec<&str> = words.iter().filter(|(set, _)| *set).map(|(_, word)| *word).collect();
        if words.is_empty() { self.bits.to_string() } else { format!("{} ({})", self.bits, words.join(", ")) }
    }
}

impl VlrInfo {
    fn new(vlr: &Vlr) -> Self {
        VlrInfo {
            user_id: vlr.user_id.clone(),
            record_id: vlr.record_id,
            description: vlr.description.clone(),
            at: vlr.data_at,
            bytes: vlr.data_length,
        }
    }
}

impl LazInfo {
    fn new(layout: &LazLayout) -> Self {
        LazInfo {
            compressor: layout.compressor,
            compressor_name: match layout.compressor {
                1 => "point-wise",
                2 => "point-wise, in chunks",
                _ => "layered, in chunks",
            },
            items: layout
                .items
                .iter()
                .map(|i| {
                    let name = format!("{:?}", i.item_type());
                    let name = name.split('(').next().unwrap_or_default().to_owned();
                    LazItemInfo { name, bytes: i.size(), version: i.version() }
                })
                .collect(),
            chunk_size: layout.chunk_size,
            chunks_found_by: layout.source,
            chunks: layout.chunks.iter().map(|c| ChunkInfo { at: c.at, bytes: c.bytes, points: c.points }).collect(),
        }
    }
}

/// The project's GUID in its usual form; its first three groups are little-endian numbers.
fn guid(b: &[u8; 16]) -> String {
    let hex = |bytes: &[u8]| bytes.iter().map(|b| format!("{b:02x}")).collect::<String>();
    let order = [b[3], b[2], b[1], b[0], b[5], b[4], b[7], b[6]];
    [hex(&order[..4]), hex(&order[4..6]), hex(&order[6..8]), hex(&b[8..10]), hex(&b[10..])].join("-")
}

impl Display for Info {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let p = &self.points;
        writeln!(f, "{}", self.path.display())?;
        line(f, "kind", format_args!("{}, {} bytes", self.kind, self.file_bytes))?;
        line(f, "system", &self.system_identifier)?;
        line(f, "software", &self.generating_software)?;
        line(f, "created", format_args!("day {} of {}", self.created_day, self.created_year))?;
        line(f, "source id", self.file_source_id)?;
        line(f, "encoding", self.global_encoding.words())?;
        line(f, "guid", &self.guid)?;
        line(f, "header", format_args!("{} bytes, points from byte {}", self.header_bytes, self.point_data_at))?;
        line(
            f,
            "records",
            format_args!("format {}, {} bytes, {} of them extra bytes", p.format, p.record_bytes, p.extra_bytes),
        )?;
        for dimension in &p.extra_dimensions {
            line(f, "extra", dimension_words(dimension))?;
        }
        line(f, "points", p.count)?;
        let used = p.by_return.iter().rposition(|&n| n > 0).map_or(0, |last| last + 1);
        let returns: Vec<String> = (1..).zip(&p.by_return[..used]).map(|(r, n)| format!("{r}: {n}")).collect();
        line(f, "by return", returns.join(", "))?;
        line(f, "scale", numbers(&self.scale))?;
        line(f, "offset", numbers(&self.offset))?;
        line(f, "min", numbers(&self.min))?;
        line(f, "max", numbers(&self.max))?;
        if let Some(t) = &self.gps_times {
            let text = |time| self.gps_clock?.text(time);
            let words = text(t.min).zip(text(t.max)).map(|(min, max)| format!(" ({min} to {max})")).unwrap_or_default();
            line(f, "gps time", format_args!("{} to {}, offset {} million s{words}", t.min, t.max, t.offset))?;
        }
        line(f, "crs", self.crs.summary().unwrap_or_else(|| "none".into()))?;
        for (name, vlrs) in [("vlr", &self.vlrs), ("evlr", &self.evlrs)] {
            for v in vlrs {
                let what = format_args!("{} {}, {} bytes at byte {}", v.user_id, v.record_id, v.bytes, v.at);
                if v.description.is_empty() {
                    line(f, name, what)?;
                } else {
                    line(f, name, format_args!("{what}: {}", v.description))?;
                }
            }
        }
        if let Some(laz) = &self.laz {
            laz.fmt(f)?;
        }
        self.warnings.iter().try_for_each(|w| line(f, "warning", w))
    }
}

impl Display for LazInfo {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let items: Vec<String> =
            self.items.iter().map(|i| format!("{} v{} ({} bytes)", i.name, i.version, i.bytes)).collect();
        line(f, "compressor", format_args!("{} ({}): {}", self.compressor, self.compressor_name, items.join(", ")))?;
        let size = self.chunk_size.map_or("varying size".into(), |n| format!("{n} points"));
        let found = match self.chunks_found_by {
            ChunkSource::Table => "from the chunk table",
            ChunkSource::Walked => "without a table, walked",
            ChunkSource::OneStream => "without a table, one stream",
        };
        line(f, "chunks", format_args!("{} of {size}, {found}", self.chunks.len()))?;
        for (number, chunk) in self.chunks.iter().enumerate().take(CHUNKS_IN_TEXT) {
            let ChunkInfo { at, bytes, points } = chunk;
            line(f, "chunk", format_args!("{number}: {points} points, {bytes} bytes at byte {at}"))?;
        }
        if self.chunks.len() > CHUNKS_IN_TEXT {
            line(f, "", format_args!("and {} more (all of them with --json)", self.chunks.len() - CHUNKS_IN_TEXT))?;
        }
        Ok(())
    }
}

/// e.g. "«height» f32 at byte 2, scale 0.01: above ground".
fn dimension_words(d: &ExtraDimension) -> String {
    let mut words = format!("«{}» {} at byte {}", d.name, d.type_name(), d.at);
    let numbers = [("no data", &d.no_data), ("min", &d.min), ("max", &d.max)];
    let numbers = numbers.iter().filter_map(|(name, n)| n.as_ref().map(|n| (*name, n)));
    for (name, numbers) in numbers {
        let numbers: Vec<String> = numbers.iter().map(|n| n.to_string()).collect();
        words += &format!(", {name} {}", numbers.join(" "));
    }
    for (name, values) in [("scale", &d.scale), ("offset", &d.offset)] {
        if let Some(values) = values {
            let values: Vec<String> = values.iter().map(f64::to_string).collect();
            words += &format!(", {name} {}", values.join(" "));
        }
    }
    if !d.description.is_empty() {
        words += &format!(": {}", d.description);
    }
    words
}

fn line(f: &mut Formatter<'_>, name: &str, value: impl Display) -> fmt::Result {
    writeln!(f, "{}", format!("  {name:<11}{value}").trim_end())
}

fn numbers(values: &[f64; 3]) -> String {
    values.map(|v| v.to_string()).join("  ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn guid_has_its_usual_form() {
        let bytes: [u8; 16] = std::array::from_fn(|i| i as u8);
        assert_eq!(guid(&bytes), "03020100-0504-0706-0809-0a0b0c0d0e0f");
    }
}
