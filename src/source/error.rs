//! Why an input could not be opened: one variant per fact, one line per message.

use std::path::PathBuf;

/// Why an input could not be opened. Every message names the input, what was expected, what was found
/// and where.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SourceError {
    #[error("no input given: expected LAS or LAZ files, or folders with such files")]
    NoInput,
    #[error("{}: no such file or folder", path.display())]
    NotFound { path: PathBuf },
    #[error("{}: no .las or .laz file in this folder or its subfolders", path.display())]
    EmptyFolder { path: PathBuf },
    #[error("{}: expected a regular file, found {found}", path.display())]
    NotAFile { path: PathBuf, found: &'static str },
    /// The operating system refused; `doing` says what.
    #[error("{}: cannot {doing}: {reason}", path.display())]
    Io { path: PathBuf, doing: &'static str, reason: String },
    /// `found` are the file's first bytes, printable.
    #[error("{}: not a LAS or LAZ file: expected «LASF» in the first four bytes, found {found}", path.display())]
    NotLas { path: PathBuf, found: String },
    #[error("{}: expected a header of {expected} bytes, the file ends at byte {found}", path.display())]
    HeaderCut { path: PathBuf, expected: u64, found: u64 },
    #[error("{}: expected LAS version 1.0 to 1.5 in bytes 24 and 25, found {major}.{minor}", path.display())]
    Version { path: PathBuf, major: u8, minor: u8 },
    #[error("{}: expected point record format 0 to 10 in byte 104, found {found}", path.display())]
    Format { path: PathBuf, found: u8 },
    #[error(
        "{}: point record format {format} takes at least {expected} bytes, the header says {found} (byte 105)",
        path.display()
    )]
    RecordLength { path: PathBuf, format: u8, expected: u16, found: u16 },
    #[error(
        "{}: expected the point data behind the header's {header_size} bytes, found offset {found} (byte 96)",
        path.display()
    )]
    PointOffset { path: PathBuf, header_size: u16, found: u32 },
    #[error(
        "{}: compressed points: expected a «laszip encoded» VLR (22204) that says how, found {vlrs} other VLRs",
        path.display()
    )]
    NoLaszipVlr { path: PathBuf, vlrs: usize },
    /// The LASzip VLR asks for something that cannot be decoded.
    #[error("{}: LASzip VLR at byte {at}: {what}", path.display())]
    LaszipVlr { path: PathBuf, at: u64, what: String },
    /// Record numbers are 32 bits wide.
    #[error(
        "{}: {points} points after {before} others: a scene holds at most {} points{}",
        path.display(),
        u32::MAX,
        if *before > 0 { ", open fewer files at once" } else { "" }
    )]
    TooManyPoints { path: PathBuf, points: u64, before: u64 },
    /// Several inputs, and none could be opened.
    #[error("none of {} inputs could be opened: {}", errors.len(), reasons(errors))]
    AllFailed { errors: Vec<SourceError> },
}

/// The first few reasons, in one line.
fn reasons(errors: &[SourceError]) -> String {
    const SHOWN: usize = 3;
    let mut reasons: Vec<String> = errors.iter().take(SHOWN).map(SourceError::to_string).collect();
    if errors.len() > SHOWN {
        reasons.push(format!("and {} more", errors.len() - SHOWN));
    }
    reasons.join("; ")
}
