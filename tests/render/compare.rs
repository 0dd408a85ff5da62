//! `bench`: a report that agrees with itself, methods that take too long, both encodings, and a chart of reports.

use std::fs;

use serde_json::Value;

use crate::bench::{Bench, gpu_or_skip};

const SMALL: &str = "--size 160x90 --frames 2 --repeat 2 --parts tables --orders original,shuffled-morton --quiet";

fn report(bench: &Bench, folder: &str) -> Value {
    serde_json::from_slice(&fs::read(bench.path(folder).join("bench.json")).unwrap()).unwrap()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap()
}

#[test]
fn both_encodings_stand_side_by_side() {
    if !gpu_or_skip() {
        return;
    }
    let bench = Bench::new();
    let methods = "--methods just-set,atomic-min,depth40,two-pass-32,hqs";
    bench
        .run(&format!("bench --synth town:60K --encoding wide,packed --views overview,far {methods} {SMALL} -o both"))
        .expect(0);
    let report = report(&bench, "both");
    assert_eq!((list(&report["blocks"]).len(), &report["complete"]), (8, &Value::from(true)));
    let ceilings = &report["ceilings"];
    for ceiling in [&ceilings["copy_bytes_per_sec"], &ceilings["copy_kernel_bytes_per_sec"]] {
        assert!(ceiling["median"].as_f64().unwrap() > 0.0);
    }
    let reads: Vec<&Value> = list(&ceilings["read"]).iter().map(|read| &read["encoding"]).collect();
    assert_eq!(reads, ["wide", "packed"]);
    for block in list(&report["blocks"]) {
        let is_packed = block["encoding"] == "packed";
        let fragments = block["fragments"].as_u64().unwrap();
        assert_eq!(block["reference_differs"], block["reference_excused"], "rounding alone");
        for row in list(&block["rows"]) {
            let method = row["method"].as_str().unwrap();
            let samples = list(&row["samples"]["frame_secs"]);
            assert_eq!((samples.len(), list(&row["samples"]["round"]).len()), (4, 4), "{method}");
            // Positions once a pass; packed, colours that are looked up lie apart.
            let passes = if ["two-pass-32", "hqs"].contains(&method) { 2 } else { 1 };
            let colors = if is_packed && ["depth40", "hqs"].contains(&method) { 4 * fragments } else { 0 };
            assert_eq!(row["bytes"], passes * 60_000 * if is_packed { 8 } else { 16 } + colors, "{method}");
        }
    }
    let html = fs::read_to_string(bench.path("both/index.html")).unwrap();
    assert!(html.contains("original, packed") && html.contains("÷ wide"));
    let host: Vec<&str> = list(&report["host"]).iter().map(|time| time["what"].as_str().unwrap()).collect();
    for what in ["the points", "shuffled-morton order", "upload of original order, packed", "the processor's far"] {
        assert_eq!(host.iter().filter(|&&name| name == what).count(), 1, "{what}: {host:?}");
    }
}

/// Next to no time is allowed, so that everything is left in the middle, and the report says so.
#[test]
fn what_takes_too_long_is_left() {
    if !gpu_or_skip() {
        return;
    }
    let bench = Bench::new();
    bench
        .run(&format!("bench --synth town:200K --max-frame 1e-7 --views far --methods early-z,hqs {SMALL} -o left"))
        .expect(0);
    let left = report(&bench, "left");
    for row in list(&left["blocks"]).iter().flat_map(|block| list(&block["rows"])) {
        let abandoned = &row["abandoned"];
        let passes = if row["method"] == "hqs" { 2 } else { 1 };
        assert_eq!(abandoned["of"], passes * 200_000, "{row}");
        assert!(
            abandoned["points"].as_u64().unwrap() < 200_000 && row["frame_secs"].is_null() && row["accuracy"].is_null()
        );
    }
    let csv = fs::read_to_string(bench.path("left/bench.csv")).unwrap();
    assert!(!csv.contains("\nblock,"), "no figure instead of a guess");
    assert!(fs::read_to_string(bench.path("left/index.html")).unwrap().contains("abandoned after"));
    // With time enough for the first frame in ten times the limit, one frame is drawn.
    let single = "--max-frame 2e-3 --views far --methods hqs --size 160x90 --parts tables --orders original --quiet";
    bench.run(&format!("bench --synth town:1M {single} -o single")).expect(0);
    let row = &report(&bench, "single")["blocks"][0]["rows"][0];
    let samples = list(&row["samples"]["frame_secs"]).len();
    let is_consistent = match (row["is_single"].as_bool().unwrap(), row["abandoned"].is_null()) {
        (true, true) => samples == 1,
        (false, true) => samples > 1,
        _ => samples == 0,
    };
    assert!(is_consistent, "{row}");
}

#[test]
fn reports_become_a_chart() {
    if !gpu_or_skip() {
        return;
    }
    let bench = Bench::new();
    for points in ["10K", "40K"] {
        let what = format!("--synth town:{points} --views overview --methods early-z,two-pass-32,just-set");
        bench.run(&format!("bench {what} {SMALL} -o r{points}")).expect(0);
    }
    bench.run("bench --chart chart.svg r10K r40K/bench.json --methods early-z,two-pass-32").expect(0);
    let svg = fs::read_to_string(bench.path("chart.svg")).unwrap();
    assert!(svg.contains(">early-z<") && svg.contains(">two-pass-32<") && !svg.contains("just-set"));
    assert_eq!(svg.matches("<circle").count(), 4, "two methods, two reports");
    let missing = bench.run("bench --chart chart2.svg r10K --orders morton").expect(2);
    assert!(missing.messages()[0].contains("no report has frame times of morton order"), "{}", missing.stderr);
    bench.write("other.json", "{}");
    assert!(bench.run("bench --chart chart2.svg other.json").expect(2).stderr.contains("expected a report"));
    bench.run("bench --chart chart2.svg nowhere.json").expect(2);
    bench.run("bench --chart chart2.svg").expect(2);
    assert!(!bench.path("chart2.svg").exists());
}
