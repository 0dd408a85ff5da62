//! The picture, its arrays and its report.

use std::fs;

use firstlight::{render::Shading, synth::Scene};
use sha2::{Digest, Sha256};

use crate::bench::{Bench, Outputs, data, gpu_or_skip, ways_to_draw};

#[test]
fn the_outputs_agree() {
    let bench = Bench::new();
    bench.scan("a.laz", Scene::Town, 100_000);
    for point_size in [1, 3] {
        let outputs = bench.render(&format!("a.laz --backend cpu --size 400x300 --point-size {point_size}"));
        assert_eq!(outputs.shape, [300, 400]);
        assert!(outputs.covered() > 10_000, "{}", outputs.covered());
        let rgb = outputs.rgb();
        for ((&id, &depth), &rgb) in outputs.ids.iter().zip(&outputs.depth).zip(&rgb) {
            assert!((-1..100_000).contains(&id));
            assert_eq!(id == -1, depth == f32::INFINITY);
            assert!(depth > 0.0);
            assert!(id >= 0 || rgb == Shading::default().background);
        }
        let rgba: Vec<u8> = rgb.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect();
        let sha: String = Sha256::digest(&rgba).iter().map(|b| format!("{b:02x}")).collect();
        assert_eq!(outputs.report["picture_sha256"], sha);
    }
}

/// Pixels of `outputs` that are not as in `other`, as columns and rows.
fn differing(outputs: &Outputs, other: &Outputs) -> Vec<[usize; 2]> {
    let width = outputs.shape[1];
    let (one, two) = (outputs.rgb(), other.rgb());
    (0..one.len()).filter(|&p| one[p] != two[p]).map(|p| [p % width, p / width]).collect()
}

#[test]
fn a_legend_is_drawn_in_its_corner_and_nowhere_else() {
    let bench = Bench::new();
    bench.scan("town.laz", Scene::Town, 30_000);
    let args =
        "town.laz --backend cpu --size 640x480 --background #204060 --color-by classification --class-color 6=#ff0102";
    let plain = bench.render(args);
    let drawn = bench.render(&format!("{args} --decorate legend"));
    assert!(plain.ids == drawn.ids && plain.depth == drawn.depth);
    let changed = differing(&drawn, &plain);
    let range = |axis: usize| {
        let of = |pixel: &[usize; 2]| pixel[axis];
        (changed.iter().map(of).min().unwrap(), changed.iter().map(of).max().unwrap())
    };
    let ((left, right), (top, bottom)) = (range(0), range(1));
    assert!(left > 320 && right < 640 && top < 30, "{left}..{right}, {top}..{bottom}");
    // The plate covers every pixel between: what changed is one rectangle, but for points that are as dark as it.
    let area = (right + 1 - left) * (bottom + 1 - top);
    assert!(changed.len() * 50 > area * 49, "{} of {area}", changed.len());
    let legend = &drawn.report["legend"];
    assert_eq!(legend["title"], "classification");
    let classes = legend["classes"].as_array().unwrap();
    assert!(classes.len() > 3, "{legend}");
    let sum: u64 = classes.iter().map(|class| class["points"].as_u64().unwrap()).sum();
    assert_eq!(sum, 30_000);
    let (before, after) = (plain.rgb(), drawn.rgb());
    for class in classes {
        let color: [u8; 3] = serde_json::from_value(class["color"].clone()).unwrap();
        let shows = |p: usize| after[p] == color && before[p] == [0x20, 0x40, 0x60];
        let squares = changed.iter().filter(|[x, y]| shows(y * 640 + x)).count();
        assert!(squares > 20, "{class}: {squares} pixels where there was background");
    }
    assert!(classes.iter().any(|class| class["value"] == 6 && class["color"] == serde_json::json!([255, 1, 2])));
}

#[test]
fn the_report_says_what_was_shown_and_how() {
    let bench = Bench::new();
    bench.scan("town.laz", Scene::Town, 5_000);
    let report =
        bench.render("town.laz --backend cpu --size 64x48 --color-by elevation --orthographic --fill-holes").report;
    let look = &report["look"];
    assert_eq!((&look["coloring"]["by"], &look["projection"]), (&"elevation".into(), &"orthographic".into()));
    assert_eq!((&look["shading"]["fill_holes"], &look["shading"]["background"][2]), (&true.into(), &0x22.into()));
    let legend = &report["legend"];
    assert_eq!((&legend["map"], &legend["transfer"]), (&"viridis".into(), &"linear".into()));
    let [low, high] = ["low", "high"].map(|end| legend[end].as_f64().unwrap());
    let [floor, top] = ["min", "max"].map(|end| report["bounds"][end][2].as_f64().unwrap());
    assert!(floor <= low && low < high && high <= top, "{low}..{high} of {floor}..{top}");
    let given = "town.laz --backend cpu --size 64x48 --color-by elevation --color-range 1,2 --color-map turbo";
    let given = bench.render(given).report["legend"].clone();
    assert_eq!((&given["low"], &given["high"], &given["map"]), (&1.0.into(), &2.0.into(), &"turbo".into()));
    assert!(bench.render("town.laz --backend cpu --size 64x48").report["legend"].is_null());
}

#[test]
fn what_is_clipped_fills_the_picture() {
    let bench = Bench::new();
    bench.scan("town.laz", Scene::Town, 200_000);
    let [min, max] = {
        let bounds = bench.render("town.laz --backend cpu --size 64x48").report["bounds"].clone();
        ["min", "max"].map(|end| [0, 1, 2].map(|a| bounds[end][a].as_f64().unwrap()))
    };
    let middle = [0, 1, 2].map(|a| (0.5 * (min[a] + max[a])).round());
    let [x, y, z] = middle;
    let (low, high) = (min[2], max[2]);
    for clip in [
        format!("--clip {},{},{low},{},{},{high}", x - 20.0, y - 20.0, x + 20.0, y + 20.0),
        format!("--clip {},{},{low},{},{},{high},45 --orthographic", x - 20.0, y - 20.0, x + 20.0, y + 20.0),
        format!("--slab {x},{y},{z},1,0,0,4"),
    ] {
        let outputs = bench.render(&format!("town.laz --backend cpu --size 320x240 {clip} --point-size 2"));
        let shown: Vec<usize> = (0..outputs.ids.len()).filter(|&p| outputs.ids[p] >= 0).collect();
        let extent = |of: &dyn Fn(usize) -> usize| {
            let places = shown.iter().map(|&p| of(p));
            places.clone().max().unwrap() - places.min().unwrap()
        };
        let (width, height) = (extent(&|p| p % 320), extent(&|p| p / 320));
        assert!(width > 192 || height > 144, "{clip}: {width} x {height} of 320 x 240 pixels");
    }
}

#[test]
fn a_metre_is_more_than_three_feet() {
    let Some(data) = data() else { return };
    let scan = data.join("scans/pdal-autzen_trim.laz");
    let bench = Bench::new();
    let world = |size: &str, more: &str| {
        let args = format!("{} --backend cpu --size 64x48 --point-size {size} {more}", scan.display());
        bench.render(&args).report["point_size_world"].as_f64()
    };
    let metre = world("1m", "").unwrap();
    assert!((metre * 0.3048 - 1.0).abs() < 1e-5, "{metre}");
    assert_eq!((world("2u", ""), world("3", "")), (Some(2.0), None));
}

/// Ids of the progressive and of the brute-force picture are the same, array for array.
fn assert_exact(bench: &Bench, inputs: &str, way: &str, more: &str) -> Outputs {
    let progressive = bench.render(&format!("{inputs} {way} {more}"));
    assert_eq!(progressive.report["converged"], true);
    let brute_force = bench.render(&format!("{inputs} {way} {more} --brute-force"));
    assert_eq!(brute_force.report["brute_force"], true);
    let differing = progressive.differing_ids(&brute_force);
    assert_eq!(differing, 0, "{inputs} {way} {more}: pixels that differ");
    assert!(progressive.covered() > 0);
    progressive
}

#[test]
fn progressive_is_brute_force() {
    let bench = Bench::new();
    bench.scan("town.laz", Scene::Town, 200_000);
    bench.scan("planes.las", Scene::Planes, 200_000);
    for way in ways_to_draw() {
        for input in ["town.laz", "planes.las"] {
            // Many insertions, and frames that try few points.
            assert_exact(&bench, input, way, "--size 500x400 --insertion-points 20k --fill 30k");
        }
        assert_exact(&bench, "town.laz planes.las", way, "--size 500x400 --point-size 2");
    }
}

#[test]
fn high_quality_is_brute_force() {
    // Of three files, each coloured by another rule.
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_data");
    let folder = folder.to_str().unwrap();
    let bench = Bench::new();
    let mut pictures = Vec::new();
    for way in ways_to_draw() {
        for point_size in [1, 2] {
            let args = format!("{folder} {way} --size 480x360 --point-size {point_size}");
            let averaged = assert_exact(&bench, folder, way, &format!("--size 480x360 --point-size {point_size} --hq"));
            assert_eq!(averaged.report["points_averaged"], averaged.report["points_stored"]);
            let sums = averaged.report["high_quality"].as_str().unwrap();
            assert!(sums == "hqs" || (sums == "hqs1r" && way != "--backend cpu"), "{way}: {sums}");
            let brute_force = bench.render(&format!("{args} --hq --brute-force"));
            assert!(averaged.png == brute_force.png, "{args}: other colours");
            let few = bench.render(&format!("{args} --hq --fill 30k --insertion-points 20k"));
            assert!(averaged.png == few.png, "{args}: other colours with many frames");
            let plain = bench.render(&args);
            assert!(plain.report["high_quality"].is_null());
            assert!(plain.png != averaged.png && plain.ids == averaged.ids, "{args}");
            let moving = bench.render(&format!("{args} --hq --stop frames=2 --fill 30k"));
            assert!(moving.report["high_quality"].is_string() && moving.report["converged"] == false);
            pictures.push((point_size, averaged.rgb()));
        }
    }
    for (size, picture) in &pictures {
        let (_, first) = pictures.iter().find(|(other, _)| other == size).unwrap();
        let unlike = picture.iter().zip(first).filter(|(a, b)| a != b).count();
        // Rounding may decide which pixel a point belongs to where a device fuses operations.
        assert!(unlike * 200 <= picture.len(), "{unlike} of {} pixels unlike the processor's", picture.len());
    }
}

#[test]
fn progressive_is_brute_force_on_samples() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_data");
    if !folder.is_dir() {
        eprintln!("SKIPPED: no {}", folder.display());
        return;
    }
    let bench = Bench::new();
    for way in ways_to_draw() {
        assert_exact(&bench, folder.to_str().unwrap(), way, "--size 640x480");
    }
}

#[test]
fn progressive_is_brute_force_on_real_scans() {
    let Some(data) = data() else { return };
    let bench = Bench::new();
    let ways = ways_to_draw();
    for (name, ways) in [
        ("pdal-autzen_trim_7.las", &ways[..]),
        ("laserchicken-AHN3.laz", &ways[..]),
        ("potree-lion_takanawa.copc.laz", &ways[..1]),
        ("pdal-lone-star.copc.laz", &ways[..1]),
    ] {
        let scan = data.join("scans").join(name);
        for way in ways {
            assert_exact(&bench, scan.to_str().unwrap(), way, "--size 640x480");
        }
    }
}

#[test]
fn the_comparison_sees_a_single_point() {
    let bench = Bench::new();
    bench.scan("a.las", Scene::Planes, 1_000);
    let all = bench.render("a.las --backend cpu --size 300x200");
    let shown = *all.ids.iter().max().unwrap();
    let fewer = bench.render(&format!("a.las --backend cpu --size 300x200 --stop points={shown}"));
    assert!((1..=2).contains(&all.differing_ids(&fewer)), "one point is missing: the last one shown");
}

#[test]
fn a_run_can_be_repeated() {
    let bench = Bench::new();
    bench.scan("a.laz", Scene::Town, 300_000);
    for way in ways_to_draw() {
        let args = format!("a.laz {way} --stop frames=2 --insertion-points 10k --fill 15k --size 320x240");
        let first = bench.render(&args);
        assert_eq!(first.report["frames"], 2);
        assert_eq!(first.report["converged"], false, "{way}: there is something left to go wrong");
        for threads in [1, 3] {
            let again = bench.render(&format!("{args} --threads {threads}"));
            assert!(first.png == again.png, "{way}, {threads} threads: other colours");
            assert!(first.ids == again.ids && first.depth == again.depth, "{way}, {threads} threads: other points");
        }
        // Each point is drawn as it arrives, so that another order in the store shows the same ones; only
        // among points of equal depth may another be shown.
        let other = bench.render(&format!("{args} --seed 2"));
        assert!(first.depth == other.depth, "{way}: the seed changes what is drawn");
    }
}

#[test]
fn only_so_many_points_are_stored() {
    let bench = Bench::new();
    bench.scan("a.laz", Scene::Town, 50_000);
    bench.scan("b.las", Scene::Town, 50_000);
    let outputs = bench.render("a.laz b.las --backend cpu --stop points=60_123 --size 320x240");
    let report = &outputs.report;
    assert_eq!(report["points_stored"], 60_123);
    assert_eq!(report["files"][0]["points_stored"], 50_000);
    assert_eq!(report["files"][1]["points_stored"], 10_123);
    assert_eq!(report["converged"], true);
    assert!(outputs.ids.iter().all(|&id| id < 60_123));
    // Of one batch in part: its colours are those of the whole scan.
    let part = bench.render("a.laz --backend cpu --stop points=5k --size 320x240 --edl 0");
    let whole = bench.render("a.laz --backend cpu --size 320x240 --edl 0");
    let (part_rgb, whole_rgb) = (part.rgb(), whole.rgb());
    let same: Vec<usize> = (0..part.ids.len()).filter(|&i| part.ids[i] >= 0 && part.ids[i] == whole.ids[i]).collect();
    assert!(same.len() > 100);
    assert!(same.iter().all(|&i| part_rgb[i] == whole_rgb[i]));
}

#[test]
fn the_reported_camera_gives_the_same_picture() {
    let bench = Bench::new();
    bench.scan("a.laz", Scene::Town, 100_000);
    let mut scans = vec![bench.path("a.laz")];
    scans.extend(data().map(|data| data.join("scans/vapc-vasp_in.laz")));
    for scan in scans {
        let args = format!("{} --backend cpu --size 400x300", scan.display());
        let fitted = bench.render(&args);
        assert_eq!(fitted.report["camera_given"], false);
        bench.write("cam.json", fitted.report["camera"].to_string());
        let given = bench.render(&format!("{args} --camera cam.json"));
        assert_eq!(given.report["camera_given"], true);
        assert_eq!(given.report["camera"], fitted.report["camera"]);
        assert!(fitted.ids == given.ids && fitted.depth == given.depth && fitted.png == given.png);
    }
}

/// The workgroup size of `NAME:SIZE`.
fn group_of(asked: &str) -> u32 {
    asked.split_once(':').map_or(256, |(_, size)| size.parse().unwrap())
}

#[test]
fn the_report_is_complete() {
    let bench = Bench::new();
    bench.scan("a.las", Scene::Town, 100_000);
    for way in ways_to_draw() {
        let report = bench.render(&format!("a.las {way} --size 320x200 --seed 7")).report;
        for key in ["points_in_header", "points_decoded", "points_stored"] {
            assert_eq!(report[key], 100_000, "{key}");
            assert_eq!(report["files"][0][key], 100_000, "{key} of the file");
        }
        assert_eq!(report["points_missing"], 0);
        assert_eq!(report["batches"], 2, "65,536 points and the rest");
        assert!(report["frames"].as_u64().unwrap() >= 1);
        assert_eq!(report["converged"], true);
        assert_eq!(report["seed"], 7);
        assert_eq!(report["size_px"], serde_json::json!([320, 200]));
        assert_eq!(report["point_size_px"], 1);
        assert_eq!(report["files"][0]["kind"], "LAS 1.2, format 3");
        assert_eq!(report["files"][0]["first_record"], 0);
        let asked = way.strip_prefix("--method ").unwrap_or("cpu");
        let method = asked.split(':').next().unwrap();
        assert_eq!(report["method"], method);
        assert_eq!(report["backend"], if method == "cpu" { "cpu" } else { "gpu" });
        if method == "cpu" {
            assert!(report["choice"].is_null());
        } else {
            assert_eq!(report["choice"]["method"], method);
            assert_eq!(report["choice"]["why"], "asked for");
            let group = if method == "points" { serde_json::Value::Null } else { group_of(asked).into() };
            assert_eq!(report["choice"]["group_size"], group);
        }
        for key in ["program", "adapter", "api", "picture_sha256"] {
            assert!(!report[key].as_str().unwrap().is_empty(), "{key}");
        }
        let seconds = ["to_first_point", "to_first_picture", "to_all_loaded", "to_converged", "to_picture"]
            .map(|key| report["seconds"][key].as_f64().unwrap_or_else(|| panic!("{key}: {report}")));
        assert!(seconds[0] > 0.0 && seconds.is_sorted_by(|a, b| a <= b), "{seconds:?}");
        if cfg!(target_os = "linux") {
            assert!(report["peak_memory_bytes"].as_u64().unwrap() > 1 << 20);
        }
        for (key, name) in
            [("picture", "out.png"), ("ids", "ids.npy"), ("depth", "depth.npy"), ("report", "report.json")]
        {
            assert_eq!(report["outputs"][key], name);
        }
    }
}

#[test]
fn the_choice_and_its_figures_are_in_the_reports() {
    if !gpu_or_skip() {
        return;
    }
    let bench = Bench::new();
    bench.run("bench-frames --synth town:100k --at 100k --frames 2 --size 320x200 --json frames.json").expect(0);
    let report: serde_json::Value = serde_json::from_slice(&fs::read(bench.path("frames.json")).unwrap()).unwrap();
    let choice = &report["choice"];
    assert_eq!(choice["why"], "measured", "{choice}");
    assert_eq!(choice["method"], report["method"]);
    assert!(!choice["reason"].as_str().unwrap().is_empty());
    assert_eq!(choice["measurement"]["size_px"], serde_json::json!([320, 200]));
    for key in ["at_secs", "took_secs", "points"] {
        assert!(choice["measurement"][key].as_f64().unwrap() > 0.0, "{key}: {choice}");
    }
    let rows = choice["candidates"].as_array().unwrap();
    assert_eq!(rows.len(), 19, "six methods in three group sizes, and point lists");
    let mut speeds = 0;
    for row in rows {
        assert!(row["method"].is_string(), "{row}");
        if row["speed"].is_null() {
            assert!(!row["left_out"].as_str().unwrap().is_empty(), "{row}");
            continue;
        }
        speeds += 1;
        assert!(["device timestamps", "wall clock"].contains(&row["speed"]["clock"].as_str().unwrap()));
        for view in ["overview_points_per_sec", "far_points_per_sec"] {
            assert!(row["speed"][view].as_f64().unwrap() > 1e3, "{row}");
        }
    }
    assert!(speeds > 0);

    // A picture that is finished sooner says what it was drawn with, and why.
    bench.scan("a.las", Scene::Town, 3_000);
    let report = bench.render("a.las --size 64x48 --backend gpu").report;
    assert_eq!(report["choice"]["why"], "default");
    assert_eq!(report["choice"]["method"], report["method"]);
    assert!(report["choice"]["measurement"].is_null());
}

#[test]
fn a_scan_without_points_is_an_empty_picture() {
    let bench = Bench::new();
    let path = bench.scan("a.las", Scene::Planes, 10);
    let mut bytes = fs::read(&path).unwrap();
    bytes[107..111].fill(0);
    let points_at = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize;
    fs::write(&path, &bytes[..points_at]).unwrap();
    for way in ways_to_draw() {
        let outputs = bench.render(&format!("a.las {way} --size 64x48"));
        assert_eq!(outputs.covered(), 0);
        assert_eq!(outputs.report["converged"], true);
        assert!(outputs.report["seconds"]["to_first_point"].is_null());
    }
}

#[test]
fn pictures_without_what_was_asked_for_say_so() {
    let bench = Bench::new();
    let path = bench.scan("a.las", Scene::Planes, 1000);
    let notes =
        |args: &str| bench.render(&format!("a.las --backend cpu --size 64x48 {args}")).report["notes"].to_string();
    for (args, note) in [
        ("--filter user-data=255", "no point is shown: --filter left none"),
        ("--filter class=0.. --clip 0,0,0,1,1,1", "no point is shown: --filter and --clip left none"),
        ("--slab 0,0,0,1,0,0,1", "no point is shown: --slab left none"),
    ] {
        assert!(notes(args).contains(note), "{args}: {}", notes(args));
    }
    let grey = "a.las: red, green and blue of all points are 0";
    assert!(!notes("--color-by rgb").contains(grey) && !notes("--filter class=0..").contains("no point is shown"));
    let mut bytes = fs::read(&path).unwrap();
    let rgb_at = match bytes[104] & 63 {
        2 => 20,
        3 => 28,
        _ => 30,
    };
    let points_at = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize;
    let length = usize::from(u16::from_le_bytes([bytes[105], bytes[106]]));
    bytes[points_at..].chunks_exact_mut(length).for_each(|record| record[rgb_at..rgb_at + 6].fill(0));
    fs::write(&path, &bytes).unwrap();
    assert!(notes("--color-by rgb").contains(grey), "{}", notes("--color-by rgb"));
}
