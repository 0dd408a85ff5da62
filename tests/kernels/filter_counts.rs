//! Filters on real scans: as many points as laspy, an independent reader, says.

use std::{
    collections::{BTreeMap, HashSet},
    path::{Path, PathBuf},
};

use firstlight::{
    render::{
        Backend, Camera, Clip, CpuBackend, FillBudget, Filter, FrameRequest, Progressive, Raster, Shading, StoreOptions,
    },
    source::{Event, Fields, OpenOptions, open},
};

use crate::backends::gpu;

/// Made by tests/reference/laspy_counts.py.
const COUNTS: &str = include_str!("../reference/filter_counts.tsv");

/// The folder of real scans, if there is one.
fn data() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = std::env::var_os("FIRSTLIGHT_DATA").map_or(beside, PathBuf::from);
    if !folder.is_dir() {
        eprintln!("SKIPPED: no real scans in {} (FIRSTLIGHT_DATA names another folder)", folder.display());
        return None;
    }
    Some(folder)
}

/// What options as `firstlight render` takes them say.
fn parse(options: &str) -> (Filter, Clip) {
    let (mut filter, mut clip) = Default::default();
    let words: Vec<&str> = options.split(' ').collect();
    for pair in words.chunks_exact(2) {
        let (filter, clip): (&mut Filter, &mut Clip) = (&mut filter, &mut clip);
        match pair[0] {
            "--filter" => filter.clauses.push(pair[1].parse().unwrap()),
            "--clip" => clip.bounds = Some(pair[1].parse().unwrap()),
            "--slab" => clip.slab = Some(pair[1].parse().unwrap()),
            other => panic!("{other}"),
        }
    }
    (filter, clip)
}

/// Loads a scan with all that its points have; then how many points each of these options shows.
fn counts(mut backend: Box<dyn Backend>, scan: &Path, options: &[&str]) -> Vec<u64> {
    let stream = open(&[scan.into()], OpenOptions { fields: Some(Fields::ALL), ..Default::default() });
    backend.resize([16, 16]).unwrap();
    let parsed: Vec<(Filter, Clip)> = options.iter().map(|options| parse(options)).collect();
    let mut progressive = Progressive::new(backend, StoreOptions { insertion_points: 10_000, ..Default::default() });
    let mut request = None;
    for event in stream.events() {
        match event {
            Event::Opened(facts) => {
                progressive.open(facts.clone());
                let needed = parsed.iter().flat_map(|(filter, _)| filter.attributes().cloned());
                progressive.carry(needed.collect::<HashSet<_>>());
                let view = Camera::fit(&facts.bounds, &facts.grid, 1.0).view(&facts.grid, [16, 16], 1).unwrap();
                request = Some(FrameRequest { view, fill: FillBudget::Fixed(1000), shading: Shading::default() });
            }
            Event::Batch(batch) => progressive.offer(batch),
            Event::Finished(_) => progressive.end_of_input(),
            Event::Failed(error) => panic!("{error}"),
        }
    }
    let request = request.unwrap();
    let mut shown = Vec::new();
    for (filter, clip) in &parsed {
        progressive.set_filter(filter, clip);
        loop {
            let frame = progressive.frame(&request).unwrap();
            // The same rules as before, differently written, draw nothing anew.
            if progressive.is_loaded() && (frame.drawn || frame.is_converged()) {
                break;
            }
        }
        shown.push(progressive.wait_for_points_shown().unwrap().expect("a number"));
    }
    shown
}

#[test]
fn as_many_points_as_laspy_says() {
    let Some(folder) = data() else { return };
    let mut scans: BTreeMap<&str, Vec<(&str, u64)>> = BTreeMap::new();
    for line in COUNTS.lines().skip(1) {
        let [scan, options, points] = line.split('\t').collect::<Vec<_>>()[..] else { panic!("{line}") };
        scans.entry(scan).or_default().push((options, points.parse().unwrap()));
    }
    let mut wrong = Vec::new();
    let mut checked = 0;
    for (scan, cases) in scans {
        let options: Vec<&str> = cases.iter().map(|case| case.0).collect();
        let mut backends: Vec<(&str, Box<dyn Backend>)> = vec![("cpu", Box::new(CpuBackend::new(Some(2))))];
        backends.extend(gpu(Raster::EarlyZ).map(|gpu| ("gpu", Box::new(gpu) as Box<dyn Backend>)));
        for (name, backend) in backends {
            for (shown, (options, points)) in counts(backend, &folder.join(scan), &options).into_iter().zip(&cases) {
                checked += 1;
                if shown != *points {
                    wrong.push(format!("{name}, {scan} {options}: {shown} shown, laspy says {points}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {checked}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(checked > 300);
}
