//! Colours of real files of every point format, held to the values that an independent reader finds in them: see
//! tests/reference/laspy_colors.py.

use std::{
    collections::{BTreeMap, HashMap},
    path::{Path, PathBuf},
    sync::Arc,
};

use firstlight::{
    headless::default_camera,
    render::{Backend, Coloring, CpuBackend, FillBudget, FrameRequest, Progressive, Raster, Shading, StoreOptions},
    scene::{Attribute, PointBatch, SceneFacts},
    source::{Event, Fields, OpenOptions, open},
};

use crate::{backends::gpu, colors::expected};

/// What the independent reader says of an attribute of a file.
struct Reference {
    attribute: Attribute,
    points: u64,
    clipped: [f64; 2],
    extent: [f64; 2],
    /// None of what is not a whole number.
    counts: Option<Vec<(u16, u64)>>,
    samples: BTreeMap<i64, f64>,
}

/// By file.
fn references() -> BTreeMap<&'static str, Vec<Reference>> {
    let mut all: BTreeMap<&str, Vec<Reference>> = BTreeMap::new();
    for line in include_str!("../reference/colors.tsv").lines().skip(1) {
        let columns: Vec<&str> = line.split('\t').collect();
        let number = |text: &str| text.parse::<f64>().unwrap();
        let pairs = |text: &'static str, by: char| text.split(' ').map(move |pair| pair.split_once(by).unwrap());
        let counts = |text| pairs(text, ':').map(|(v, n)| (v.parse().unwrap(), n.parse().unwrap())).collect();
        all.entry(columns[0]).or_default().push(Reference {
            attribute: columns[1].parse().unwrap(),
            points: columns[2].parse().unwrap(),
            clipped: [number(columns[3]), number(columns[4])],
            extent: [number(columns[5]), number(columns[6])],
            counts: (columns[7] != "-").then(|| counts(columns[7])),
            samples: pairs(columns[8], '=').map(|(record, v)| (record.parse().unwrap(), number(v))).collect(),
        });
    }
    all
}

/// The folder of real scans, if it is there; says so loudly if not.
fn data() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let found = std::env::var_os("FIRSTLIGHT_DATA").map_or(beside, PathBuf::from);
    if !found.is_dir() {
        use std::io::Write;
        let _ = writeln!(
            std::io::stderr(),
            "SKIPPED: no real scans: {} is not there (set FIRSTLIGHT_DATA)",
            found.display()
        );
        return None;
    }
    Some(found)
}

fn read(path: &Path) -> (Arc<SceneFacts>, Vec<PointBatch>) {
    let stream = open(&[path.to_owned()], OpenOptions { fields: Some(Fields::ALL), ..Default::default() });
    let (mut facts, mut batches) = (None, Vec::new());
    for event in stream.events() {
        match event {
            Event::Opened(opened) => facts = Some(opened),
            Event::Batch(batch) => batches.push(batch),
            Event::Finished(_) => {}
            Event::Failed(error) => panic!("{error}"),
        }
    }
    (facts.expect("Opened"), batches)
}

#[test]
fn colours_of_real_files_are_those_of_an_independent_readers_values() {
    let Some(data) = data() else { return };
    let mut backends: Vec<Box<dyn Backend>> = vec![Box::new(CpuBackend::new(Some(2)))];
    backends.extend(gpu(Raster::EarlyZ).map(|gpu| Box::new(gpu) as Box<dyn Backend>));
    let mut sessions: Vec<_> =
        backends.into_iter().map(|backend| Progressive::new(backend, StoreOptions::default())).collect();
    let mut seen: HashMap<Attribute, usize> = HashMap::new();
    let mut formats = [0; 11];
    for (name, references) in references() {
        let (facts, batches) = read(&data.join(name));
        formats[usize::from(facts.files[0].record.format)] += 1;
        let camera = default_camera(&facts, batches.first(), [320, 240]);
        let view = camera.view(&facts.grid, [320, 240], 4).unwrap();
        let shading = Shading { edl_strength: 0.0, ..Default::default() };
        let request = FrameRequest { view, fill: FillBudget::Fixed(1_000_000), shading };
        for progressive in &mut sessions {
            progressive.open(facts.clone());
            progressive.carry(references.iter().map(|reference| reference.attribute.clone()));
            batches.iter().for_each(|batch| progressive.offer(batch.clone()));
            progressive.end_of_input();
            while !progressive.frame(&request).unwrap().is_converged() || !progressive.is_loaded() {}
            for Reference { attribute, points, clipped, extent, counts, samples } in &references {
                let case = format!("{name}, {attribute}");
                // A range that does not depend on how values are binned.
                let range = (extent[0] < extent[1]).then_some(*extent);
                let coloring = Coloring { by: attribute.clone().into(), range, ..Default::default() };
                assert_eq!(progressive.lacking([attribute]), [], "{case}");
                progressive.set_coloring(&coloring);
                progressive.frame(&request).unwrap();
                let picture = progressive.read().unwrap();
                for (record, [r, g, b, _]) in picture.records.iter().zip(&picture.rgba) {
                    if let Some(value) = samples.get(record).filter(|_| range.is_some() || attribute.is_categorical()) {
                        let colors = expected(&coloring, attribute, Some(*value), *extent);
                        assert!(colors.contains(&[*r, *g, *b]), "{case}: record {record}, {value}: {:?}", [r, g, b]);
                        *seen.entry(attribute.clone()).or_default() += 1;
                    }
                }
                // The statistics: of intensities and of large scenes' elevations only a sample is counted.
                if *attribute == Attribute::Intensity {
                    continue;
                }
                let stats = progressive.stats(attribute).unwrap();
                assert_eq!(stats.total(), *points, "{case}");
                if let Some(counts) = counts {
                    assert_eq!(progressive.counts(attribute), *counts, "{case}");
                }
                progressive.set_coloring(&Coloring { range: None, ..coloring });
                let scale = progressive.scale(attribute);
                // Two bins: the value lies in one, the border is that of its neighbour.
                let bin = if counts.is_some() { 0.0 } else { (extent[1] - extent[0]) / 4096.0 };
                let is_near = |found: f64, expected: f64| (found - expected).abs() <= bin + 1e-9 * expected.abs();
                assert!(
                    is_near(scale.low, clipped[0]) && is_near(scale.high, clipped[1]),
                    "{case}: {scale:?} {clipped:?}"
                );
                assert!(progressive.legend().is_some(), "{case}");
            }
        }
    }
    assert!(formats.iter().all(|&files| files >= 2), "every format: {formats:?}");
    // What a file does not have by itself laspy has not either.
    let derived = [Attribute::File, Attribute::LastReturn];
    for (_, attribute) in Attribute::NAMED.iter().filter(|(_, attribute)| !derived.contains(attribute)) {
        assert!(seen[attribute] > 1000, "{attribute}: {} pixels", seen[attribute]);
    }
    assert!(seen.keys().filter(|attribute| matches!(attribute, Attribute::Extra(_))).count() >= 6, "{seen:?}");
}
