//! The fill budget: how many random points a frame may try (`numRandom`).

use super::backend::PassTimes;

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

/// Follows measured pass times to hold a target frame time.
#[derive(Debug, Clone, Copy)]
pub struct BudgetController {
    points: u32,
}

impl Default for BudgetController {
    fn default() -> Self {
        BudgetController { points: FIRST_FILL }
    }
}

impl BudgetController {
    /// Points to try in the next frame.
    pub fn points(&self, budget: FillBudget) -> u32 {
        match budget {
            FillBudget::Fixed(points) => points,
            FillBudget::Target(_) => self.points,
        }
    }

    /// Learns from a finished frame. What is left of the target after the other passes belongs to the
    /// fill. A budget grows by no more than half per frame, since one quick frame (all points outside
    /// of the picture, say) tells little about the next, and shrinks at once.
    pub fn learn(&mut self, times: &PassTimes, target_secs: f64) {
        // Short fills are dominated by the dispatch itself.
        if times.fill_points < MIN_FILL || times.fill <= 0.0 {
            return;
        }
        let left = (target_secs - (times.total() - times.fill)).max(0.1 * target_secs);
        let fitting = left * f64::from(times.fill_points) / times.fill;
        let limit = 1.5 * f64::from(self.points);
        self.points = (fitting.min(limit) as u32).clamp(MIN_FILL, MAX_FILL);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A device with a fixed cost and a cost per point.
    fn settle(per_point: f64, other: f64, target: f64) -> f64 {
        let mut controller = BudgetController::default();
        let mut total = 0.0;
        for _ in 0..60 {
            let fill_points = controller.points(FillBudget::Target(target));
            let times = PassTimes {
                fill: per_point * f64::from(fill_points),
                resolve: other,
                fill_points,
                ..Default::default()
            };
            total = times.total();
            controller.learn(&times, target);
        }
        total
    }

    #[test]
    fn holds_the_target_on_slow_and_fast_devices() {
        for per_point in [1e-10, 1e-8, 2e-7] {
            let total = settle(per_point, 0.004, 0.016);
            assert!((total - 0.016).abs() < 0.001, "{per_point}: {total}");
        }
    }

    #[test]
    fn never_stops_when_the_rest_alone_exceeds_the_target() {
        assert!(settle(1e-8, 0.05, 0.016) > 0.05);
    }

    #[test]
    fn a_fixed_budget_stays() {
        assert_eq!(BudgetController::default().points(FillBudget::Fixed(5)), 5);
    }
}
