//! A small town for tests: terrain, houses with level roofs, and duplicates, in scan lines. Level
//! ground seen from above, and duplicates, make points of equal depth in a pixel: ties matter.

use std::ops::Range;

use firstlight::{
    render::Camera,
    scene::{Bounds, ColorStats, FileFacts, Grid, PointBatch, SceneFacts, intensity_bin},
    store::Packing,
};

/// Extent in grid steps.
const SIDE: i32 = 100_000;

/// Points in order of arrival, their records counted from 0.
#[derive(Clone)]
pub struct Cloud {
    pub facts: SceneFacts,
    positions: Vec<[i32; 3]>,
}

impl Cloud {
    /// About `points` points, exactly so many.
    pub fn town(points: usize) -> Cloud {
        let lines = (points as f64).sqrt().ceil() as usize;
        let mut positions: Vec<[i32; 3]> = Vec::with_capacity(points);
        for k in 0..points {
            // Every tenth point is there twice, some later ones three times.
            if k % 10 == 9 {
                positions.push(positions[k - 1 - k % 7]);
                continue;
            }
            let along = |i: usize| (i as i64 * i64::from(SIDE) / lines as i64) as i32;
            let (x, y) = (along(k % lines) + noise(k, 1) % 200, along(k / lines) + noise(k, 2) % 200);
            let in_house = (x / 5000) % 3 == 1 && (y / 5000) % 3 == 1;
            let terrain = (3000.0 * (f64::from(x) / 21_000.0).sin() * (f64::from(y) / 17_000.0).cos()) as i32;
            positions.push([x, y, if in_house { 8000 } else { terrain }]);
        }
        let mut cloud = Cloud {
            facts: SceneFacts {
                grid: Grid { scale: [0.001; 3], origin: [0.0; 3] },
                bounds: Bounds { min: [0.0; 3], max: [0.0; 3] },
                files: Vec::new(),
                warnings: Vec::new(),
            },
            positions,
        };
        cloud.promise();
        cloud
    }

    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// The points in another order, every record number going with its place in the new one.
    pub fn in_random_order(mut self) -> Cloud {
        for i in (1..self.len()).rev() {
            self.positions.swap(i, noise(i, 3) as usize % (i + 1));
        }
        self
    }

    pub fn with_scale(mut self, scale: f64) -> Cloud {
        self.facts.grid.scale = [scale; 3];
        self.promise();
        self
    }

    pub fn shifted_origin(mut self, shift: [f64; 3]) -> Cloud {
        self.facts.grid.origin = std::array::from_fn(|a| self.facts.grid.origin[a] + shift[a]);
        self.promise();
        self
    }

    pub fn shifted_integers(mut self, shift: [i32; 3]) -> Cloud {
        for position in &mut self.positions {
            *position = std::array::from_fn(|a| position[a] + shift[a]);
        }
        self.promise();
        self
    }

    /// Other points, on the same grid.
    pub fn replace(&mut self, positions: Vec<[i32; 3]>) {
        self.positions = positions;
        self.promise();
    }

    /// Every `nth` point, from the first `from` on, lies where no header promised it, kilometres away on one axis or
    /// another; the promise stays.
    pub fn with_outliers(mut self, from: usize, nth: usize) -> Cloud {
        for (k, position) in self.positions.iter_mut().enumerate().skip(from).step_by(nth) {
            position[k % 3] = if k % 2 == 0 { i32::MAX - k as i32 } else { i32::MIN + k as i32 };
        }
        self
    }

    /// The default camera.
    pub fn camera(&self) -> Camera {
        Camera::fit(&self.facts.bounds, &self.facts.grid, 4.0 / 3.0)
    }

    /// Views from around and above, nearer with each step; step 2 looks straight down, where level
    /// ground has equal depths.
    pub fn camera_moved(&self, step: usize) -> Camera {
        let camera = self.camera();
        let size = self.facts.bounds.diagonal();
        let target = camera.target;
        if step == 2 {
            return Camera { eye: [target[0], target[1], target[2] + size], ..camera };
        }
        let (turn, distance) = (step as f64 * 0.7, size * (1.0 - 0.09 * step as f64));
        let eye = [target[0] + distance * turn.sin(), target[1] - distance * turn.cos(), target[2] + 0.4 * distance];
        Camera { eye, ..camera }
    }

    /// Of what the header promises.
    pub fn packing(&self) -> Option<Packing> {
        Packing::of_scene(&self.facts.grid, &self.facts.bounds).ok()
    }

    pub fn positions(&self) -> &[[i32; 3]] {
        &self.positions
    }

    /// The points of `range` as a decoder sends them.
    pub fn batch(&self, range: Range<usize>) -> PointBatch {
        let mut stats = ColorStats::default();
        let colors: Vec<[u16; 4]> = range
            .clone()
            .map(|k| {
                let c: [u16; 4] = std::array::from_fn(|c| noise(k, 4 + c as u32) as u16);
                stats.rgb_max = stats.rgb_max.max(c[0]).max(c[1]).max(c[2]);
                stats.intensity_min = stats.intensity_min.min(c[3]);
                stats.intensity_max = stats.intensity_max.max(c[3]);
                stats.intensity[intensity_bin(c[3])] += 1;
                c
            })
            .collect();
        let positions = self.positions[range.clone()].to_vec();
        for position in &positions {
            stats.z_min = stats.z_min.min(position[2]);
            stats.z_max = stats.z_max.max(position[2]);
        }
        PointBatch {
            file: 0,
            positions,
            colors,
            records: range.map(|k| k as u32).collect(),
            stats,
            ..Default::default()
        }
    }

    /// Writes the facts that a header would promise.
    fn promise(&mut self) {
        let fold = |start, pick: fn(i32, i32) -> i32| {
            let corner = self.positions.iter().fold([start; 3], |c, p| std::array::from_fn(|a| pick(c[a], p[a])));
            self.facts.grid.world(corner)
        };
        let bounds = Bounds { min: fold(i32::MAX, i32::min), max: fold(i32::MIN, i32::max) };
        self.facts.bounds = bounds;
        self.facts.files = vec![FileFacts {
            path: "town.las".into(),
            first_record: 0,
            points_in_header: self.positions.len() as u64,
            bounds,
            kind: "LAS 1.4, format 7".into(),
            ..Default::default()
        }];
    }
}

/// A non-negative number that depends on `k` and `stream` in no visible way.
fn noise(k: usize, stream: u32) -> i32 {
    let mut x = (k as u32).wrapping_mul(0x9E37_79B9) ^ stream.wrapping_mul(0x85EB_CA6B);
    x = (x ^ (x >> 15)).wrapping_mul(0x2C1B_3C6D);
    x = (x ^ (x >> 12)).wrapping_mul(0x297A_2D39);
    ((x ^ (x >> 15)) >> 1) as i32
}
