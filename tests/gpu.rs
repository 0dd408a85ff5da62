//! The GPU backend against the CPU twins: every rasterizer, page sizes that straddle insertions,
//! point sizes, cameras.

use std::{path::PathBuf, sync::Arc};

use firstlight::{
    render::{
        Backend, Camera, CpuBackend, FileColor, FillBudget, FramePlan, FrameRequest, GpuBackend, Picture, Progressive,
        RasterChoice, Shading, StoreOptions,
    },
    scene::{Bounds, ColorRule, ColorStats, FileFacts, Grid, PointBatch, SceneFacts},
    store::Insertion,
};

const RASTERS: [RasterChoice; 3] = [RasterChoice::Compute, RasterChoice::Compute32, RasterChoice::Hardware];

fn gpu(raster: RasterChoice) -> Option<GpuBackend> {
    match GpuBackend::headless(raster) {
        Ok(backend) => Some(backend),
        Err(error) => {
            assert!(std::env::var_os("FIRSTLIGHT_REQUIRE_GPU").is_none(), "a GPU is required: {error}");
            eprintln!("SKIPPED: {error}");
            None
        }
    }
}

const SIDE: i32 = 40_000;

fn facts(points: u64) -> Arc<SceneFacts> {
    let bounds = Bounds { min: [0.0; 3], max: [f64::from(SIDE) * 0.001; 3] };
    Arc::new(SceneFacts {
        grid: Grid { scale: [0.001; 3], origin: [0.0; 3] },
        bounds,
        files: vec![FileFacts {
            path: PathBuf::from("test"),
            first_record: 0,
            points_in_header: points,
            bounds,
            kind: String::new(),
        }],
    })
}

/// A bumpy surface with duplicates.
fn cloud(points: u32) -> PointBatch {
    let hash =
        |i: u32, k: u32| (i.wrapping_mul(0x9E37_79B1) ^ k.wrapping_mul(0x85EB_CA6B)).wrapping_mul(0xC2B2_AE35) >> 8;
    let mut batch = PointBatch::default();
    for record in 0..points {
        let i = record - record % 3 / 2; // every third point is the one before it, again
        let x = (hash(i, 1) % SIDE as u32) as i32;
        let y = (hash(i, 2) % SIDE as u32) as i32;
        let z = ((x / 1000 * y / 1000) % 17) * 700 + (hash(i, 3) % 50) as i32;
        batch.positions.push([x, y, z]);
        batch.colors.push([hash(record, 4) as u16, hash(record, 5) as u16, hash(record, 6) as u16, 7]);
        batch.records.push(record);
    }
    batch.stats = ColorStats { rgb_max: 65535, ..Default::default() };
    batch
}

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
    let facts = facts(run.points.into());
    progressive.open(facts.clone());
    let fit = Camera::fit(&facts.bounds, &facts.grid, f64::from(run.size[0]) / f64::from(run.size[1]));
    let request = |camera: &Camera| FrameRequest {
        view: camera.view(&facts.grid, run.size, run.point_size).unwrap(),
        fill: FillBudget::Fixed(run.fill),
        shading: Shading::default(),
    };
    progressive.offer(cloud(run.points));
    progressive.end_of_input();
    let mut frames = 0;
    while !progressive.is_loaded() {
        let mut camera = fit;
        camera.eye[0] += f64::from(frames.min(2)) * 0.8;
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
        assert_eq!(differing(&progressive.records, &brute.records), 0, "{raster:?}: progressive against brute force");
        let shown = progressive.records.iter().filter(|&&record| record >= 0).count();
        let different = differing(&progressive.records, &cpu.records);
        eprintln!(
            "{raster:?}, {} points, pages {page_points:?}: {shown} of {n} pixels shown, {different} unlike the CPU",
            r.points
        );
        assert!(shown * 20 > n.min(r.points as usize), "{raster:?}: {shown} of {n} pixels shown");
        // Float rounding may decide a pixel where a device fuses multiplication and addition.
        assert!(different * 1000 <= n, "{raster:?}: {different} of {n} pixels unlike the CPU's");
        let colors: Vec<u8> = progressive.rgba.iter().flatten().copied().collect();
        let expected: Vec<u8> = cpu.rgba.iter().flatten().copied().collect();
        let off = colors.iter().zip(&expected).filter(|(a, b)| a.abs_diff(**b) > 1).count();
        assert!(off * 100 <= n, "{raster:?}: {off} channels off by more than one level");
    }
}

/// The insertion kernels against their twin, slot for slot.
#[test]
fn insertion_equals_its_twin() {
    let batches: [u32; 14] = [1, 1, 2, 31, 32, 33, 255, 256, 257, 1, 4097, 65_536, 70_000, 3];
    for page_points in [None, Some(64), Some(4097)] {
        let Some(mut backend) = gpu(RasterChoice::Compute) else { return };
        // Pages of 64 points would be thousands at the larger sizes.
        let batches = if page_points == Some(64) { &batches[..11] } else { &batches[..] };
        let total: u32 = batches.iter().sum();
        backend.store_mut().set_page_points(page_points);
        backend.reset(total.into());
        let points = cloud(total);
        let mut expected: Vec<u32> = Vec::new();
        let camera = Camera::fit(&facts(1).bounds, &facts(1).grid, 1.0);
        for (index, &new) in batches.iter().enumerate() {
            let old = expected.len() as u32;
            let insertion = Insertion::new(old, new, 3, index as u64);
            let range = old as usize..(old + new) as usize;
            let batch = PointBatch {
                positions: points.positions[range.clone()].to_vec(),
                colors: points.colors[range.clone()].to_vec(),
                records: points.records[range.clone()].to_vec(),
                ..Default::default()
            };
            backend.insert(&insertion, &batch).unwrap();
            let plan = FramePlan {
                view: camera.view(&facts(1).grid, [64, 64], 1).unwrap(),
                reproject: true,
                fresh: true,
                fill: [0..0, 0..0],
                shading: Shading::default(),
                files: vec![FileColor::new(0, ColorRule::Rgb16)],
            };
            backend.draw(&plan).unwrap();
            insertion.apply(&mut expected, &points.records[range], &insertion.moved_to());
            let records = backend.store_mut().read_records().unwrap();
            assert!(records[..expected.len()] == expected, "pages {page_points:?}, batch {index} of {new} points");
        }
        assert_ne!(expected, points.records, "the comparison can fail: this is not the order of arrival");
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
