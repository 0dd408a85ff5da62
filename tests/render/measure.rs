//! `firstlight measure`: the same report everywhere with the virtual clock, checks that can fail, times with the real
//! one, and everything that can be wrong with the command line.

use std::fs;

use firstlight::synth::Scene;
use serde_json::Value;

use crate::bench::{Bench, gpu_or_skip};

const SMALL: &str = "--synth town:20k --size 96x64 --clock virtual --fill 700 --frames 5 --quiet";

fn report(bench: &Bench, folder: &str) -> Value {
    serde_json::from_slice(&fs::read(bench.path(folder).join("measure.json")).unwrap()).unwrap()
}

fn verdicts(report: &Value) -> Vec<(String, Option<bool>)> {
    let checks = report["checks"].as_array().unwrap();
    checks.iter().map(|check| (check["what"].as_str().unwrap().into(), check["holds"].as_bool())).collect()
}

fn frames<'a>(report: &'a Value, variant: &str) -> Vec<&'a Value> {
    let runs = report["runs"].as_array().unwrap();
    let run = runs.iter().find(|run| run["variant"] == variant).unwrap();
    run["frames"].as_array().unwrap().iter().collect()
}

#[test]
fn the_virtual_clock_gives_the_same_report_on_every_adapter() {
    let bench = Bench::new();
    let texts = |folder: &str, more: &str| {
        bench.run(&format!("measure {SMALL} -o {folder} {more}")).expect(0);
        fs::read_to_string(bench.path(folder).join("measure.json")).unwrap()
    };
    let cpu = texts("cpu", "--backend cpu --threads 2");
    assert!(texts("again", "--backend cpu --threads 1").replace("1 thread", "2 threads") == cpu, "run to run");
    assert!(texts("seed", "--backend cpu --threads 2 --seed 2") != cpu, "the comparison can fail");
    let parsed = report(&bench, "cpu");
    assert!(parsed.get("machine").is_none() && !cpu.contains("_secs\""), "no times");
    for csv in ["cpu", "again"].map(|folder| fs::read_to_string(bench.path(folder).join("measure.csv")).unwrap()) {
        assert!(csv.lines().count() > 100);
    }
    if gpu_or_skip() {
        for method in ["early-z", "two-pass-32:64", "points"] {
            let gpu = texts(&method.replace(':', "-"), &format!("--backend gpu --method {method}"));
            let mut gpu: Value = serde_json::from_str(&gpu).unwrap();
            assert_ne!(gpu["adapter"], parsed["adapter"]);
            gpu["adapter"] = parsed["adapter"].clone();
            assert!(gpu == parsed, "{method}");
        }
    }
}

/// What a file is stored in and what is decoded of it are settings too. No pixel depends on the first; without
/// colours the same points are shown in others.
#[test]
fn encodings_and_fields_are_compared() {
    let bench = Bench::new();
    bench.scan("a.laz", Scene::Town, 30_000);
    let args = "measure a.laz --size 64x48 --clock virtual --fill 900 --frames 3 --no-baselines -q --motion jump \
                --encoding wide,packed,auto --fields colors,positions,all";
    let measured = |folder: &str, backend: &str| {
        bench.run(&format!("{args} -o {folder} {backend}")).expect(0);
        report(&bench, folder)
    };
    let cpu = measured("cpu", "--backend cpu");
    let runs = cpu["runs"].as_array().unwrap();
    let names: Vec<[&str; 2]> =
        runs.iter().map(|run| ["encoding", "fields"].map(|key| run[key].as_str().unwrap())).collect();
    let of = |encoding| ["colors", "positions", "all"].map(|fields| [encoding, fields]);
    assert_eq!(names, [of("wide"), of("packed")].concat(), "what auto chooses is run once");
    let viewers: Vec<bool> = runs.iter().map(|run| run["is_viewers_method"].as_bool().unwrap()).collect();
    assert_eq!(viewers, [false, false, false, true, false, false]);
    let shown = |run: &Value, of: &str| -> Vec<Value> {
        run["frames"].as_array().unwrap().iter().map(|frame| frame["received"][of].clone()).collect()
    };
    for run in &runs[1..] {
        for metric in ["covered_share", "right_share", "depth_error_p95_m"] {
            assert_eq!(shown(run, metric), shown(&runs[0], metric), "{metric}");
        }
        let is_colored = run["fields"] != "positions";
        assert_eq!(shown(run, "psnr_db") == shown(&runs[0], "psnr_db"), is_colored, "other colours, other errors");
    }
    let csv = fs::read_to_string(bench.path("cpu").join("measure.csv")).unwrap();
    assert!(csv.contains(",packed,positions,1,jump,"), "{csv}");
    let page = fs::read_to_string(bench.path("cpu").join("index.html")).unwrap();
    assert!(page.contains("900, 2 px, packed, positions"), "a dot for each setting");
    if gpu_or_skip() {
        let mut gpu = measured("gpu", "--backend gpu --method early-z");
        assert_ne!(gpu["adapter"], cpu["adapter"]);
        gpu["adapter"] = cpu["adapter"].clone();
        assert!(gpu == cpu);
    }
}

#[test]
fn theory_holds_for_the_shuffle_and_fails_without_it() {
    let bench = Bench::new();
    bench.run(&format!("measure {SMALL} -o out --backend cpu --point-size 1,3")).expect(0);
    let report = report(&bench, "out");
    let verdicts = verdicts(&report);
    assert_eq!(verdicts.len(), 4, "{verdicts:?}");
    assert!(verdicts.iter().all(|(_, holds)| *holds == Some(true)), "{verdicts:?}");
    assert!(verdicts[3].0.contains("unshuffled"), "{verdicts:?}");

    // The methods come out as their definitions say.
    let mean = |variant: &str, of: &dyn Fn(&Value) -> f64| {
        let moving: Vec<f64> = frames(&report, variant).into_iter().filter(|f| f["phase"] == "orbit").map(of).collect();
        moving.iter().sum::<f64>() / moving.len() as f64
    };
    let covered = |variant| mean(variant, &|f| f["received"]["covered_share"].as_f64().unwrap());
    assert_eq!(covered("brute-force"), 1.0);
    assert!(1.0 - covered("firstlight") < 0.8 * (1.0 - covered("clear-on-move")), "fewer holes");
    assert!((covered("clear-on-move") - covered("no-reprojection")).abs() < 0.02, "both are one sample per frame");
    let loading = |variant| {
        let frames = frames(&report, variant);
        let right = |f: &&Value| f["phase"] == "loading" && f["received"]["front_share"] == 1.0;
        frames.iter().filter(|f| right(f)).count()
    };
    assert_eq!(loading("firstlight"), frames(&report, "firstlight").iter().filter(|f| f["phase"] == "loading").count());
    assert!(loading("no-moved-to") < loading("firstlight") / 2, "points are lost as others arrive");
}

#[test]
fn real_time_is_measured_and_then_compared() {
    let bench = Bench::new();
    bench.scan("a.laz", Scene::Town, 150_000);
    let run = bench.run("measure a.laz -o out --size 64x48 --backend cpu --fill auto,9k --frames 6 --baselines clear-on-move --motion orbit");
    // The viewer's choice may be beaten on a busy machine: that is exit code 4.
    assert!(matches!(run.code, Some(0 | 4)), "{}", run.stderr);
    let report = report(&bench, "out");
    let verdicts = verdicts(&report);
    let timed = verdicts.iter().find(|(what, _)| what.contains("those that were timed")).unwrap();
    assert_eq!(timed.1, Some(true));
    assert_eq!((verdicts[0].1, verdicts[1].1), (Some(true), Some(true)), "{verdicts:?}");
    assert!(report["command"].as_str().unwrap().contains("--fill auto,9k") && report["machine"]["cores"].is_u64());
    for run in report["runs"].as_array().unwrap() {
        let frames = run["frames"].as_array().unwrap();
        let ends: Vec<f64> =
            frames.iter().map(|f| f["start_secs"].as_f64().unwrap() + f["frame_secs"].as_f64().unwrap()).collect();
        assert!(ends.is_sorted() && ends[0] > 0.0);
        assert_eq!(frames[0]["points_stored"], 65_536.min(frames[0]["points_stored"].as_u64().unwrap()));
        assert_eq!(frames.last().unwrap()["points_stored"], 150_000);
        let headline = &run["headline"];
        assert!(headline["right_50"]["secs"].as_f64() <= headline["right_100"]["secs"].as_f64());
        assert!(headline["frame_ms_p99"].as_f64().unwrap() > 0.0);
    }
    let page = fs::read_to_string(bench.path("out").join("index.html")).unwrap();
    assert!(page.contains("★ auto, 2 px") && page.contains("<svg"));
}

#[test]
fn a_path_of_cameras_is_followed() {
    let bench = Bench::new();
    let camera = |x: f64| format!(r#"{{"eye":[{x},-400,300],"target":[{x},0,0]}}"#);
    bench.write("cams.json", format!("[{}, {}]", camera(0.0), camera(80.0)));
    bench.run(&format!("measure {SMALL} -o out --backend cpu --no-baselines --path cams.json")).expect(0);
    let report = report(&bench, "out");
    assert_eq!(report["phases"], serde_json::json!(["loading", "still", "path", "after path"]));
    assert_eq!(report["camera"]["eye"][0], 0.0, "loading is seen from the first");
    assert_eq!(frames(&report, "firstlight").iter().filter(|f| f["phase"] == "path").count(), 5);
    bench.run(&format!("measure {SMALL} -o out --backend cpu --no-baselines --motion none")).expect(0);
    assert_eq!(self::report(&bench, "out")["phases"], serde_json::json!(["loading", "still"]), "an older report goes");
}

#[test]
fn points_that_are_missing_are_said() {
    let bench = Bench::new();
    let path = bench.scan("a.laz", Scene::Town, 150_000);
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let args =
        "measure a.laz -o out --size 64x48 --backend cpu --clock virtual --fill 50k --frames 2 --no-baselines -q";
    let run = bench.run(args).expect(4);
    assert!(!run.messages().is_empty(), "{}", run.stderr);
    assert!(!report(&bench, "out")["problems"].as_array().unwrap().is_empty());
}

#[test]
fn what_is_wrong_is_said_before_the_work() {
    let bench = Bench::new();
    bench.scan("a.las", Scene::Planes, 2000);
    let mut wide = fs::read(bench.path("a.las")).unwrap();
    // The header's largest and smallest x, y and z: nearly all that 32 bits hold of steps of a millimetre.
    for (axis, offset) in [500_000.0, 5_000_000.0, 0.0].into_iter().enumerate() {
        for (at, value) in [(179, offset + 2.1e6_f64), (187, offset - 2.1e6)] {
            wide[at + 16 * axis..][..8].copy_from_slice(&value.to_le_bytes());
        }
    }
    fs::write(bench.path("wide.las"), wide).unwrap();
    bench.write("text.las", "no scan");
    bench.write("none.json", "[]");
    bench.write("second.json", r#"[{"eye":[0,-9,1],"target":[0,0,0]},{"eye":[1,1,1],"target":[1,1,1]}]"#);
    bench.write("one.json", r#"{"eye":[0,0,1],"target":[0,0,0]}"#);
    fs::create_dir(bench.path("taken")).unwrap();
    bench.write("taken/other.txt", "mine");
    for (args, code, says) in [
        ("", 2, "required"),
        ("a.las", 2, "--output"),
        ("a.las -o out --fill 0", 2, "at least 1"),
        ("a.las -o out --fill often", 2, "or `auto`"),
        ("a.las -o out --clock virtual --fill 10,auto", 2, "--fill auto"),
        ("a.las -o out --load 5k", 2, "--load"),
        ("a.las -o out --clock virtual --load 1M", 2, "393216"),
        ("a.las -o out --point-size 9", 2, "1..=8"),
        ("a.las -o out --baselines best", 2, "unshuffled"),
        ("a.las -o out --baselines unshuffled --no-baselines", 2, "cannot be used"),
        ("a.las -o out --backend cpu --method early-z", 2, "--method"),
        ("a.las -o out --encoding narrow", 2, "packed"),
        ("a.las -o out --fields names", 2, "positions"),
        ("--synth town:5 -o out --fields all", 2, "--fields"),
        ("wide.las -o out --backend cpu --encoding packed", 2, "choose the wide encoding"),
        ("a.las -o out --path none.json", 2, "at least one camera"),
        ("a.las -o out --path one.json", 2, "expected [{"),
        ("a.las -o out --path missing.json", 2, "missing.json"),
        ("a.las -o out --path second.json --backend cpu", 2, "eye and target"),
        ("a.las -o out --path one.json --motion orbit", 2, "cannot be used"),
        ("a.las --synth town:5 -o out", 2, "cannot be used"),
        ("text.las -o out --backend cpu", 3, "text.las"),
        ("missing.las -o out --backend cpu", 3, "missing.las"),
        ("a.las -o taken --backend cpu", 5, "holds other files"),
    ] {
        let run = bench.run(&format!("measure {args}")).expect(code);
        assert!(run.stderr.contains(says), "{args}: {}", run.stderr);
        assert!(!run.stderr.contains("loading"), "{args}: before the first frame: {}", run.stderr);
    }
    let help = String::from_utf8(bench.run("measure --help").expect(0).stdout).unwrap();
    assert!((0..=6).all(|code| help.contains(&format!("\n  {code}  "))), "every exit code is listed");
}
