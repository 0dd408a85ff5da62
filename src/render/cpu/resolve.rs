//! Words to colours. Twin of `shaders/resolve.wgsl`.

use std::{
    collections::TryReserveError,
    sync::atomic::{AtomicU64, Ordering::Relaxed},
    thread,
};

use super::{
    BACKGROUND, PIXELS_PER_THREAD,
    average::{self, PixelSums},
    columns::Columns,
    raster,
    store::PointStore,
    threads::map_parts,
};
use crate::render::{FramePlan, NO_DATA, PointColors, holes, shading};

/// What the window shows, and the record of each pixel's point: slots lose their meaning with the
/// next insertion.
#[derive(Default)]
pub struct Resolved {
    pub rgba: Vec<[u8; 4]>,
    /// 0 for background.
    pub records: Vec<u32>,
    /// +∞ for background.
    depth: Vec<f32>,
}

impl Resolved {
    pub fn resize(&mut self, pixels: usize) -> Result<(), TryReserveError> {
        *self = Resolved::default();
        self.rgba.try_reserve_exact(pixels)?;
        self.rgba.resize(pixels, [0; 4]);
        self.records.try_reserve_exact(pixels)?;
        self.records.resize(pixels, 0);
        self.depth.try_reserve_exact(pixels)?;
        self.depth.resize(pixels, f32::INFINITY);
        Ok(())
    }

    /// Colours the picture in `words`: by front points, or with `sums` by averages.
    pub fn resolve(
        &mut self,
        plan: &FramePlan,
        words: &[AtomicU64],
        sums: Option<&[PixelSums]>,
        store: &PointStore,
        columns: &Columns,
        threads: usize,
    ) {
        let width = plan.view.width as usize;
        let lit = plan.shading.edl_strength > 0.0;
        if words.is_empty() {
            return;
        }
        let rows = (plan.view.height as usize).div_ceil(threads).max(PIXELS_PER_THREAD.div_ceil(width));
        let part = rows * width;

        thread::scope(|scope| {
            let parts = self.rgba.chunks_mut(part).zip(self.records.chunks_mut(part));
            let parts = parts.zip(self.depth.chunks_mut(part)).zip(words.chunks(part));
            for (k, (((rgba, records), depth), words)) in parts.enumerate() {
                let sums = sums.map(|sums| &sums[k * part..][..words.len()]);
                scope.spawn(move || {
                    for (i, word) in words.iter().enumerate() {
                        let word = word.load(Relaxed);
                        (rgba[i], records[i]) = color(plan, word, sums.map(|sums| &sums[i]), store, columns);
                        if lit {
                            depth[i] = if word == BACKGROUND { f32::INFINITY } else { raster::depth(word) };
                        }
                    }
                });
            }
        });
        if lit {
            self.light(plan, part);
        }
        if plan.shading.fill_holes {
            self.fill_holes(words, [width, plan.view.height as usize], threads);
        }
    }

    /// Darkens the colours, `part` pixels in each thread.
    fn light(&mut self, plan: &FramePlan, part: usize) {
        let width = plan.view.width as usize;
        let depth = &self.depth;
        thread::scope(|scope| {
            for (k, rgba) in self.rgba.chunks_mut(part).enumerate() {
                scope.spawn(move || {
                    for (i, pixel) in rgba.iter_mut().enumerate() {
                        let at = k * part + i;
                        if depth[at] < f32::INFINITY {
                            let product = edl_product(depth, plan, at % width, at / width);
                            let shade = shading::edl_shade(product, plan.shading.edl_strength);
                            let [r, g, b, a] = *pixel;
                            let [r, g, b] = [r, g, b].map(|c| (f32::from(c) * shade + 0.5) as u8);
                            *pixel = [r, g, b, a];
                        }
                    }
                });
            }
        });
    }

    /// Twin of `shaders/holes.wgsl`: only background pixels are written, and only others read.
    fn fill_holes(&mut self, words: &[AtomicU64], size: [usize; 2], threads: usize) {
        let word = |at: usize| words[at].load(Relaxed);
        let depth = |at: usize| if word(at) == BACKGROUND { f32::INFINITY } else { raster::depth(word(at)) };
        let found = map_parts(threads, words.len(), PIXELS_PER_THREAD, |part| {
            let background = part.filter(|&at| word(at) == BACKGROUND);
            let from = |at| holes::source(size, at, holes::REACH, holes::MASK, depth).map(|from| (at, from));
            background.filter_map(from).collect::<Vec<_>>()
        });
        for (at, from) in found.into_iter().flatten() {
            self.rgba[at] = self.rgba[from];
        }
    }
}

/// Colour before lighting, and record, of a pixel.
fn color(
    plan: &FramePlan,
    word: u64,
    sums: Option<&PixelSums>,
    store: &PointStore,
    columns: &Columns,
) -> ([u8; 4], u32) {
    if word == BACKGROUND {
        let [r, g, b] = plan.shading.background;
        return ([r, g, b, 255], 0);
    }
    let slot = raster::slot(word);
    let record = store.records[slot as usize];
    let [r, g, b] = match &plan.colors.column {
        Some(colors) => match columns.key(colors.column, record) {
            0 => NO_DATA,
            key => colors.color(key),
        },
        None => {
            let front = point_color(&plan.colors, store, slot);
            sums.map_or(front, |sums| shading::average(front, average::unpacked(sums)))
        }
    };
    ([r, g, b, 255], record)
}

/// Colour of a point by its file's rule.
pub fn point_color(colors: &PointColors, store: &PointStore, slot: u32) -> [u8; 3] {
    let slot = slot as usize;
    colors.color(store.records[slot], store.attributes[slot], store.positions[slot][2])
}

/// How far a pixel lies behind its eight neighbours, see [`shading`].
fn edl_product(depth: &[f32], plan: &FramePlan, x: usize, y: usize) -> f32 {
    let (width, height) = (plan.view.width as usize, plan.view.height as usize);
    let center = depth[y * width + x];
    let mut product = 1.0;
    for [dx, dy] in shading::edl_neighbours(plan.view.point_size_at(center)) {
        if let (Some(x), Some(y)) = (x.checked_add_signed(dx), y.checked_add_signed(dy))
            && x < width
            && y < height
        {
            // A background neighbour is infinitely far, and so changes nothing.
            product = shading::edl_product(product, plan.view.times_as_far(center, depth[y * width + x]));
        }
    }
    product
}
