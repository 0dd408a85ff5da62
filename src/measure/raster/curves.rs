//! Cost against the number of points, and against the points per pixel.

use std::fmt;

use super::{
    RasterError,
    input::Scan,
    orders::gather,
    report::{CurveKind, CurveRuns, RasterReport},
    run::{BenchRaster, Part, in_turn, supported},
    stacks::Stack,
    views::Viewpoint,
};
use crate::{
    measure::stats::Summary,
    methods::{Cloud, Gpu, Runner},
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
pub fn measure(
    step: &Step,
    settings: &BenchRaster,
    gpu: &Gpu,
    scan: &Scan,
    report: &mut RasterReport,
) -> Result<(), RasterError> {
    match step {
        Step::Points(points) => {
            let cloud = thin(&scan.cloud, *points);
            let camera = Viewpoint::Overview.camera(&scan.cloud.positions, &scan.grid, settings.size);
            let view = camera.view(&scan.grid, settings.size, 1)?;
            let (picture, fragments) = super::brute_force(&cloud, &view);
            let covered = picture.depth.iter().filter(|depth| depth.is_finite()).count();
            run(CurveKind::Points, &cloud, &view, fragments as f64 / covered as f64, settings, gpu, report)
        }
        Step::Stack(kind, stack) => {
            let (cloud, view) = (stack.cloud(settings.seed), stack.view()?);
            run(*kind, &cloud, &view, stack.fragments_per_pixel(), settings, gpu, report)
        }
    }
}

/// So many points, evenly from all of the cloud and in its order.
fn thin(cloud: &Cloud, points: u64) -> Cloud {
    let all = cloud.positions.len() as u64;
    let kept: Vec<u32> = (0..points).map(|i| (u128::from(i) * u128::from(all) / u128::from(points)) as u32).collect();
    Cloud { positions: gather(&cloud.positions, &kept), colors: gather(&cloud.colors, &kept) }
}

fn run(
    curve: CurveKind,
    cloud: &Cloud,
    view: &View,
    fragments_per_pixel: f64,
    settings: &BenchRaster,
    gpu: &Gpu,
    report: &mut RasterReport,
) -> Result<(), RasterError> {
    let mut runner = Runner::new(gpu, cloud, settings.encoding, settings.size)?;
    let methods = supported(settings, &runner, report);
    let mut samples = vec![Vec::new(); methods.len()];
    let mut wall_clock = false;
    // The first run of each is not counted.
    for round in 0..=settings.repeat {
        for i in in_turn(methods.len(), round) {
            let times = runner.time(methods[i], view, settings.frames)?;
            wall_clock |= times.iter().any(|time| time.undivided_secs.is_some());
            if round > 0 {
                samples[i].extend(times.iter().map(|time| time.total_secs()));
            }
        }
    }
    report.wall_clock = wall_clock;
    let of = |(method, samples_secs): (&&crate::methods::Method, Vec<f64>)| CurveRuns {
        curve,
        method: method.name,
        points: cloud.positions.len() as u64,
        fragments_per_pixel,
        frame_secs: Summary::of(&samples_secs),
        samples_secs,
    };
    report.curves.extend(methods.iter().zip(samples).map(of));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        measure::raster::{Input, Order},
        methods::Encoding,
        synth::{Scene, SynthOptions},
    };

    fn settings(parts: &[Part]) -> BenchRaster {
        BenchRaster {
            input: Input::Synth(SynthOptions::new(Scene::Planes)),
            methods: vec![],
            orders: vec![Order::Original],
            views: vec![],
            camera: None,
            parts: parts.to_vec(),
            size: [640, 360],
            encoding: Encoding::Wide,
            frames: 1,
            repeat: 1,
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
        let cloud = Cloud { positions: (0..1000).map(|i| [i, 0, 0]).collect(), colors: (0..1000).collect() };
        let thinned = thin(&cloud, 100);
        assert_eq!(thinned.colors, (0..100).map(|i| 10 * i).collect::<Vec<u32>>());
        assert_eq!(thin(&cloud, 1000), cloud);
    }
}
