//! What to measure: the methods that are compared, the settings of each, and the clock.

use std::fmt;

use clap::ValueEnum;
use serde::Serialize;

use super::motion::Motion;
use crate::{
    headless::BackendChoice,
    measure::raster::Input,
    render::{Camera, FillBudget, RasterChoice, Reprojection},
    source::Fields,
    store::{Encoding, SlotOrder},
};

/// A way to get from points to pictures: this program's, and what it is judged against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// What the viewer does
    Firstlight,
    /// All points received so far, in every frame
    BruteForce,
    /// No shuffle: points lie in the buffer as they lie in the file, and are read so
    Unshuffled,
    /// Each insertion is shuffled, and then put behind the old points
    BatchShuffled,
    /// A new random sample in every frame, nothing of the last one
    NoReprojection,
    /// Reprojection that does not follow points which insertions move
    NoMovedTo,
    /// The picture begins anew whenever the camera moves, as in common desktop viewers
    ClearOnMove,
}

impl Variant {
    /// As the command line calls it.
    pub fn name(self) -> &'static str {
        match self {
            Variant::Firstlight => "firstlight",
            Variant::BruteForce => "brute-force",
            Variant::Unshuffled => "unshuffled",
            Variant::BatchShuffled => "batch-shuffled",
            Variant::NoReprojection => "no-reprojection",
            Variant::NoMovedTo => "no-moved-to",
            Variant::ClearOnMove => "clear-on-move",
        }
    }

    pub(super) fn slot_order(self) -> SlotOrder {
        match self {
            Variant::Unshuffled => SlotOrder::Arrival,
            Variant::BatchShuffled => SlotOrder::BatchShuffled,
            _ => SlotOrder::Shuffled,
        }
    }

    pub(super) fn reprojection(self) -> Reprojection {
        match self {
            Variant::NoReprojection => Reprojection::Never,
            Variant::ClearOnMove => Reprojection::WhileStill,
            _ => Reprojection::Always,
        }
    }

    /// Whether the slots that a frame tries are a uniform random sample.
    pub fn is_shuffled(self) -> bool {
        self.slot_order() == SlotOrder::Shuffled && self != Variant::BruteForce
    }
}

/// How many random points a frame tries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fill {
    /// As many as fit into a frame of 16 ms: the viewer's choice.
    Auto,
    Points(u32),
}

/// Frame time that the automatic fill aims at: what the viewer does.
pub const AUTO_TARGET_SECS: f64 = 0.016;

impl Fill {
    pub(super) fn budget(self) -> FillBudget {
        match self {
            Fill::Auto => FillBudget::Target(AUTO_TARGET_SECS),
            Fill::Points(points) => FillBudget::Fixed(points),
        }
    }
}

impl fmt::Display for Fill {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fill::Auto => f.write_str("auto"),
            Fill::Points(n) if n % 1_000_000 == 0 => write!(f, "{}M", n / 1_000_000),
            Fill::Points(n) if n % 1000 == 0 => write!(f, "{}k", n / 1000),
            Fill::Points(n) => write!(f, "{n}"),
        }
    }
}

/// What is decoded of each point while loading. Layered LAZ (formats 6 and up) spares the layers of the rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Decoded {
    /// Nothing else: pictures are coloured by elevation
    Positions,
    /// What a viewer needs for its colours: RGB and intensity
    Colors,
    /// All fields
    All,
}

impl Decoded {
    pub(super) fn fields(self) -> Option<Fields> {
        match self {
            Decoded::Positions => Some(Fields::NONE),
            Decoded::Colors => None,
            Decoded::All => Some(Fields::ALL),
        }
    }

    /// As the command line calls it.
    pub fn name(self) -> &'static str {
        match self {
            Decoded::Positions => "positions",
            Decoded::Colors => "colors",
            Decoded::All => "all",
        }
    }
}

/// What makes one run differ from another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setting {
    pub variant: Variant,
    pub fill: Fill,
    /// Width of a point, pixels.
    pub point_size: u32,
    pub method: RasterChoice,
    /// How positions are stored; `None`: as a viewer does.
    pub encoding: Option<Encoding>,
    pub decoded: Decoded,
}

/// Width of a point in the viewer, unless the user says otherwise; pixels.
pub const VIEWER_POINT_SIZE: u32 = 2;

/// What drives a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Clock {
    /// Frames follow one another as in a window, and are timed
    Real,
    /// So many points per frame arrive and are tried: the same numbers on every machine, no times
    Virtual,
}

/// All that [`super::measure`] needs to know.
#[derive(Debug, Clone)]
pub struct Measure {
    pub input: Input,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// By default the whole scene, or the first camera of a path.
    pub camera: Option<Camera>,
    pub motions: Vec<Motion>,
    pub backend: BackendChoice,
    pub methods: Vec<RasterChoice>,
    pub encodings: Vec<Option<Encoding>>,
    pub decoded: Vec<Decoded>,
    pub fills: Vec<Fill>,
    pub point_sizes: Vec<u32>,
    /// Compared at the first of each of the lists above.
    pub baselines: Vec<Variant>,
    pub clock: Clock,
    /// Frames that a motion takes: virtual ones, or sixtieths of a second.
    pub frames: u32,
    /// Points that arrive per virtual frame; by default a thirty-second part of all.
    pub load: Option<u32>,
    /// Runs of every setting.
    pub repeat: u32,
    pub seed: u64,
    /// Decoder threads, and threads of the CPU backend.
    pub threads: Option<usize>,
    /// The command line, for the report.
    pub command: String,
}

impl Measure {
    /// One run each, this program's settings first, then the baselines.
    pub fn settings(&self) -> Vec<Setting> {
        let mut settings = Vec::new();
        let ways = (self.methods.iter())
            .flat_map(|&method| self.encodings.iter().map(move |&encoding| (method, encoding)))
            .flat_map(|way| self.decoded.iter().map(move |&decoded| (way, decoded)));
        for ((method, encoding), decoded) in ways {
            for &point_size in &self.point_sizes {
                let variant = Variant::Firstlight;
                let of = |&fill| Setting { variant, fill, point_size, method, encoding, decoded };
                settings.extend(self.fills.iter().map(of));
            }
        }
        let first = settings.first().copied();
        let baselines = self.baselines.iter().filter(|&&variant| variant != Variant::Firstlight);
        settings.extend(baselines.filter_map(|&variant| first.map(|first| Setting { variant, ..first })));
        settings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::{Scene, SynthOptions};

    #[test]
    fn every_setting_once_and_the_baselines_at_the_first() {
        let measure = Measure {
            input: Input::Synth(SynthOptions::new(Scene::Town)),
            size: [8, 8],
            camera: None,
            motions: vec![],
            backend: BackendChoice::Cpu,
            methods: vec![RasterChoice::Auto],
            encodings: vec![None, Some(Encoding::Wide)],
            decoded: vec![Decoded::Colors, Decoded::Positions],
            fills: vec![Fill::Points(1000), Fill::Auto],
            point_sizes: vec![2, 1],
            baselines: vec![Variant::Firstlight, Variant::Unshuffled],
            clock: Clock::Real,
            frames: 1,
            load: None,
            repeat: 1,
            seed: 1,
            threads: None,
            command: String::new(),
        };
        let settings = measure.settings();
        assert_eq!(settings.len(), 17);
        let last = settings[16];
        assert_eq!((last.encoding, last.decoded), (None, Decoded::Colors));
        assert!((1..17).all(|n| !settings[..n].contains(&settings[n])));
        assert_eq!((last.variant, last.fill, last.point_size), (Variant::Unshuffled, Fill::Points(1000), 2));
        assert!(settings[..16].iter().all(|setting| setting.variant == Variant::Firstlight));
    }

    #[test]
    fn names_are_those_of_the_command_line() {
        for variant in Variant::value_variants() {
            assert_eq!(variant.to_possible_value().unwrap().get_name(), variant.name());
        }
        for decoded in Decoded::value_variants() {
            assert_eq!(decoded.to_possible_value().unwrap().get_name(), decoded.name());
        }
        let names = [Fill::Auto, Fill::Points(1500), Fill::Points(250_000), Fill::Points(2_000_000)];
        assert_eq!(names.map(|fill| fill.to_string()), ["auto", "1500", "250k", "2M"]);
    }
}
