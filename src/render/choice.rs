//! Which method draws, and in workgroups of how many threads: the decision alone, as a function of
//! measured figures. A GPU backend measures them.

use serde::Serialize;

use crate::device::Raster;

/// Workgroup sizes of the fill that are compared.
pub const GROUP_SIZES: [u32; 3] = [256, 128, 64];

/// Another candidate must be so much faster than the current one: what noise alone decides would
/// change with every measurement.
pub const MARGIN: f64 = 1.05;

/// A method and the workgroup size of its fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub struct Candidate {
    pub method: Raster,
    /// Threads in a workgroup; none for methods without compute shaders.
    pub group_size: Option<u32>,
}

impl Candidate {
    /// The method with the largest workgroups, as all devices can run them.
    pub fn new(method: Raster) -> Candidate {
        let has_groups = !matches!(method, Raster::Points | Raster::Cpu);
        Candidate { method, group_size: has_groups.then_some(GROUP_SIZES[0]) }
    }

    /// All candidates: every method with its first group size, then with the others. Point lists come
    /// last, since they are the slowest to measure.
    pub fn all() -> Vec<Candidate> {
        let compute =
            [Raster::EarlyZ, Raster::ReduceEarlyZ, Raster::AtomicMin, Raster::Reduce, Raster::TwoPass32, Raster::Dedup];
        let sized = |group: u32| compute.map(|method| Candidate { group_size: Some(group), ..Candidate::new(method) });
        GROUP_SIZES.iter().flat_map(|&group| sized(group)).chain([Candidate::new(Raster::Points)]).collect()
    }
}

impl std::fmt::Display for Candidate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.group_size {
            Some(group) => write!(f, "{}:{group}", self.method),
            None => write!(f, "{}", self.method),
        }
    }
}

/// What the user wants.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum RasterChoice {
    /// The fastest, by measurement.
    #[default]
    Auto,
    /// This one.
    Fixed(Candidate),
}

impl From<Raster> for RasterChoice {
    fn from(method: Raster) -> RasterChoice {
        RasterChoice::Fixed(Candidate::new(method))
    }
}

/// What a figure was measured with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Clock {
    /// Timestamps that the device writes before and after a pass.
    #[serde(rename = "device timestamps")]
    Device,
    /// From submission until the device is done, by the host.
    #[serde(rename = "wall clock")]
    Wall,
}

/// How fast a candidate is, points per second.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Speed {
    /// In the view on screen.
    pub overview_points_per_sec: f64,
    /// With all of that drawn together into the middle of the picture.
    pub far_points_per_sec: f64,
    pub clock: Clock,
}

impl Speed {
    /// Seconds to draw one point from each view. This decides, and not the worst ratio or a product of
    /// both: it is a time that somebody waits for, the view that suffers most weighs most (the frame
    /// rate falls there when the user moves to it, before the budget follows), and where all
    /// candidates are fast the noise of measuring counts for little.
    pub fn secs_per_point(&self) -> f64 {
        1.0 / self.overview_points_per_sec + 1.0 / self.far_points_per_sec
    }

    /// Of two measurements by one clock the faster, view by view: what slows a run down is not the
    /// candidate's.
    #[must_use]
    pub fn faster(self, other: Speed) -> Speed {
        if self.clock != other.clock {
            return self;
        }
        Speed {
            overview_points_per_sec: self.overview_points_per_sec.max(other.overview_points_per_sec),
            far_points_per_sec: self.far_points_per_sec.max(other.far_points_per_sec),
            clock: self.clock,
        }
    }
}

/// A row of the table behind a choice.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measured {
    #[serde(flatten)]
    pub candidate: Candidate,
    pub speed: Option<Speed>,
    /// Why there is no speed.
    pub left_out: Option<String>,
}

/// The fastest of those measured; the current one unless another is faster by more than [`MARGIN`].
/// Times by different clocks are never compared: the current candidate's clock counts, and if it has
/// none, it stays.
pub fn best(current: Candidate, table: &[Measured]) -> Candidate {
    let usable = |speed: &Speed| speed.secs_per_point().is_finite() && speed.secs_per_point() > 0.0;
    let speed_of = |row: &Measured| row.speed.filter(usable);
    let Some(now) = table.iter().find(|row| row.candidate == current).and_then(speed_of) else { return current };
    let others = table.iter().filter_map(|row| Some((row.candidate, speed_of(row)?)));
    let fastest = others
        .filter(|(_, speed)| speed.clock == now.clock)
        .min_by(|(_, a), (_, b)| a.secs_per_point().total_cmp(&b.secs_per_point()));
    match fastest {
        Some((other, speed)) if speed.secs_per_point() * MARGIN < now.secs_per_point() => other,
        _ => current,
    }
}

/// Why a candidate draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Why {
    /// `--method` says so.
    #[serde(rename = "asked for")]
    AskedFor,
    /// Nothing else was measured (yet): the method that is the fastest on most devices, of those that
    /// this one can run.
    #[serde(rename = "default")]
    Default,
    #[serde(rename = "measured")]
    Measured,
}

/// When and on what a choice was measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Measurement {
    /// Seconds after the device was ready.
    pub at_secs: f64,
    /// Seconds that it took in all, compiling included.
    pub took_secs: f64,
    /// Points that each run drew.
    pub points: u32,
    pub size_px: [u32; 2],
    pub point_size_px: u32,
    /// Measurements before this one; the picture's size had changed.
    pub before: u32,
}

/// The candidate that draws, and what speaks for it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Choice {
    #[serde(flatten)]
    pub candidate: Candidate,
    pub why: Why,
    /// In a sentence.
    pub reason: String,
    pub measurement: Option<Measurement>,
    pub candidates: Vec<Measured>,
}

#[cfg(test)]
mod tests {
    use super::*;

    const EARLY_Z: Candidate = Candidate { method: Raster::EarlyZ, group_size: Some(256) };
    const REDUCE: Candidate = Candidate { method: Raster::ReduceEarlyZ, group_size: Some(128) };
    const POINTS: Candidate = Candidate { method: Raster::Points, group_size: None };

    fn row(candidate: Candidate, overview: f64, far: f64, clock: Clock) -> Measured {
        let speed = Speed { overview_points_per_sec: overview, far_points_per_sec: far, clock };
        Measured { candidate, speed: Some(speed), left_out: None }
    }

    #[test]
    fn the_fastest_wins() {
        let table = [
            row(EARLY_Z, 80e9, 70e9, Clock::Device),
            row(REDUCE, 100e9, 90e9, Clock::Device),
            row(POINTS, 1e9, 1e9, Clock::Device),
        ];
        assert_eq!(best(EARLY_Z, &table), REDUCE);
        assert_eq!(best(POINTS, &table), REDUCE);
        assert_eq!(best(REDUCE, &table), REDUCE);
    }

    #[test]
    fn a_view_that_suffers_outweighs_one_that_gains() {
        let atomic_min = Candidate::new(Raster::AtomicMin);
        let table = [row(EARLY_Z, 80e9, 70e9, Clock::Device), row(atomic_min, 120e9, 5e9, Clock::Device)];
        assert_eq!(best(EARLY_Z, &table), EARLY_Z);
        assert_eq!(best(atomic_min, &table), EARLY_Z);
    }

    #[test]
    fn little_gain_changes_nothing() {
        let gain =
            |share: f64| [row(EARLY_Z, 1e9, 1e9, Clock::Wall), row(REDUCE, share * 1e9, share * 1e9, Clock::Wall)];
        assert_eq!(best(EARLY_Z, &gain(1.049)), EARLY_Z);
        assert_eq!(best(EARLY_Z, &gain(1.051)), REDUCE);
        // And back again only by as much.
        assert_eq!(best(REDUCE, &gain(1.0 / 1.049)), REDUCE);
        assert_eq!(best(REDUCE, &gain(1.0 / 1.051)), EARLY_Z);
    }

    #[test]
    fn clocks_are_not_mixed() {
        let table = [row(EARLY_Z, 1e9, 1e9, Clock::Wall), row(REDUCE, 100e9, 100e9, Clock::Device)];
        assert_eq!(best(EARLY_Z, &table), EARLY_Z);
        assert_eq!(best(REDUCE, &table), REDUCE);
    }

    #[test]
    fn what_was_not_measured_is_not_chosen() {
        let missing = Measured { candidate: REDUCE, speed: None, left_out: Some("it lacks subgroups".into()) };
        assert_eq!(best(EARLY_Z, &[row(EARLY_Z, 1e9, 1e9, Clock::Wall), missing.clone()]), EARLY_Z);
        // Nor is anything compared with a current one that has no figure.
        assert_eq!(best(REDUCE, &[row(EARLY_Z, 1e9, 1e9, Clock::Wall), missing]), REDUCE);
        assert_eq!(best(EARLY_Z, &[]), EARLY_Z);
        for broken in [0.0, f64::NAN, f64::INFINITY] {
            let table = [row(EARLY_Z, 1e9, 1e9, Clock::Wall), row(REDUCE, broken, broken, Clock::Wall)];
            assert_eq!(best(EARLY_Z, &table), EARLY_Z, "{broken}");
        }
    }

    #[test]
    fn candidates_are_all_methods_in_all_sizes() {
        let all = Candidate::all();
        assert_eq!(all.len(), 6 * 3 + 1);
        for method in Raster::ON_GPU {
            let sizes = all.iter().filter(|candidate| candidate.method == method).count();
            assert_eq!(sizes, if method == Raster::Points { 1 } else { 3 }, "{method}");
        }
        assert_eq!(all.iter().collect::<std::collections::HashSet<_>>().len(), all.len());
    }
}
