//! Where to look from: the viewpoints of Schütz, Kerbl and Wimmer 2021, for any scan.

use clap::ValueEnum;
use glam::DVec3;
use serde::Serialize;

use crate::{
    methods::parallel::extent,
    render::Camera,
    scene::{Bounds, Grid},
};

/// A viewpoint that every scan has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Viewpoint {
    /// Within the scan's outline, over its top, looking up: no point in the frustum, all are only read
    InsideNone,
    /// A tenth of the overview's distance from a point in the middle
    Closeup,
    /// The whole scan fills the picture
    Overview,
    /// The whole scan on a few thousand pixels: many points per pixel
    Far,
}

/// Pixels that the box of the scan may fill in [`Viewpoint::Far`], about; its points cover fewer.
const FAR_PIXELS: f64 = 6000.0;

/// Share of the overview's distance in [`Viewpoint::Closeup`].
const CLOSE: f64 = 0.1;

impl Viewpoint {
    /// As the command line calls it.
    pub fn name(self) -> &'static str {
        match self {
            Viewpoint::InsideNone => "inside-none",
            Viewpoint::Closeup => "closeup",
            Viewpoint::Overview => "overview",
            Viewpoint::Far => "far",
        }
    }

    /// The camera for a picture of `size` pixels. The points' own box counts, not what headers promise.
    pub fn camera(self, positions: &[[i32; 3]], grid: &Grid, size: [u32; 2]) -> Camera {
        let (low, high) = extent(positions).unwrap_or_default();
        let [a, b] = [grid.world(low), grid.world(high)];
        // A scale may be negative.
        let bounds =
            Bounds { min: std::array::from_fn(|i| a[i].min(b[i])), max: std::array::from_fn(|i| a[i].max(b[i])) };
        let overview = Camera::fit(&bounds, grid, f64::from(size[0]) / f64::from(size[1]));
        let [eye, target] = [overview.eye, overview.target].map(DVec3::from_array);
        match self {
            Viewpoint::Overview => overview,
            Viewpoint::Far => {
                let farther = (f64::from(size[0]) * f64::from(size[1]) / FAR_PIXELS).sqrt().max(1.0);
                Camera { eye: (target + farther * (eye - target)).to_array(), ..overview }
            }
            Viewpoint::Closeup => {
                let center = DVec3::from_array(bounds.center());
                // A point, not the box's centre, which may be in the air. Some thousand are looked at.
                let step = (positions.len() / 4096).max(1);
                let near = positions.iter().step_by(step).map(|&p| DVec3::from_array(grid.world(p)));
                let middle = near.min_by(|p, q| p.distance_squared(center).total_cmp(&q.distance_squared(center)));
                let middle = middle.unwrap_or(center);
                Camera { eye: (middle + CLOSE * (eye - target)).to_array(), target: middle.to_array(), ..overview }
            }
            Viewpoint::InsideNone => {
                let [x, y, _] = bounds.center();
                // Above every point by a hundredth of the box, at least a hundred steps: no rounding reaches there.
                let room = (0.01 * bounds.diagonal()).max(100.0 * grid.scale[2].abs());
                let (eye, target) = ([x, y, bounds.max[2] + room], [x, y, bounds.max[2] + 2.0 * room]);
                Camera { eye, target, up: [0.0, 1.0, 0.0], ..overview }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::{Generator, Scene, SynthOptions};

    const SIZE: [u32; 2] = [640, 360];

    /// Points in the frustum, and pixels with any.
    fn seen(camera: &Camera, positions: &[[i32; 3]], grid: &Grid) -> (usize, usize) {
        let view = camera.view(grid, SIZE, 1).unwrap();
        let mut pixels = vec![false; (SIZE[0] * SIZE[1]) as usize];
        let mut points = 0;
        for projected in positions.iter().filter_map(|&p| view.project(p)) {
            let [x, y] = projected.corner;
            pixels[y as usize * SIZE[0] as usize + x as usize] = true;
            points += 1;
        }
        (points, pixels.iter().filter(|&&covered| covered).count())
    }

    #[test]
    fn each_view_shows_what_it_is_for() {
        for scene in [Scene::Town, Scene::Planes] {
            let generator = Generator::new(&SynthOptions { points: 50_000, ..SynthOptions::new(scene) }).unwrap();
            let positions: Vec<_> = generator.iter().map(|point| point.position).collect();
            let grid = generator.grid();
            let see = |view: Viewpoint| seen(&view.camera(&positions, &grid, SIZE), &positions, &grid);
            assert_eq!(see(Viewpoint::InsideNone), (0, 0), "{scene:?}");
            let (points, overview) = see(Viewpoint::Overview);
            assert_eq!(points, positions.len(), "{scene:?}: the whole scan");
            let (points, far) = see(Viewpoint::Far);
            assert_eq!(points, positions.len(), "{scene:?}: the whole scan, from afar");
            assert!((500..6000).contains(&far) && far < overview, "{scene:?}: {far} pixels, {overview}");
            let (points, _) = see(Viewpoint::Closeup);
            assert!(points > 0 && points < positions.len() / 2, "{scene:?}: {points} points in the closeup");
        }
    }

    #[test]
    fn any_cloud_has_views() {
        let grid = Grid { scale: [0.01, 0.01, -0.01], origin: [5e6, 1e6, 0.0] };
        let line: Vec<_> = (0..100).map(|x| [x, 0, 0]).collect();
        for positions in [&[][..], &[[5, 5, 5]], &line, &[[i32::MIN; 3], [i32::MAX; 3]]] {
            for view in [Viewpoint::InsideNone, Viewpoint::Closeup, Viewpoint::Overview, Viewpoint::Far] {
                let camera = view.camera(positions, &grid, SIZE);
                let view_of = camera.view(&grid, SIZE, 1);
                assert!(view_of.is_ok(), "{view:?} {:?}: {view_of:?}", positions.first());
                if view == Viewpoint::InsideNone {
                    assert_eq!(seen(&camera, positions, &grid), (0, 0));
                }
            }
        }
    }
}
