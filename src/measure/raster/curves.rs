//! Cost against the number of points, and against the points per pixel.

use std::fmt;

use super::{
    RasterError,
    block::{Trial, patience},
    input::Scan,
    processor::Processor,
    report::{CurveKind, CurveRuns, RasterReport},
    run::{BenchRaster, Part, in_turn},
    stacks::Stack,
    views::Viewpoint,
};
use crate::{
    measure::stats::Summary,
    methods::{Arranged, Encoding, FrameTime, Gpu, Method, Paced, Runner, parallel::fill},
    render::View,
};

/// Fewest points of the curve against points, unless the scan has fewer than a hundred times as many.
const FEWEST: u64 = 100_000;

/// Most planes before the camera; half a power of ten more than a town seen from above has points per pixel. A
/// software rasterizer gets by with fewer.
const PLANES: [u32; 2] = [32, 8];

/// One cloud and one view of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// The scan thinned to so many points.
    Points(u64),
    Stack(CurveKind, Stack),
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Step::Points(points) => write!(f, "{points} points"),
            Step::Stack(_, stack) => write!(f, "{:.0} points per pixel", stack.fragments_per_pixel()),
        }
    }
}

/// The places of all curves that were asked for.
pub fn plan(settings: &BenchRaster, points: u64, is_software: bool) -> Vec<Step> {
    let mut steps = Vec::new();
    if settings.parts.contains(&Part::Points) {
        // Half decades down from all points, the fewest first.
        let least = FEWEST.min(points.div_ceil(100)).max(1);
        let levels = (0..32).map(|k| (points as f64 * 10f64.powf(-0.5 * f64::from(k))).round() as u64);
        let levels: Vec<u64> = levels.take_while(|&level| level >= least).collect();
        steps.extend(levels.into_iter().rev().map(Step::Points));
    }
    if settings.parts.contains(&Part::Fragments) {
        let size = settings.size;
        let pixels = size[0].saturating_mul(size[1]);
        let most = PLANES[usize::from(is_software)];
        let planes = (0..6).map(|k| 1 << k).take_while(|&n| n <= most);
        let of_planes = planes.map(|n| Stack { size, base: size, points: pixels.saturating_mul(n) });
        steps.extend(of_planes.map(|stack| Step::Stack(CurveKind::Planes, stack)));
        let bases = (0..32).map(|k| size.map(|n| (n >> k).max(1)));
        let mut bases: Vec<[u32; 2]> = bases.collect();
        bases.dedup();
        let shrunk = bases.into_iter().map(|base| Stack { size, base, points: pixels });
        steps.extend(shrunk.map(|stack| Step::Stack(CurveKind::Base, stack)));
    }
    steps
}

/// Measures all methods at one place.
///
/// # Errors
/// If the device cannot hold or draw the cloud.
pub(super) fn measure(
    step: &Step,
    settings: &BenchRaster,
    encoding: Encoding,
    gpu: &Gpu,
    scan: &Scan,
    methods: &[&'static Method],
    report: &mut RasterReport,
) -> Result<(), RasterError> {
    match step {
        Step::Points(points) => {
            let kept = thinned(scan.cloud.positions.len() as u64, *points);
            let arranged = Arranged { cloud: &scan.cloud, order: kept.as_deref() };
            let camera = Viewpoint::Overview.camera(&scan.cloud.positions, &scan.grid, settings.size);
            let view = camera.view(&scan.grid, settings.size, 1)?;
            let processor = Processor::of(arranged, &view);
            let place = Place {
                curve: CurveKind::Points,
                points: *points,
                fragments_per_pixel: processor.fragments as f64 / processor.covered() as f64,
            };
            let mut runner = Runner::new(gpu, arranged, encoding, settings.size)?;
            run(&place, &mut runner, &view, settings, methods, report)
        }
        Step::Stack(kind, stack) => {
            let (cloud, view) = (stack.cloud(settings.seed), stack.view()?);
            let fragments_per_pixel = stack.fragments_per_pixel();
            let place = Place { curve: *kind, points: stack.points.into(), fragments_per_pixel };
            let mut runner = Runner::new(gpu, &cloud, encoding, settings.size)?;
            run(&place, &mut runner, &view, settings, methods, report)
        }
    }
}

/// So many of `all` points, evenly and in their order; `None` for all of them.
fn thinned(all: u64, points: u64) -> Option<Vec<u32>> {
    let kept = |i: usize| (i as u128 * u128::from(all) / u128::from(points)) as u32;
    (points != all).then(|| fill(points as usize, kept))
}

/// Where on a curve.
struct Place {
    curve: CurveKind,
    points: u64,
    fragments_per_pixel: f64,
}

fn run(
    place: &Place,
    runner: &mut Runner,
    view: &View,
    settings: &BenchRaster,
    methods: &[&'static Method],
    report: &mut RasterReport,
) -> Result<(), RasterError> {
    let (mut runs, mut frames, mut wall_clock) = (Vec::new(), Vec::new(), false);
    for method in methods {
        let mut runs_of = CurveRuns {
            curve: place.curve,
            method: method.name,
            points: place.points,
            fragments_per_pixel: place.fragments_per_pixel,
            frame_secs: None,
            abandoned: None,
            samples_secs: Vec::new(),
        };
        let trial = match runner.draw_paced(method, view, patience(settings))? {
            Paced::Abandoned(abandoned) => {
                runs_of.abandoned = Some(abandoned);
                Trial { frames: 0, is_single: false }
            }
            Paced::Drawn { secs, .. } => {
                let second = runner.time(method, view, 1)?.first().map_or(secs, FrameTime::total_secs);
                let trial = Trial::of(settings, runner.gpu.is_software(), secs, second);
                runs_of.samples_secs.extend(trial.is_single.then_some(second));
                trial
            }
        };
        runs.push(runs_of);
        frames.push(trial.frames);
    }
    for round in 1..=settings.repeat {
        for i in in_turn(methods.len(), round) {
            let times = runner.time(methods[i], view, frames[i])?;
            wall_clock |= times.iter().any(|time| time.undivided_secs.is_some());
            runs[i].samples_secs.extend(times.iter().map(FrameTime::total_secs));
        }
    }
    report.wall_clock = wall_clock;
    runs.iter_mut().for_each(|runs| runs.frame_secs = Summary::of(&runs.samples_secs));
    report.curves.extend(runs);
    Ok(())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::{
        measure::raster::{Input, Order},
        methods::Encoding,
        synth::{Scene, SynthOptions},
    };

    /// Of nothing but these parts.
    pub fn settings(parts: &[Part]) -> BenchRaster {
        BenchRaster {
            input: Input::Synth(SynthOptions::new(Scene::Planes)),
            methods: vec![],
            orders: vec![Order::Original],
            views: vec![],
            camera: None,
            parts: parts.to_vec(),
            size: [640, 360],
            encodings: vec![Encoding::Wide],
            frames: 1,
            repeat: 1,
            max_frame_secs: 1.0,
            seed: 1,
            command: String::new(),
        }
    }

    #[test]
    fn the_curve_against_points_ends_with_all_of_them() {
        let levels = |points| -> Vec<u64> {
            let steps = plan(&settings(&[Part::Points]), points, false);
            steps.iter().map(|step| if let Step::Points(n) = step { *n } else { 0 }).collect()
        };
        assert_eq!(levels(1_000_000_000).len(), 9);
        assert_eq!(levels(1_000_000_000)[0], 100_000);
        assert_eq!(levels(250_000), [2500, 7906, 25_000, 79_057, 250_000]);
        assert_eq!(levels(1), [1]);
    }

    #[test]
    fn the_base_shrinks_to_one_pixel() {
        let steps = plan(&settings(&[Part::Fragments]), 5, true);
        let of = |wanted: CurveKind| -> Vec<Stack> {
            let stack = |step: &Step| if let Step::Stack(kind, stack) = step { Some((*kind, *stack)) } else { None };
            steps.iter().filter_map(stack).filter(|s| s.0 == wanted).map(|s| s.1).collect()
        };
        assert_eq!(of(CurveKind::Planes).iter().map(|s| s.points / (640 * 360)).collect::<Vec<_>>(), [1, 2, 4, 8]);
        let bases = of(CurveKind::Base);
        assert!(bases.iter().all(|stack| stack.points == 640 * 360));
        assert_eq!((bases[0].base, bases.last().unwrap().base), ([640, 360], [1, 1]));
        assert!(bases.windows(2).all(|w| w[0].fragments_per_pixel() < w[1].fragments_per_pixel()));
    }

    #[test]
    fn thinning_takes_from_everywhere() {
        assert_eq!(thinned(1000, 100), Some((0..100).map(|i| 10 * i).collect()));
        assert_eq!(thinned(3, 2), Some(vec![0, 1]));
        assert_eq!(thinned(1000, 1000), None);
    }
}
