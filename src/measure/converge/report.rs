//! All samples of a measurement; its JSON is the report that tables, charts and other programs read. With the virtual
//! clock it says nothing that differs from run to run, or between machines, but for the adapter.

use serde::Serialize;

use super::{
    metrics::{Change, Metrics},
    settings::{Clock, Decoded, Fill, Variant},
    theory::Expected,
};
use crate::{measure::machine::Machine, measure::raster::Check, render::Camera, store::Encoding};

/// What the JSON says of itself; a folder with such a file may be written over.
pub const TITLE: &str = "firstlight measure";

/// The whole measurement.
#[derive(Debug, Clone, Serialize)]
pub struct ConvergeReport {
    pub report: &'static str,
    /// "firstlight" and its version.
    pub program: String,
    /// Who drew: device, interface, method.
    pub adapter: String,
    /// False as long as runs are missing.
    pub complete: bool,
    pub clock: Clock,
    /// The command line, quoted for a shell, and what it ran on; only with the real clock.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub machine: Option<Machine>,
    /// Names without folders.
    pub inputs: Vec<String>,
    pub points: u64,
    pub size_px: [u32; 2],
    pub seed: u64,
    /// Frames that a motion takes, virtual ones or sixtieths of a second.
    pub motion_frames: u32,
    /// Points that arrive per virtual frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load: Option<u64>,
    /// Length of the file's unit, metres; null if the file does not say: then a unit counts as a metre.
    pub metres_per_unit: Option<f64>,
    /// While loading, and until the first motion.
    pub camera: Camera,
    /// In the order of a run.
    pub phases: Vec<String>,
    pub runs: Vec<Run>,
    pub checks: Vec<Check>,
    /// One line each: what could not be read.
    pub problems: Vec<String>,
}

/// One setting, run once.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Run {
    pub variant: Variant,
    pub fill: Fill,
    pub point_size_px: u32,
    /// Which method, where several are compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// How positions were stored, where several encodings are compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoding: Option<Encoding>,
    /// What was decoded, where that is compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fields: Option<Decoded>,
    /// Method, encoding and fields are those that the viewer takes by itself, or the only ones: the others of a list are
    /// not its choice.
    pub is_viewers_method: bool,
    /// Counted from 1.
    pub round: u32,
    pub headline: Headline,
    pub frames: Vec<Frame>,
}

/// A drawn frame. Frames in which nothing changed are not drawn.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Frame {
    pub frame: u32,
    pub phase: String,
    pub points_stored: u64,
    /// Points tried since the view last changed.
    pub points_tried: u64,
    /// Of these, tried by this frame's fill.
    pub fill: u32,
    /// Points drawn so far, by the fill and as they arrived; not those drawn again because they were visible.
    pub points_drawn: u64,
    /// All were tried, and no tie is open.
    pub converged: bool,
    /// What a uniform sample would show: while loading, as many of the file's points as have arrived; then as many of
    /// them as were tried.
    pub expected: Option<Expected>,
    /// Against all points received so far.
    pub received: Metrics,
    /// Against all points of the file.
    pub file: Metrics,
    /// Since the frame before.
    pub change: Option<Change>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub times: Option<Times>,
    /// The frame that was timed is not the one that was compared.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub differs_from_log: bool,
}

/// When a frame was drawn, seconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Times {
    /// Since the files were opened, the device being ready.
    pub start_secs: f64,
    /// From its first command to its last pixel.
    pub frame_secs: f64,
}

impl Times {
    /// When it is on the screen.
    pub fn end_secs(&self) -> f64 {
        self.start_secs + self.frame_secs
    }
}

/// How far a run was when something was reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Reached {
    /// Frames drawn, this one included.
    pub frames: u32,
    pub points_stored: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub secs: Option<f64>,
}

/// What stands for a run. Null: it was not reached.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Headline {
    /// A pixel shows a point.
    pub first_picture: Option<Reached>,
    /// Share of the file's truth with the right record, before the camera first moves: 50, 90, 99 and 100 %.
    pub right_50: Option<Reached>,
    pub right_90: Option<Reached>,
    pub right_99: Option<Reached>,
    pub right_100: Option<Reached>,
    /// Area under the curve of the share that is not right, until the camera first moves, in frames and in seconds.
    pub error_frames: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_secs: Option<f64>,
    /// Means over the frames in motion: 1 − SSIM, and shares of holes and of flickering pixels.
    pub moving_error: Option<f64>,
    pub moving_holes: Option<f64>,
    pub moving_flicker: Option<f64>,
    /// Points that a frame's fill tries in motion, mean.
    pub moving_fill: Option<f64>,
    /// From the last frame of each motion: the areas under the curve of 1 − SSIM until the picture has converged, added
    /// up, in frames and in seconds, and the longest way back to the picture of all points; null if one never came back.
    pub rest_error_frames: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest_error_secs: Option<f64>,
    pub rest_frames: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest_secs: Option<f64>,
    /// Frame times, milliseconds: 99th percentile of all, and while loading; medians in motion and at rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame_ms_p99: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loading_frame_ms_p99: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moving_frame_ms: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest_frame_ms: Option<f64>,
}

impl Run {
    /// In words, short.
    pub fn label(&self) -> String {
        match self.variant {
            Variant::Firstlight => format!("{}, {} px{}", self.fill, self.point_size_px, self.suffix()),
            other => other.name().into(),
        }
    }

    /// What is compared besides.
    fn suffix(&self) -> String {
        let names = [self.method.as_deref(), self.encoding.map(Encoding::name), self.fields.map(Decoded::name)];
        names.into_iter().flatten().map(|name| format!(", {name}")).collect()
    }
}

/// Whether a phase is one in motion, or a rest after one.
pub fn is_moving(phase: &str) -> bool {
    !matches!(phase, "loading" | "still") && !is_rest(phase)
}

pub fn is_rest(phase: &str) -> bool {
    phase.starts_with("after ")
}

#[cfg(test)]
impl ConvergeReport {
    /// A report of nothing.
    pub fn for_tests() -> ConvergeReport {
        ConvergeReport {
            report: TITLE,
            program: "firstlight".into(),
            adapter: "a device".into(),
            complete: true,
            clock: Clock::Virtual,
            command: None,
            machine: None,
            inputs: vec!["a <scan>.laz".into()],
            points: 1000,
            size_px: [40, 30],
            seed: 1,
            motion_frames: 4,
            load: Some(100),
            metres_per_unit: Some(1.0),
            camera: Camera {
                eye: [0.0, -1.0, 0.0],
                target: [0.0; 3],
                up: [0.0, 0.0, 1.0],
                fov_y_deg: 60.0,
                ..Default::default()
            },
            phases: vec!["loading".into(), "still".into(), "orbit".into(), "after orbit".into()],
            runs: Vec::new(),
            checks: Vec::new(),
            problems: Vec::new(),
        }
    }
}
