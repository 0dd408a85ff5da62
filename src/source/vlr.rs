//! Variable length records, found by walking from one to the next. Sizes are checked against the
//! file; contents stay in the file until somebody asks for them.

use std::fs::File;

use super::bytes::{read_vec_at, text, u16_at, u64_at};

/// Size in bytes of a VLR's header, and of an extended one's.
const VLR_HEADER: u64 = 54;
pub const EVLR_HEADER: u64 = 60;

/// More records than this are not listed: a count that large is an accident.
const MAX_RECORDS: usize = 65_536;

/// One variable length record: where it is and what it calls itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Vlr {
    pub user_id: String,
    pub record_id: u16,
    pub description: String,
    /// True for an extended record, behind the points.
    pub extended: bool,
    /// File offset of the contents, and their length in bytes (as far as the file goes).
    pub data_at: u64,
    pub data_length: u64,
}

impl Vlr {
    pub fn is(&self, user_id: &str, record_id: u16) -> bool {
        self.user_id == user_id && self.record_id == record_id
    }

    /// The contents, at most `limit` bytes of them.
    pub fn data(&self, file: &File, limit: usize) -> std::io::Result<Vec<u8>> {
        read_vec_at(file, self.data_at, self.data_length.min(limit as u64) as usize)
    }
}

/// Lists up to `count` records in bytes `start..end` of the file. What does not fit ends the walk,
/// with a warning.
pub fn walk(
    file: &File,
    (start, end): (u64, u64),
    count: u64,
    extended: bool,
    warnings: &mut Vec<String>,
) -> std::io::Result<Vec<Vlr>> {
    let name = if extended { "EVLR" } else { "VLR" };
    let header_length = if extended { EVLR_HEADER } else { VLR_HEADER };
    let mut vlrs = Vec::new();
    let mut at = start;
    for number in 0..count {
        if vlrs.len() == MAX_RECORDS {
            warnings.push(format!("{count} {name}s in the header: only the first {MAX_RECORDS} were looked at"));
            break;
        }
        if at > end || end - at < header_length {
            warnings.push(format!(
                "expected {count} {name}s, found {number}: no room for another one between byte {at} and byte {end}"
            ));
            break;
        }
        let header = read_vec_at(file, at, header_length as usize)?;
        if header.len() < header_length as usize {
            warnings.push(format!("{name} {number}: the file ends in its header at byte {at}"));
            break;
        }
        let (length, description_at) =
            if extended { (u64_at(&header, 20), 28) } else { (u64::from(u16_at(&header, 20)), 22) };
        let data_at = at + header_length;
        let data_length = length.min(end - data_at);
        vlrs.push(Vlr {
            user_id: text(&header[2..18]),
            record_id: u16_at(&header, 18),
            description: text(&header[description_at..]),
            extended,
            data_at,
            data_length,
        });
        if data_length < length {
            warnings.push(format!(
                "{name} {number} says {length} bytes from byte {data_at} on, only {data_length} are there"
            ));
            break;
        }
        at = data_at + length;
    }
    Ok(vlrs)
}
