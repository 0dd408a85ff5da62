//! The GPU backend against the CPU twins: every rasterizer, page sizes that straddle insertions,
//! point sizes, cameras.

use std::sync::Arc;

use firstlight::{
    render::{
        Backend, Camera, CpuBackend, FileColor, FillBudget, FramePlan, FrameRequest, Picture, Progressive, Raster,
        Shading, StoreOptions,
    },
    scene::ColorRule,
    store::{Insertion, SlotOrder},
};

use crate::{
    backends::{RASTERS, gpu},
    cloud::Cloud,
};

struct Run {
    points: u32,
    insertion_points: u32,
    point_size: u32,
    fill: u32,
    size: [u32; 2],
}

/// Loads with a moving camera, then converges; the progressive and the brute-force picture.
fn run(backend: Box<dyn Backend>, run: &Run) -> (Picture, Picture) {
    let options = StoreOptions { seed: 5, insertion_points: run.insertion_points, ..Default::default() };
    let mut progressive = Progressive::new(backend, options);
    let cloud = Cloud::town(run.points as usize);
    let facts = Arc::new(cloud.facts.clone());
    progressive.open(facts.clone());
    let fit = Camera::fit(&facts.bounds, &facts.grid, f64::from(run.size[0]) / f64::from(run.size[1]));
    let request = |camera: &Camera| FrameRequest {
        view: camera.view(&facts.grid, run.size, run.point_size).unwrap(),
        fill: FillBudget::Fixed(run.fill),
        shading: Shading::default(),
    };
    progressive.offer(cloud.batch(0..cloud.len()));
    progressive.end_of_input();
    let mut frames = 0;
    while !progressive.is_loaded() {
        let mut camera = fit;
        camera.eye[0] += f64::from(frames.min(2)) * 3.0;
        progressive.frame(&request(&camera)).unwrap();
        frames += 1;
    }
    while !progressive.frame(&request(&fit)).unwrap().is_converged() {}
    let picture = progressive.read().unwrap();
    progressive.brute_force(&request(&fit)).unwrap();
    (picture, progressive.read().unwrap())
}

fn differing<T: PartialEq>(a: &[T], b: &[T]) -> usize {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

fn check(r: Run, page_points: Option<u32>) {
    let (cpu, cpu_brute) = run(Box::new(CpuBackend::new(None)), &r);
    assert_eq!(cpu.records, cpu_brute.records, "CPU");
    for raster in RASTERS {
        let Some(mut backend) = gpu(raster) else { return };
        backend.store_mut().set_page_points(page_points);
        let (progressive, brute) = run(Box::new(backend), &r);
        let n = progressive.records.len();
        assert_eq!(differing(&progressive.records, &brute.records), 0, "{raster}: progressive against brute force");
        let shown = progressive.records.iter().filter(|&&record| record >= 0).count();
        let different = differing(&progressive.records, &cpu.records);
        eprintln!(
            "{raster}, {} points, pages {page_points:?}: {shown} of {n} pixels shown, {different} unlike the CPU",
            r.points
        );
        assert!(shown * 20 > n.min(r.points as usize), "{raster}: {shown} of {n} pixels shown");
        // Float rounding may decide a pixel where a device fuses multiplication and addition.
        assert!(different * 1000 <= n, "{raster}: {different} of {n} pixels unlike the CPU's");
        let colors: Vec<u8> = progressive.rgba.iter().flatten().copied().collect();
        let expected: Vec<u8> = cpu.rgba.iter().flatten().copied().collect();
        let off = colors.iter().zip(&expected).filter(|(a, b)| a.abs_diff(**b) > 1).count();
        assert!(off * 100 <= n, "{raster}: {off} channels off by more than one level");
    }
}

/// The insertion kernels against their twin, slot for slot.
#[test]
fn insertion_equals_its_twin() {
    let batches: [u32; 14] = [1, 1, 2, 31, 32, 33, 255, 256, 257, 1, 4097, 65_536, 70_000, 3];
    let other = [SlotOrder::BatchShuffled, SlotOrder::Arrival].map(|order| (Some(4097), order));
    for (page_points, order) in [None, Some(64), Some(4097)].map(|p| (p, SlotOrder::Shuffled)).into_iter().chain(other)
    {
        let Some(mut backend) = gpu(Raster::EarlyZ) else { return };
        // Pages of 64 points would be thousands at the larger sizes.
        let batches = if page_points == Some(64) { &batches[..11] } else { &batches[..] };
        let total: u32 = batches.iter().sum();
        backend.store_mut().set_page_points(page_points);
        let cloud = Cloud::town(total as usize);
        backend.reset(total.into(), cloud.packing());
        let mut expected: Vec<u32> = Vec::new();
        let view = cloud.camera().view(&cloud.facts.grid, [64, 64], 1).unwrap();
        for (index, &new) in batches.iter().enumerate() {
            let old = expected.len() as u32;
            let insertion = Insertion::in_order(order, old, new, 3, index as u64);
            let batch = cloud.batch(old as usize..(old + new) as usize);
            backend.insert(&insertion, &batch).unwrap();
            let plan = FramePlan {
                view,
                keeps_depths: false,
                averaging: None,
                reproject: true,
                fresh: true,
                fill: [0..0, 0..0],
                shading: Shading::default(),
                colors: Arc::new(vec![FileColor::new(0, ColorRule::Rgb16)].into()),
                mask: None,
                aside: false,
            };
            backend.draw(&plan).unwrap();
            insertion.apply(&mut expected, &batch.records, &insertion.moved_to());
            let points = backend.store_mut().read_points().unwrap();
            let case = format!("{order:?}, pages {page_points:?}, batch {index} of {new} points");
            assert!(points.records[..expected.len()] == expected, "{case}: records");
            let all = cloud.batch(0..total as usize);
            for (slot, &record) in expected.iter().enumerate() {
                assert_eq!(points.positions[slot], all.positions[record as usize], "{case}: slot {slot}");
                assert_eq!(points.colors[slot], all.colors[record as usize], "{case}: slot {slot}");
            }
        }
        let is_arrival = expected.into_iter().eq(0..total);
        assert_eq!(is_arrival, order == SlotOrder::Arrival, "the comparison can fail: the orders differ");
    }
}

/// The same pictures, pixel for pixel, with pages of 1,000 points as with one page.
#[test]
fn pages_change_nothing() {
    for raster in RASTERS {
        let pictures: Vec<Picture> = [None, Some(1000)]
            .into_iter()
            .filter_map(|page_points| {
                let mut backend = gpu(raster)?;
                backend.store_mut().set_page_points(page_points);
                let r = Run { points: 30_001, insertion_points: 4097, point_size: 2, fill: 7_777, size: [160, 120] };
                Some(run(Box::new(backend), &r).0)
            })
            .collect();
        if let [whole, paged] = &pictures[..] {
            assert!(whole == paged, "{raster}: {} pixels differ", differing(&whole.records, &paged.records));
        }
    }
}

#[test]
fn one_page() {
    check(Run { points: 150_001, insertion_points: 10_000, point_size: 1, fill: 40_001, size: [320, 240] }, None);
}

#[test]
fn pages_of_a_thousand_points() {
    check(Run { points: 20_007, insertion_points: 4097, point_size: 2, fill: 7_777, size: [160, 120] }, Some(1000));
}

#[test]
fn large_points() {
    check(Run { points: 5_000, insertion_points: 333, point_size: 8, fill: 999, size: [97, 61] }, None);
}

#[test]
fn few_points() {
    for points in [1, 2, 31, 33, 255, 257] {
        check(Run { points, insertion_points: 32, point_size: 3, fill: 5, size: [33, 31] }, Some(64));
    }
}
