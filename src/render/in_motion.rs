//! Whether high-quality shading is drawn while the picture changes, or only at rest.

use crate::device::Passes;

/// So many frames with sums in a row must be too long before the sums are dropped.
const PATIENCE: u32 = 3;
/// They come back once they would leave this share of the target to everything else, for [`RECOVERY`] frames.
const COMFORT: f64 = 0.7;
const RECOVERY: u32 = 30;
/// More than this a frame's fixed part does not grow by sums: twice the geometry, and clearing. A larger
/// ratio is a disturbance, and should not keep the sums away for good.
const MAX_RATIO: f64 = 3.0;

/// Drops the sums of moving frames when what a frame takes besides its fill exceeds the target, and takes
/// them up again when it would be well below.
#[derive(Debug, Clone, Copy, Default)]
pub struct InMotion {
    is_dropped: bool,
    /// Frames in a row that speak for a change.
    votes: u32,
    /// What a frame with sums took when they were dropped.
    dropped_at_secs: f64,
    /// That in the time of a frame without, known one frame later.
    ratio: Option<f64>,
}

impl InMotion {
    pub fn is_dropped(&self) -> bool {
        self.is_dropped
    }

    /// Learns from a frame that took `fixed_secs` besides its fill.
    pub fn note(&mut self, passes: Passes, fixed_secs: f64, target_secs: f64) {
        let (speaks_for_change, needed) = match (self.is_dropped, passes) {
            (false, Passes::DepthsAndSums) => (fixed_secs > target_secs, PATIENCE),
            (true, Passes::Depths) => {
                let measured = (self.dropped_at_secs / fixed_secs.max(1e-9)).clamp(1.0, MAX_RATIO);
                let ratio = *self.ratio.get_or_insert(measured);
                (fixed_secs * ratio < COMFORT * target_secs, RECOVERY)
            }
            // Frames at rest say nothing of moving ones, nor do frames that were under way when the sums
            // were dropped or taken up.
            _ => return,
        };
        self.votes = if speaks_for_change { self.votes + 1 } else { 0 };
        if self.votes >= needed {
            *self = InMotion { is_dropped: !self.is_dropped, votes: 0, dropped_at_secs: fixed_secs, ratio: None };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TARGET: f64 = 0.016;

    /// Frames of a device whose fixed part takes `secs(frame)` without sums and `ratio` times that with; in
    /// how many of them sums were dropped or taken up.
    fn changes(in_motion: &mut InMotion, frames: usize, ratio: f64, secs: impl Fn(usize) -> f64) -> usize {
        let mut changes = 0;
        for frame in 0..frames {
            let before = in_motion.is_dropped();
            let passes = if before { Passes::Depths } else { Passes::DepthsAndSums };
            let fixed = secs(frame) * if before { 1.0 } else { ratio };
            in_motion.note(passes, fixed, TARGET);
            changes += usize::from(in_motion.is_dropped() != before);
        }
        changes
    }

    #[test]
    fn sums_are_dropped_once_and_come_back_once() {
        let mut in_motion = InMotion::default();
        assert_eq!(changes(&mut in_motion, 500, 2.0, |_| 0.005), 0, "10 ms of 16");
        assert!(!in_motion.is_dropped());
        assert_eq!(changes(&mut in_motion, 500, 2.0, |_| 0.010), 1, "20 ms of 16");
        assert!(in_motion.is_dropped());
        assert_eq!(changes(&mut in_motion, 500, 2.0, |_| 0.007), 0, "14 ms would fit, but not in comfort");
        assert!(in_motion.is_dropped());
        assert_eq!(changes(&mut in_motion, 500, 2.0, |_| 0.005), 1, "10 ms, say in a smaller window");
        assert!(!in_motion.is_dropped());
    }

    #[test]
    fn nothing_flips_at_the_border_or_for_single_frames() {
        for ratio in [1.1, 2.0, 3.0] {
            // Around the target by a tenth, in both directions.
            let noisy = |frame: usize| TARGET / ratio * [0.9, 1.1, 1.05, 0.95, 1.08, 1.02, 1.07][frame % 7];
            assert!(changes(&mut InMotion::default(), 2000, ratio, noisy) <= 1, "ratio {ratio}");
        }
        let stutter = |frame: usize| if frame.is_multiple_of(10) { 0.1 } else { 0.004 };
        assert_eq!(changes(&mut InMotion::default(), 2000, 2.0, stutter), 0);
    }

    #[test]
    fn a_disturbance_does_not_keep_the_sums_away() {
        let mut in_motion = InMotion::default();
        // Half a second a frame, say while the device is busy with something else.
        assert_eq!(changes(&mut in_motion, PATIENCE as usize, 2.0, |_| 0.25), 1);
        assert_eq!(changes(&mut in_motion, 200, 2.0, |_| 0.002), 1);
        assert!(!in_motion.is_dropped());
    }

    #[test]
    fn frames_at_rest_say_nothing() {
        let mut in_motion = InMotion::default();
        for _ in 0..100 {
            in_motion.note(Passes::Sums, 1.0, TARGET);
        }
        assert!(!in_motion.is_dropped());
    }
}
