//! Damaged inputs: what can be read is shown, what is missing is counted.

use std::fs;

use firstlight::synth::Scene;

use crate::bench::{Bench, Outputs, data};

const OUTPUTS: &str = "-o out.png --ids ids.npy --depth depth.npy --json report.json --backend cpu";

#[test]
fn a_cut_file_gives_the_picture_of_what_is_there() {
    let bench = Bench::new();
    for name in ["cut.las", "cut.laz"] {
        let path = bench.scan(name, Scene::Town, 150_000);
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() * 7 / 10]).unwrap();
        let run = bench.run(&format!("render {name} {OUTPUTS}")).expect(4);
        assert!(run.messages().iter().any(|m| m.contains(name) && m.contains("missing")), "{}", run.stderr);
        let outputs = Outputs::read(&bench);
        let report = &outputs.report;
        let count = |key: &str| report[key].as_u64().unwrap();
        assert_eq!(count("points_in_header"), 150_000);
        assert!(count("points_stored") > 50_000, "{}", count("points_stored"));
        assert_eq!(count("points_stored"), count("points_decoded"));
        assert_eq!(count("points_missing"), 150_000 - count("points_decoded"));
        assert!(report["files"][0]["error"].is_string());
        assert_eq!(report["converged"], true);
        assert!(outputs.covered() > 1000);
    }
}

#[test]
fn one_bad_file_does_not_spoil_the_others() {
    let bench = Bench::new();
    bench.scan("a.las", Scene::Planes, 500);
    bench.write("b.las", "no scan");
    bench.scan("c.laz", Scene::Planes, 700);
    let run = bench.run(&format!("render a.las b.las c.laz {OUTPUTS} --quiet")).expect(4);
    assert_eq!(run.messages().len(), 1, "the error is not silenced: {}", run.stderr);
    assert!(run.messages()[0].contains("b.las"));
    let report = Outputs::read(&bench).report;
    let files = report["files"].as_array().unwrap();
    let stored: Vec<_> = files.iter().map(|f| f["points_stored"].as_u64().unwrap()).collect();
    assert_eq!(stored, [500, 700, 0]);
    assert_eq!(files[1]["first_record"], 500);
    assert!(files[2]["path"].as_str().unwrap().ends_with("b.las"));
    assert!(files[2]["error"].is_string());
}

#[test]
fn real_damage_has_a_small_exit_code() {
    let Some(data) = data() else { return };
    let bench = Bench::new();
    let mut seen = [0; 7];
    for entry in fs::read_dir(data.join("broken")).unwrap() {
        let path = entry.unwrap().path();
        let run = bench.run(&format!("render {} {OUTPUTS} --size 320x240", path.display()));
        let code = run.code.unwrap_or_else(|| panic!("{}: a signal", path.display()));
        assert!([0, 3, 4].contains(&code), "{}: {code}: {}", path.display(), run.stderr);
        assert!(!run.stderr.contains("internal error"), "{}", run.stderr);
        assert!(code == 0 || run.stderr.contains(path.file_name().unwrap().to_str().unwrap()), "{}", run.stderr);
        if code != 3 {
            Outputs::read(&bench);
        }
        seen[code as usize] += 1;
    }
    assert!(seen[0] > 0 && seen[3] > 0 && seen[4] > 0, "{seen:?}");
}
