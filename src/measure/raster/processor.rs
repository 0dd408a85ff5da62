//! The processor's picture of a cloud, and whether a device's picture is one that 32-bit arithmetic may give.
//!
//! A device need not round as the processor does ([`rounding`](super::rounding)), and among many points some lie so
//! close to a pixel's border, or so close behind another, that rounding decides. So a pixel that differs is *excused*
//! if, within those bounds, the point shown may lie in it, has the depth that the device says, and is not farther than
//! a point that must be in this pixel; an empty one, if no point must be in it. Whatever else differs is wrong.

use std::thread;

use super::rounding::Exact;
use crate::{
    methods::{
        Arranged, Drawn, NO_POINT,
        parallel::{map, part_len},
    },
    render::View,
};

/// What the processor says about a view: of each pixel the nearest point, and the nearest of those that no
/// rounding moves elsewhere. It does not depend on the order of the points.
pub struct Processor {
    view: View,
    /// Bits of the depth above the point's number; all ones without any.
    nearest: Vec<u64>,
    /// The farthest that the front of a pixel may be; infinite if none must be there.
    firm: Vec<f32>,
    /// Points in the frustum.
    pub fragments: u64,
}

/// A device's picture against the processor's.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Agreement {
    /// Pixels that show another point, depth or colour than the processor's; of points that are equally deep any
    /// may be shown.
    pub differ: u64,
    /// Of these, the ones that rounding explains.
    pub excused: u64,
}

/// Rows of pixels that a thread compares at a time.
const ROWS: usize = 16;

struct Part {
    nearest: Vec<u64>,
    firm: Vec<f32>,
    fragments: u64,
}

impl Part {
    fn new(pixels: usize) -> Part {
        Part { nearest: vec![u64::MAX; pixels], firm: vec![f32::INFINITY; pixels], fragments: 0 }
    }

    fn draw(&mut self, view: &View, slot: usize, position: [i32; 3]) {
        let Some(projected) = view.project(position) else { return };
        self.fragments += 1;
        let pixel = projected.corner.map(|c| c.max(0) as u32);
        let i = (pixel[1] as usize * view.width as usize + pixel[0] as usize).min(self.nearest.len() - 1);
        // Bits of positive floats are in the order of the floats.
        let word = u64::from(projected.depth.to_bits()) << 32 | slot as u64;
        self.nearest[i] = self.nearest[i].min(word);
        // Few points are nearer than all before them; only these are looked at closely.
        if projected.depth < self.firm[i] {
            let certain = Exact::of(view, position).filter(|exact| exact.must_be_in(pixel));
            if let Some(exact) = certain {
                self.firm[i] = self.firm[i].min(((exact.depth + exact.depth_error) as f32).next_up());
            }
        }
    }

    fn merge(mut self, other: Part) -> Part {
        self.nearest.iter_mut().zip(other.nearest).for_each(|(a, b)| *a = (*a).min(b));
        self.firm.iter_mut().zip(other.firm).for_each(|(a, b)| *a = a.min(b));
        self.fragments += other.fragments;
        self
    }
}

impl Processor {
    /// Draws all points by all threads.
    pub fn of<'a>(cloud: impl Into<Arranged<'a>>, view: &View) -> Processor {
        let (arranged, view) = (cloud.into(), View { point_size: 1, ..*view });
        let pixels = view.width as usize * view.height as usize;
        let part = part_len(arranged.len());
        let drawn = thread::scope(|scope| {
            let draw = move |first: usize| {
                let mut drawn = Part::new(pixels);
                for slot in first..arranged.len().min(first + part) {
                    if let Some(position) = arranged.position(slot) {
                        drawn.draw(&view, slot, position);
                    }
                }
                drawn
            };
            let parts = (0..arranged.len()).step_by(part);
            let parts: Vec<_> = parts.map(|first| scope.spawn(move || draw(first))).collect();
            // A minimum cannot panic.
            parts.into_iter().filter_map(|part| part.join().ok()).reduce(Part::merge)
        });
        let Part { nearest, firm, fragments } = drawn.unwrap_or_else(|| Part::new(pixels));
        Processor { view, nearest, firm, fragments }
    }

    /// Pixels that show a point.
    pub fn covered(&self) -> u64 {
        self.nearest.iter().filter(|&&word| word != u64::MAX).count() as u64
    }

    /// A picture of the same cloud, from the same view, in any order.
    ///
    /// # Panics
    /// If it is of another size.
    pub fn compare(&self, drawn: &Drawn, arranged: Arranged<'_>) -> Agreement {
        assert_eq!(drawn.size, [self.view.width, self.view.height], "pictures of one size");
        let width = self.view.width as usize;
        let pixels = self.nearest.len();
        let rows = map(pixels.div_ceil(ROWS * width), |band| {
            let mut found = Agreement::default();
            for i in band * ROWS * width..pixels.min((band + 1) * ROWS * width) {
                if !self.agrees(i, drawn, arranged) {
                    found.differ += 1;
                    found.excused += u64::from(self.is_excused(i, drawn, arranged));
                }
            }
            found
        });
        rows.iter().fold(Agreement::default(), |a, b| Agreement {
            differ: a.differ + b.differ,
            excused: a.excused + b.excused,
        })
    }

    fn pixel(&self, i: usize) -> [u32; 2] {
        [i as u32 % self.view.width, i as u32 / self.view.width]
    }

    /// Whether the pixel shows a nearest point, with its depth and colour.
    fn agrees(&self, i: usize, drawn: &Drawn, arranged: Arranged<'_>) -> bool {
        let (slot, depth) = (drawn.point[i], drawn.depth[i]);
        if slot == NO_POINT || self.nearest[i] == u64::MAX {
            return slot == NO_POINT && self.nearest[i] == u64::MAX;
        }
        let Some(position) = arranged.position(slot as usize) else { return false };
        let is_there = self.view.project(position).is_some_and(|projected| {
            projected.corner.map(|c| c as u32) == self.pixel(i) && projected.depth.to_bits() == depth.to_bits()
        });
        is_there && depth.to_bits() == (self.nearest[i] >> 32) as u32 && self.has_color(i, drawn, arranged)
    }

    fn has_color(&self, i: usize, drawn: &Drawn, arranged: Arranged<'_>) -> bool {
        let point = arranged.point(drawn.point[i] as usize);
        arranged.cloud.colors.get(point).is_some_and(|color| color.to_le_bytes()[..3] == drawn.rgba[i][..3])
    }

    fn is_excused(&self, i: usize, drawn: &Drawn, arranged: Arranged<'_>) -> bool {
        let slot = drawn.point[i];
        if slot == NO_POINT {
            return self.firm[i] == f32::INFINITY;
        }
        let Some(position) = arranged.position(slot as usize) else { return false };
        let Some(exact) = Exact::of(&self.view, position) else { return false };
        exact.may_be_in(self.pixel(i))
            && (f64::from(drawn.depth[i]) - exact.depth).abs() <= exact.depth_error
            && exact.depth - exact.depth_error <= f64::from(self.firm[i])
            && self.has_color(i, drawn, arranged)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        measure::raster::{Order, Orders, rounding::tests::project_fused},
        methods::Cloud,
        render::Camera,
        scene::Grid,
        synth::{Generator, Scene, SynthOptions},
    };

    const SIZE: [u32; 2] = [160, 90];

    fn town() -> (Cloud, View) {
        let generator = Generator::new(&SynthOptions { points: 200_000, ..SynthOptions::new(Scene::Town) }).unwrap();
        let positions: Vec<_> = generator.iter().map(|point| point.position).collect();
        let colors = (0..positions.len() as u32).map(|i| i.wrapping_mul(0x9e37_79b9)).collect();
        let camera = Camera::fit(&generator.bounds(), &generator.grid(), 16.0 / 9.0);
        let view = camera.view(&generator.grid(), SIZE, 1).unwrap();
        (Cloud { positions, colors }, view)
    }

    /// The nearest of the slots that `keep` keeps, by a projection.
    fn draw(
        arranged: Arranged<'_>,
        keep: impl Fn(usize) -> bool,
        project: impl Fn([i32; 3]) -> Option<([f32; 2], f32)>,
    ) -> Drawn {
        let pixels = (SIZE[0] * SIZE[1]) as usize;
        let (mut point, mut depth) = (vec![NO_POINT; pixels], vec![f32::INFINITY; pixels]);
        for slot in (0..arranged.len()).filter(|&slot| keep(slot)) {
            let Some((at, w)) = project(arranged.position(slot).unwrap()) else { continue };
            let i = at[1] as usize * SIZE[0] as usize + at[0] as usize;
            if w < depth[i] {
                (point[i], depth[i]) = (slot as u32, w);
            }
        }
        let color = |&slot: &u32| match slot {
            NO_POINT => [0; 4],
            slot => arranged.cloud.colors[arranged.point(slot as usize)].to_le_bytes(),
        };
        let rgba = point.iter().map(color).collect();
        Drawn { size: SIZE, point, depth, rgba, give_ups: 0 }
    }

    fn twin(view: &View) -> impl Fn([i32; 3]) -> Option<([f32; 2], f32)> {
        |position| view.project(position).map(|p| (p.corner.map(|c| c as f32), p.depth))
    }

    #[test]
    fn rounding_is_excused_and_nothing_else() {
        let (cloud, view) = town();
        let processor = Processor::of(&cloud, &view);
        let orders = Orders::new(&cloud.positions);
        for order in [Order::Original, Order::Shuffled, Order::Morton] {
            let points = orders.points(order, 5);
            let arranged = Arranged { cloud: &cloud, order: points.as_deref() };
            let same = processor.compare(&draw(arranged, |_| true, twin(&view)), arranged);
            assert_eq!(same, Agreement::default(), "{order:?}: the same arithmetic");
            let fused = processor.compare(&draw(arranged, |_| true, |p| project_fused(&view, p)), arranged);
            assert!(fused.differ > 0, "{order:?}: other arithmetic shows");
            assert_eq!(fused.excused, fused.differ, "{order:?}: and is right");
        }
    }

    #[test]
    fn wrong_pictures_are_not_excused() {
        let (cloud, view) = town();
        let (processor, arranged) = (Processor::of(&cloud, &view), Arranged::from(&cloud));
        assert!(
            processor.covered() > 1000 && processor.fragments > 10 * processor.covered(),
            "{}",
            processor.covered()
        );
        let wrong = |drawn: &Drawn| {
            let found = processor.compare(drawn, arranged);
            found.differ - found.excused
        };
        let fused = |keep: &dyn Fn(usize) -> bool| draw(arranged, keep, |p| project_fused(&view, p));
        let right = fused(&|_| true);
        assert_eq!(wrong(&right), 0);
        // One pixel aside.
        let mut shifted = right.clone();
        shifted.point.rotate_right(1);
        shifted.depth.rotate_right(1);
        shifted.rgba.rotate_right(1);
        assert!(wrong(&shifted) > processor.covered() / 2);
        // One point in a hundred left out.
        let dropped = wrong(&fused(&|slot| slot % 100 != 7));
        assert!(dropped > processor.covered() / 500, "{dropped} of {}", processor.covered());
        // Whoever comes last, as just-set does.
        let mut last = right.clone();
        for (slot, &position) in cloud.positions.iter().enumerate() {
            let Some((at, depth)) = project_fused(&view, position) else { continue };
            let i = at[1] as usize * SIZE[0] as usize + at[0] as usize;
            (last.point[i], last.depth[i], last.rgba[i]) = (slot as u32, depth, cloud.colors[slot].to_le_bytes());
        }
        assert!(wrong(&last) > processor.covered() / 2);
        // One pixel, in each way.
        let shown = right.point.iter().position(|&point| point != NO_POINT).unwrap();
        let empty = right.point.iter().position(|&point| point == NO_POINT).unwrap();
        let one = |damage: &dyn Fn(&mut Drawn)| {
            let mut damaged = right.clone();
            damage(&mut damaged);
            wrong(&damaged)
        };
        assert_eq!(one(&|d| d.rgba[shown][0] ^= 1), 1, "another colour");
        assert_eq!(one(&|d| d.depth[shown] *= 1.0001), 1, "another depth");
        assert_eq!(one(&|d| d.point[shown] = u32::MAX - 1), 1, "no such point");
        assert_eq!(one(&|d| (d.point[empty], d.depth[empty]) = (d.point[shown], d.depth[shown])), 1, "not there");
        // A pixel with many points has some that must be in it.
        let crowded = (0..right.point.len()).find(|&i| processor.firm[i].is_finite()).unwrap();
        assert_eq!(one(&|d| (d.point[crowded], d.depth[crowded]) = (NO_POINT, f32::INFINITY)), 1, "a hole");
    }

    #[test]
    fn every_number_of_points_is_drawn() {
        let (mut cloud, view) = town();
        for len in [20_001, 16_385, 16_384, 1, 0] {
            cloud.positions.truncate(len);
            cloud.colors.truncate(len);
            let processor = Processor::of(&cloud, &view);
            let drawn = draw(Arranged::from(&cloud), |_| true, twin(&view));
            assert_eq!(processor.covered(), drawn.point.iter().filter(|&&p| p != NO_POINT).count() as u64);
            assert_eq!(processor.compare(&drawn, Arranged::from(&cloud)), Agreement::default());
        }
        let grid = Grid { scale: [0.001; 3], origin: [0.0; 3] };
        let camera =
            Camera { eye: [9.0; 3], target: [8.0; 3], up: [0.0, 0.0, 1.0], fov_y_deg: 60.0, ..Default::default() };
        let view = camera.view(&grid, SIZE, 1).unwrap();
        assert_eq!(Processor::of(&cloud, &view).covered(), 0);
    }
}
