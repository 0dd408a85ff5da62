//! All runs of a measurement: every setting, in turn.

use super::{
    ConvergeError,
    checks::checks,
    driver::{self, Driver},
    input::{Feeder, Recording},
    live,
    motion::{Director, Phase, phases},
    replay::{Script, replay},
    report::{ConvergeReport, Frame, Headline, Run, TITLE},
    settings::{Clock, Decoded, Fill, Measure, Setting, Variant},
};
use crate::{
    headless::default_camera,
    measure::{machine::Machine, report_dir::ReportDirError},
    render::{Backend, BackendInfo, Camera, FillBudget, INSERTION_POINTS, Picture, RasterChoice, Shading, View},
    source::Order,
    store::{Encoding, Packing},
};

use super::motion::Motion;

/// Who follows a measurement.
pub trait Watcher {
    /// `done` of `total` runs; `what` goes on.
    fn step(&mut self, done: usize, total: usize, what: &str);
    /// Keeps what there is so far.
    ///
    /// # Errors
    /// If it cannot be written.
    fn save(&mut self, report: &ConvergeReport) -> Result<(), ReportDirError>;
}

/// Virtual frames that loading takes, unless the scan is large; the points of each frame, and the points that enter
/// the store at a time, follow from it.
const LOADING_FRAMES: u64 = 32;
/// Fewest and most points of such a frame. Every backend can insert as many between two frames.
const LEAST_LOAD: u64 = 1000;
pub const MOST_LOAD: u32 = 6 * INSERTION_POINTS;

/// Points that arrive per virtual frame.
fn load(measure: &Measure, points: u64) -> u64 {
    let default = points.div_ceil(LOADING_FRAMES).clamp(LEAST_LOAD, MOST_LOAD.into());
    measure.load.map_or(default, |load| u64::from(load.clamp(1, MOST_LOAD)))
}

/// Measures everything asked for and keeps the report as it grows.
///
/// # Errors
/// If nothing can be read, no device does what is asked, or the report cannot be kept.
pub fn measure(measure: &Measure, watcher: &mut dyn Watcher) -> Result<ConvergeReport, ConvergeError> {
    let settings = measure.settings();
    let Some(first) = settings.first() else { return Err(ConvergeError::NoPoints) };
    if measure.clock == Clock::Virtual && measure.fills.contains(&Fill::Auto) {
        return Err(ConvergeError::AutoNeedsTime);
    }
    watcher.step(0, settings.len() * measure.repeat as usize, "reading the points");
    let scans = Scans::new(measure, &settings)?;
    let Some(scan) = scans.of(first) else { return Err(ConvergeError::NoPoints) };
    let packing = Packing::of_scene(&scan.facts.grid, &scan.facts.bounds);
    if settings.iter().any(|setting| setting.encoding == Some(Encoding::Packed)) {
        packing?;
    }
    // As in a viewer, whoever draws: the reports are to be the same on all devices. A point outside of the promised box
    // widens a packed store while it loads.
    let packs = packing.is_ok_and(|packing| scan.batches.iter().all(|batch| packing.holds_all(&batch.positions)));
    let viewers_encoding = if packs { Encoding::default() } else { Encoding::Wide };
    let viewers_fields = if measure.decoded.len() > 1 { Decoded::Colors } else { first.decoded };
    let camera = first_camera(measure, scan);
    let auto = Setting { method: RasterChoice::Auto, ..*first };
    let asks_auto = settings.iter().any(|setting| setting.method == RasterChoice::Auto);
    let info = who_draws(measure, if asks_auto { &auto } else { first }, scan, &camera)?;
    // What was measured to be faster once is not measured again, or runs could differ; on the processor there is
    // nothing to choose.
    let chosen = info.choice.as_ref().map_or(RasterChoice::Auto, |choice| RasterChoice::Fixed(choice.candidate));
    let settle = |setting: &Setting| {
        let method = if setting.method == RasterChoice::Auto { chosen } else { setting.method };
        let encoding = Some(setting.encoding.unwrap_or(viewers_encoding));
        Setting { method, encoding, ..*setting }
    };
    let viewers_method = match (asks_auto, &measure.methods[..]) {
        (true, _) => Some(chosen),
        (false, [only]) => Some(*only),
        (false, _) => None,
    };
    let is_viewers = |setting: &Setting| {
        let is_encoding = measure.encodings.len() < 2 || setting.encoding == Some(viewers_encoding);
        viewers_method == Some(setting.method) && is_encoding && setting.decoded == viewers_fields
    };
    // A method or an encoding that is both named and chosen is run once.
    let mut settled: Vec<Setting> = Vec::new();
    for setting in settings.iter().map(settle) {
        if !settled.contains(&setting) {
            settled.push(setting);
        }
    }
    let settings = settled;
    let phases = phases(camera, &measure.motions);
    // Before hours of work, not after.
    for motion in &measure.motions {
        if let Motion::Path(cameras) = motion {
            for camera in cameras {
                camera.view(&scan.facts.grid, measure.size, first.point_size)?;
            }
        }
    }
    let mut report = empty(measure, scan, &info, camera, &phases);
    if !packs && settings.iter().any(|setting| setting.encoding == Some(Encoding::Packed)) {
        report.problems.push(
            "points lie outside of the box that the header promises: runs called packed hold 12 bytes a point from there on"
                .into(),
        );
    }
    let total = settings.len() * measure.repeat as usize;
    for round in 1..=measure.repeat {
        // Every second round backwards: nobody always follows the same neighbour.
        let forwards = 0..settings.len();
        let order: Vec<usize> = if round % 2 == 0 { forwards.rev().collect() } else { forwards.collect() };
        for i in order {
            let setting = &settings[i];
            let mut run = Run {
                variant: setting.variant,
                fill: setting.fill,
                point_size_px: setting.point_size,
                method: match setting.method {
                    RasterChoice::Fixed(candidate) if measure.methods.len() > 1 => Some(candidate.to_string()),
                    _ => None,
                },
                encoding: setting.encoding.filter(|_| measure.encodings.len() > 1),
                fields: (measure.decoded.len() > 1).then_some(setting.decoded),
                is_viewers_method: is_viewers(setting),
                round,
                headline: Headline::default(),
                frames: Vec::new(),
            };
            let Some(recording) = scans.of(setting) else { return Err(ConvergeError::NoPoints) };
            let name = match setting.variant {
                Variant::Firstlight => format!("firstlight, {}", run.label()),
                other => other.name().into(),
            };
            let done = report.runs.len();
            let mut each = |frame: &Frame| watcher.step(done, total, &format!("{name}: {}", frame.phase));
            run.frames = one_run(measure, setting, recording, &phases, load(measure, scan.points), &mut each)?;
            run.headline = Headline::of(&run.frames);
            report.runs.push(run);
            report.checks = checks(&report);
            report.complete = report.runs.len() == total;
            if let (Some(machine), true) = (&mut report.machine, report.complete) {
                machine.finish();
            }
            watcher.save(&report)?;
        }
    }
    watcher.step(total, total, "done");
    Ok(report)
}

/// In which order a setting reads its points.
fn order_of(setting: &Setting) -> Order {
    if setting.variant == Variant::Unshuffled { Order::File } else { Order::PreviewFirst }
}

/// What all settings begin from: the points in the orders that they need, with and without colours.
struct Scans(Vec<((Order, bool), Recording)>);

impl Scans {
    fn new(measure: &Measure, settings: &[Setting]) -> Result<Scans, ConvergeError> {
        let mut scans = Scans(Vec::new());
        for setting in settings {
            if scans.of(setting).is_none() {
                let scan = Recording::new(&measure.input, order_of(setting), setting.decoded, measure.threads)?;
                scans.0.push((Scans::key(setting), scan));
            }
        }
        Ok(scans)
    }

    /// What else was decoded makes no difference to a picture.
    fn key(setting: &Setting) -> (Order, bool) {
        (order_of(setting), setting.decoded != Decoded::Positions)
    }

    fn of(&self, setting: &Setting) -> Option<&Recording> {
        self.0.iter().find(|(key, _)| *key == Scans::key(setting)).map(|(_, scan)| scan)
    }
}

/// One setting: what it does first, then the same with comparisons.
fn one_run(
    measure: &Measure,
    setting: &Setting,
    recording: &Recording,
    phases: &[Phase],
    load: u64,
    each: &mut dyn FnMut(&Frame),
) -> Result<Vec<Frame>, ConvergeError> {
    let start = phases.first().map_or(Camera::fit(&recording.facts.bounds, &recording.facts.grid, 1.0), |p| p.start);
    let view_of = |camera: &Camera| -> Result<View, ConvergeError> {
        Ok(camera.view(&recording.facts.grid, measure.size, setting.point_size)?)
    };
    let (truth, script, insertion_points): (Picture, Script<'_>, u32) = match (measure.clock, setting.fill) {
        (Clock::Virtual, Fill::Auto) => return Err(ConvergeError::AutoNeedsTime),
        (Clock::Virtual, Fill::Points(fill)) => {
            let insertion_points = load.min(INSERTION_POINTS.into()) as u32;
            let mut driver = Driver::new(measure, setting, recording, insertion_points, driver::unlit())?;
            load_all(&mut driver, recording, load, &start)?;
            let director = Director::new(phases, measure.frames, false);
            (driver.truth(&start)?, Script::Virtual { director, load, fill }, insertion_points)
        }
        (Clock::Real, fill) => {
            let mut driver = Driver::new(measure, setting, recording, INSERTION_POINTS, Shading::default())?;
            let (order, decoded) = (order_of(setting), setting.decoded);
            let points = live::Points::of(&measure.input, recording, order, decoded, measure.threads);
            let log = live::run(&mut driver, points, phases, measure.frames, fill.budget())?;
            (driver.truth(&start)?, Script::Log(log.into()), INSERTION_POINTS)
        }
    };
    // Where two stores do not fit side by side, the first is gone by now.
    let mut driver = Driver::new(measure, setting, recording, insertion_points, driver::unlit())?;
    replay(&mut driver, recording, phases, script, &truth, &view_of, each)
}

/// The store as it is when all has arrived.
fn load_all(driver: &mut Driver, recording: &Recording, load: u64, camera: &Camera) -> Result<(), ConvergeError> {
    let mut feeder = Feeder::new(recording);
    while !driver.progressive.is_loaded() {
        let arrived = feeder.offered() + load;
        feeder.offer_up_to(arrived, &mut driver.progressive);
        driver.frame(camera, FillBudget::Fixed(0))?;
        driver.progressive.spent().for_each(drop);
    }
    Ok(())
}

fn first_camera(measure: &Measure, scan: &Recording) -> Camera {
    let of_path = measure.motions.iter().find_map(|motion| match motion {
        Motion::Path(cameras) => cameras.first().copied(),
        _ => None,
    });
    let fitted = || default_camera(&scan.facts, scan.batches.first(), measure.size);
    measure.camera.or(of_path).unwrap_or_else(fitted)
}

/// The device; where frames are timed, it has measured on the whole scan which of its methods is the fastest, as a
/// viewer does between frames.
fn who_draws(
    measure: &Measure,
    setting: &Setting,
    scan: &Recording,
    camera: &Camera,
) -> Result<BackendInfo, ConvergeError> {
    let mut driver = Driver::new(measure, setting, scan, INSERTION_POINTS, driver::unlit())?;
    if measure.clock == Clock::Real && setting.method == RasterChoice::Auto {
        load_all(&mut driver, scan, load(measure, scan.points), camera)?;
        driver.progressive.backend_mut().choose()?;
    }
    Ok(driver.progressive.backend().info().clone())
}

fn empty(measure: &Measure, scan: &Recording, info: &BackendInfo, camera: Camera, phases: &[Phase]) -> ConvergeReport {
    let is_real = measure.clock == Clock::Real;
    let name = |file: &crate::scene::FileFacts| match file.path.file_name() {
        Some(name) => name.to_string_lossy().into_owned(),
        None => file.path.display().to_string(),
    };
    ConvergeReport {
        report: TITLE,
        program: concat!("firstlight ", env!("CARGO_PKG_VERSION")).into(),
        adapter: format!("{} ({}, {})", info.adapter, info.api, info.method),
        complete: false,
        clock: measure.clock,
        command: is_real.then(|| measure.command.clone()),
        machine: is_real.then(Machine::find),
        inputs: scan.facts.files.iter().map(name).collect(),
        points: scan.points,
        size_px: measure.size,
        seed: measure.seed,
        motion_frames: measure.frames,
        load: (!is_real).then(|| load(measure, scan.points)),
        metres_per_unit: scan.metres,
        camera,
        phases: phases.iter().map(|phase| phase.name.clone()).collect(),
        runs: Vec::new(),
        checks: Vec::new(),
        problems: scan.problems.clone(),
    }
}
