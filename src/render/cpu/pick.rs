//! The point that a pick takes. Twin of `shaders/pick.wgsl`.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use super::{BACKGROUND, raster, store::PointStore};
use crate::render::{Pick, PickAt};

/// The point nearest to a pixel, in a picture of `width` columns.
pub fn pick(words: &[AtomicU64], width: u32, store: &PointStore, at: PickAt) -> Option<Pick> {
    let [column, row] = at.pixel;
    let height = (words.len() as u32).checked_div(width)?;
    let from = |middle: u32| middle.saturating_sub(at.reach);
    let to = |middle: u32, end: u32| middle.saturating_add(at.reach + 1).min(end);
    let pixels = (from(row)..to(row, height)).flat_map(|y| (from(column)..to(column, width)).map(move |x| [x, y]));
    let shown = pixels.filter_map(|[x, y]| {
        let distance = x.abs_diff(column).pow(2) + y.abs_diff(row).pow(2);
        let pixel = y * width + x;
        let word = words[pixel as usize].load(Relaxed);
        (word != BACKGROUND && distance <= at.reach.pow(2)).then_some((distance, word, pixel))
    });
    // Depths are positive: their bits are in their order.
    let (_, word, pixel) = shown.min_by_key(|&(distance, word, pixel)| (distance, word >> 32, pixel))?;
    let slot = raster::slot(word) as usize;
    Some(Pick {
        record: store.records[slot],
        position: store.positions[slot],
        depth: raster::depth(word),
        pixel: [pixel % width, pixel / width],
    })
}
