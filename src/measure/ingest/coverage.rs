//! How soon the points so far show the whole extent: cells of a grid over x and y that hold a point.

use serde::Serialize;

use super::reader::Way;
use crate::scene::SceneFacts;

/// Cells along x, and along y.
pub const SIDE: usize = 64;

/// The cells hit so far.
pub struct Cells {
    low: [f64; 2],
    per_step: [f64; 2],
    hit: Vec<bool>,
    count: u32,
}

impl Cells {
    /// A grid over the box that the headers promise (where it is nonsense, the reader has already put
    /// that of sampled points in its place). Points outside count for the cells at the border.
    pub fn new(facts: &SceneFacts) -> Cells {
        let (a, b) = (facts.grid.steps(facts.bounds.min), facts.grid.steps(facts.bounds.max));
        let low = [0, 1].map(|k| a[k].min(b[k]));
        let per_step = [0, 1].map(|k| {
            let extent = (a[k] - b[k]).abs();
            if extent > 0.0 { SIDE as f64 / extent } else { 0.0 }
        });
        Cells { low, per_step, hit: vec![false; SIDE * SIDE], count: 0 }
    }

    /// Marks the cells of these positions; returns how many are new.
    pub fn mark(&mut self, positions: &[[i32; 3]]) -> u32 {
        let before = self.count;
        for position in positions {
            // Numbers out of range, and none at all, saturate: the cast cannot leave the grid.
            let [x, y] = [0, 1].map(|k| {
                let cell = (f64::from(position[k]) - self.low[k]) * self.per_step[k];
                (cell as usize).min(SIDE - 1)
            });
            let hit = &mut self.hit[y * SIDE + x];
            self.count += u32::from(!*hit);
            *hit = true;
        }
        self.count - before
    }

    pub fn count(&self) -> u32 {
        self.count
    }
}

/// A batch that hit cells for the first time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Step {
    /// When it arrived, seconds from opening the file.
    pub secs: f64,
    /// Points up to and with it.
    pub points: u64,
    /// Cells up to and with it.
    pub cells: u32,
}

/// One run of the reader with an eye on the cells.
#[derive(Debug, Clone, Serialize)]
pub struct Coverage {
    /// When the last batch arrived.
    pub total_secs: f64,
    pub total_points: u64,
    /// Cells that hold a point in the end: the 100 % that shares refer to.
    pub total_cells: u32,
    /// Batches that hit no new cell are left out.
    pub steps: Vec<Step>,
    /// Share of the cells hit after 7 % of the total time.
    pub share_at_7_percent_of_time: f64,
    /// Share of the cells hit by the first 7 % of the points, in order of arrival.
    pub share_at_7_percent_of_points: f64,
}

/// Collects a [`Coverage`], batch by batch.
#[derive(Default)]
pub struct Watch {
    cells: Option<Cells>,
    steps: Vec<Step>,
    points: u64,
    secs: f64,
}

impl Watch {
    pub fn arrive(&mut self, facts: &SceneFacts, positions: &[[i32; 3]], secs: f64) {
        let cells = self.cells.get_or_insert_with(|| Cells::new(facts));
        let new = cells.mark(positions);
        self.points += positions.len() as u64;
        self.secs = secs;
        if new > 0 {
            self.steps.push(Step { secs, points: self.points, cells: cells.count() });
        }
    }

    /// `None` if no point came.
    pub fn finish(self) -> Option<Coverage> {
        let mut coverage = Coverage {
            total_secs: self.secs,
            total_points: self.points,
            total_cells: self.cells?.count(),
            steps: self.steps,
            share_at_7_percent_of_time: 0.0,
            share_at_7_percent_of_points: 0.0,
        };
        coverage.share_at_7_percent_of_time = coverage.share_after_time(0.07);
        coverage.share_at_7_percent_of_points = coverage.share_after_points(0.07);
        Some(coverage)
    }
}

impl Coverage {
    /// Share of the cells hit once a share of the total time has passed.
    pub fn share_after_time(&self, share: f64) -> f64 {
        self.share_while(|step| step.secs <= share * self.total_secs)
    }

    /// Share of the cells hit by a share of the points. Whole batches only: what part of a batch hits
    /// is not known.
    pub fn share_after_points(&self, share: f64) -> f64 {
        self.share_while(|step| step.points as f64 <= share * self.total_points as f64)
    }

    fn share_while(&self, counts: impl Fn(&Step) -> bool) -> f64 {
        let step = self.steps.iter().take_while(|step| counts(step)).last();
        step.map_or(0.0, |step| f64::from(step.cells) / f64::from(self.total_cells))
    }

    /// The curve in percent of the cells, as stairs: coverage stays until the next step.
    pub fn stairs(&self, x: impl Fn(&Step) -> f64, end: f64) -> Vec<(f64, f64)> {
        let percent = |cells: u32| 100.0 * f64::from(cells) / f64::from(self.total_cells);
        let mut out = vec![(0.0, 0.0)];
        let mut last = 0.0;
        for step in &self.steps {
            out.push((x(step), last));
            last = percent(step.cells);
            out.push((x(step), last));
        }
        out.push((end, last));
        out
    }
}

/// Runs of one way to read.
#[derive(Debug, Clone, Serialize)]
pub struct CoverageRuns {
    #[serde(flatten)]
    pub way: Way,
    pub samples: Vec<Coverage>,
}

impl CoverageRuns {
    /// The run whose coverage after 7 % of the time is the median.
    pub fn median(&self) -> Option<&Coverage> {
        let mut runs: Vec<&Coverage> = self.samples.iter().collect();
        runs.sort_by(|a, b| a.share_at_7_percent_of_time.total_cmp(&b.share_at_7_percent_of_time));
        runs.get((runs.len().max(1) - 1) / 2).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Bounds, FileFacts, Grid};

    /// 64 by 64 metres at centimetres: a cell is a metre wide.
    fn facts() -> SceneFacts {
        let bounds = Bounds { min: [1000.0, 2000.0, 0.0], max: [1064.0, 2064.0, 9.0] };
        let file = FileFacts {
            path: "a.las".into(),
            first_record: 0,
            points_in_header: 0,
            bounds,
            kind: "LAS 1.2, format 0".into(),
            ..Default::default()
        };
        SceneFacts {
            grid: Grid { scale: [0.01; 3], origin: [1000.0, 2000.0, 0.0] },
            bounds,
            files: vec![file],
            warnings: vec![],
        }
    }

    fn center(x: usize, y: usize) -> [i32; 3] {
        [100 * x as i32 + 50, 100 * y as i32 + 50, 0]
    }

    /// 64 batches of 4096 points, a second each; the same points in either order.
    fn watch(point: impl Fn(usize, usize) -> [i32; 3]) -> Coverage {
        let mut watch = Watch::default();
        for batch in 0..64 {
            let positions: Vec<_> = (0..4096).map(|i| point(batch, i)).collect();
            watch.arrive(&facts(), &positions, (batch + 1) as f64);
        }
        watch.finish().unwrap()
    }

    #[test]
    fn row_by_row_is_visibly_worse_than_a_little_of_everything() {
        let rows = watch(|batch, i| center(i % 64, batch));
        let spread = watch(|_, i| center(i % 64, i / 64));
        for coverage in [&rows, &spread] {
            assert_eq!((coverage.total_cells, coverage.total_points), (4096, 64 * 4096));
            assert_eq!(coverage.share_after_time(1.0), 1.0);
            assert_eq!(coverage.share_after_points(1.0), 1.0);
        }
        // 7 % of 64 batches: four rows of 64.
        assert_eq!(rows.share_at_7_percent_of_time, 4.0 / 64.0);
        assert_eq!(rows.share_at_7_percent_of_points, 4.0 / 64.0);
        assert_eq!(rows.share_after_time(0.5), 0.5);
        assert_eq!(spread.share_at_7_percent_of_time, 1.0);
        assert_eq!((rows.steps.len(), spread.steps.len()), (64, 1));
        assert_eq!(spread.share_after_time(0.01), 0.0, "before the first batch there is nothing");
    }

    #[test]
    fn stairs_rise_only_at_steps_and_end_at_all() {
        let curve = watch(|batch, i| center(i % 64, batch)).stairs(|step| step.secs, 64.0);
        assert!(curve.windows(2).all(|w| w[0].0 <= w[1].0 && w[0].1 <= w[1].1));
        assert_eq!(curve[..3], [(0.0, 0.0), (1.0, 0.0), (1.0, 100.0 / 64.0)]);
        assert_eq!(curve.last(), Some(&(64.0, 100.0)));
    }

    #[test]
    fn points_outside_and_boxes_without_extent_stay_on_the_grid() {
        let mut cells = Cells::new(&facts());
        assert_eq!(cells.mark(&[[i32::MIN; 3], center(0, 0), [i32::MAX; 3], center(63, 63)]), 2);
        let mut flat = facts();
        flat.bounds.max = flat.bounds.min;
        let mut cells = Cells::new(&flat);
        assert_eq!(cells.mark(&[[0; 3], [i32::MAX; 3]]), 1);
        flat.bounds.max = [f64::NAN; 3];
        assert_eq!(Cells::new(&flat).mark(&[[0; 3], [5; 3]]), 1);
        assert!(Watch::default().finish().is_none());
    }
}
