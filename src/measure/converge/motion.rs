//! How the camera moves, and which part of a run comes when.

use std::time::{Duration, Instant};

use glam::DVec3;

use crate::render::Camera;

/// A way to move the camera.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// Round the target by 30 degrees.
    Orbit,
    /// Straight ahead, level, by a quarter of the distance to the target.
    Walk,
    /// At once to a nearer view from another side; then it stays.
    Jump,
    /// Through these cameras, in equal times, straight from each to the next.
    Path(Vec<Camera>),
}

/// Degrees that an orbit turns.
pub const ORBIT_DEG: f64 = 30.0;
/// Share of the distance from the eye to the target that a walk covers.
pub const WALK_SHARE: f64 = 0.25;
/// Degrees that a jump turns, and what is left of the distance then.
pub const JUMP_DEG: f64 = 120.0;
pub const JUMP_SHARE: f64 = 0.6;

impl Motion {
    pub fn name(&self) -> &'static str {
        match self {
            Motion::Orbit => "orbit",
            Motion::Walk => "walk",
            Motion::Jump => "jump",
            Motion::Path(_) => "path",
        }
    }

    /// Where the camera is after a share `at` of the way, 0 to 1, if it began at `start`.
    pub fn camera(&self, start: &Camera, at: f64) -> Camera {
        let at = at.clamp(0.0, 1.0);
        let [eye, target] = [start.eye, start.target].map(DVec3::from_array);
        match self {
            Motion::Orbit => start.turned(ORBIT_DEG * at),
            Motion::Walk => {
                let ahead = target - eye;
                let level = DVec3::new(ahead.x, ahead.y, 0.0).try_normalize().unwrap_or(DVec3::Y);
                let step = level * (WALK_SHARE * at * ahead.length());
                Camera { eye: (eye + step).to_array(), target: (target + step).to_array(), ..*start }
            }
            Motion::Jump => {
                let turned = start.turned(JUMP_DEG);
                let eye = target + JUMP_SHARE * (DVec3::from_array(turned.eye) - target);
                Camera { eye: eye.to_array(), ..turned }
            }
            Motion::Path(cameras) => {
                let Some(last) = cameras.len().checked_sub(1) else { return *start };
                let place = at * last as f64;
                let i = (place as usize).min(last);
                let (a, b) = (&cameras[i], &cameras[(i + 1).min(last)]);
                let share = place - i as f64;
                let mix = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|k| a[k] + share * (b[k] - a[k]));
                Camera {
                    eye: mix(a.eye, b.eye),
                    target: mix(a.target, b.target),
                    up: mix(a.up, b.up),
                    fov_y_deg: a.fov_y_deg + share * (b.fov_y_deg - a.fov_y_deg),
                    projection: a.projection,
                }
            }
        }
    }
}

/// Part of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Phase {
    /// "loading", "still", "orbit", "after orbit", …
    pub name: String,
    pub kind: PhaseKind,
    /// Where it begins.
    pub start: Camera,
}

#[derive(Debug, Clone, PartialEq)]
pub enum PhaseKind {
    /// Until all points are stored; the camera stands still.
    Loading,
    /// Until the picture has converged.
    Still,
    Moving(Motion),
}

/// All parts of a run: loading, still, and each motion with a rest behind it.
pub fn phases(start: Camera, motions: &[Motion]) -> Vec<Phase> {
    let phase = |name: &str, kind, start| Phase { name: name.into(), kind, start };
    let mut phases = vec![phase("loading", PhaseKind::Loading, start), phase("still", PhaseKind::Still, start)];
    let mut at = start;
    for motion in motions {
        let name = motion.name();
        phases.push(phase(name, PhaseKind::Moving(motion.clone()), at));
        at = motion.camera(&at, 1.0);
        phases.push(phase(&format!("after {name}"), PhaseKind::Still, at));
    }
    phases
}

/// What the director needs to know of the frame before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seen {
    pub loaded: bool,
    pub converged: bool,
}

/// Sixtieths of a second that a frame of a window takes.
pub const FRAME: Duration = Duration::from_nanos(16_666_667);

/// Most frames of a rest: a picture that never converges must not hold up a measurement.
const MOST_STILL_FRAMES: u32 = 5000;

/// Says what each frame shows, from phase to phase.
pub struct Director<'a> {
    phases: &'a [Phase],
    /// Frames that a motion takes.
    frames: u32,
    /// Time instead of frames says how far a motion is.
    is_timed: bool,
    phase: usize,
    /// Frames shown in this phase, when it began, and how far it was at the last one.
    shown: u32,
    begun: Instant,
    at: f64,
}

impl<'a> Director<'a> {
    pub fn new(phases: &'a [Phase], frames: u32, is_timed: bool) -> Director<'a> {
        Director { phases, frames: frames.max(1), is_timed, phase: 0, shown: 0, begun: Instant::now(), at: 0.0 }
    }

    /// The phase and the camera of the next frame; `None` at the end.
    pub fn next(&mut self, seen: Seen) -> Option<(usize, Camera)> {
        while self.is_over(seen) {
            *self = Director { phase: self.phase + 1, ..Director::new(self.phases, self.frames, self.is_timed) };
        }
        let phase = self.phases.get(self.phase)?;
        self.shown += 1;
        self.at = if self.is_timed {
            self.begun.elapsed().as_secs_f64() / (f64::from(self.frames) * FRAME.as_secs_f64())
        } else {
            f64::from(self.shown) / f64::from(self.frames)
        };
        let camera = match &phase.kind {
            PhaseKind::Moving(motion) => motion.camera(&phase.start, self.at),
            PhaseKind::Loading | PhaseKind::Still => phase.start,
        };
        Some((self.phase, camera))
    }

    fn is_over(&self, seen: Seen) -> bool {
        match self.phases.get(self.phase).map(|phase| &phase.kind) {
            Some(PhaseKind::Loading) => seen.loaded,
            // At least one: what converged in the phase before is still to be seen here.
            Some(PhaseKind::Still) => self.shown > 0 && (seen.converged || self.shown >= MOST_STILL_FRAMES),
            Some(PhaseKind::Moving(Motion::Jump)) => self.shown > 0,
            Some(PhaseKind::Moving(_)) => self.at >= 1.0,
            None => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start() -> Camera {
        Camera {
            eye: [0.0, -100.0, 50.0],
            target: [0.0; 3],
            up: [0.0, 0.0, 1.0],
            fov_y_deg: 60.0,
            ..Default::default()
        }
    }

    fn distance(camera: &Camera) -> f64 {
        DVec3::from_array(camera.eye).distance(DVec3::from_array(camera.target))
    }

    #[test]
    fn motions_do_what_they_are_called() {
        let d = distance(&start());
        let orbit = Motion::Orbit.camera(&start(), 1.0);
        assert!((distance(&orbit) - d).abs() < 1e-9 && (orbit.eye[0] - 50.0).abs() < 1e-9, "{orbit:?}");
        let walk = Motion::Walk.camera(&start(), 1.0);
        assert!((walk.eye[1] - (-100.0 + 0.25 * d)).abs() < 1e-9 && walk.eye[2] == 50.0, "{walk:?}");
        let jump = Motion::Jump.camera(&start(), 0.1);
        assert!((distance(&jump) - 0.6 * d).abs() < 1e-9 && jump.eye[1] > 0.0, "{jump:?}");
        for motion in [Motion::Orbit, Motion::Walk] {
            assert_eq!(motion.camera(&start(), 0.0), start());
        }
        let path = Motion::Path(vec![start(), orbit, walk]);
        assert_eq!([0.0, 0.5, 1.0].map(|at| path.camera(&jump, at)), [start(), orbit, walk]);
        let between = path.camera(&jump, 0.75);
        assert!((between.eye[0] - 0.5 * (orbit.eye[0] + walk.eye[0])).abs() < 1e-9);
        assert_eq!(Motion::Path(vec![]).camera(&jump, 0.3), jump);
        let down = Camera { eye: [0.0, 0.0, 9.0], ..start() };
        assert!(Motion::Walk.camera(&down, 1.0).eye[1] > 0.0, "straight down there is no ahead");
    }

    #[test]
    fn frames_follow_the_phases() {
        let phases = phases(start(), &[Motion::Orbit, Motion::Jump]);
        let names: Vec<&str> = phases.iter().map(|phase| phase.name.as_str()).collect();
        assert_eq!(names, ["loading", "still", "orbit", "after orbit", "jump", "after jump"]);
        assert_eq!(phases[4].start, Motion::Orbit.camera(&start(), 1.0), "where the last one ended");
        let mut director = Director::new(&phases, 4, false);
        // Loaded after three frames; every still picture takes three to converge, or is already.
        let mut shown = Vec::new();
        let (mut frame, mut still) = (0, 0);
        let mut last = None;
        while let Some((phase, camera)) = director.next(Seen { loaded: frame >= 3, converged: still >= 3 }) {
            still = if last == Some(camera) { still + 1 } else { 1 };
            last = Some(camera);
            frame += 1;
            shown.push(phase);
            assert!(frame < 100);
        }
        assert_eq!(shown, [0, 0, 0, 1, 2, 2, 2, 2, 3, 3, 4, 5, 5]);
    }
}
