//! The flight: which beam a point belongs to, and which of its returns it is.
//!
//! Points come in groups of four along a scan line, so that point `i` can be found without those
//! before it: a group is four single beams on open ground; under a crown, one beam may use up
//! several of the four as its returns. Strips run along y, lines zigzag across them, neighbouring strips overlap
//! by a sixth and are flown in turns north and south.

use super::super::{
    SynthPoint,
    noise::{hash, mix, unit},
};
use super::plan::Plan;
use super::surface::{Beam, Hit, Target, crown_hit, strike};

/// Points per group.
const GROUP: u64 = 4;
/// Points per square metre of ground, as long as the scan covers less than [`LONGEST_SIDE`].
const DENSITY: f64 = 8.0;
const SHORTEST_SIDE: f64 = 48.0;
const LONGEST_SIDE: f64 = 2048.0;
/// Every other line looks forward, those between back, by this tangent (14°): walls on all sides get points.
const TILT: f64 = 0.249;
/// Beams per second.
const PULSE_RATE: f64 = 500_000.0;
/// Seconds from the start of one strip to that of the next, at least; longer strips take longer.
const TURN_SECONDS: f64 = 60.0;

/// The scene: the town and the flight over it.
pub(in super::super) struct Town {
    plan: Plan,
    points: u64,
    side: f64,
    groups_per_strip: u64,
    groups_per_line: u64,
    lines: u64,
    /// Width of a strip and distance between strips, in metres.
    width: f64,
    spacing: f64,
    strip_seconds: f64,
}

impl Town {
    pub fn new(seed: u64, points: u64) -> Town {
        let side = (points as f64 / DENSITY).sqrt().clamp(SHORTEST_SIDE, LONGEST_SIDE);
        let strips = ((side / 300.0 + 0.5) as u64).max(1);
        let width = if strips == 1 { side } else { 1.2 * side / strips as f64 };
        let spacing = if strips == 1 { 0.0 } else { (side - width) / (strips - 1) as f64 };
        let groups = points.div_ceil(GROUP).max(1);
        let groups_per_strip = groups.div_ceil(strips);
        // As far from point to point as from line to line.
        let step = (width * side / (groups_per_strip * GROUP) as f64).sqrt();
        let groups_per_line = ((width / (step * GROUP as f64) + 0.5) as u64).clamp(1, groups_per_strip);
        Town {
            plan: Plan::new(seed),
            points,
            side,
            groups_per_strip,
            groups_per_line,
            lines: groups_per_strip.div_ceil(groups_per_line),
            width,
            spacing,
            strip_seconds: TURN_SECONDS + 1.05 * (groups_per_strip * GROUP) as f64 / PULSE_RATE,
        }
    }

    /// A box that holds every point, in metres.
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        let half = 0.5 * self.side;
        // Tilted lines see roofs, up to 60 m above the ground, beyond the square's ends.
        let ahead = half + 60.0 * TILT;
        [[-half, -ahead, 186.0], [half, ahead, 330.0]]
    }

    /// Calls `emit` with points `first..end` in order: metres from the town's centre, and the
    /// rest of the point.
    #[inline]
    pub fn run(&self, first: u64, end: u64, mut emit: impl FnMut([f64; 3], SynthPoint)) {
        let mut group = first / GROUP;
        while group * GROUP < end {
            let start = group * GROUP;
            self.group(group, |number, at, point| {
                let i = start + u64::from(number);
                if i >= first && i < end {
                    emit(at, point);
                }
            });
            group += 1;
        }
    }

    #[inline]
    fn group(&self, group: u64, mut emit: impl FnMut(u8, [f64; 3], SynthPoint)) {
        let len = (self.points - group * GROUP).min(GROUP) as u8;
        let strip = group / self.groups_per_strip;
        let in_strip = group % self.groups_per_strip;
        let line = in_strip / self.groups_per_line;
        let in_line = in_strip % self.groups_per_line;
        let center = -0.5 * self.side + 0.5 * self.width + strip as f64 * self.spacing;
        let is_back = line % 2 == 1;
        let mut number = 0;
        while number < len {
            let pulse = in_strip * GROUP + u64::from(number);
            let h = hash(self.plan.seed, group as i64, i64::from(number));
            let j = mix(h);
            let beam_in_line = (in_line * GROUP) as f64 + f64::from(number) + 0.15 + 0.7 * unit(j, 0);
            let t = beam_in_line / (self.groups_per_line * GROUP) as f64;
            let across = if is_back { 0.5 - t } else { t - 0.5 };
            let along = (line as f64 + 0.2 * t + 0.8 * unit(j, 1)) / self.lines as f64 - 0.5;
            let along = if strip % 2 == 1 { -along } else { along };
            // Flown at 1.25 times the strip's width above the ground: at most 21.8° off the nadir.
            let tangent = across / 1.25;
            let tilt = if is_back { -TILT } else { TILT };
            let slope = (tangent * tangent + tilt * tilt).sqrt();
            let beam = Beam {
                at: [center + across * self.width, along * self.side],
                slope,
                toward: [-tangent / slope, tilt / slope],
                hash: h,
            };
            let mut point = SynthPoint {
                gps_time: strip as f64 * self.strip_seconds + pulse as f64 / PULSE_RATE,
                // Degrees in steps of 0.006; the arc tangent's series is exact to a hundredth of a step here.
                scan_angle: (arc_tangent(tangent) * (57.295_779_513_082_32 / 0.006)) as i16,
                point_source: strip as u16 + 1,
                scan_direction: !is_back,
                edge_of_flight_line: in_line + 1 == self.groups_per_line && number + 1 == len,
                ..SynthPoint::default()
            };
            let mut send = |number: u8, hit: Hit, of: u8, count: u8, h: u64| {
                let [red, green, blue, nir] = hit.paint.color(hit.shade, h);
                point.rgb = [red, green, blue];
                point.nir = nir;
                point.intensity = hit.paint.intensity(count, h);
                point.classification = hit.paint.class;
                point.return_number = of;
                point.number_of_returns = count;
                emit(number, hit.at, point);
            };
            match strike(&self.plan, &beam) {
                Target::Solid(hit) => {
                    send(number, hit, 1, 1, h);
                    number += 1;
                }
                Target::Crown { tree, ground, away } => {
                    let count = (1 + (j >> 60) as u8 % 4).min(len - number);
                    for k in 0..count {
                        let hit = crown_hit(tree, &beam, ground, away, k, count);
                        send(number + k, hit, k + 1, count, mix(h ^ u64::from(k) << 32));
                    }
                    number += count;
                }
            }
        }
    }
}

/// Arc tangent for |x| ≤ 0.4, in radians, by its series.
fn arc_tangent(x: f64) -> f64 {
    let s = x * x;
    x * (1.0 - s * (1.0 / 3.0 - s * (1.0 / 5.0 - s * (1.0 / 7.0 - s * (1.0 / 9.0 - s * (1.0 / 11.0 - s / 13.0))))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arc_tangent_is_good_to_a_hundredth_of_a_step() {
        for k in -40..=40 {
            let x = f64::from(k) * 0.01;
            assert!((arc_tangent(x) - x.atan()).abs() * 57.3 < 0.006 * 0.01);
        }
    }

    #[test]
    fn a_large_scan_has_several_strips_within_its_side() {
        let town = Town::new(1, 30_000_000);
        let strips = (town.points / GROUP).div_ceil(town.groups_per_strip);
        assert!(strips > 3);
        let last = -0.5 * town.side + 0.5 * town.width + (strips - 1) as f64 * town.spacing;
        assert!((last + 0.5 * town.width - 0.5 * town.side).abs() < 1e-6);
    }
}
