//! A run with a comparison after every frame. What each frame does is fixed beforehand: by the virtual clock, or by
//! the log of a run in real time. So comparing, which takes longer than drawing, changes nothing that is measured.

use std::collections::VecDeque;

use super::{
    ConvergeError,
    driver::Driver,
    input::{Feeder, Recording},
    metrics::{Change, Metrics},
    motion::{Director, Phase, PhaseKind, Seen},
    report::{Frame, Times},
    theory::Counts,
};
use crate::render::{Camera, FillBudget, Picture, View};

/// A frame of a run in real time.
#[derive(Debug, Clone, PartialEq)]
pub struct Logged {
    pub phase: usize,
    pub camera: Camera,
    /// Points in the store, tried, and tried by this frame's fill.
    pub stored: u64,
    pub tried: u64,
    pub fill: u32,
    pub times: Times,
}

/// What fixes the frames.
pub enum Script<'a> {
    /// So many points arrive per frame, and so many are tried.
    Virtual {
        director: Director<'a>,
        load: u64,
        fill: u32,
    },
    Log(VecDeque<Logged>),
}

/// What a frame is to do.
struct Step {
    phase: usize,
    camera: Camera,
    /// Points that have arrived by now.
    arrived: u64,
    fill: u32,
    logged: Option<Logged>,
}

/// The expected shares of the latest view.
struct Expecting {
    view: Option<View>,
    counts: Option<Counts>,
}

/// Draws and compares every frame. `file_truth` is the picture of all points of the file at the first camera, and
/// `metres` the length of the file's unit. `each` is told of every frame.
///
/// # Errors
/// If a frame cannot be drawn.
pub fn replay(
    driver: &mut Driver,
    recording: &Recording,
    phases: &[Phase],
    mut script: Script<'_>,
    file_truth: &Picture,
    view_of: &dyn Fn(&Camera) -> Result<View, ConvergeError>,
    each: &mut dyn FnMut(&Frame),
) -> Result<Vec<Frame>, ConvergeError> {
    let metres = recording.metres.unwrap_or(1.0);
    let mut feeder = Feeder::new(recording);
    let mut frames: Vec<Frame> = Vec::new();
    let mut seen = Seen { loaded: false, converged: false };
    let mut last: Option<[Picture; 2]> = None;
    let mut expecting = Expecting { view: None, counts: None };
    while let Some(step) = script.next(seen, feeder.offered()) {
        feeder.offer_up_to(step.arrived, &mut driver.progressive);
        let report = driver.frame(&step.camera, FillBudget::Fixed(step.fill))?;
        driver.progressive.spent().for_each(drop);
        seen = Seen { loaded: driver.progressive.is_loaded(), converged: report.is_converged() };
        let now = match last.take() {
            // Nothing was drawn: nothing has changed.
            Some(last) if !report.drawn => last,
            before => {
                let picture = driver.progressive.read()?;
                let now = [picture, driver.truth(&step.camera)?];
                let change = before.as_ref().map(|[a, b]| Change::of([a, b], [&now[0], &now[1]]));
                let received = Metrics::of(&now[0], &now[1], metres);
                let is_loading = phases[step.phase].kind == PhaseKind::Loading;
                let is_whole = report.points_stored == recording.points;
                // While points arrive the camera stands where the truth of the file was drawn.
                let file =
                    if is_loading && !is_whole { Metrics::of(&now[0], file_truth, metres) } else { received.clone() };
                let sample = if is_loading { report.points_stored } else { report.points_tried };
                let (stored, drawn) = frames.last().map_or((0, 0), |last| (last.points_stored, last.points_drawn));
                // All points at once are the new ones too.
                let fresh = if driver.is_brute_force() { 0 } else { report.points_stored - stored };
                let frame = Frame {
                    frame: frames.len() as u32,
                    phase: phases[step.phase].name.clone(),
                    points_stored: report.points_stored,
                    points_tried: report.points_tried,
                    fill: report.fill,
                    points_drawn: drawn + fresh + u64::from(report.fill),
                    converged: report.is_converged(),
                    expected: expecting.counts(view_of(&step.camera)?, recording).expect(sample),
                    received,
                    file,
                    change,
                    times: step.logged.as_ref().map(|logged| logged.times),
                    differs_from_log: step.logged.as_ref().is_some_and(|logged| {
                        (logged.stored, logged.tried) != (report.points_stored, report.points_tried)
                    }),
                };
                each(&frame);
                frames.push(frame);
                now
            }
        };
        last = Some(now);
    }
    Ok(frames)
}

impl Script<'_> {
    fn next(&mut self, seen: Seen, offered: u64) -> Option<Step> {
        match self {
            Script::Virtual { director, load, fill } => {
                let (phase, camera) = director.next(seen)?;
                Some(Step { phase, camera, arrived: offered + *load, fill: *fill, logged: None })
            }
            Script::Log(log) => {
                let logged = log.pop_front()?;
                let Logged { phase, camera, stored, fill, .. } = logged;
                Some(Step { phase, camera, arrived: stored, fill, logged: Some(logged) })
            }
        }
    }
}

impl Expecting {
    /// Points of each pixel, counted again when the view changes.
    fn counts(&mut self, view: View, recording: &Recording) -> &Counts {
        if self.view != Some(view) {
            self.counts = None;
            self.view = Some(view);
        }
        self.counts.get_or_insert_with(|| Counts::of(&recording.batches, &view))
    }
}
