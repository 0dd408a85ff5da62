//! `bench`: a report that agrees with itself, pictures that are as right as they should be, and what may go
//! wrong before there is one.

use std::fs;

use firstlight::{methods::METHODS, synth::Scene};
use serde_json::{Value, json};

use crate::bench::{Bench, gpu_or_skip};

const POINTS: f64 = 20_000.0;

fn number(value: &Value) -> Result<f64, String> {
    value.as_f64().ok_or_else(|| format!("expected a number, found {value}"))
}

fn list(value: &Value) -> Result<&[Value], String> {
    value.as_array().map(Vec::as_slice).ok_or_else(|| format!("expected a list, found {value}"))
}

fn ensure(holds: bool, what: &str) -> Result<(), String> {
    if holds { Ok(()) } else { Err(what.into()) }
}

/// The summary is that of the samples.
fn check_summary(summary: &Value, mut samples: Vec<f64>, count: f64) -> Result<(), String> {
    samples.sort_by(f64::total_cmp);
    ensure(samples.len() as f64 == count, "a sample per frame and round")?;
    ensure(samples[0] > 0.0, "time passes")?;
    let expected = [samples[0], samples[samples.len().div_ceil(2) - 1], samples[samples.len() - 1]];
    let found = [number(&summary["min"])?, number(&summary["median"])?, number(&summary["max"])?];
    ensure(found == expected, &format!("{found:?} of {samples:?}"))
}

/// What must hold of any report, whatever the machine.
fn check(report: &Value) -> Result<(), String> {
    ensure(report["report"] == "firstlight bench" && report["complete"] == true, "its kind, and all of it")?;
    let count = number(&report["frames"])? * number(&report["repeat"])?;
    let points = number(&report["points"])?;
    ensure(points == POINTS, "all points")?;
    let measured = list(&report["methods"])?.iter().filter(|method| method["missing"].is_null()).count();
    for block in list(&report["blocks"])? {
        let (view, rows) = (&block["view"], list(&block["rows"])?);
        ensure(rows.len() == measured, "a row per method")?;
        ensure(number(&block["fragments"])? >= number(&block["covered_pixels"])?, "a point per covered pixel")?;
        ensure((number(&block["fragments"])? == 0.0) == (view == "inside-none"), "nothing in that view only")?;
        for row in rows {
            let name = row["method"].as_str().unwrap_or_default();
            check_row(block, row, points, count).map_err(|what| format!("{view} {name}: {what}"))?;
        }
    }
    for runs in list(&report["curves"])? {
        let secs = list(&runs["samples_secs"])?.iter().map(number).collect::<Result<Vec<_>, _>>()?;
        check_summary(&runs["frame_secs"], secs, count)?;
    }
    ensure(list(&report["checks"])?.iter().all(|check| check["holds"] != false), "no check failed")
}

fn check_row(block: &Value, row: &Value, points: f64, count: f64) -> Result<(), String> {
    let secs = list(&row["samples"]["frame_secs"])?.iter().map(number).collect::<Result<Vec<_>, _>>()?;
    check_summary(&row["frame_secs"], secs, count)?;
    let median = |field: &str| number(&row[field]["median"]);
    let rate = median("points_per_sec")? * median("frame_secs")?;
    // Six digits each.
    ensure((rate / points - 1.0).abs() < 1e-4, "points per second times seconds")?;
    let bytes = median("bytes_per_sec")? * median("frame_secs")?;
    ensure((bytes / number(&row["bytes"])? - 1.0).abs() < 1e-4, "bytes per second times seconds")?;
    ensure(number(&row["bytes"])? >= 16.0 * points, "the positions of all points, at least once")?;
    let a = &row["accuracy"];
    let covered = number(&a["covered_pixels"])?;
    ensure(covered >= number(&block["covered_pixels"])?, "covered in one of the pictures")?;
    if let (Some(wrong), Some(share)) = (a["wrong_pixels"].as_f64(), a["right_share"].as_f64()) {
        ensure((1.0 - wrong / covered - share).abs() < 1e-5, "wrong pixels and their share")?;
    }
    if row["method"] == "atomic-min" && covered > 0.0 {
        ensure(a["right_share"] == 1.0 && a["psnr_db"].is_null(), "atomic-min is what it is compared with")?;
    }
    Ok(())
}

fn report(bench: &Bench) -> Value {
    serde_json::from_slice(&fs::read(bench.path("out/bench.json")).unwrap()).unwrap()
}

/// The least right of a method's pictures.
fn worst(report: &Value, method: &str) -> f64 {
    let rows = report["blocks"].as_array().unwrap().iter().flat_map(|block| block["rows"].as_array().unwrap());
    let shares = rows.filter(|row| row["method"] == method).filter_map(|row| row["accuracy"]["right_share"].as_f64());
    shares.fold(f64::INFINITY, f64::min)
}

#[test]
fn a_report_agrees_with_itself() {
    if !gpu_or_skip() {
        return;
    }
    let bench = Bench::new();
    let args = "--synth town:20k --size 160x90 --frames 2 --repeat 2 --orders original,shuffled-morton -o out";
    let run = bench.run(&format!("bench {args}")).expect(0);
    assert!(run.stderr.contains("0 of ") && run.stderr.contains("inside-none"), "progress: {}", run.stderr);
    let text = String::from_utf8(run.stdout).unwrap();
    assert!(text.contains("| early-z |") && text.contains("just-set (wrong on purpose)"), "{text}");
    let report = report(&bench);
    assert_eq!(check(&report), Ok(()));
    assert_eq!(report["blocks"].as_array().unwrap().len(), 8);
    // Wrong on purpose, and seen to be.
    assert!(worst(&report, "just-set") < 0.9, "{}", worst(&report, "just-set"));
    assert!(worst(&report, "racy") < 0.99, "{}", worst(&report, "racy"));
    for exact in ["points", "early-z", "two-pass-32"] {
        assert!(worst(&report, exact) > 0.999, "{exact}: {}", worst(&report, exact));
    }

    // The check can fail.
    let spoil = |path: &str, value: Value| {
        let mut spoiled = report.clone();
        *spoiled.pointer_mut(path).unwrap() = value;
        assert!(check(&spoiled).is_err(), "{path}");
    };
    spoil("/points", json!(19_999));
    spoil("/complete", json!(false));
    spoil("/frames", json!(3));
    spoil("/blocks/0/rows/0/bytes", json!(8));
    spoil("/checks/0/holds", json!(false));
    spoil("/blocks/0/rows/0/samples/frame_secs/0", json!(99.0));
    spoil("/blocks/1/rows/3/points_per_sec/median", json!(1.0));
    spoil("/blocks/2/rows/1/accuracy/wrong_pixels", json!(1));
    spoil("/blocks/0/fragments", json!(7));
    spoil("/curves/0/frame_secs/median", json!(99.0));

    let csv = fs::read_to_string(bench.path("out/bench.csv")).unwrap();
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().all(|line| line.split(',').count() == columns));
    let methods = report["blocks"][0]["rows"].as_array().unwrap().len();
    assert_eq!(csv.lines().filter(|line| line.starts_with("block,")).count(), 8 * methods * 4);
    let page = fs::read_to_string(bench.path("out/index.html")).unwrap();
    assert!(page.contains("RTX 3090") && page.contains("10.1111/cgf.14345") && !page.contains("NaN"));
    assert_eq!(page.matches("http").count(), page.matches("http://www.w3.org/2000/svg").count(), "no network");
    assert!(!page.contains("NOT COMPLETE") && page.matches("<svg").count() == 6 + 1 + 2);
}

#[test]
fn files_cameras_and_encodings() {
    if !gpu_or_skip() {
        return;
    }
    let bench = Bench::new();
    bench.scan("a.las", Scene::Planes, 3000);
    let camera = json!({"eye": [500_000.0, 5_000_000.0, 90.0], "target": [500_000.0, 5_000_000.0, 0.0]});
    bench.write("cam.json", camera.to_string());
    let args = "a.las --camera cam.json --size 96x64 --parts tables --orders morton --frames 1 --repeat 1 -o out -q";
    let mut pictures = Vec::new();
    for (encoding, bytes) in [("wide", 16 * 3000), ("packed", 8 * 3000)] {
        let run = bench.run(&format!("bench {args} --encoding {encoding} --methods early-z,just-set,hqs")).expect(0);
        assert!(run.stdout.is_empty(), "--quiet is quiet");
        let report = report(&bench);
        assert_eq!((&report["points"], &report["encodings"]), (&json!(3000), &json!([encoding])));
        let block = &report["blocks"][0];
        assert_eq!((&block["encoding"], &block["rows"][1]["bytes"]), (&json!(encoding), &json!(bytes)));
        assert_eq!((&block["view"], &block["fragments"]), (&json!("camera"), &json!(3000)), "from above, all of it");
        assert_eq!(report["blocks"].as_array().unwrap().len(), 1, "no other viewpoint was asked for");
        let names: Vec<&Value> = report["methods"].as_array().unwrap().iter().map(|method| &method["name"]).collect();
        assert_eq!(names, ["just-set", "early-z", "hqs"], "in the order of the table");
        pictures.push((block["covered_pixels"].clone(), block["rows"][1]["accuracy"].clone()));
    }
    assert_eq!(pictures[0], pictures[1], "both encodings hold the same integers");

    let whole = fs::read(bench.path("a.las")).unwrap();
    bench.write("cut.las", &whole[..whole.len() - 34 * 400 - 5]);
    let args = "cut.las --size 96x64 --parts tables --orders original --views overview --frames 1 --repeat 1 -o out -q";
    let run = bench.run(&format!("bench {args} --methods early-z")).expect(4);
    assert!(run.stderr.contains("401 of 3000"), "{}", run.stderr);
    assert_eq!(report(&bench)["points"], 2599);
}

#[test]
#[cfg(unix)]
fn an_interrupted_run_keeps_what_is_done() {
    use std::io::BufRead;
    if !gpu_or_skip() {
        return;
    }
    let bench = Bench::new();
    // Four blocks of a second or so each.
    let args = "bench --synth town:20k --size 160x90 --frames 400 --repeat 2 --methods atomic-min,points --orders original \
                --parts tables -o out";
    let mut running =
        bench.command(args).stderr(std::process::Stdio::piped()).stdout(std::process::Stdio::null()).spawn().unwrap();
    let lines = std::io::BufReader::new(running.stderr.take().unwrap()).lines();
    let begun = lines.map_while(Result::ok).any(|line| line.starts_with("1 of "));
    let interrupt = std::process::Command::new("kill").args(["-INT", &running.id().to_string()]).status().unwrap();
    let ended = running.wait().unwrap();
    assert!(begun && interrupt.success() && !ended.success(), "{ended}");
    let report = report(&bench);
    assert_eq!(report["complete"], false);
    let blocks = report["blocks"].as_array().unwrap();
    assert!(!blocks.is_empty() && blocks.len() < 4, "{} blocks", blocks.len());
    let samples = blocks[0]["rows"][0]["samples"]["frame_secs"].as_array().unwrap().len();
    assert!((2..=800).contains(&samples), "{samples} samples; slow machines draw fewer");
    assert!(fs::read_to_string(bench.path("out/index.html")).unwrap().contains("NOT COMPLETE"));
    let names: Vec<String> =
        fs::read_dir(bench.path("out")).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    assert!(names.iter().all(|name| ["bench.csv", "bench.json", "index.html"].contains(&&name[..]) || name.ends_with(".unfinished")), "{names:?}");
}

#[test]
fn every_method_is_listed_with_its_source() {
    let bench = Bench::new();
    let run = bench.run("bench --list").expect(0);
    let text = String::from_utf8(run.stdout).unwrap();
    for method in METHODS {
        assert!(text.lines().any(|line| line == method.name) && text.contains(method.source), "{}", method.name);
    }
    assert_eq!(
        text.matches("wrong on purpose").count(),
        METHODS.iter().filter(|m| m.wrong_on_purpose.is_some()).count()
    );
}

#[test]
fn what_goes_wrong_is_said_and_leaves_no_report() {
    let bench = Bench::new();
    bench.scan("a.las", Scene::Planes, 1000);
    bench.write("noise.laz", "this is no point cloud, whatever its name says");
    bench.write("cam.json", "{\"eye\":[1,2]}");
    bench.write("file", "");
    fs::create_dir(bench.path("photos")).unwrap();
    bench.write("photos/a.png", "somebody's");
    let mut cases = vec![
        ("a.las", 2, &["--output"][..]),
        ("a.las -o out --methods sideways", 2, &["--methods", "sideways", "early-z", "--list"]),
        ("a.las -o out --orders sideways", 2, &["--orders", "shuffled-morton"]),
        ("a.las -o out --views sideways", 2, &["--views", "inside-none"]),
        ("a.las -o out --parts legs", 2, &["--parts", "fragments"]),
        ("a.las -o out --size 0x5", 2, &["--size"]),
        ("a.las -o out --frames 0", 2, &["--frames"]),
        ("a.las -o out --repeat 0", 2, &["--repeat"]),
        ("a.las -o out --encoding zip", 2, &["--encoding", "packed"]),
        ("a.las -o out --synth town:1k", 2, &["--synth"]),
        ("-o out --synth village:1k", 2, &["--synth", "planes"]),
        ("a.las -o out --camera cam.json", 2, &["--camera", "cam.json"]),
        ("a.las -o out --camera none.json", 2, &["none.json"]),
        ("a.las -o photos", 5, &["photos", "other files"]),
        ("a.las -o file", 5, &["file", "not a folder"]),
        ("a.las -o file/out", 5, &["file/out"]),
    ];
    if gpu_or_skip() {
        cases.push(("missing.las -o out", 3, &["missing.las", "no such file"]));
        cases.push(("noise.laz -o out", 3, &["noise.laz", "LASF"]));
    }
    for (args, code, words) in cases {
        let run = bench.run(&format!("bench {args}"));
        assert_eq!(run.code, Some(code), "{args}: {}", run.stderr);
        for word in words {
            assert!(run.stderr.contains(word), "{args}: no `{word}` in {}", run.stderr);
        }
        assert!(!bench.path("out/bench.json").exists() && !bench.path("out/index.html").exists(), "{args}");
    }
    assert_eq!(fs::read(bench.path("photos/a.png")).unwrap(), b"somebody's");
    // A machine without any Vulkan driver.
    let nothing = bench.path("no-driver.json");
    let output = bench
        .command("bench a.las -o out")
        .env("VK_DRIVER_FILES", &nothing)
        .env("VK_ICD_FILENAMES", &nothing)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if cfg!(target_os = "linux") {
        assert_eq!(output.status.code(), Some(6), "{said}");
        assert!(said.contains("no GPU adapter"), "{said}");
    }
}
