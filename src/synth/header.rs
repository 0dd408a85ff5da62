//! The bytes before the points: public header block and variable length records.

use las::{
    Version,
    raw::{Header, header::LargeFile},
};
use laz::LazVlr;

use super::{SynthOptions, record::Tally, record::record_length};

/// GPS time at the survey's start: adjusted standard time (LAS 1.2 and later), or seconds of the week.
pub(super) fn survey_start(options: &SynthOptions) -> f64 {
    if options.las_version >= (1, 2) { 450_000_000.0 } else { 200_000.0 }
}

const GPS_STANDARD_TIME: u16 = 1;
const CRS_IS_WKT: u16 = 16;

/// WGS 84 / UTM zone 32N.
const WKT: &str = concat!(
    r#"PROJCS["WGS 84 / UTM zone 32N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563,"#,
    r#"AUTHORITY["EPSG","7030"]],AUTHORITY["EPSG","6326"]],PRIMEM["Greenwich",0,AUTHORITY["EPSG","8901"]],"#,
    r#"UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AUTHORITY["EPSG","4326"]],"#,
    r#"PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",9],"#,
    r#"PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],PARAMETER["false_northing",0],"#,
    r#"UNIT["metre",1,AUTHORITY["EPSG","9001"]],AXIS["Easting",EAST],AXIS["Northing",NORTH],"#,
    r#"AUTHORITY["EPSG","32632"]]"#,
    "\0"
);

/// The same as GeoTIFF keys: version 1.1.0, 4 keys; projected, pixel is area, EPSG:32632, metres.
const GEO_KEYS: [u16; 20] = [1, 1, 0, 4, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32632, 3076, 0, 1, 9001];

/// Header and VLRs. Their length does not depend on the tally, so that the final header can replace
/// the first one in place.
pub(super) fn file_head(options: &SynthOptions, tally: &Tally, laz: Option<&LazVlr>) -> std::io::Result<Vec<u8>> {
    let version = Version::new(options.las_version.0, options.las_version.1);
    let (count, vlrs) = vlrs(options, laz)?;
    let header_size: u16 = match options.las_version.1 {
        0..=2 => 227,
        3 => 235,
        _ => 375,
    };
    let is_extended = options.point_format >= 6;
    let mut header = Header {
        version,
        file_creation_day_of_year: 1,
        file_creation_year: 2026,
        header_size,
        offset_to_point_data: u32::from(header_size) + vlrs.len() as u32,
        number_of_variable_length_records: count,
        // LAZ marks compressed points in the format's highest bit.
        point_data_record_format: options.point_format | if laz.is_some() { 0x80 } else { 0 },
        point_data_record_length: record_length(options.point_format),
        ..Header::default()
    };
    header.system_identifier[..16].copy_from_slice(b"firstlight synth");
    header.generating_software[..16].copy_from_slice(b"firstlight synth");
    if options.las_version >= (1, 2) {
        header.global_encoding |= GPS_STANDARD_TIME;
    }
    if is_extended {
        header.global_encoding |= CRS_IS_WKT;
    }
    // The old 32-bit counts stay zero where LAS 1.4 says so: with formats 6 and above, and beyond 2³².
    if !is_extended && let Ok(points) = u32::try_from(tally.points) {
        header.number_of_point_records = points;
        header.number_of_points_by_return = std::array::from_fn(|i| tally.by_return[i] as u32);
    }
    if options.las_version >= (1, 4) {
        header.large_file =
            Some(LargeFile { number_of_point_records: tally.points, number_of_points_by_return: tally.by_return });
    }
    let grid = options.grid();
    [header.x_scale_factor, header.y_scale_factor, header.z_scale_factor] = grid.scale;
    [header.x_offset, header.y_offset, header.z_offset] = grid.origin;
    if tally.points > 0 {
        let world = |i: [i32; 3]| std::array::from_fn(|a| f64::from(i[a]) * grid.scale[a] + grid.origin[a]);
        [header.min_x, header.min_y, header.min_z] = world(tally.low);
        [header.max_x, header.max_y, header.max_z] = world(tally.high);
    }
    let mut head = Vec::new();
    header.write_to(&mut head).map_err(std::io::Error::other)?;
    debug_assert_eq!(head.len(), usize::from(header_size));
    head.extend(vlrs);
    Ok(head)
}

fn vlrs(options: &SynthOptions, laz: Option<&LazVlr>) -> std::io::Result<(u32, Vec<u8>)> {
    let mut out = Vec::new();
    let mut count = 0;
    let is_first_version = options.las_version == (1, 0);
    let mut push = |user: &str, record: u16, description: &str, data: &[u8]| {
        let mut fixed = [0u8; 54];
        // LAS 1.0 begins a record with a signature that later versions reserve.
        if is_first_version {
            fixed[..2].copy_from_slice(&0xaabbu16.to_le_bytes());
        }
        fixed[2..2 + user.len()].copy_from_slice(user.as_bytes());
        fixed[18..20].copy_from_slice(&record.to_le_bytes());
        fixed[20..22].copy_from_slice(&(data.len() as u16).to_le_bytes());
        fixed[22..22 + description.len()].copy_from_slice(description.as_bytes());
        out.extend_from_slice(&fixed);
        out.extend_from_slice(data);
        count += 1;
    };
    let [east, north, _] = options.origin;
    // Elsewhere the coordinates are in no UTM zone, and the file names no system.
    if (100_000.0..900_000.0).contains(&east) && (0.0..10_000_000.0).contains(&north) && north > 0.0 {
        if options.point_format >= 6 {
            push("LASF_Projection", 2112, "WGS 84 / UTM zone 32N", WKT.as_bytes());
        } else {
            let keys: Vec<u8> = GEO_KEYS.iter().flat_map(|k| k.to_le_bytes()).collect();
            push("LASF_Projection", 34735, "GeoTIFF keys: EPSG:32632", &keys);
        }
    }
    if let Some(laz) = laz {
        let mut data = Vec::new();
        laz.write_to(&mut data)?;
        push(LazVlr::USER_ID, LazVlr::RECORD_ID, LazVlr::DESCRIPTION, &data);
    }
    if is_first_version {
        // LAS 1.0 puts a signature between the VLRs and the points.
        out.extend_from_slice(&[0xdd, 0xcc]);
    }
    Ok((count, out))
}
