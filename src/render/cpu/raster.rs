//! One point to its pixels. Twin of `shaders/raster.wgsl`.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use crate::render::View;

/// Writes the point to each pixel that it covers and where nothing nearer is, `words` being a picture
/// of the view's size. Among points of equal depth the lowest slot wins.
#[inline]
pub fn draw_point(words: &[AtomicU64], view: &View, slot: u32, position: [i32; 3]) {
    let Some(point) = view.project(position) else { return };
    let word = u64::from(point.depth.to_bits()) << 32 | u64::from(slot);
    let [left, top] = point.corner;
    let size = view.point_size as i32;
    let columns = left.max(0) as usize..(left + size).min(view.width as i32).max(0) as usize;
    for row in top.max(0)..(top + size).min(view.height as i32) {
        let row = &words[row as usize * view.width as usize..][columns.clone()];
        for pixel in row {
            // Most points are hidden, and a load is much cheaper than an atomic minimum.
            if word < pixel.load(Relaxed) {
                pixel.fetch_min(word, Relaxed);
            }
        }
    }
}

/// Depth of the point that a word names.
pub fn depth(word: u64) -> f32 {
    f32::from_bits((word >> 32) as u32)
}

/// Slot of the point that a word names.
pub fn slot(word: u64) -> u32 {
    word as u32
}
