//! The slots that a picture shows, each once. Twin of `shaders/index.wgsl`, which leaves them
//! unordered; here they are in order of pixels.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use super::{BACKGROUND, PIXELS_PER_THREAD, raster::slot, threads::map_parts};
use crate::render::View;

/// Replaces `visible` by the slots in `words`.
pub fn build(visible: &mut Vec<u32>, words: &[AtomicU64], view: &View, threads: usize) {
    let width = view.width as usize;
    let rows_per_thread = PIXELS_PER_THREAD.div_ceil(width.max(1));
    let parts = map_parts(threads, view.height as usize, rows_per_thread, |rows| {
        let mut found = Vec::new();
        for y in rows {
            for x in 0..width {
                let word = words[y * width + x].load(Relaxed);
                if word != BACKGROUND && is_first(words, width, view.point_size as usize, x, y, word) {
                    found.push(slot(word));
                }
            }
        }
        found
    });
    visible.clear();
    parts.iter().for_each(|part| visible.extend(part));
}

/// True if no earlier pixel, in reading order, shows the same point: one can only be in the
/// `(2 * size - 1)` × `size` pixels that a point covering this pixel may cover too.
fn is_first(words: &[AtomicU64], width: usize, size: usize, x: usize, y: usize, word: u64) -> bool {
    let reach = size - 1;
    let left = x.saturating_sub(reach);
    let same = |pixel: &AtomicU64| pixel.load(Relaxed) == word;
    let above = y.saturating_sub(reach)..y;
    !words[y * width..][left..x].iter().any(same)
        && !above.into_iter().any(|row| words[row * width..][left..width.min(x + size)].iter().any(same))
}
