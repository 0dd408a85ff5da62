//! High-quality shading: every backend's sums against the definition, progressive averages against those
//! of all points at once.

use std::sync::Arc;

use firstlight::{
    render::{
        AVERAGED_DEPTH, Averaging, Backend, BackendInfo, Camera, ColumnId, CpuBackend, FileColor, FillBudget,
        FramePlan, FrameRequest, GpuBackend, Keys, PassTimes, Picture, Progressive, Raster, RenderError, Shading, Sums,
        View,
    },
    scene::{ColorRule, PointBatch},
    store::{Insertion, Packing},
};

use crate::{
    backends::{self, gpu},
    cloud::Cloud,
    convergence::{Session, covered, difference, options, request},
};

pub fn high(mut request: FrameRequest) -> FrameRequest {
    request.shading.high_quality = true;
    request
}

fn unlit(mut request: FrameRequest) -> FrameRequest {
    request.shading.edl_strength = 0.0;
    request
}

/// Red, green, blue and number of the fragments of each pixel within `window` times its front depth, the
/// front among them.
fn definition(cloud: &Cloud, view: &View, window: f32) -> Vec<[u64; 4]> {
    let [width, height] = [view.width as i32, view.height as i32];
    let colors = cloud.batch(0..cloud.len()).colors;
    let mut fragments: Vec<Vec<(f32, [u64; 3])>> = vec![Vec::new(); (width * height) as usize];
    for (&position, color) in cloud.positions().iter().zip(&colors) {
        let Some(point) = view.project(position) else { continue };
        let rgb = [0, 1, 2].map(|c| u64::from(color[c] >> 8));
        for k in 0..(view.point_size * view.point_size) as i32 {
            let size = view.point_size as i32;
            let [x, y] = [point.corner[0] + k % size, point.corner[1] + k / size];
            if (0..width).contains(&x) && (0..height).contains(&y) {
                fragments[(y * width + x) as usize].push((point.depth, rgb));
            }
        }
    }
    let sums = |pixel: Vec<(f32, [u64; 3])>| {
        let front = pixel.iter().map(|f| f.0).fold(f32::INFINITY, f32::min);
        let blended = pixel.iter().filter(|f| f.0 <= front * window);
        blended.fold([0; 4], |sum, (_, rgb)| [sum[0] + rgb[0], sum[1] + rgb[1], sum[2] + rgb[2], sum[3] + 1])
    };
    fragments.into_iter().map(sums).collect()
}

/// The mean colour, rounded to the nearest.
fn mean([r, g, b, count]: [u64; 4]) -> [u8; 4] {
    let mean = |sum: u64| ((2 * sum + count) / (2 * count)) as u8;
    [mean(r), mean(g), mean(b), 255]
}

/// Pixels that a picture does not show as the definition says.
fn unlike(picture: &Picture, sums: &[[u64; 4]], background: [u8; 3]) -> usize {
    let [r, g, b] = background;
    let expected = |sum: &[u64; 4]| if sum[3] == 0 { [r, g, b, 255] } else { mean(*sum) };
    picture.rgba.iter().zip(sums).filter(|(rgba, sum)| **rgba != expected(sum)).count()
}

/// A backend whose sums can be read.
enum Summing {
    Cpu(Box<CpuBackend>),
    Gpu(Box<GpuBackend>),
}

impl Summing {
    fn backend(&mut self) -> &mut dyn Backend {
        match self {
            Summing::Cpu(cpu) => &mut **cpu,
            Summing::Gpu(gpu) => &mut **gpu,
        }
    }

    fn sums(&self) -> Vec<[u64; 4]> {
        match self {
            Summing::Cpu(cpu) => cpu.read_sums(),
            Summing::Gpu(gpu) => gpu.read_sums().unwrap(),
        }
    }
}

fn summing(page_points: Option<u32>) -> Vec<(String, Summing)> {
    let mut all = vec![
        ("cpu, 1 thread".to_owned(), Summing::Cpu(Box::new(CpuBackend::new(Some(1))))),
        ("cpu, 3 threads".to_owned(), Summing::Cpu(Box::new(CpuBackend::new(Some(3))))),
    ];
    let mut add = |name: &str, gpu: Option<GpuBackend>| {
        if let Some(mut gpu) = gpu {
            gpu.store_mut().set_page_points(page_points);
            all.push((format!("{name}, {}", gpu.sums()), Summing::Gpu(Box::new(gpu))));
        }
    };
    add("gpu", gpu(Raster::EarlyZ));
    add("gpu without 64-bit additions", backends::without(wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS));
    all
}

/// Draws all points of `cloud` at once; the sums, with the front points added, and the picture.
fn draw_all(backend: &mut Summing, cloud: &Cloud, view: View) -> (Vec<[u64; 4]>, Picture) {
    let colors = cloud.batch(0..cloud.len()).colors;
    let count = cloud.len() as u32;
    let request = unlit(high(FrameRequest { view, fill: FillBudget::Fixed(0), shading: Default::default() }));
    let target = backend.backend();
    target.reset(count.into(), cloud.packing());
    target.insert(&Insertion::new(0, count, 3, 0), &cloud.batch(0..cloud.len())).unwrap();
    let plan = FramePlan {
        view,
        keeps_depths: false,
        reproject: false,
        fresh: false,
        fill: [0..count, 0..0],
        shading: request.shading,
        colors: Arc::new(vec![FileColor::new(0, ColorRule::Rgb16)].into()),
        averaging: Some(Averaging { begins: true, lists: false, slots: [0..count, 0..0] }),
        mask: None,
        aside: false,
    };
    target.draw(&plan).unwrap();
    let picture = target.read().unwrap();
    let mut sums = backend.sums();
    for (sum, &record) in sums.iter_mut().zip(&picture.records) {
        if record < 0 {
            assert_eq!(*sum, [0; 4], "nothing is summed up where nothing is");
        } else {
            (0..3).for_each(|c| sum[c] += u64::from(colors[record as usize][c] >> 8));
            sum[3] += 1;
        }
    }
    (sums, picture)
}

#[test]
fn sums_equal_the_definition() {
    let mut differ_with_another_window = 0;
    for page_points in [None, Some(64), Some(1000)] {
        for (name, mut backend) in summing(page_points) {
            // Elsewhere rounding may decide which pixel a point's square begins in: 3 pixels more, 3 less.
            let is_exact = name.starts_with("cpu") || backend.backend().info().adapter.starts_with("llvmpipe");
            let allowed = if is_exact { 0 } else { 6 + 83 * 61 / 50 };
            for count in [1, 2, 31, 32, 33, 255, 256, 257, 999, 1000, 1001, 4097] {
                let cloud = Cloud::town(count);
                for (point_size, distance) in [(1, 1.0), (2, 4.0), (3, 1.0)] {
                    let camera = Camera::fit(&cloud.facts.bounds, &cloud.facts.grid, 1.3);
                    let away = |a: usize| camera.target[a] + distance * (camera.eye[a] - camera.target[a]);
                    let camera = Camera { eye: std::array::from_fn(away), ..camera };
                    let view = camera.view(&cloud.facts.grid, [83, 61], point_size).unwrap();
                    let (sums, picture) = draw_all(&mut backend, &cloud, view);
                    let expected = definition(&cloud, &view, AVERAGED_DEPTH);
                    let case = format!("{name}, pages {page_points:?}, {count} points of {point_size} pixels");
                    let off = sums.iter().zip(&expected).filter(|(a, b)| a != b).count();
                    assert!(off <= allowed, "{case}: {off} pixels");
                    let background = Shading::default().background;
                    assert!(unlike(&picture, &expected, background) <= allowed, "{case}");
                    let wrong = definition(&cloud, &view, 1.02);
                    differ_with_another_window += unlike(&picture, &wrong, background);
                }
            }
        }
    }
    assert!(differ_with_another_window > 1000, "2 % would do as well: {differ_with_another_window} pixels differ");
}

/// A word of sums is handed over at 64 fragments; published packings overflow at 255 and 1,023.
#[test]
fn thousands_of_fragments_in_a_pixel() {
    let cloud = Cloud::town(60_000);
    let fit = cloud.camera();
    for distance in [3.0, 12.0, 60.0] {
        let away = |a: usize| fit.target[a] + distance * (fit.eye[a] - fit.target[a]);
        let camera = Camera { eye: std::array::from_fn(away), ..fit };
        let view = camera.view(&cloud.facts.grid, [64, 48], 1).unwrap();
        let expected = definition(&cloud, &view, AVERAGED_DEPTH);
        let most = expected.iter().map(|sum| sum[3]).max().unwrap();
        let around = expected.iter().filter(|sum| (56..72).contains(&sum[3])).count();
        eprintln!("at {distance} times the distance: up to {most} fragments a pixel, {around} pixels near 64");
        assert!(if distance == 3.0 { around > 5 } else { most > 1023 });
        for (name, mut backend) in summing(None) {
            let (sums, _) = draw_all(&mut backend, &cloud, view);
            assert!(sums == expected, "{name}, {distance} times the distance");
        }
    }
}

#[test]
fn the_device_decides_how_sums_are_kept() {
    let Some(all) = gpu(Raster::EarlyZ) else { return };
    let less = backends::without(wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS).expect("the same device with less");
    assert_eq!(less.sums(), Sums::Hqs);
    assert!(all.sums() == Sums::Hqs1r || all.sums() == Sums::Hqs);
    assert_eq!(CpuBackend::new(None).sums(), Sums::Hqs);
}

#[test]
fn a_still_camera_converges_to_the_averages_of_all_points() {
    let cloud = Cloud::town(60_000);
    for (point_size, insertion_points) in [(1, 65_536), (2, 1000), (3, 7777)] {
        for mut session in Session::all(&cloud, options(insertion_points)) {
            let plain = request(&cloud, &cloud.camera(), point_size, 9001);
            session.offer(&cloud, 0..cloud.len(), 5000);
            session.progressive.end_of_input();
            let case = format!("size {point_size}, insertions of {insertion_points}");
            let average = session.assert_exact(&high(plain.clone()), &case);
            // Switched off and on again, at rest.
            let front = session.assert_exact(&plain, &case);
            assert!(difference(&front, &average).is_some(), "{}, {case}: averages change nothing", session.name);
            assert_eq!((front.records, front.depth), (average.records.clone(), average.depth.clone()));
            let again = session.assert_exact(&high(plain.clone()), &case);
            assert_eq!(difference(&again, &average), None, "{}, {case}", session.name);
        }
    }
}

#[test]
fn averages_converge_after_loading_and_moving() {
    let cloud = Cloud::town(40_000);
    for mut session in Session::all(&cloud, options(1000)) {
        let at = |step: usize, size| high(request(&cloud, &cloud.camera_moved(step), size, 3000));
        for step in 0..10 {
            session.offer(&cloud, step * 4000..(step + 1) * 4000, 900);
            session.frame(&at(step, 2));
        }
        session.progressive.end_of_input();
        session.assert_exact(&at(9, 2), "moved mid-load");
        for step in 0..4 {
            session.frame(&at(step, 1));
            session.assert_exact(&at(step, 1 + step as u32 % 3), &format!("moved after loading, step {step}"));
        }
        // Interrupted half-way through the averages.
        let view = cloud.camera().view(&cloud.facts.grid, [97, 31], 2).unwrap();
        for _ in 0..40_000 / 3000 + 3 {
            session.frame(&at(2, 2));
        }
        let report = session.frame(&at(2, 2));
        assert!((1..40_000).contains(&report.points_averaged), "{}: {report:?}", session.name);
        session.assert_exact(&FrameRequest { view, ..at(2, 2) }, "another size");
    }
}

/// Batches arrive one by one, and each time all is tried and averaged before the next.
#[test]
fn averages_begin_anew_with_every_insertion() {
    let cloud = Cloud::town(20_000);
    for mut session in Session::all(&cloud, options(1000)) {
        let request = high(request(&cloud, &cloud.camera(), 2, 50_000));
        for start in (0..cloud.len()).step_by(2000) {
            session.offer(&cloud, start..start + 2000, 1000);
            for _ in 0..4 {
                session.frame(&request);
            }
            let seen = session.read();
            let all = session.brute_force(&request);
            assert!(covered(&all) > 100);
            // Ties are open while points move: another slot of the same depth may be the front.
            let unlike = seen.rgba.iter().zip(&all.rgba).filter(|(a, b)| a != b).count();
            assert_eq!(unlike, 0, "{}, {} points", session.name, start + 2000);
        }
        session.progressive.end_of_input();
        session.assert_exact(&request, "batch by batch");
    }
}

#[test]
fn nothing_is_drawn_once_the_averages_are_final() {
    let cloud = Cloud::town(10_000);
    for mut session in Session::all(&cloud, options(3000)) {
        let mut request = high(request(&cloud, &cloud.camera(), 2, 2500));
        session.offer(&cloud, 0..cloud.len(), 1000);
        session.progressive.end_of_input();
        let mut half_way = 0;
        let picture = session.converge(&request, |_| half_way += 1);
        assert!(half_way > 7, "{}: depths take four frames, averages nearly as many", session.name);
        let report = session.frame(&request);
        assert!(!report.drawn && report.is_converged(), "{}: {report:?}", session.name);
        assert_eq!(report.points_averaged, 10_000);
        assert_eq!(difference(&session.read(), &picture), None);
        request.shading.edl_strength = 0.0;
        let report = session.frame(&request);
        assert!(report.drawn && report.is_converged(), "{}: other lighting needs no other sums", session.name);
        let lit_otherwise = session.read();
        assert_eq!(difference(&session.brute_force(&request), &lit_otherwise), None, "{}", session.name);
        request.shading.high_quality = false;
        assert!(session.frame(&request).drawn);
        assert!(!session.frame(&request).drawn);
        request.shading.high_quality = true;
        let report = session.frame(&request);
        assert!(report.drawn && !report.is_converged(), "{}: {report:?}", session.name);
    }
}

/// Sum of all channels' differences.
fn distance(a: &Picture, b: &Picture) -> u64 {
    let channels = |picture: &Picture| picture.rgba.iter().flatten().copied().collect::<Vec<u8>>();
    channels(a).iter().zip(channels(b)).map(|(a, b)| u64::from(a.abs_diff(b))).sum()
}

#[test]
fn the_error_falls_to_zero() {
    let cloud = Cloud::town(60_000).in_random_order();
    let fit = cloud.camera();
    let away = |a: usize| fit.target[a] + 4.0 * (fit.eye[a] - fit.target[a]);
    let camera = Camera { eye: std::array::from_fn(away), ..fit };
    for mut session in Session::all(&cloud, options(65_536)) {
        let near = unlit(high(request(&cloud, &fit, 1, 7500)));
        let request = unlit(high(request(&cloud, &camera, 1, 7500)));
        session.offer(&cloud, 0..cloud.len(), 65_536);
        session.progressive.end_of_input();
        session.converge(&near, |_| ());
        let mut pictures = Vec::new();
        loop {
            let report = session.frame(&request);
            pictures.push((report.points_averaged, session.read()));
            if session.progressive.is_loaded() && report.is_converged() {
                break;
            }
        }
        let truth = session.brute_force(&request);
        let errors: Vec<u64> = pictures.iter().map(|(_, picture)| distance(picture, &truth)).collect();
        eprintln!("{}: error after each frame {errors:?}", session.name);
        assert_eq!(errors.last(), Some(&0));
        // From the frame on whose depths are final, each frame brings the averages nearer.
        let averaging: Vec<u64> =
            pictures.iter().zip(&errors).filter(|((points, _), _)| *points > 0).map(|(_, &error)| error).collect();
        assert_eq!(averaging.len(), 8, "60,000 points, 7,500 a frame");
        assert!(averaging.windows(2).all(|pair| pair[1] < pair[0]), "{}: {averaging:?}", session.name);
        // And the frames before are not far off: no jump when the camera comes to rest.
        let before = errors[errors.len() - averaging.len() - 1];
        assert!(averaging[0] * 2 < before * 3, "{}: from {before} to {}", session.name, averaging[0]);
        let mut plain = request;
        plain.shading.high_quality = false;
        let front = distance(&session.brute_force(&plain), &truth);
        assert!(errors[0] < front, "{}: {} at first, {front} without averages", session.name, errors[0]);
    }
}

/// Frames in motion, while points arrive: the sums of lists, in which a point may be that is also in the
/// span of the fill, are those of the twin.
#[test]
fn frames_in_motion_equal_their_twin() {
    let cloud = Cloud::town(30_000);
    let mut twin: Vec<(Vec<[u64; 4]>, Vec<i64>)> = Vec::new();
    for (name, backend) in summing(Some(4097)) {
        let mut progressive = Progressive::new(backend, options(2000));
        progressive.open(Arc::new(cloud.facts.clone()));
        for step in 0..12 {
            if step < 6 {
                progressive.offer(cloud.batch(step * 5000..(step + 1) * 5000));
            } else {
                progressive.end_of_input();
            }
            let camera = cloud.camera_moved(step % 4);
            let away = |a: usize| camera.target[a] + 3.0 * (camera.eye[a] - camera.target[a]);
            let camera = Camera { eye: std::array::from_fn(away), ..camera };
            let request = high(request(&cloud, &camera, 1 + step as u32 % 3, 9000));
            let report = progressive.frame(&request).unwrap();
            assert!(report.drawn);
            let records = progressive.read().unwrap().records;
            let sums = progressive.backend().sums();
            let all = definition(&cloud, &request.view, f32::INFINITY);
            let counts = |sums: &[[u64; 4]]| sums.iter().map(|sum| sum[3]).sum::<u64>();
            assert!(counts(&sums) > 100, "{name}, step {step}: there is something to compare");
            let twice = sums.iter().zip(&all).filter(|(sum, all)| all[3] > 0 && sum[3] >= all[3]).count();
            assert_eq!(twice, 0, "{name}, step {step}: points counted twice");
            match twin.get(step) {
                None => twin.push((sums, records)),
                Some((expected, fronts)) => {
                    assert!(*fronts == records, "{name}, step {step}: other fronts");
                    assert!(*expected == sums, "{name}, step {step}: other sums");
                }
            }
        }
    }
}

impl Backend for Summing {
    fn info(&self) -> &BackendInfo {
        match self {
            Summing::Cpu(cpu) => cpu.info(),
            Summing::Gpu(gpu) => gpu.info(),
        }
    }
    fn sums(&self) -> Sums {
        match self {
            Summing::Cpu(cpu) => cpu.sums(),
            Summing::Gpu(gpu) => gpu.sums(),
        }
    }
    fn reset(&mut self, points: u64, packing: Option<Packing>) {
        self.backend().reset(points, packing);
    }
    fn insertions_per_frame(&self) -> usize {
        // The same for all, so that all insert the same in each frame.
        8
    }
    fn resize(&mut self, size: [u32; 2]) -> Result<(), RenderError> {
        self.backend().resize(size)
    }
    fn insert(&mut self, insertion: &Insertion, points: &PointBatch) -> Result<(), RenderError> {
        self.backend().insert(insertion, points)
    }
    fn fill_column(&mut self, column: ColumnId, records: &[u32], keys: Keys<'_>) -> Result<(), RenderError> {
        self.backend().fill_column(column, records, keys)
    }
    fn drop_column(&mut self, column: ColumnId) {
        self.backend().drop_column(column);
    }
    fn set_relocation(&mut self, on: bool) {
        self.backend().set_relocation(on);
    }
    fn draw(&mut self, plan: &FramePlan) -> Result<(), RenderError> {
        self.backend().draw(plan)
    }
    fn pass_times(&mut self) -> Option<PassTimes> {
        self.backend().pass_times()
    }
    fn wait(&mut self) -> Result<(), RenderError> {
        self.backend().wait()
    }
    fn read(&mut self) -> Result<Picture, RenderError> {
        self.backend().read()
    }
}
