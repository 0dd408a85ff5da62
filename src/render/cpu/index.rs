//! The slots that a picture shows, each once. Twin of `shaders/index.wgsl`, which leaves them
//! unordered; here they are in order of pixels.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use super::{
    BACKGROUND, PIXELS_PER_THREAD,
    raster::{depth, slot},
    threads::map_parts,
};
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
                if word != BACKGROUND && is_first(words, width, view.point_size_at(depth(word)) as usize, x, y, word) {
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::{
        render::{Camera, PointWidth},
        scene::Grid,
    };

    #[test]
    fn lists_each_visible_slot_once() {
        let grid = Grid { scale: [0.01; 3], origin: [0.0; 3] };
        let camera = Camera { eye: [0.0, -10.0, 0.0], ..Default::default() };
        let noise = |i: u32, k: u32| ((i.wrapping_mul(0x9E37_79B9) ^ k).wrapping_mul(0x85EB_CA6B) >> 12) as i32;
        let sizes = (1..=8).map(PointWidth::Pixels).chain([0.1, 0.5, 1e6].map(PointWidth::World));
        for point_size in sizes {
            for count in [0, 1, 2, 33, 257, 4097] {
                let view = camera.view(&grid, [129, 131], point_size).unwrap();
                let words: Vec<AtomicU64> = (0..129 * 131).map(|_| AtomicU64::new(BACKGROUND)).collect();
                for i in 0..count {
                    let position = [0, 1, 2].map(|k| noise(i, k) % 1600 - 800);
                    super::super::raster::draw_point(&words, &view, i, position);
                }
                let shown = words.iter().map(|w| w.load(Relaxed)).filter(|&w| w != BACKGROUND).map(slot);
                let expected: BTreeSet<u32> = shown.collect();
                for threads in [1, 3] {
                    let mut visible = vec![7, 7, 7];
                    build(&mut visible, &words, &view, threads);
                    assert_eq!(visible.len(), expected.len(), "size {point_size:?}, {count} points");
                    assert_eq!(visible.into_iter().collect::<BTreeSet<_>>(), expected);
                }
            }
        }
    }
}
