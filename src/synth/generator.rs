//! Points by number, without a file.

use std::ops::Range;

use crate::scene::{Bounds, Grid, PointBatch, intensity_bin};

use super::{Scene, SynthError, SynthOptions, planes, town::Town};

/// One point with all fields that any format stores.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SynthPoint {
    /// The record's X, Y, Z: steps of [`SynthOptions::grid`].
    pub position: [i32; 3],
    /// 16 bits per channel.
    pub rgb: [u16; 3],
    /// Near infrared, 16 bits.
    pub nir: u16,
    pub intensity: u16,
    /// From 1 up to `number_of_returns`, which is at most 4.
    pub return_number: u8,
    pub number_of_returns: u8,
    /// ASPRS class as in formats 6 and above.
    pub classification: u8,
    /// Steps of 0.006°, negative to the left of the flight.
    pub scan_angle: i16,
    /// Seconds since the survey began; files add a start date.
    pub gps_time: f64,
    /// The flight strip, from 1.
    pub point_source: u16,
    pub scan_direction: bool,
    pub edge_of_flight_line: bool,
}

enum Kind {
    Town(Box<Town>),
    Planes,
}

/// Makes any points of a scan, in any order; shared freely between threads.
pub struct Generator {
    kind: Kind,
    seed: u64,
    points: u64,
    grid: Grid,
    /// Grid steps per metre, and from the grid's origin to the scene's.
    steps_per_metre: f64,
    shift: [i32; 3],
    bounds: Bounds,
}

impl Generator {
    /// Prepares a scene; for a town, this lays out streets and houses in some milliseconds.
    ///
    /// # Errors
    /// As [`SynthOptions::check`], and [`SynthError::Range`] if coordinates do not fit the grid.
    pub fn new(options: &SynthOptions) -> Result<Generator, SynthError> {
        options.check()?;
        let (kind, local) = match options.scene {
            Scene::Town => {
                let town = Town::new(options.seed, options.points);
                let bounds = town.bounds();
                (Kind::Town(Box::new(town)), bounds)
            }
            Scene::Planes => (Kind::Planes, planes::BOUNDS.map(|corner| corner.map(|x| f64::from(x) * options.scale))),
        };
        let grid = options.grid();
        let mut shift = [0; 3];
        for axis in 0..3 {
            let from_offset = options.origin[axis] - grid.origin[axis];
            let (low, high) = (local[0][axis] + from_offset, local[1][axis] + from_offset);
            // One step of slack for rounding; written so that NaN does not pass.
            let fits = |x: f64| (x / options.scale).abs() < f64::from(i32::MAX) - 1.0;
            if !(fits(low) && fits(high)) {
                return Err(SynthError::Range { axis: ['x', 'y', 'z'][axis], low, high, scale: options.scale });
            }
            shift[axis] = (from_offset / options.scale).round() as i32;
        }
        // The scene's true place on the grid, which the origin may lie between two steps of.
        let place = |corner: [f64; 3], slack: f64| {
            std::array::from_fn(|a| grid.origin[a] + f64::from(shift[a]) * options.scale + corner[a] + slack)
        };
        let bounds = Bounds { min: place(local[0], -options.scale), max: place(local[1], options.scale) };
        let steps_per_metre = 1.0 / options.scale;
        Ok(Generator { kind, seed: options.seed, points: options.points, grid, steps_per_metre, shift, bounds })
    }

    /// Number of points of the scan.
    pub fn len(&self) -> u64 {
        self.points
    }

    pub fn is_empty(&self) -> bool {
        self.points == 0
    }

    /// The grid that positions lie on.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// A box, in the file's coordinates, that all points lie in; somewhat larger than the smallest one.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Calls `f` with each point of a range, in order. The range is cut at the end of the scan.
    #[inline]
    pub fn for_each(&self, range: Range<u64>, mut f: impl FnMut(SynthPoint)) {
        let end = range.end.min(self.points);
        match &self.kind {
            Kind::Town(town) => town.run(range.start, end, |metres, point| {
                // Rounded half up, through a cast that truncates: far faster than `floor` on baseline x86.
                let bias = f64::from(1 << 30);
                let step = |a: usize| {
                    ((metres[a] * self.steps_per_metre + (bias + 0.5)) as i64 - (1 << 30)) as i32 + self.shift[a]
                };
                f(SynthPoint { position: [step(0), step(1), step(2)], ..point });
            }),
            Kind::Planes => {
                for i in range.start..end {
                    let (steps, point) = planes::point(self.seed, i);
                    f(SynthPoint { position: std::array::from_fn(|a| steps[a] + self.shift[a]), ..point });
                }
            }
        }
    }

    /// Fills a slice with the points from `first` on.
    ///
    /// # Panics
    /// If the scan has fewer points than asked for.
    pub fn fill(&self, first: u64, points: &mut [SynthPoint]) {
        assert!(first + points.len() as u64 <= self.points, "the scan has {} points", self.points);
        let mut slots = points.iter_mut();
        self.for_each(first..first + slots.len() as u64, |point| {
            if let Some(slot) = slots.next() {
                *slot = point;
            }
        });
    }

    /// Puts a range of points into a batch, as a reader of a file with RGB would.
    ///
    /// # Panics
    /// If the range ends beyond the scan, or beyond the 2³² record numbers of a scene.
    pub fn fill_batch(&self, range: Range<u64>, batch: &mut PointBatch) {
        assert!(range.end <= self.points && range.end <= 1 << 32, "the scan has {} points", self.points);
        batch.clear();
        let stats = &mut batch.stats;
        self.for_each(range.clone(), |point| {
            let [red, green, blue] = point.rgb;
            batch.positions.push(point.position);
            batch.colors.push([red, green, blue, point.intensity]);
            stats.rgb_max = stats.rgb_max.max(red).max(green).max(blue);
            stats.intensity_min = stats.intensity_min.min(point.intensity);
            stats.intensity_max = stats.intensity_max.max(point.intensity);
            stats.z_min = stats.z_min.min(point.position[2]);
            stats.z_max = stats.z_max.max(point.position[2]);
        });
        for colors in batch.colors.iter().step_by(16) {
            batch.stats.intensity[intensity_bin(colors[3])] += 1;
        }
        batch.records.extend(range.map(|i| i as u32));
    }

    /// Point `i`.
    ///
    /// # Panics
    /// If the scan has no such point.
    pub fn point(&self, i: u64) -> SynthPoint {
        let mut point = [SynthPoint::default()];
        self.fill(i, &mut point);
        point[0]
    }

    /// All points in order.
    pub fn iter(&self) -> impl Iterator<Item = SynthPoint> + '_ {
        const RUN: u64 = 4096;
        (0..self.points.div_ceil(RUN)).flat_map(move |run| {
            let mut points = Vec::with_capacity(RUN as usize);
            self.for_each(run * RUN..(run + 1) * RUN, |point| points.push(point));
            points
        })
    }
}
