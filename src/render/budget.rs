//! The fill budget: how many random points a frame may try (`numRandom`).

use super::in_motion::InMotion;
use crate::device::{PassTimes, Passes};

/// Fewest points a frame tries: progress must not stop on the slowest device.
const MIN_FILL: u32 = 10_000;
/// Most points a frame tries.
const MAX_FILL: u32 = 1 << 30;
/// Where the automatic budget starts; a software rasterizer takes some 20 ms for it.
const FIRST_FILL: u32 = 1_000_000;

/// How many points to try in each frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FillBudget {
    /// So many points, whatever it takes.
    Fixed(u32),
    /// As many as fit into a frame of this many seconds on the device.
    Target(f64),
}

/// Share of the target that the fill gets even where the other passes alone exceed it: without, a slow
/// device would pay for whole frames and see nothing new in them.
const LEAST_SHARE: f64 = 0.5;
/// Frame times, in targets, above which loading takes fewer insertions per frame, and below which more.
const TOO_LONG: f64 = 1.5;
const SHORT_ENOUGH: f64 = 1.0;

/// Fewest insertions per frame while points wait: the rest of a frame costs a slow device as much as
/// these do, and with fewer a file would take minutes to load.
const MIN_INSERTIONS: usize = 4;

/// Follows measured frame times to hold a target: with the fill, while loading with the number of
/// insertions, and with high-quality shading in motion or without.
#[derive(Debug, Clone, Copy)]
pub struct BudgetController {
    insertions: usize,
    /// A fill for each kind of frame, in the order of [`Passes`].
    fills: [Fill; 3],
    in_motion: InMotion,
}

/// The fill of one kind of frame.
#[derive(Debug, Clone, Copy, Default)]
struct Fill {
    /// None until a frame of the kind has been timed.
    points: Option<u32>,
    cost: CostModel,
}

impl Default for BudgetController {
    fn default() -> Self {
        BudgetController { insertions: MIN_INSERTIONS, fills: Default::default(), in_motion: InMotion::default() }
    }
}

impl BudgetController {
    /// Points to try in the next frame, if it makes these passes.
    pub fn points(&self, budget: FillBudget, passes: Passes) -> u32 {
        match budget {
            FillBudget::Fixed(points) => points,
            FillBudget::Target(_) => self.target_points(passes),
        }
    }

    fn target_points(&self, passes: Passes) -> u32 {
        let learnt = |passes: Passes| self.fills[passes as usize].points;
        match passes {
            Passes::Depths => learnt(passes).unwrap_or(FIRST_FILL),
            // Sums cost about as much as depths.
            Passes::DepthsAndSums => learnt(passes).unwrap_or(self.target_points(Passes::Depths) / 2).max(MIN_FILL),
            Passes::Sums => learnt(passes).unwrap_or(self.target_points(Passes::DepthsAndSums)),
        }
    }

    /// Whether high-quality shading is also for frames that draw depths.
    pub fn averages_in_motion(&self, budget: FillBudget) -> bool {
        matches!(budget, FillBudget::Fixed(_)) || !self.in_motion.is_dropped()
    }

    /// Insertions that the next frame may take, at most `limit`.
    pub fn insertions(&self, budget: FillBudget, limit: usize) -> usize {
        match budget {
            FillBudget::Fixed(_) => limit,
            FillBudget::Target(_) => self.insertions.min(limit),
        }
    }

    /// Learns from a finished frame; `host_secs` is what its insertions took on the host.
    pub fn learn(&mut self, times: &PassTimes, host_secs: f64, target_secs: f64) {
        let has_stages = times.undivided == 0.0;
        if times.insertions > 0 {
            // The host's part overlaps with the device's, or is the same on the CPU backend.
            let secs = times.total() - times.insert + times.insert.max(host_secs);
            if secs > TOO_LONG * target_secs {
                // Nothing else is left to be given up.
                if self.insertions == MIN_INSERTIONS && !has_stages {
                    self.in_motion.note(times.passes, secs, target_secs);
                }
                self.insertions = (self.insertions / 2).max(MIN_INSERTIONS);
            } else if times.insertions as usize >= self.insertions {
                // Twice as many take at most twice as long.
                if secs < 0.5 * SHORT_ENOUGH * target_secs {
                    self.insertions *= 2;
                } else if secs < SHORT_ENOUGH * target_secs {
                    self.insertions += 1;
                }
            }
        }
        let before = self.target_points(times.passes);
        let fill = &mut self.fills[times.passes as usize];
        let learnt = fill.cost.learn(times);
        if has_stages || (learnt.is_some() && fill.cost.tells_fixed()) {
            let fixed_secs = match learnt {
                Some((fixed_secs, _)) if !has_stages => fixed_secs,
                // Insertions have their own limit.
                _ => times.total() - times.fill - times.average_fill - times.insert,
            };
            self.in_motion.note(times.passes, fixed_secs, target_secs);
        }
        let Some((fixed_secs, secs_per_point)) = learnt else { return };
        // At rest nobody waits for the next frame: no more than half of the time goes to what each costs anyway.
        // (With less, averages of 2 M points took 125 frames on two cores.)
        let at_rest = if times.passes == Passes::Sums { fixed_secs } else { 0.0 };
        let left = (target_secs - fixed_secs).max(LEAST_SHARE * target_secs).max(at_rest);
        // A budget grows by no more than half per frame, since one quick frame (all points outside of the
        // picture, say) tells little about the next, and shrinks at once.
        let limit = 1.5 * f64::from(before);
        fill.points = Some(((left / secs_per_point).min(limit) as u32).clamp(MIN_FILL, MAX_FILL));
    }
}

/// Seconds per frame and per point tried.
///
/// A device that times its passes says both. Of others only whole frames are known: a line through
/// the recent ones, `secs = fixed + per_point * points`, older ones weighing less and less. A single frame
/// that was held up (the processor had other work) counts as [`HELD_UP`] times what the line says; with the next one
/// as slow, it is the device that has become slower. Simulated with 20 ms more in every tenth frame, at random: the
/// middle budget is 92 to 93 % of an undisturbed one, where it was 84 %.
#[derive(Debug, Clone, Copy, Default)]
struct CostModel {
    was_held_up: bool,
    weight: f64,
    points: f64,
    secs: f64,
    points_squared: f64,
    points_secs: f64,
    secs_per_point: f64,
}

/// Times above what the line says by which a frame is told to be held up: more than the usual noise of a tenth.
const HELD_UP: f64 = 1.3;
/// Frames, by their weights, that make a line to judge others by.
const ENOUGH_FRAMES: f64 = 3.0;

/// Of a slope that a frame says nothing of. Budgets differ enough after some ten frames.
const FADING: f64 = 0.985;

impl CostModel {
    /// Seconds that a frame takes besides, and per point of its fill.
    fn learn(&mut self, times: &PassTimes) -> Option<(f64, f64)> {
        let points = times.fill_points.max(times.average_points);
        // Short fills are dominated by the dispatch itself.
        if points < MIN_FILL {
            return None;
        }
        if times.undivided == 0.0 {
            let fill_secs = times.fill + times.average_fill;
            // Points that only one of both passes drew cost less than those of other frames; two rates add up.
            let rate = |secs: f64, points: u32| if points < MIN_FILL { 0.0 } else { secs / f64::from(points) };
            let secs_per_point = rate(times.fill, times.fill_points) + rate(times.average_fill, times.average_points);
            return (secs_per_point > 0.0).then_some((times.total() - fill_secs, secs_per_point));
        }
        let is_uneven = times.passes == Passes::DepthsAndSums && times.fill_points != times.average_points;
        if times.insertions > 0 || is_uneven {
            return None;
        }
        let x = f64::from(points);
        const KEPT: f64 = 0.9;
        let y = self.without_hold_up(x, times.undivided);
        for (sum, sample) in [
            (&mut self.weight, 1.0),
            (&mut self.points, x),
            (&mut self.secs, y),
            (&mut self.points_squared, x * x),
            (&mut self.points_secs, x * y),
        ] {
            *sum = KEPT * *sum + sample;
        }
        let (mean_x, mean_y) = (self.points / self.weight, self.secs / self.weight);
        let variance = self.points_squared / self.weight - mean_x * mean_x;
        let slope = (self.points_secs / self.weight - mean_x * mean_y) / variance;
        // Budgets that hardly differ say nothing of the slope. What was learnt before fades, so that the budget grows
        // until it tells: else a device that was busy once would keep the budget of that time for good.
        if variance > (0.05 * mean_x).powi(2) && slope > 0.0 {
            self.secs_per_point = slope.min(mean_y / mean_x);
        } else if self.secs_per_point == 0.0 {
            self.secs_per_point = mean_y / mean_x;
        } else {
            self.secs_per_point *= FADING;
        }
        Some(((mean_y - self.secs_per_point * mean_x).max(0.0), self.secs_per_point))
    }

    /// What a frame with a fill of `x` points counts as that took `secs`.
    fn without_hold_up(&mut self, x: f64, secs: f64) -> f64 {
        if self.weight < ENOUGH_FRAMES {
            return secs;
        }
        let expected = self.secs / self.weight + self.secs_per_point * (x - self.points / self.weight);
        let is_long = expected > 0.0 && secs > HELD_UP * expected;
        let was_held_up = std::mem::replace(&mut self.was_held_up, is_long);
        if is_long && !was_held_up { HELD_UP * expected } else { secs }
    }

    /// True once frames of different fills have told their fixed part from the rest.
    fn tells_fixed(&self) -> bool {
        self.secs_per_point > 0.0 && self.secs_per_point < self.secs / self.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frame time that the fill settles at, on a device with a fixed cost and a cost per point.
    fn settle(per_point: f64, fixed: f64, target: f64, tells_passes: bool) -> f64 {
        let mut controller = BudgetController::default();
        let mut total = 0.0;
        for _ in 0..80 {
            let fill_points = controller.points(FillBudget::Target(target), Passes::Depths);
            let fill = per_point * f64::from(fill_points);
            let times = if tells_passes {
                PassTimes { fill, resolve: fixed, fill_points, ..Default::default() }
            } else {
                PassTimes { undivided: fixed + fill, fill_points, ..Default::default() }
            };
            total = times.total();
            controller.learn(&times, 0.0, target);
        }
        total
    }

    #[test]
    fn holds_the_target_on_slow_and_fast_devices() {
        for tells_passes in [true, false] {
            for per_point in [1e-10, 1e-8, 2e-7] {
                let total = settle(per_point, 0.004, 0.016, tells_passes);
                assert!((total - 0.016).abs() < 0.001, "{per_point}, passes {tells_passes}: {total}");
            }
        }
    }

    #[test]
    fn goes_on_when_the_rest_alone_exceeds_the_target() {
        for tells_passes in [true, false] {
            let total = settle(1e-8, 0.05, 0.016, tells_passes);
            assert!((total - 0.058).abs() < 0.002, "passes {tells_passes}: {total}");
        }
    }

    /// Least and largest fill, in shares of the undisturbed one, of a device that does not time its passes, from frame
    /// 100 on; `slower(frame)` says how many times a frame's time it takes.
    fn fills_while(frames: u32, slower: impl Fn(u32) -> f64) -> (f64, f64) {
        let (per_point, fixed, target) = (1e-8, 0.004, 0.016);
        let mut controller = BudgetController::default();
        let (mut least, mut largest) = (f64::INFINITY, 0.0_f64);
        for frame in 0..frames {
            let fill_points = controller.points(FillBudget::Target(target), Passes::Depths);
            let undivided = (fixed + per_point * f64::from(fill_points)) * slower(frame);
            let share = f64::from(fill_points) * per_point / (target - fixed);
            if frame >= 100 {
                (least, largest) = (least.min(share), largest.max(share));
            }
            controller.learn(&PassTimes { undivided, fill_points, ..Default::default() }, 0.0, target);
        }
        (least, largest)
    }

    #[test]
    fn a_frame_held_up_says_little_and_a_slower_device_all() {
        let (least, largest) = fills_while(300, |frame| if frame % 9 == 0 { 2.5 } else { 1.0 });
        assert!(least > 0.85 && largest < 1.1, "{least} {largest}");
        // Of one frame in nine the line would be a sixth too high.
        let (least, _) = fills_while(300, |frame| if frame % 9 < 2 { 2.5 } else { 1.0 });
        assert!(least < 0.7, "two in a row count: {least}");
        // Busy for a second or two, then free again.
        let (_, largest) = fills_while(250, |frame| if frame < 100 { 8.0 } else { 1.0 });
        assert!(largest > 0.95, "what was learnt while it was slow fades: {largest}");
        let (least, _) = fills_while(140, |frame| if frame < 100 { 1.0 } else { 3.0 });
        assert!(least < 0.3, "forty frames after it became three times slower: {least}");
    }

    #[test]
    fn each_kind_of_frame_has_its_own_fill() {
        let target = FillBudget::Target(0.016);
        let mut controller = BudgetController::default();
        for _ in 0..80 {
            for (passes, secs_per_point, fixed) in
                [(Passes::Depths, 1e-8, 0.002), (Passes::DepthsAndSums, 3e-8, 0.004), (Passes::Sums, 2e-8, 0.030)]
            {
                let points = controller.points(target, passes);
                let secs = secs_per_point * f64::from(points);
                let (fill_points, average_points) = match passes {
                    Passes::Depths => (points, 0),
                    Passes::DepthsAndSums => (points, points),
                    Passes::Sums => (0, points),
                };
                let [fill, average_fill] = match passes {
                    Passes::Depths => [secs, 0.0],
                    Passes::DepthsAndSums => [secs / 3.0, secs * 2.0 / 3.0],
                    Passes::Sums => [0.0, secs],
                };
                let times = PassTimes {
                    passes,
                    fill,
                    average_fill,
                    fill_points,
                    average_points,
                    resolve: fixed,
                    ..Default::default()
                };
                controller.learn(&times, 0.0, 0.016);
            }
        }
        let near =
            |passes: Passes, points: f64| (f64::from(controller.points(target, passes)) / points - 1.0).abs() < 0.01;
        assert!(near(Passes::Depths, 0.014 / 1e-8), "{controller:?}");
        assert!(near(Passes::DepthsAndSums, 0.012 / 3e-8), "{controller:?}");
        assert!(near(Passes::Sums, 0.030 / 2e-8), "at rest as long as the rest of the frame: {controller:?}");
    }

    #[test]
    fn a_fixed_budget_stays() {
        assert_eq!(BudgetController::default().points(FillBudget::Fixed(5), Passes::Sums), 5);
        assert_eq!(BudgetController::default().insertions(FillBudget::Fixed(5), 16), 16);
    }

    #[test]
    fn loading_takes_what_the_frame_time_allows() {
        for (secs_per_insertion, expected) in [(0.05, 4..=4), (0.002, 5..=12), (1e-5, 16..=16)] {
            let mut controller = BudgetController::default();
            for _ in 0..100 {
                let insertions = controller.insertions(FillBudget::Target(0.016), 16);
                let insert = secs_per_insertion * insertions as f64;
                let times = PassTimes { insert, insertions: insertions as u32, ..Default::default() };
                controller.learn(&times, 0.0, 0.016);
            }
            let settled = controller.insertions(FillBudget::Target(0.016), 16);
            assert!(expected.contains(&settled), "{secs_per_insertion}: {settled}");
        }
    }
}
