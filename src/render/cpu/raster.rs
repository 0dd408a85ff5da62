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
    let size = point.size as i32;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{render::Camera, scene::Grid};

    const GRID: Grid = Grid { scale: [0.01; 3], origin: [0.0; 3] };

    fn view(size: [u32; 2], point_size: u32) -> View {
        let camera = Camera { eye: [0.0, -10.0, 0.0], ..Default::default() };
        camera.view(&GRID, size, point_size).unwrap()
    }

    /// Points all over the view and around it, some of them equal.
    fn points(count: u32) -> Vec<[i32; 3]> {
        let noise = |i: u32, k: u32| ((i.wrapping_mul(0x9E37_79B9) ^ k).wrapping_mul(0x85EB_CA6B) >> 12) as i32;
        (0..count).map(|i| i - i % 5 / 4).map(|i| [0, 1, 2].map(|k| noise(i, k) % 1600 - 800)).collect()
    }

    /// Every pixel looks at every point: the definition, in other words.
    fn naive(view: &View, points: &[[i32; 3]]) -> Vec<u64> {
        let size = view.point_size as i32;
        let mut words = Vec::new();
        for y in 0..view.height as i32 {
            for x in 0..view.width as i32 {
                let covers = |p: &crate::render::Projected| {
                    (0..size).contains(&(x - p.corner[0])) && (0..size).contains(&(y - p.corner[1]))
                };
                let here = points
                    .iter()
                    .enumerate()
                    .filter_map(|(slot, &position)| view.project(position).filter(covers).map(|p| (p.depth, slot)));
                let nearest = here.min_by(|a, b| a.partial_cmp(b).unwrap());
                words.push(nearest.map_or(u64::MAX, |(depth, slot)| (u64::from(depth.to_bits()) << 32) + slot as u64));
            }
        }
        words
    }

    #[test]
    fn equals_the_definition() {
        for point_size in 1..=8 {
            for count in [0, 1, 2, 31, 32, 33, 255, 256, 257, 4097] {
                let (view, points) = (view([23, 17], point_size), points(count));
                let words: Vec<AtomicU64> = (0..23 * 17).map(|_| AtomicU64::new(u64::MAX)).collect();
                for (slot, &position) in points.iter().enumerate().rev() {
                    draw_point(&words, &view, slot as u32, position);
                }
                let words: Vec<u64> = words.into_iter().map(AtomicU64::into_inner).collect();
                assert!(words == naive(&view, &points), "size {point_size}, {count} points");
            }
        }
    }

    #[test]
    fn points_at_the_border_are_clipped() {
        // A column of points far beyond both sides: each pixel of the border rows shows the point whose
        // square reaches in, for every size.
        for point_size in 1..=8 {
            let view = view([9, 9], point_size);
            for x in -900..900 {
                let words: Vec<AtomicU64> = (0..81).map(|_| AtomicU64::new(u64::MAX)).collect();
                draw_point(&words, &view, 0, [x, 0, 0]);
                let covered: Vec<usize> = (0..81).filter(|&p| words[p].load(Relaxed) != u64::MAX).collect();
                // One grid step is 0.0078 pixels here; the square's middle is at 4.5 + x times that.
                let scale = 9.0 / (2.0 * 10.0 * 30f64.to_radians().tan()) * 0.01;
                let left = (4.5 + f64::from(x) * scale - 0.5 * f64::from(point_size - 1)).floor() as i64;
                let columns = left.max(0)..(left + i64::from(point_size)).min(9);
                let rows = (5 - (i64::from(point_size) + 1) / 2).max(0)..(5 + i64::from(point_size) / 2).min(9);
                assert!(covered.iter().all(|&p| columns.contains(&(p as i64 % 9))), "size {point_size}, x {x}");
                assert_eq!(covered.len(), (columns.count() * rows.count()), "size {point_size}, x {x}");
            }
        }
    }
}
