//! `firstlight pick`, held to `render --ids`; `firstlight point`; what both print.

use firstlight::synth::Scene;
use serde_json::Value;

use crate::bench::{Bench, Outputs, ways_to_draw};

/// JSON of a pick at these pixels.
fn picked(bench: &Bench, args: &str, pixels: &[[usize; 2]], reach: usize) -> Vec<Value> {
    let at: String = pixels.iter().map(|[x, y]| format!(" --at {x},{y}")).collect();
    let run = bench.run(&format!("pick {args} --reach {reach} --json{at}")).expect(0);
    serde_json::from_slice(&run.stdout).unwrap()
}

/// The pixel with a point nearest to `at`, by distance, then depth, then place.
fn nearest(outputs: &Outputs, [x, y]: [usize; 2], reach: usize) -> Option<usize> {
    let distance = |p: usize| (p % outputs.shape[1]).abs_diff(x).pow(2) + (p / outputs.shape[1]).abs_diff(y).pow(2);
    let shown = (0..outputs.ids.len()).filter(|&p| outputs.ids[p] >= 0 && distance(p) <= reach * reach);
    shown.min_by(|&a, &b| {
        distance(a).cmp(&distance(b)).then(outputs.depth[a].total_cmp(&outputs.depth[b])).then(a.cmp(&b))
    })
}

#[test]
fn a_pick_is_the_id_of_the_picture_on_every_rasterizer() {
    let bench = Bench::new();
    bench.scan("a.laz", Scene::Town, 60_000);
    bench.scan("b.las", Scene::Planes, 20_000);
    for way in ways_to_draw() {
        let args = format!("a.laz b.las --size 300x200 {way}");
        let outputs = bench.render(&args);
        // Some that show a point, and some background two columns before one.
        let pixels = |wanted: &dyn Fn(usize) -> bool| {
            let all: Vec<usize> = (0..outputs.ids.len() - 2).filter(|&p| p % 300 < 298 && wanted(p)).collect();
            (0..20).map(move |i| all[i * 7_919 % all.len()]).map(|p| [p % 300, p / 300]).collect::<Vec<_>>()
        };
        let shows = |p: usize| outputs.ids[p] >= 0;
        let pixels = [pixels(&shows), pixels(&|p| !shows(p) && shows(p + 2))].concat();
        let mut hits = [0; 2];
        for (i, reach) in [0, 5].into_iter().enumerate() {
            for (at, found) in pixels.iter().zip(picked(&bench, &args, &pixels, reach)) {
                let expected = nearest(&outputs, *at, reach);
                assert_eq!(found.is_null(), expected.is_none(), "{way}, {at:?}, {reach}: {found}");
                let Some(p) = expected else { continue };
                assert_eq!(found["id"], outputs.ids[p], "{way}, {at:?}, {reach}");
                assert_eq!(
                    [&found["pixel_x"], &found["pixel_y"]].map(Value::as_u64),
                    [p % 300, p / 300].map(|n| Some(n as u64))
                );
                assert_eq!(found["depth"].as_f64().map(|depth| depth as f32), Some(outputs.depth[p]));
                // The record of its file, with that file's own name.
                let id = outputs.ids[p] as u64;
                let (file, record) = if id < 60_000 { ("a.laz", id) } else { ("b.las", id - 60_000) };
                assert_eq!((found["file"].as_str(), found["record"].as_u64()), (Some(file), Some(record)), "{way}");
                hits[i] += 1;
            }
        }
        assert_eq!(hits, [20, 40], "{way}");
    }
}

#[test]
fn a_point_is_printed_in_three_forms() {
    let bench = Bench::new();
    bench.scan("a.laz", Scene::Town, 5_000);
    let json = bench.run("point a.laz 4321 --json").expect(0);
    let object: Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((object["record"].as_u64(), object["format"].as_u64()), (Some(4321), Some(3)));
    let text = String::from_utf8(bench.run("point a.laz 4321").expect(0).stdout).unwrap();
    let x = serde_json::to_string(&object["x"]).unwrap();
    assert!(text.contains(&format!("\nX                 {x}")), "{text}");
    let csv = String::from_utf8(bench.run("point a.laz 0 4321 4999 --csv").expect(0).stdout).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 4, "{csv}");
    assert!(lines[0].starts_with("file,record,format,X,Y,Z,x,y,z,intensity,"));
    assert!(lines[2].starts_with(&format!("a.laz,4321,3,{},", object["X"])), "{csv}");
    let all: Value = serde_json::from_slice(&bench.run("point a.laz 0 4321 --json").expect(0).stdout).unwrap();
    assert_eq!(all[1], object);
    let range: Value = serde_json::from_slice(&bench.run("point a.laz 4320..4322 --json").expect(0).stdout).unwrap();
    assert_eq!((range.as_array().unwrap().len(), &range[1]), (3, &object));
}

#[test]
fn every_mistake_has_its_line() {
    let bench = Bench::new();
    bench.scan("a.las", Scene::Planes, 100);
    bench.write("noise.laz", "this is no point cloud, whatever its name says");
    for (args, code, words) in [
        ("point a.las 100", 2, &["a.las", "no record 100", "expected 0 to 99"][..]),
        ("point a.las -1", 2, &["-1"]),
        ("point a.las", 2, &["RECORD"]),
        ("point a.las 1-5", 2, &["1-5", "1200..1205"]),
        ("point a.las 98..100", 2, &["no record 100"]),
        ("pick a.las --at 5,5 --edl 1", 2, &["--edl"]),
        ("pick a.las --at 5,5 --color-by rgb", 2, &["--color-by"]),
        ("point a.las 1 --json --csv", 2, &["--json", "--csv"]),
        ("point none.las 1", 3, &["none.las", "no such file"]),
        ("point noise.laz 1", 3, &["noise.laz", "LASF"]),
        ("pick a.las", 2, &["--at"]),
        ("pick a.las --at 5", 2, &["--at", "800,450"]),
        ("pick a.las --at 100,5 --size 100x100", 2, &["--at 100,5", "100x100", "--size"]),
        ("pick a.las --at 5,5 --reach 65", 2, &["--reach", "0..=64"]),
        ("pick none.las --at 5,5", 3, &["none.las"]),
        (r#"pick a.las --at 5,5 --camera {"eye":[0,0,1]}"#, 2, &["--camera", "missing field `target`"]),
    ] {
        let run = bench.run(args).expect(code);
        for word in words {
            assert!(run.stderr.contains(word), "{args}: no `{word}` in {}", run.stderr);
        }
    }
    let far = r#"--camera {"eye":[0,0,1],"target":[0,0,2]}"#;
    let run = bench.run(&format!("pick a.las --backend cpu --at 5,6 {far}")).expect(0);
    assert_eq!((run.messages(), run.stdout.len()), (vec!["firstlight: no point within 4 pixels of 5,6"], 0));
    // What the run has to say, it says.
    let run = bench.run(&format!("pick a.las --backend cpu --at 5,6 --filter extra:height=1 {far}")).expect(0);
    assert!(run.messages().concat().contains("a.las has no extra:height"), "{}", run.stderr);
    let run = bench.run(&format!("pick a.las --backend cpu --at 5,6 --json {far}")).expect(0);
    assert_eq!(run.stdout, b"null\n");
}
