//! The choice of a method: all candidates draw one picture, measuring changes none, and what a device
//! lacks is said.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use firstlight::render::{
    Backend, Candidate, FillBudget, FrameRequest, GpuBackend, Picture, Progressive, Raster, RasterChoice, Shading,
    StoreOptions, Why,
};

use crate::{
    backends::{gpu, with_choice_without, without},
    cloud::Cloud,
};

/// All 64-bit atomics.
const INT64: wgpu::Features = wgpu::Features::SHADER_INT64
    .union(wgpu::Features::SHADER_INT64_ATOMIC_MIN_MAX)
    .union(wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS);

struct Scene {
    cloud: Cloud,
    progressive: Progressive<GpuBackend>,
    fill: u32,
}

impl Scene {
    fn open(backend: GpuBackend, points: usize, fill: u32) -> Scene {
        let options = StoreOptions { seed: 5, insertion_points: 4097, ..Default::default() };
        let mut progressive = Progressive::new(backend, options);
        let cloud = Cloud::town(points);
        progressive.open(Arc::new(cloud.facts.clone()));
        progressive.offer(cloud.batch(0..points));
        progressive.end_of_input();
        Scene { cloud, progressive, fill }
    }

    fn request(&self, size: [u32; 2], point_size: u32) -> FrameRequest {
        let view = self.cloud.camera().view(&self.cloud.facts.grid, size, point_size).unwrap();
        FrameRequest { view, fill: FillBudget::Fixed(self.fill), shading: Shading::default() }
    }

    fn converge(&mut self, size: [u32; 2], point_size: u32) -> Picture {
        let request = self.request(size, point_size);
        while !(self.progressive.frame(&request).unwrap().is_converged() && self.progressive.is_loaded()) {}
        self.progressive.read().unwrap()
    }

    fn brute_force(&mut self, size: [u32; 2], point_size: u32) -> Picture {
        let request = self.request(size, point_size);
        self.progressive.brute_force(&request).unwrap();
        self.progressive.read().unwrap()
    }

    fn choose(&mut self) -> firstlight::render::Choice {
        let backend = self.progressive.backend_mut();
        backend.choose().unwrap();
        backend.info().choice.clone().unwrap()
    }
}

fn differing(a: &Picture, b: &Picture) -> usize {
    assert_eq!((a.width, a.height), (b.width, b.height));
    let pixel = |p: &Picture, i: usize| (p.records[i], p.depth[i].to_bits(), p.rgba[i]);
    (0..a.records.len()).filter(|&i| pixel(a, i) != pixel(b, i)).count()
}

/// Pixels that differ between two methods. Other devices than lavapipe may fuse multiplication and addition in one
/// kernel and not in another: there depths may differ in their last bits, and points on borders fall into
/// the next pixel, in one pixel of 50.
fn unlike(backend: &GpuBackend, a: &Picture, b: &Picture) -> usize {
    if backend.info().adapter.starts_with("llvmpipe") {
        return differing(a, b);
    }
    let other = (0..a.records.len()).filter(|&i| a.records[i] != b.records[i]).count();
    other.saturating_sub(a.records.len() / 50)
}

#[test]
fn all_candidates_draw_the_picture_of_all_points() {
    const SIZE: [u32; 2] = [97, 61];
    let mut references: Vec<Picture> = Vec::new();
    for candidate in Candidate::all() {
        let Some(mut backend) = gpu(RasterChoice::Fixed(candidate)) else { return };
        // Spans of these pages end amid groups and subgroups of every size.
        backend.store_mut().set_page_points(Some(1000));
        assert_eq!(backend.info().choice.as_ref().unwrap().candidate, candidate);
        assert_eq!(backend.info().method, candidate.method);
        let mut scene = Scene::open(backend, 6_007, 777);
        for (i, point_size) in [1, 2, 3, 8].into_iter().enumerate() {
            let progressive = scene.converge(SIZE, point_size);
            let brute = scene.brute_force(SIZE, point_size);
            assert_eq!(differing(&progressive, &brute), 0, "{candidate}, {point_size} px: against brute force");
            // Of early-z:256, whose kernel the twins hold.
            match references.get(i) {
                Some(reference) => {
                    let different = unlike(scene.progressive.backend(), &progressive, reference);
                    assert!(different == 0, "{candidate}, {point_size} px: {different} pixels differ");
                }
                None => references.push(progressive),
            }
        }
    }
    assert!(differing(&references[0], &references[1]) > 100, "the comparison can fail: other points, other pixels");
    let mut wrong = references[0].clone();
    wrong.depth[0] += 1.0;
    wrong.records[5] += 1;
    assert_eq!(differing(&references[0], &wrong), if wrong.depth[0].is_infinite() { 1 } else { 2 });
}

#[test]
fn measuring_names_its_figures_and_changes_no_picture() {
    let Some(backend) = gpu(RasterChoice::Auto) else { return };
    let mut scene = Scene::open(backend, 60_001, 20_000);
    assert_eq!(scene.progressive.backend().info().choice.as_ref().unwrap().why, Why::Default);
    let before = scene.converge([320, 240], 2);
    let choice = scene.choose();
    assert_eq!(choice.why, Why::Measured, "{choice:?}");
    assert_eq!(choice.candidates.len(), Candidate::all().len(), "each has its row");
    for row in &choice.candidates {
        match &row.speed {
            Some(speed) => assert!(speed.secs_per_point() > 0.0 && speed.secs_per_point() < 1e-3, "{row:?}"),
            None => assert!(!row.left_out.as_ref().unwrap().is_empty()),
        }
    }
    let measured: Vec<_> = choice.candidates.iter().filter(|row| row.speed.is_some()).collect();
    assert!(measured.iter().any(|row| row.candidate == choice.candidate));
    let clock = measured[0].speed.unwrap().clock;
    assert!(measured.iter().all(|row| row.speed.unwrap().clock == clock), "one clock: {measured:?}");
    let measurement = choice.measurement.unwrap();
    assert_eq!((measurement.size_px, measurement.point_size_px, measurement.before), ([320, 240], 2, 0));
    assert!(measurement.points > 1000 && measurement.took_secs > 0.0 && measurement.at_secs > 0.0);
    // The words on screen are not those that were measured with.
    assert_eq!(differing(&before, &scene.progressive.read().unwrap()), 0);
    let after = scene.brute_force([320, 240], 2);
    assert_eq!(unlike(scene.progressive.backend(), &before, &after), 0);
    assert_eq!(scene.progressive.backend_mut().measure_at_rest().unwrap(), None, "nothing is left to measure");
}

#[test]
fn another_size_is_measured_for_once_it_stays() {
    let Some(backend) = gpu(RasterChoice::Auto) else { return };
    let mut scene = Scene::open(backend, 60_001, 20_000);
    scene.converge([320, 240], 1);
    let first = scene.choose();
    assert_eq!(first.measurement.unwrap().size_px, [320, 240]);
    // As while a window is dragged. A frame may take longer than that on a busy machine.
    let mut in_time = 0;
    for width in [321, 322, 323] {
        let begun = Instant::now();
        let request = scene.request([width, 240], 1);
        scene.progressive.frame(&request).unwrap();
        let wait = scene.progressive.backend_mut().measure_at_rest().unwrap().expect("it will measure");
        let choice = scene.progressive.backend().info().choice.clone();
        if begun.elapsed() < Duration::from_millis(300) {
            assert!(wait > Duration::ZERO && wait <= Duration::from_millis(300), "{wait:?}");
            assert_eq!(choice, Some(first.clone()), "not yet");
            in_time += 1;
        }
    }
    assert!(in_time > 0, "no frame took less than 300 ms");
    std::thread::sleep(Duration::from_millis(310));
    let second = scene.choose().measurement.unwrap();
    assert_eq!((second.size_px, second.before), ([323, 240], 1));
    assert!(second.at_secs > first.measurement.unwrap().at_secs);
    let progressive = scene.converge([323, 240], 1);
    assert_eq!(differing(&progressive, &scene.brute_force([323, 240], 1)), 0);
}

#[test]
fn who_asks_for_a_method_gets_it_unmeasured() {
    let Some(backend) = gpu(Raster::TwoPass32) else { return };
    let mut scene = Scene::open(backend, 60_001, 20_000);
    scene.converge([320, 240], 1);
    let choice = scene.choose();
    assert_eq!((choice.candidate, choice.why), (Candidate::new(Raster::TwoPass32), Why::AskedFor));
    assert!(choice.measurement.is_none());
}

#[test]
fn too_few_points_are_not_measured() {
    let Some(backend) = gpu(RasterChoice::Auto) else { return };
    let mut scene = Scene::open(backend, 4_000, 20_000);
    scene.converge([64, 48], 1);
    assert_eq!(scene.choose().why, Why::Default);
}

#[test]
fn without_features_others_draw_and_the_table_says_why() {
    for (features, default, unable, lacks) in [
        (
            wgpu::Features::SUBGROUP,
            Raster::EarlyZ,
            vec![Raster::Reduce, Raster::ReduceEarlyZ, Raster::Dedup],
            "subgroups",
        ),
        // As on Metal; the early test loads nothing atomically.
        (wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS, Raster::EarlyZ, vec![], "64-bit atomics"),
        (
            INT64 | wgpu::Features::SUBGROUP,
            Raster::TwoPass32,
            vec![Raster::EarlyZ, Raster::AtomicMin, Raster::Reduce, Raster::ReduceEarlyZ, Raster::Dedup],
            "64-bit atomic",
        ),
    ] {
        let Some(backend) = without(features) else { return };
        assert_eq!(backend.info().method, default, "without {features:?}");
        let mut scene = Scene::open(backend, 60_001, 20_000);
        let picture = scene.converge([160, 120], 2);
        assert_eq!(differing(&picture, &scene.brute_force([160, 120], 2)), 0, "without {features:?}");
        let choice = scene.choose();
        assert_eq!(choice.why, Why::Measured);
        for row in &choice.candidates {
            if unable.contains(&row.candidate.method) {
                let why = row.left_out.as_deref().unwrap_or_default();
                assert!(why.contains(lacks), "without {features:?}: {row:?}");
                assert!(row.speed.is_none() && choice.candidate != row.candidate);
            } else {
                assert!(row.left_out.as_ref().is_none_or(|why| !why.contains("lacks")), "{row:?}");
            }
        }
        for method in unable {
            let Some(Err(error)) = with_choice_without(method.into(), features) else {
                panic!("{method} without {features:?}")
            };
            let message = error.to_string();
            assert!(message.contains(method.name()) && message.contains(lacks), "{message}");
        }
    }
}
