//! Filters, clipping boxes and slabs: the bits of every backend against the definition, and filtered pictures against
//! those of a scene that has no other points.

use std::sync::Arc;

use firstlight::{
    render::{
        Backend, Clause, Clip, ClipBox, CpuBackend, Filter, FrameRequest, MaskRules, Picture, Place, Progressive,
        Raster, Slab,
    },
    scene::{Attribute, FileFacts, PointBatch, SceneFacts},
};

use crate::{
    backends::gpu,
    cloud::Cloud,
    convergence::{Session, covered, difference, options, request},
    high_quality::high,
};

/// The town is 100 m wide; a second file begins with the record in its middle.
fn town(points: usize) -> Cloud {
    let mut cloud = Cloud::town(points);
    let files = &mut cloud.facts.files;
    files[0].points_in_header = points as u64 / 2;
    files[0].record.has_intensities = true;
    files.push(FileFacts { first_record: points as u32 / 2, ..files[0].clone() });
    cloud
}

fn filter(clauses: &[&str]) -> Filter {
    Filter { clauses: clauses.iter().map(|clause| clause.parse().expect("a clause")).collect() }
}

/// Borders of levels lie halfway between two steps of the grid.
fn cases() -> Vec<(Filter, Clip)> {
    let slab = Slab { point: [50.0, 50.0, 0.0], normal: [0.6, -0.8, 0.1], thickness: 30.0 };
    let turned = ClipBox { min: [20.0, 10.0, -2.0005], max: [90.0, 60.0, 8.0005], degrees: 33.0 };
    let level = ClipBox { degrees: 0.0, ..turned };
    let clip = |bounds, slab| Clip { bounds, slab };
    let nothing = Clip::default();
    vec![
        (filter(&["elevation=-1.0005..2.0005,7.9995..8.0005"]), nothing),
        (filter(&["elevation!=-1.0005..2.0005", "intensity=1000..30000"]), nothing),
        (filter(&["intensity!=0..999,5000..60000"]), nothing),
        (filter(&["file=1", "intensity=..40000"]), nothing),
        (filter(&["file!=1,7"]), clip(Some(level), None)),
        (filter(&[]), clip(Some(turned), None)),
        (filter(&[]), clip(None, Some(slab))),
        (filter(&["elevation=-0.5005.."]), clip(Some(turned), Some(slab))),
        (filter(&["elevation=500.."]), nothing),
        (filter(&["classification!=7"]), nothing),
    ]
}

/// The definition, in f64: whether a point is shown. None where rounding may decide.
fn shows((filter, clip): &(Filter, Clip), facts: &SceneFacts, points: &PointBatch, i: usize) -> Option<bool> {
    let world = facts.grid.world(points.positions[i]);
    let mut shown = true;
    for clause in &filter.clauses {
        let value = match clause.attribute.to_string().as_str() {
            "elevation" => world[2],
            "intensity" => points.colors[i][3].into(),
            "file" => f64::from(u8::from(points.records[i] >= facts.files[1].first_record)),
            // Not read.
            _ => return Some(false),
        };
        shown &= clause.holds(value);
    }
    let mut margin = f64::INFINITY;
    let mut within = |distance: f64, reach: f64| {
        margin = margin.min((distance.abs() - reach).abs());
        shown &= distance.abs() < reach;
    };
    if let Some(b) = &clip.bounds {
        let (c, (sin, cos)) = (b.center(), b.degrees.to_radians().sin_cos());
        let (x, y) = (world[0] - c[0], world[1] - c[1]);
        within(x * cos + y * sin, 0.5 * (b.max[0] - b.min[0]));
        within(y * cos - x * sin, 0.5 * (b.max[1] - b.min[1]));
        within(world[2] - c[2], 0.5 * (b.max[2] - b.min[2]));
    }
    if let Some(s) = &clip.slab {
        let length = s.normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        within((0..3).map(|k| (world[k] - s.point[k]) * s.normal[k] / length).sum(), 0.5 * s.thickness);
    }
    (margin > 1e-4).then_some(shown)
}

/// A scene in a backend of its own kind, so that its bits can be read.
fn load<B: Backend>(backend: B, cloud: &Cloud, piece: u32) -> Progressive<B> {
    let mut progressive = Progressive::new(backend, options(piece));
    progressive.open(Arc::new(cloud.facts.clone()));
    progressive.offer(cloud.batch(0..cloud.len()));
    progressive.end_of_input();
    progressive
}

/// The GPU's bits and the processor's after every frame, which insert `piece` points each or more.
fn check_bits(points: usize, page_points: Option<u32>, piece: u32, case: &(Filter, Clip)) {
    let cloud = town(points);
    let mut cpu = load(CpuBackend::new(Some(2)), &cloud, piece);
    cpu.set_filter(&case.0, &case.1);
    let request = request(&cloud, &cloud.camera(), 1, 100);
    let Some(mut backend) = gpu(Raster::EarlyZ) else { return };
    backend.store_mut().set_page_points(page_points);
    let mut gpu = load(backend, &cloud, piece);
    gpu.set_filter(&case.0, &case.1);
    let at = |stored| format!("{stored} of {points} points, pages {page_points:?}, {case:?}");
    loop {
        let stored = gpu.frame(&request).unwrap().points_stored as usize;
        while cpu.points_stored() < stored as u64 {
            cpu.frame(&request).unwrap();
        }
        let hidden = gpu.backend().read_hidden().unwrap();
        if cpu.points_stored() == stored as u64 {
            assert_eq!(hidden, cpu.backend().read_hidden(), "{}", at(stored));
        }
        let held = gpu.backend_mut().store_mut().read_points().unwrap();
        assert_eq!(hidden.len(), stored);
        for (slot, &is_hidden) in hidden.iter().enumerate() {
            if let Some(shown) = shows(case, &cloud.facts, &held, slot) {
                assert_eq!(!is_hidden, shown, "{}: slot {slot}", at(stored));
            }
        }
        let shown = hidden.iter().filter(|hidden| !**hidden).count() as u64;
        assert_eq!(gpu.wait_for_points_shown().unwrap().unwrap(), shown, "{}", at(stored));
        if gpu.is_loaded() {
            return;
        }
    }
}

#[test]
fn bits_of_all_sizes_are_those_of_the_definition() {
    for case in [1, 3, 7] {
        for points in [1, 2, 31, 32, 33, 255, 256, 257, 999, 1000, 1001, 4097] {
            check_bits(points, Some(1000), 300, &cases()[case]);
        }
    }
    for case in &cases() {
        check_bits(20_000, Some(4096), 3001, case);
    }
    check_bits(150_000, None, 65_536, &cases()[7]);
}

#[test]
fn an_empty_scene_can_be_filtered() {
    let cloud = town(10);
    for mut session in Session::all(&cloud, options(100)) {
        session.progressive.set_filter(&filter(&["intensity=1.."]), &Clip::default());
        let request = request(&cloud, &cloud.camera(), 1, 100);
        session.frame(&request);
        session.progressive.end_of_input();
        session.frame(&request);
        assert_eq!(covered(&session.read()), 0);
    }
}

/// The town's batches have intensities, and nothing else.
fn place(attribute: &Attribute) -> Place {
    if *attribute == Attribute::Intensity { Place::Slots } else { Place::Nowhere }
}

/// The points that a case shows, as a scene of their own; records are those of the whole.
fn shown_alone(cloud: &Cloud, case: &(Filter, Clip)) -> PointBatch {
    let rules = MaskRules::new(&case.0, &case.1, &cloud.facts, place).expect("tests");
    let mut batch = cloud.batch(0..cloud.len());
    let shown: Vec<usize> = (0..cloud.len())
        .filter(|&i| rules.show(batch.positions[i], batch.colors[i], batch.records[i], |_| 0))
        .collect();
    batch.positions = shown.iter().map(|&i| batch.positions[i]).collect();
    batch.colors = shown.iter().map(|&i| batch.colors[i]).collect();
    batch.records = shown.iter().map(|&i| batch.records[i]).collect();
    batch
}

/// What a picture shows but for which of several points of equal depth it is: that is up to their slots.
fn depths(picture: &Picture) -> Vec<u32> {
    picture.depth.iter().map(|depth| depth.to_bits()).collect()
}

#[test]
fn a_converged_picture_is_that_of_the_shown_points() {
    let cloud = town(30_000);
    for (n, case) in cases().iter().enumerate() {
        let alone = shown_alone(&cloud, case);
        for mut session in Session::all(&cloud, options(7777)) {
            let request = request(&cloud, &cloud.camera_moved(n % 4), 1 + n as u32 % 3, 5003);
            session.progressive.set_filter(&case.0, &case.1);
            session.offer(&cloud, 0..cloud.len(), 5000);
            session.progressive.end_of_input();
            let picture = session.assert_exact(&request, &format!("case {n}"));
            let facts = &cloud.facts;
            session.progressive.open(Arc::new(facts.clone()));
            session.progressive.set_filter(&Filter::default(), &Clip::default());
            session.progressive.offer(alone.clone());
            session.progressive.end_of_input();
            let truth = session.assert_exact(&request, &format!("case {n}, alone"));
            assert_eq!(depths(&picture), depths(&truth), "{}, case {n}", session.name);
            assert_eq!(covered(&picture) > 50, n < 8, "{}, case {n}: {}", session.name, covered(&picture));
            let is_shown = |record: &&i64| **record < 0 || alone.records.binary_search(&(**record as u32)).is_ok();
            assert!(picture.records.iter().all(|record| is_shown(&record)), "{}, case {n}", session.name);
        }
    }
}

/// Loads in small batches with a frame after each; `switch` may set another filter then.
fn load_slowly(
    session: &mut Session,
    cloud: &Cloud,
    request: &FrameRequest,
    mut switch: impl FnMut(&mut Session, usize),
) {
    for (n, start) in (0..cloud.len()).step_by(1500).enumerate() {
        switch(session, n);
        session.offer(cloud, start..cloud.len().min(start + 1500), 1500);
        session.frame(request);
    }
    session.progressive.end_of_input();
}

#[test]
fn a_filter_switched_while_loading_is_one_from_the_start() {
    let cloud = town(30_000);
    let cases = cases();
    for point_size in [1, 2] {
        let request = request(&cloud, &cloud.camera(), point_size, 2000);
        for (mut early, mut late) in
            Session::all(&cloud, options(500)).into_iter().zip(Session::all(&cloud, options(500)))
        {
            early.progressive.set_filter(&cases[7].0, &cases[7].1);
            load_slowly(&mut early, &cloud, &request, |_, _| ());
            load_slowly(&mut late, &cloud, &request, |session, n| match n {
                3 => session.progressive.set_filter(&cases[1].0, &cases[1].1),
                6 => session.progressive.set_filter(&Filter::default(), &Clip::default()),
                9 => session.progressive.set_filter(&cases[7].0, &cases[7].1),
                _ => {}
            });
            let picture = early.assert_exact(&request, "from the start");
            assert_eq!(difference(&picture, &late.assert_exact(&request, "switched")), None, "{}", late.name);
            // And back, at rest.
            late.progressive.set_filter(&Filter::default(), &Clip::default());
            let all = late.assert_exact(&request, "switched off");
            assert!(covered(&all) > covered(&picture));
            late.progressive.set_filter(&cases[7].0, &cases[7].1);
            assert_eq!(difference(&picture, &late.assert_exact(&request, "switched on")), None, "{}", late.name);
        }
    }
}

#[test]
fn what_is_shown_keeps_its_pixels_while_points_arrive() {
    let cloud = town(20_000);
    let case = &cases()[7];
    let request = request(&cloud, &cloud.camera(), 2, 100);
    for mut session in Session::all(&cloud, options(500)) {
        session.progressive.set_filter(&case.0, &case.1);
        let mut before = 0;
        load_slowly(&mut session, &cloud, &request, |session, _| {
            let picture = session.read();
            assert!(covered(&picture) >= before, "{}: {} after {before}", session.name, covered(&picture));
            before = covered(&picture);
        });
        assert!(before > 300, "{}: {before}", session.name);
    }
}

#[test]
fn averages_are_of_shown_points_alone() {
    let cloud = town(30_000);
    let case = &cases()[5];
    let alone = shown_alone(&cloud, case);
    for mut session in Session::all(&cloud, options(7777)) {
        let mut request = high(request(&cloud, &cloud.camera_moved(1), 3, 3000));
        request.shading.edl_strength = 0.0;
        session.progressive.set_filter(&case.0, &case.1);
        session.offer(&cloud, 0..cloud.len(), 5000);
        session.progressive.end_of_input();
        let picture = session.assert_exact(&request, "filtered");
        session.progressive.set_filter(&Filter::default(), &Clip::default());
        let all = session.assert_exact(&request, "all");
        assert!(difference(&picture, &all).is_some());
        session.progressive.open(Arc::new(cloud.facts.clone()));
        session.progressive.offer(alone.clone());
        session.progressive.end_of_input();
        let truth = session.assert_exact(&request, "alone");
        assert_eq!(picture.rgba, truth.rgba, "{}", session.name);
    }
}

#[test]
fn faces_of_a_clipping_box_belong_to_it() {
    let cloud = town(5000);
    let low = cloud.positions().iter().copied().reduce(|a, b| std::array::from_fn(|k| a[k].min(b[k]))).unwrap();
    let high = cloud.positions().iter().copied().reduce(|a, b| std::array::from_fn(|k| a[k].max(b[k]))).unwrap();
    let (min, max) = (cloud.facts.grid.world(low), cloud.facts.grid.world(high));
    let shown = |bounds: ClipBox| {
        let clip = Clip { bounds: Some(bounds), slab: None };
        let rules = MaskRules::new(&Filter::default(), &clip, &cloud.facts, place).unwrap();
        let batch = cloud.batch(0..cloud.len());
        (0..cloud.len()).filter(|&i| rules.show(batch.positions[i], batch.colors[i], batch.records[i], |_| 0)).count()
    };
    for degrees in [0.0, 360.0, 180.0] {
        assert_eq!(shown(ClipBox { min, max, degrees }), cloud.len(), "{degrees} degrees");
        for a in 0..3 {
            let (mut smaller, mut larger) = (max, min);
            smaller[a] -= 0.0005;
            larger[a] += 0.0005;
            assert!(shown(ClipBox { min, max: smaller, degrees }) < cloud.len(), "{degrees} degrees, axis {a}");
            assert!(shown(ClipBox { min: larger, max, degrees }) < cloud.len(), "{degrees} degrees, axis {a}");
        }
    }
}

/// The comparisons above can fail: other rules give other bits and another picture.
#[test]
fn a_wrong_filter_is_noticed() {
    let cloud = town(20_000);
    let cases = cases();
    let request = request(&cloud, &cloud.camera(), 1, 100_000);
    let look = |case: &(Filter, Clip)| {
        let mut progressive = load(CpuBackend::new(Some(2)), &cloud, 5000);
        progressive.set_filter(&case.0, &case.1);
        while !progressive.is_loaded() || !progressive.frame(&request).unwrap().is_converged() {
            progressive.frame(&request).unwrap();
        }
        (progressive.backend().read_hidden(), progressive.read().unwrap())
    };
    let right = look(&cases[7]);
    let mut wrong = cases[7].clone();
    wrong.0.clauses[0] = "elevation=-0.4005..".parse::<Clause>().unwrap();
    let wrong = look(&wrong);
    assert_ne!(right.0, wrong.0);
    assert!(difference(&right.1, &wrong.1).is_some());
    let off = look(&(Filter::default(), Clip::default()));
    assert!(off.0.is_empty() && difference(&right.1, &off.1).is_some());
}
