//! Points to try methods on, and how they enter a store. All of it follows from numbers: the same on every machine.

use std::sync::Arc;

use super::StabilityError;
use crate::{
    render::{Backend, Camera, FillBudget, FrameRequest, Progressive, Shading, StoreOptions, View},
    scene::{Bounds, ColorStats, FileFacts, Grid, PointBatch, SceneFacts, intensity_bin},
};

/// A number that depends on `k` and `stream` in no visible way.
pub fn noise(k: u32, stream: u32) -> u32 {
    let mut x = k.wrapping_mul(0x9E37_79B9) ^ stream.wrapping_mul(0x85EB_CA6B);
    x = (x ^ (x >> 15)).wrapping_mul(0x2C1B_3C6D);
    x = (x ^ (x >> 12)).wrapping_mul(0x297A_2D39);
    x ^ (x >> 15)
}

/// `noise` as a share, 0 to 1.
pub fn share(k: u32, stream: u32) -> f64 {
    f64::from(noise(k, stream)) / 2f64.powi(32)
}

/// Millimetres, from the origin.
pub const MILLIMETRES: Grid = Grid { scale: [0.001; 3], origin: [0.0; 3] };

/// Points in order of arrival, as of one file; record numbers count them.
pub struct Scene {
    pub facts: Arc<SceneFacts>,
    pub positions: Vec<[i32; 3]>,
    /// Red, green, blue, intensity.
    pub colors: Vec<[u16; 4]>,
}

impl Scene {
    pub fn new(grid: Grid, positions: Vec<[i32; 3]>, colors: Vec<[u16; 4]>) -> Scene {
        let corner = |start, pick: fn(i32, i32) -> i32| {
            grid.world(positions.iter().fold([start; 3], |c, p| std::array::from_fn(|a| pick(c[a], p[a]))))
        };
        let bounds = Bounds { min: corner(i32::MAX, i32::min), max: corner(i32::MIN, i32::max) };
        let file = FileFacts {
            path: "stability".into(),
            points_in_header: positions.len() as u64,
            bounds,
            ..Default::default()
        };
        let facts = Arc::new(SceneFacts { grid, bounds, files: vec![file], warnings: Vec::new() });
        Scene { facts, positions, colors }
    }

    /// Rolling ground of 100 m with houses, in scan lines; every tenth point is there twice.
    pub fn town(points: u32) -> Scene {
        const SIDE: f64 = 100_000.0;
        let lines = f64::from(points).sqrt().ceil() as u32;
        let place = |k: u32| {
            let k = if k % 10 == 9 { k - 1 } else { k };
            let along = |i: u32, stream| (f64::from(i) + 0.5 * share(k, stream)) * SIDE / f64::from(lines);
            let (x, y) = (along(k % lines, 1), along(k / lines, 2));
            let in_house = (x / 5000.0) as u32 % 3 == 1 && (y / 5000.0) as u32 % 3 == 1;
            let ground = 3000.0 * (x / 21_000.0).sin() * (y / 17_000.0).cos();
            [x as i32, y as i32, if in_house { 8000 } else { ground as i32 }]
        };
        let positions: Vec<[i32; 3]> = (0..points).map(place).collect();
        let color = |(p, k): (&[i32; 3], u32)| {
            let grain = (noise(k, 4) >> 18) as u16;
            let base =
                if p[2] == 8000 { [44_000, 20_000, 14_000] } else { [14_000, (30_000 + 4 * p[2]) as u16, 12_000] };
            [base[0] + grain, base[1] + grain, base[2] + grain, 30_000]
        };
        let colors = positions.iter().zip(0..).map(color).collect();
        Scene::new(MILLIMETRES, positions, colors)
    }

    pub fn len(&self) -> u32 {
        self.positions.len() as u32
    }

    /// All points in batches of so many, as a decoder sends them.
    pub fn batches(&self, size: usize) -> impl Iterator<Item = PointBatch> + '_ {
        let columns = self.positions.chunks(size).zip(self.colors.chunks(size));
        columns.enumerate().map(move |(i, (positions, colors))| {
            let mut stats = ColorStats::default();
            for (position, color) in positions.iter().zip(colors) {
                stats.rgb_max = stats.rgb_max.max(color[0]).max(color[1]).max(color[2]);
                stats.intensity_min = stats.intensity_min.min(color[3]);
                stats.intensity_max = stats.intensity_max.max(color[3]);
                stats.intensity[intensity_bin(color[3])] += 1;
                stats.z_min = stats.z_min.min(position[2]);
                stats.z_max = stats.z_max.max(position[2]);
            }
            let first = (i * size) as u32;
            PointBatch {
                positions: positions.to_vec(),
                colors: colors.to_vec(),
                records: (first..first + positions.len() as u32).collect(),
                stats,
                ..Default::default()
            }
        })
    }

    /// From the south and above, all of it in the picture.
    pub fn camera(&self, size: [u32; 2]) -> Camera {
        Camera::fit(&self.facts.bounds, &self.facts.grid, f64::from(size[0]) / f64::from(size[1]))
    }

    /// The view of a camera.
    ///
    /// # Errors
    /// A camera without direction.
    pub fn view(&self, camera: &Camera, size: [u32; 2], point_size: u32) -> Result<View, StabilityError> {
        Ok(camera.view(&self.facts.grid, size, point_size)?)
    }

    /// All points stored, seen from `view` with one point tried per frame.
    ///
    /// # Errors
    /// Memory that runs out, a lost device.
    pub fn load<B: Backend>(
        &self,
        backend: B,
        options: StoreOptions,
        view: &View,
    ) -> Result<Progressive<B>, StabilityError> {
        let mut progressive = Progressive::new(backend, options);
        progressive.open(self.facts.clone());
        self.batches(options.insertion_points as usize).for_each(|batch| progressive.offer(batch));
        progressive.end_of_input();
        while !progressive.is_loaded() {
            progressive.frame(&request(*view, 1))?;
        }
        Ok(progressive)
    }
}

/// A frame that tries so many points, shown in the points' own colours.
pub fn request(view: View, fill: u32) -> FrameRequest {
    let shading = Shading { edl_strength: 0.0, ..Default::default() };
    FrameRequest { view, fill: FillBudget::Fixed(fill), shading }
}

/// Pixels that show one record in one picture and another, or none, in the other; a pixel that is background in both
/// is not counted. And how many are counted.
pub fn differing(a: &[i64], b: &[i64]) -> (u32, u32) {
    let shown = || a.iter().zip(b).filter(|(a, b)| **a >= 0 || **b >= 0);
    (shown().filter(|(a, b)| a != b).count() as u32, shown().count() as u32)
}

/// `part / whole`; NaN of nothing.
pub fn ratio(part: u32, whole: u32) -> f64 {
    f64::from(part) / f64::from(whole)
}
