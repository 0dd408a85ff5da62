//! `firstlight stability` as a user runs it.

use std::fs;

use serde_json::Value;

use crate::bench::Bench;

#[test]
fn a_report_is_written_and_written_over() {
    let bench = Bench::new();
    let run = bench.run("stability --only exposure,slot-zero --no-gpu -o out").expect(0);
    assert!(run.stderr.contains("0 of 2: slot-zero") && run.stderr.contains("index.html"), "{}", run.stderr);
    assert!(String::from_utf8(run.stdout).unwrap().contains("| slot-zero |"));
    let report: Value = serde_json::from_slice(&fs::read(bench.path("out/stability.json")).unwrap()).unwrap();
    assert_eq!((&report["report"], &report["complete"]), (&"firstlight stability".into(), &true.into()));
    let names: Vec<&Value> = report["experiments"].as_array().unwrap().iter().map(|entry| &entry["name"]).collect();
    assert_eq!(names, ["slot-zero", "exposure"], "in the order of the table");
    let html = fs::read_to_string(bench.path("out/index.html")).unwrap();
    let sheet = fs::read(bench.path("out/stability.png")).unwrap();
    assert!(sheet.starts_with(b"\x89PNG") && sheet[16..20] == 732_u32.to_be_bytes(), "three pictures side by side");
    assert!(html.contains("--only exposure,slot-zero") && html.contains("data:image/png"));
    assert!(!html.contains("src=\"http") && !html.contains("<script"), "one page, nothing else needed");
    assert!(fs::read_to_string(bench.path("out/stability.csv")).unwrap().lines().count() > 8);
    bench.run("stability --only slot-zero --no-gpu -q -o out").expect(0);
    assert!(!fs::read_to_string(bench.path("out/stability.json")).unwrap().contains("exposure"));
}

#[test]
fn without_a_folder_there_is_a_table() {
    let bench = Bench::new();
    let run = bench.run("stability --only slot-zero --no-gpu").expect(0);
    assert!(String::from_utf8(run.stdout).unwrap().contains("as expected"));
    assert!(bench.names().is_empty());
    let list = String::from_utf8(bench.run("stability --list").expect(0).stdout).unwrap();
    assert!(list.contains("far-coordinates") && list.contains("starved-fill") && list.contains("from:"));
}

#[test]
fn what_is_wrong_is_said_before_the_work() {
    let bench = Bench::new();
    fs::create_dir(bench.path("taken")).unwrap();
    bench.write("taken/other.txt", "mine");
    for (args, code, says) in [
        ("--only no-such", 2, "far-coordinates, moving-origin"),
        ("--only no-such", 2, "starved-fill"),
        ("scan.las", 2, "unexpected argument"),
        ("-o taken", 5, "holds other files"),
    ] {
        let run = bench.run(&format!("stability {args}")).expect(code);
        assert!(run.stderr.contains(says), "{args}: {}", run.stderr);
    }
    let help = String::from_utf8(bench.run("stability --help").expect(0).stdout).unwrap();
    assert!([0, 1, 2, 4, 5, 6].iter().all(|code| help.contains(&format!("\n  {code}  "))), "every exit code is listed");
}
