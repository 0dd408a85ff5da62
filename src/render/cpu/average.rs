//! The sums of high-quality shading. Twin of `shaders/average.wgsl` and `shaders/sums_32.wgsl`.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use super::raster;
use crate::render::{
    View,
    shading::{AVERAGED_DEPTH, MOST_FRAGMENTS},
};

/// Sums of a pixel in 32-bit halves: green above red, fragments above blue.
pub type PixelSums = [AtomicU64; 2];

/// Adds a point to each pixel that it covers without being the point shown there, if it is not too
/// far behind. `color` is asked for when first needed.
#[inline]
pub fn add_point(
    sums: &[PixelSums],
    words: &[AtomicU64],
    view: &View,
    slot: u32,
    position: [i32; 3],
    color: impl Fn() -> [u8; 3],
) {
    let Some(point) = view.project(position) else { return };
    let mut known = None;
    let [left, top] = point.corner;
    let size = point.size as i32;
    for y in top.max(0)..(top + size).min(view.height as i32) {
        for x in left.max(0)..(left + size).min(view.width as i32) {
            let pixel = y as usize * view.width as usize + x as usize;
            let front = words[pixel].load(Relaxed);
            // A background pixel's depth is not a number, and nothing is nearer than that.
            if raster::slot(front) != slot && point.depth <= view.far_as(raster::depth(front), AVERAGED_DEPTH) {
                add(&sums[pixel], *known.get_or_insert_with(&color));
            }
        }
    }
}

/// Adds a fragment.
fn add(sums: &PixelSums, color: [u8; 3]) {
    if sums[1].load(Relaxed) >> 32 < MOST_FRAGMENTS {
        let [r, g, b] = color.map(u64::from);
        sums[0].fetch_add(g << 32 | r, Relaxed);
        sums[1].fetch_add(1 << 32 | b, Relaxed);
    }
}

/// Red, green, blue and fragments.
pub fn unpacked(sums: &PixelSums) -> [u64; 4] {
    let [red_green, blue_count] = [0, 1].map(|half| sums[half].load(Relaxed));
    [red_green & 0xffff_ffff, red_green >> 32, blue_count & 0xffff_ffff, blue_count >> 32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_sum_overflows() {
        let sums: PixelSums = Default::default();
        add(&sums, [1, 2, 255]);
        assert_eq!(unpacked(&sums), [1, 2, 255, 1]);
        let nearly = MOST_FRAGMENTS - 1;
        let sums = [nearly * 255 * ((1 << 32) + 1), (nearly << 32) | (nearly * 255)].map(AtomicU64::new);
        for _ in 0..3 {
            add(&sums, [255; 3]);
        }
        let full = MOST_FRAGMENTS * 255;
        assert_eq!(unpacked(&sums), [full, full, full, MOST_FRAGMENTS]);
        // A million threads that all looked before it was full.
        const { assert!((MOST_FRAGMENTS + 1_000_000) * 255 < 1 << 32) };
    }
}
