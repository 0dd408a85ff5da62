//! High-quality shading on a device that is too slow for it while the camera moves.

use std::sync::Arc;

use firstlight::{
    render::{
        Backend, BackendInfo, Camera, CpuBackend, FillBudget, FramePlan, FrameRequest, PassTimes, Passes, Progressive,
        Raster, RenderError,
    },
    scene::PointBatch,
    store::Insertion,
};

use crate::{
    cloud::Cloud,
    convergence::{difference, options, request},
    high_quality::high,
};

/// A processor that says it takes so many seconds to resolve, and twice that with sums.
struct Slow {
    cpu: CpuBackend,
    secs: f64,
    passes: Vec<Passes>,
    /// What it says that it is, if not a processor.
    says: Option<BackendInfo>,
}

impl Backend for Slow {
    crate::backends::as_the_processor!();
    fn info(&self) -> &BackendInfo {
        self.says.as_ref().unwrap_or(self.cpu.info())
    }
    fn insert(&mut self, insertion: &Insertion, points: &PointBatch) -> Result<(), RenderError> {
        self.cpu.insert(insertion, points)
    }
    fn draw(&mut self, plan: &FramePlan) -> Result<(), RenderError> {
        self.passes.push(plan.passes());
        self.cpu.draw(plan)
    }
    fn pass_times(&mut self) -> Option<PassTimes> {
        let PassTimes { fill_points, average_points, insertions, passes, .. } = self.cpu.pass_times()?;
        let average = if passes == Passes::DepthsAndSums { self.secs } else { 0.0 };
        let [fill, average_fill] = [fill_points, average_points].map(|points| f64::from(points) * 1e-7);
        let resolve = self.secs;
        let sums = (average, average_fill, average_points);
        let times = PassTimes { fill, resolve, fill_points, insertions, passes, ..Default::default() };
        Some(PassTimes { average: sums.0, average_fill: sums.1, average_points: sums.2, ..times })
    }
}

#[test]
fn a_slow_device_averages_at_rest_and_comes_to_the_same() {
    let cloud = Cloud::town(200_000);
    let target = FillBudget::Target(0.016);
    let mut pictures = Vec::new();
    for (secs, passes_in_motion) in [(0.002, Passes::DepthsAndSums), (0.012, Passes::Depths)] {
        let backend = Slow { cpu: CpuBackend::new(Some(2)), secs, passes: Vec::new(), says: None };
        let mut progressive = Progressive::new(backend, options(65_536));
        progressive.open(Arc::new(cloud.facts.clone()));
        progressive.offer(cloud.batch(0..cloud.len()));
        progressive.end_of_input();
        let at = |step: usize| {
            let camera = cloud.camera();
            let eye = [camera.eye[0] + step as f64 * 0.1, camera.eye[1], camera.eye[2]];
            FrameRequest { fill: target, ..high(request(&cloud, &Camera { eye, ..camera }, 1, 0)) }
        };
        for step in 0..60 {
            progressive.frame(&at(step)).unwrap();
        }
        let passes = &progressive.backend().passes;
        assert!(passes[10..].iter().all(|&passes| passes == passes_in_motion), "{secs} s: {passes:?}");
        assert_eq!(progressive.averages_in_motion(target), passes_in_motion == Passes::DepthsAndSums);
        let mut frames = 0;
        while !progressive.frame(&at(60)).unwrap().is_converged() {
            frames += 1;
            assert!(frames < 1000);
        }
        let picture = progressive.read().unwrap();
        progressive.brute_force(&at(60)).unwrap();
        assert_eq!(difference(&progressive.read().unwrap(), &picture), None, "{secs} s");
        pictures.push(picture);
    }
    assert_eq!(difference(&pictures[0], &pictures[1]), None);
}

/// Two methods may round a point into different pixels: half a picture of each would be no method's.
#[test]
fn after_a_change_of_method_all_points_are_tried_again() {
    let cloud = Cloud::town(10_000);
    let backend = Slow { cpu: CpuBackend::new(Some(1)), secs: 0.0, passes: Vec::new(), says: None };
    let mut progressive = Progressive::new(backend, options(65_536));
    progressive.open(Arc::new(cloud.facts.clone()));
    progressive.offer(cloud.batch(0..cloud.len()));
    progressive.end_of_input();
    let request = request(&cloud, &cloud.camera(), 1, 3000);
    let mut tried = || progressive.frame(&request).unwrap().points_tried;
    assert_eq!([tried(), tried()], [10_000; 2], "all of them arrived in the first frame");
    let info = progressive.backend().info().clone();
    progressive.backend_mut().says = Some(BackendInfo { method: Raster::EarlyZ, ..info });
    let mut tried = || progressive.frame(&request).unwrap().points_tried;
    assert_eq!([tried(), tried(), tried(), tried(), tried()], [3000, 6000, 9000, 10_000, 10_000]);
}
