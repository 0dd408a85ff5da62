//! `bench-ingest`: a report that agrees with itself, and what may go wrong before there is one.

use std::fs;

use firstlight::synth::Scene;
use serde_json::{Value, json};

use crate::bench::{Bench, gpu_or_skip};

const POINTS: u64 = 300_000;

fn number(value: &Value) -> Result<f64, String> {
    value.as_f64().ok_or_else(|| format!("expected a number, found {value}"))
}

fn list(value: &Value) -> Result<&[Value], String> {
    value.as_array().map(Vec::as_slice).ok_or_else(|| format!("expected a list, found {value}"))
}

fn numbers(list: &[Value], field: &str) -> Result<Vec<f64>, String> {
    list.iter().map(|item| number(&item[field])).collect()
}

fn ensure(holds: bool, what: &str) -> Result<(), String> {
    if holds { Ok(()) } else { Err(what.into()) }
}

/// The summary is that of the samples.
fn check_summary(summary: &Value, samples: &[f64], rounds: usize, what: &str) -> Result<(), String> {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    ensure(sorted.len() == rounds, &format!("{what}: a sample per round"))?;
    ensure(sorted[0] > 0.0, &format!("{what}: time passes"))?;
    let expected = [sorted[0], sorted[rounds.div_ceil(2) - 1], sorted[rounds - 1]];
    let found = [number(&summary["min"])?, number(&summary["median"])?, number(&summary["max"])?];
    ensure(found == expected, &format!("{what}: {found:?} of {sorted:?}"))
}

/// What must hold of any report, whatever the machine.
fn check(report: &Value) -> Result<(), String> {
    ensure(report["report"] == "firstlight bench-ingest", "its kind")?;
    let rounds = number(&report["repeat"])? as usize;
    for file in list(&report["files"])? {
        check_file(file, rounds).map_err(|what| format!("{}: {what}", file["path"]))?;
    }
    Ok(())
}

fn check_file(file: &Value, rounds: usize) -> Result<(), String> {
    let points = number(&file["points"])?;
    ensure(points == POINTS as f64, "points of the file")?;
    if file["compressed"] == false {
        ensure(number(&file["point_bytes"])? == 34.0 * points, "34 bytes per record of format 3")?;
    }
    for runs in list(&file["reader"])? {
        let samples = list(&runs["samples"])?;
        let secs = numbers(samples, "secs")?;
        check_summary(&runs["seconds"], &secs, rounds, "reader")?;
        let rate = number(&runs["points_per_sec"]["median"])? * number(&runs["seconds"]["median"])?;
        ensure((rate / points - 1.0).abs() < 1e-9, "points per second times seconds")?;
        for sample in samples {
            ensure(sample["points"] == file["points"], "points of a run")?;
            let threads = list(&sample["threads"])?;
            ensure(threads.len() as u64 <= runs["threads"].as_u64().unwrap_or(0), "no more threads than asked for")?;
            ensure(numbers(threads, "points")?.iter().sum::<f64>() == points, "points of all threads")?;
            let mut total = 0.0;
            for thread in threads {
                let stages = ["read_secs", "decode_secs", "convert_secs", "wait_secs"];
                let busy: f64 = stages.iter().map(|&stage| number(&thread[stage])).sum::<Result<f64, _>>()?;
                ensure(busy <= number(&sample["secs"])? + 0.01, "stages within the run")?;
                total += busy;
            }
            if let Some(busy) = sample["processor_secs"].as_f64() {
                // Counted in hundredths, by as many threads as there are, and two beside them.
                let most = (threads.len() as f64 + 2.0) * (number(&sample["secs"])? + 0.02);
                ensure((0.0..=most).contains(&busy), "processor time")?;
            }
            ensure(total > 0.0, "some thread did something")?;
            let order = ["secs_to_opened", "secs_to_first_batch", "secs"].map(|name| number(&sample[name]));
            let order = order.into_iter().collect::<Result<Vec<_>, _>>()?;
            ensure(order.is_sorted() && order[0] > 0.0, "opened, first batch, end")?;
        }
    }
    for ceilings in [&file["read_alone"], &file["memcpy"]] {
        for runs in list(ceilings)? {
            let secs = list(&runs["samples_secs"])?.iter().map(number).collect::<Result<Vec<_>, _>>()?;
            check_summary(&runs["seconds"], &secs, rounds, "ceiling")?;
        }
    }
    for runs in list(&file["coverage"])? {
        ensure(list(&runs["samples"])?.len() == rounds, "coverage of every round")?;
        for sample in list(&runs["samples"])? {
            let steps = list(&sample["steps"])?;
            for field in ["secs", "points", "cells"] {
                ensure(numbers(steps, field)?.is_sorted(), &format!("coverage: {field} never fall"))?;
            }
            let last = steps.last().ok_or("a step")?;
            ensure(last["cells"] == sample["total_cells"], "coverage ends at 100 %")?;
            ensure(sample["total_points"] == file["points"], "coverage has seen all points")?;
        }
    }
    for sample in file["screen"]["samples"].as_array().into_iter().flatten() {
        let names = ["first_batch", "first_picture", "all_loaded", "converged"];
        let secs = names.map(|name| number(&sample[format!("secs_to_{name}")]));
        ensure(secs.into_iter().collect::<Result<Vec<_>, _>>()?.is_sorted(), "first picture, all points, converged")?;
        ensure(sample["points_stored"] == file["points"], "points on screen")?;
        ensure(number(&sample["covered_pixels"])? > 0.0, "something is seen")?;
        let frames = list(&sample["frames"])?;
        for field in ["at_secs", "points_stored"] {
            ensure(numbers(frames, field)?.is_sorted(), &format!("frames: {field} never falls"))?;
        }
        ensure(frames.last().is_some_and(|f| f["points_stored"] == file["points"]), "the last frame has all points")?;
        let slowest = numbers(frames, "wall_ms")?.into_iter().fold(0.0, f64::max);
        let p99 = number(&sample["frame_ms_p99"])?;
        ensure(number(&sample["frame_ms_median"])? <= p99 && p99 <= slowest, "percentiles of the frames")?;
    }
    Ok(())
}

fn report(bench: &Bench) -> Value {
    serde_json::from_slice(&fs::read(bench.path("out/ingest.json")).unwrap()).unwrap()
}

fn scans(bench: &Bench) {
    bench.scan("a.las", Scene::Town, POINTS);
    bench.scan("b.laz", Scene::Town, POINTS);
}

#[test]
fn a_report_agrees_with_itself() {
    let bench = Bench::new();
    scans(&bench);
    let args = "bench-ingest a.las b.laz -o out --repeat 3 --threads 2,1 --backend cpu --size 160x120 -q";
    let run = bench.run(args).expect(0);
    assert!(run.stderr.is_empty() && run.stdout.is_empty(), "--quiet is quiet: {}", run.stderr);
    let report = report(&bench);
    check(&report).unwrap();
    assert_eq!(report["files"][0]["reader"].as_array().unwrap().len(), 4, "two orders, one and two threads");
    assert_eq!(report["files"][1]["coverage"].as_array().unwrap().len(), 2, "both orders");
    assert!(report["command"].as_str().unwrap().ends_with(args));
    assert!(report["machine"]["cores"].as_u64().unwrap() > 0);
    assert_eq!(report["files"][0]["screen"]["samples"][0]["upload_secs"], Value::Null, "memory of its own");
    assert!(report["files"][0]["screen"]["samples"][0]["scatter_secs"].as_f64().unwrap() > 0.0);

    // Reports that do not agree with themselves are told.
    for (place, wrong) in [
        ("/files/0/points", json!(POINTS + 1)),
        ("/files/0/point_bytes", json!(5)),
        ("/files/0/reader/0/seconds/median", json!(1e9)),
        ("/files/1/reader/2/samples/1/points", json!(1)),
        ("/files/1/reader/2/samples/1/secs_to_first_batch", json!(1e9)),
        ("/files/1/reader/3/samples/1/threads/0/points", json!(1)),
        ("/files/1/reader/3/samples/1/threads/0/decode_secs", json!(1e9)),
        ("/files/1/reader/3/samples/1/processor_secs", json!(1e9)),
        ("/files/0/memcpy/1/samples_secs/0", json!(-1.0)),
        ("/files/0/coverage/0/samples/2/total_cells", json!(4097)),
        ("/files/1/coverage/1/samples/0/steps/0/cells", json!(4097)),
        ("/files/1/screen/samples/0/secs_to_first_picture", json!(1e9)),
        ("/files/1/screen/samples/0/frames/0/points_stored", json!(1e9)),
        ("/files/1/screen/samples/0/points_stored", json!(1)),
    ] {
        let mut damaged = report.clone();
        *damaged.pointer_mut(place).unwrap_or_else(|| panic!("no {place}")) = wrong;
        check(&damaged).expect_err(place);
    }

    let csv = fs::read_to_string(bench.path("out/ingest.csv")).unwrap();
    // Per file and round: 4 ways, 2 × 2 ceilings, 2 orders' coverage, the screen.
    assert_eq!(csv.lines().count(), 1 + 2 * 3 * (4 + 4 + 2 + 1));
    let columns = csv.lines().next().unwrap().split(',').count();
    // No field here holds a comma but the kind, which is quoted.
    assert!(csv.lines().skip(1).all(|line| line.split(',').count() == columns + 1), "{csv}");
    let html = fs::read_to_string(bench.path("out/index.html")).unwrap();
    assert!(html.matches("<svg").count() >= 10 && html.contains("currentColor"));
    assert_eq!(html.matches("http").count(), html.matches("xmlns=\"http").count(), "nothing is fetched");

    // Its own report may be written over; with tables and progress this time.
    let run = bench.run("bench-ingest a.las -o out --repeat 1 --threads 1 --no-screen --order file").expect(0);
    assert!(run.stderr.contains("a.las: round 1 of 1") && run.stderr.contains("out/index.html"), "{}", run.stderr);
    let tables = String::from_utf8(run.stdout).unwrap();
    assert!(tables.contains("| file order, auto fields | 1 |") && tables.contains("read alone, MB/s"), "{tables}");
    let report = self::report(&bench);
    check(&report).unwrap();
    assert_eq!((&report["backend"], &report["files"][0]["screen"]), (&Value::Null, &Value::Null));
}

#[test]
fn a_gpu_tells_what_uploading_takes() {
    if !gpu_or_skip() {
        return;
    }
    let bench = Bench::new();
    scans(&bench);
    bench.run("bench-ingest b.laz -o out --repeat 2 --threads 1 --backend gpu --size 160x120 -q").expect(0);
    let report = report(&bench);
    check(&report).unwrap();
    assert_ne!(report["backend"]["method"], "cpu");
    let upload = |i: usize| report["files"][0]["screen"]["samples"][i]["upload_secs"].as_f64().unwrap();
    assert!(upload(0) > 0.0 && upload(1) > 0.0);
}

#[test]
fn fields_and_decoders_are_measured_side_by_side() {
    let bench = Bench::new();
    scans(&bench);
    let ways = "--order preview --decoder own,laz --fields xyz,all";
    bench.run(&format!("bench-ingest a.las b.laz -o out --repeat 1 --threads 1 --no-screen -q {ways}")).expect(0);
    let report = report(&bench);
    check(&report).unwrap();
    let files = report["files"].as_array().unwrap();
    let reader = |file: usize| files[file]["reader"].as_array().unwrap();
    assert_eq!((reader(0).len(), reader(1).len()), (2, 4), "a decoder is chosen where there is something to decode");
    let bytes = |i: usize| reader(1)[i]["samples"][0]["batch_bytes"].as_u64().unwrap();
    assert_eq!([bytes(0), bytes(1)], [bytes(2), bytes(3)], "the same points, whoever decodes them");
    // GPS time alone is 8 bytes.
    assert!(bytes(1) >= bytes(0) + 8 * POINTS);
}

#[test]
#[cfg(unix)]
fn another_program_is_measured_in_turn() {
    let bench = Bench::new();
    scans(&bench);
    // Notes when it is called, and with what.
    bench.write("other.sh", "echo \"$@\" >> calls; echo points 300000; echo 0.125\n");
    bench
        .command("bench-ingest b.laz -o out --repeat 3 --threads 1 --no-screen -q")
        .args(["--against", "sh other.sh 'two words'"])
        .status()
        .unwrap();
    assert_eq!(fs::read_to_string(bench.path("calls")).unwrap(), "two words b.laz\n".repeat(3));
    let report = report(&bench);
    let against = &report["files"][0]["against"][0];
    assert_eq!(against["command"], "sh other.sh 'two words'");
    assert_eq!(against["seconds"]["median"], 0.125);
    assert_eq!(against["points_per_sec"]["median"], POINTS as f64 / 0.125);
}

#[test]
fn what_goes_wrong_is_said_and_leaves_no_report() {
    let bench = Bench::new();
    bench.scan("a.las", Scene::Planes, 1000);
    bench.write("noise.laz", "this is no point cloud, whatever its name says");
    bench.write("file", "");
    fs::create_dir(bench.path("photos")).unwrap();
    bench.write("photos/a.png", "somebody's");
    for (args, code, words) in [
        ("a.las", 2, &["--output"][..]),
        ("-o out", 2, &["IN"]),
        ("a.las -o out --order sideways", 2, &["--order", "preview", "file"]),
        ("a.las -o out --fields rgb,smell", 2, &["--fields", "colors", "xyz"]),
        ("a.las -o out --decoder zip", 2, &["--decoder", "own", "laz"]),
        ("a.las -o out --repeat 0", 2, &["--repeat"]),
        ("a.las -o out --threads 0", 2, &["--threads"]),
        ("a.las -o out --backend cpu --method early-z", 2, &["--method"]),
        ("a.las -o out --no-screen --against no-such-program", 2, &["--against", "cannot be started", "a.las"]),
        ("missing.las -o out", 3, &["missing.las", "no such file"]),
        ("noise.laz -o out --no-screen", 3, &["noise.laz", "LASF"]),
        ("a.las -o photos", 5, &["photos", "other files"]),
        ("a.las -o file", 5, &["file", "not a folder"]),
        ("a.las -o file/out", 5, &["file/out"]),
    ] {
        let run = bench.run(&format!("bench-ingest {args}"));
        assert_eq!(run.code, Some(code), "{args}: {}", run.stderr);
        for word in words {
            assert!(run.stderr.contains(word), "{args}: no `{word}` in {}", run.stderr);
        }
        assert!(!bench.path("out/ingest.json").exists() && !bench.path("out/index.html").exists(), "{args}");
    }
    assert_eq!(fs::read(bench.path("photos/a.png")).unwrap(), b"somebody's");
    assert_eq!(fs::read_dir(bench.path("photos")).unwrap().count(), 1);
}

#[test]
#[cfg(unix)]
fn an_interrupted_run_leaves_the_older_report() {
    let bench = Bench::new();
    scans(&bench);
    bench.run("bench-ingest a.las -o out --repeat 1 --threads 1 --no-screen -q").expect(0);
    let before = fs::read(bench.path("out/ingest.json")).unwrap();
    let args = "bench-ingest b.laz -o out --repeat 1000 --threads 1 --no-screen";
    let mut running = bench.command(args).stderr(std::process::Stdio::piped()).spawn().unwrap();
    // In the midst of it: one round is over.
    let mut line = String::new();
    let stderr = running.stderr.take().unwrap();
    std::io::BufRead::read_line(&mut std::io::BufReader::new(stderr), &mut line).unwrap();
    assert!(line.contains("round 1 of 1000"), "{line}");
    let interrupt = std::process::Command::new("kill").args(["-INT", &running.id().to_string()]).status().unwrap();
    assert!(interrupt.success() && !running.wait().unwrap().success());
    assert_eq!(fs::read(bench.path("out/ingest.json")).unwrap(), before);
    assert_eq!(fs::read_dir(bench.path("out")).unwrap().count(), 3);
}

#[test]
fn a_damaged_file_is_measured_as_far_as_it_goes() {
    let bench = Bench::new();
    bench.scan("a.las", Scene::Planes, 1000);
    let whole = fs::read(bench.path("a.las")).unwrap();
    bench.write("cut.las", &whole[..whole.len() - 34 * 400 - 5]);
    bench.write("noise.laz", "this is no point cloud, whatever its name says");
    let args = "bench-ingest a.las cut.las noise.laz -o out --repeat 1 --threads 1 --backend cpu --size 64x48 -q";
    let run = bench.run(args).expect(4);
    let messages = run.messages();
    assert_eq!(messages.len(), 2, "{}", run.stderr);
    assert!(messages[0].contains("cut.las") && messages[0].contains("401 of 1000"), "{}", run.stderr);
    assert!(messages[1].contains("noise.laz"), "{}", run.stderr);
    let report = report(&bench);
    assert_eq!((&report["files"][0]["points"], &report["files"][1]["points"]), (&json!(1000), &json!(599)));
    assert_eq!(report["files"][1]["screen"]["samples"][0]["points_stored"], 599);
    assert_eq!(report["problems"].as_array().unwrap().len(), 2);
}

#[test]
fn a_file_without_points_has_no_rates_but_a_report() {
    let bench = Bench::new();
    let empty = bench.scan("a.las", Scene::Planes, 1000);
    let mut bytes = fs::read(&empty).unwrap();
    let points_at = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize;
    bytes.truncate(points_at);
    bytes[107..111].fill(0);
    bytes[111..131].fill(0);
    fs::write(&empty, bytes).unwrap();
    bench.run("bench-ingest a.las -o out --repeat 1 --threads 1 --backend cpu --size 64x48 -q").expect(0);
    let report = report(&bench);
    assert_eq!(report["files"][0]["points"], 0);
    assert_eq!(report["files"][0]["screen"]["samples"][0]["secs_to_first_picture"], Value::Null);
    assert_eq!(report["files"][0]["coverage"][0]["samples"], json!([]));
    assert!(!fs::read_to_string(bench.path("out/index.html")).unwrap().contains("NaN"));
}
