//! The hierarchy of a COPC file: which of its chunks hold the coarser levels of the octree.
//!
//! A COPC file (<https://copc.io>) is a LAZ file whose chunks are the nodes of an octree. Each point is in
//! exactly one node; those of level 0 are spread over the whole extent, and every level doubles the
//! density. Writers put the nodes anywhere in the file: two of the tested ones put the root last.

use std::{collections::HashMap, fs::File, io};

use super::{
    bytes::{i32_at, read_vec_at, u64_at},
    chunks::Chunk,
    header::Header,
};

/// Bytes of an entry: level, x, y, z, offset, bytes, points.
const ENTRY: usize = 32;
/// Where the info VLR says where the root page is, and how large.
const ROOT_PAGE: usize = 40;
const INFO: usize = 160;

/// The octree level of each chunk; chunks that the hierarchy does not name come last.
///
/// # Errors
/// If the file cannot be read. A hierarchy that makes no sense is used as far as it does.
pub fn levels(header: &Header, file: &File, chunks: &[Chunk]) -> io::Result<Vec<u8>> {
    let Some(info) = header.vlrs.first().filter(|vlr| vlr.is("copc", 1)) else { return Ok(Vec::new()) };
    let info = info.data(file, INFO)?;
    let mut levels = HashMap::new();
    let mut pages = Vec::new();
    if info.len() >= ROOT_PAGE + 16 {
        pages.push((u64_at(&info, ROOT_PAGE), u64_at(&info, ROOT_PAGE + 8)));
    }
    // A page may name itself: as many entries as there can be sensible ones end the walk.
    let mut left = 4 * chunks.len() + 64;
    while let Some((at, bytes)) = pages.pop() {
        let bytes = bytes.min(header.file_length.saturating_sub(at)).min((left * ENTRY) as u64);
        let page = read_vec_at(file, at, bytes as usize)?;
        for entry in page.chunks_exact(ENTRY) {
            left -= 1;
            let (level, offset, bytes, points) =
                (i32_at(entry, 0), u64_at(entry, 16), i32_at(entry, 24), i32_at(entry, 28));
            if points == -1 {
                pages.push((offset, bytes.max(0) as u64));
            } else if points > 0 {
                levels.insert(offset, level.clamp(0, i32::from(u8::MAX)) as u8);
            }
        }
    }
    Ok(chunks.iter().map(|chunk| levels.get(&chunk.at).copied().unwrap_or(u8::MAX)).collect())
}
