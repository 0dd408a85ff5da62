//! What the user may get wrong, each with its line and its exit code.

use std::{io::Read, process::Stdio};

use firstlight::synth::Scene;

use crate::bench::Bench;

const CAMERA: &str = r#"{"eye":[500000,4999500,400],"target":[500000,5000000,0],"up":[0,0,1],"fov_y_deg":60}"#;

#[test]
fn every_mistake_has_its_line_and_its_code() {
    let bench = Bench::new();
    bench.scan("a.las", Scene::Planes, 100);
    bench.write("noise.laz", "this is no point cloud, whatever its name says");
    bench.write("empty.las", "");
    bench.write("cam.json", CAMERA);
    bench.write("cut.json", &CAMERA[..40]);
    bench.write("misspelt.json", CAMERA.replace("fov_y_deg", "fov"));
    bench.write("nowhere.json", CAMERA.replace("[500000,5000000,0]", "[500000,4999500,400]"));
    bench.write("wide.json", CAMERA.replace("60", "180"));
    std::fs::create_dir(bench.path("folder")).unwrap();
    let before = bench.names();

    // Arguments after `render`, exit code, and words of the message.
    for (args, code, words) in [
        ("", 2, &["IN", "--output"][..]),
        ("a.las", 2, &["--output"]),
        ("-o a.png", 2, &["IN"]),
        ("a.las -o x.png --size 0x10", 2, &["--size", "1600x900", "0x10"]),
        ("a.las -o x.png --size 100000x100000", 2, &["--size", "pixels"]),
        ("a.las -o x.png --point-size 9", 2, &["--point-size", "pixels from 1 to 8"]),
        ("a.las -o x.png --point-size 5cm", 2, &["--point-size", "0.05m, 0.2ft or 0.05u"]),
        ("a.las -o x.jpg", 2, &["-o x.jpg", "PNG", "x.png"]),
        ("a.las -o x.TIFF", 2, &["-o x.TIFF", "PNG", "x.png"]),
        ("a.las -o x.png --color-map jet", 2, &["--color-map", "viridis, plasma", "`jet`"]),
        ("a.las -o x.png --color-by colour", 2, &["--color-by", "auto, rgb, intensity", "extra:NAME", "`colour`"]),
        ("a.las -o x.png --decorate ruler", 2, &["--decorate", "none or some of box", "`ruler`"]),
        ("a.las -o x.png --fill 0", 2, &["--fill", "at least 1"]),
        ("a.las -o x.png --fill many", 2, &["--fill", "250k", "many"]),
        ("a.las -o x.png --stop later", 2, &["--stop", "converged", "later"]),
        ("a.las -o x.png --stop frames=0", 2, &["--stop", "frames=1"]),
        ("a.las -o x.png --method paint", 2, &["--method", "early-z", "points"]),
        ("a.las -o x.png --method just-set", 2, &["no depth test", "early-z", "firstlight bench"]),
        ("a.las -o x.png --edl -1", 2, &["--edl"]),
        ("a.las -o x.png --no-such-flag", 2, &["--no-such-flag"]),
        ("a.las -o x.png --brute-force --stop frames=3", 2, &["--brute-force", "--stop"]),
        ("a.las -o x.png --backend cpu --method early-z", 2, &["--method", "--backend cpu"]),
        ("a.las -o x.png --depth ./x.png", 2, &["-o", "--depth", "x.png"]),
        ("a.las -o a.las", 2, &["-o", "a.las", "input"]),
        ("a.las -o x.png --camera none.json", 2, &["--camera", "none.json"]),
        ("a.las -o x.png --camera cut.json", 2, &["cut.json", "fov_y_deg", "line 1 column 40"]),
        ("a.las -o x.png --camera misspelt.json", 2, &["misspelt.json", "unknown field `fov`"]),
        ("a.las -o x.png --camera nowhere.json", 2, &["eye and target are the same"]),
        ("a.las -o x.png --camera wide.json", 2, &["fov_y_deg", "180"]),
        ("missing.las -o x.png", 3, &["missing.las", "no such file"]),
        ("noise.laz -o x.png", 3, &["noise.laz", "LASF", "this"]),
        ("empty.las -o x.png", 3, &["empty.las", "empty file"]),
        ("folder -o x.png", 3, &["folder", "no .las or .laz"]),
        ("a.las -o none/x.png", 5, &["none/x.png", "no folder none"]),
        ("a.las -o x.png --ids folder", 5, &["folder", "file name"]),
        ("a.las -o x.png --json none/x.json", 5, &["none/x.json", "no folder"]),
    ] {
        let backend = if args.contains("--backend") || code == 2 { "" } else { "--backend cpu" };
        let run = bench.run(&format!("render {args} {backend}"));
        assert_eq!(run.code, Some(code), "{args}: {}", run.stderr);
        for word in words {
            assert!(run.stderr.contains(word), "{args}: no `{word}` in {}", run.stderr);
        }
        if code != 2 {
            assert_eq!(run.stderr.lines().count(), 1, "{args}: {}", run.stderr);
        }
        assert_eq!(bench.names(), before, "{args}: nothing is left behind");
    }
}

#[test]
fn options_that_change_nothing_are_noted() {
    let bench = Bench::new();
    bench.scan("a.las", Scene::Planes, 100);
    let render =
        |args: &str| bench.run(&format!("render a.las --backend cpu --size 32x32 --json r.json {args}")).expect(0);
    let run = render("--color-map turbo --color-range 1,2 --class-color 6=#ff0000 --color-by rgb");
    let messages = run.messages().join("\n");
    for option in ["--color-map", "--color-range", "--class-color"] {
        assert_eq!(
            messages.matches(&format!("firstlight: {option} changes nothing in colours by rgb")).count(),
            1,
            "{messages}"
        );
    }
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(bench.path("r.json")).unwrap()).unwrap();
    assert_eq!(report["notes"].as_array().unwrap().len(), 3, "{report}");
    let run = render("--color-by elevation --color-map turbo --color-range 1,2");
    assert_eq!(run.messages(), [""; 0]);
}

#[test]
fn help_and_version_are_no_mistakes() {
    let bench = Bench::new();
    for args in ["--help", "render --help", "synth --help", "info --help", "bench-ingest --help", "help", "--version"] {
        assert!(!bench.run(args).expect(0).stdout.is_empty());
    }
    let help = bench.run("render --help").stdout;
    let help = String::from_utf8(help).unwrap();
    for words in ["Exit codes:", "  4  partly read", "--brute-force", "REPORT.json", "fov_y_deg"] {
        assert!(help.contains(words), "{words}");
    }
    assert!(!help.contains("--insertion-points"), "for tests");
}

#[test]
fn a_reader_that_has_seen_enough_is_no_mistake() {
    let bench = Bench::new();
    bench.scan("a.las", Scene::Planes, 100);
    for args in ["render a.las --json - --backend cpu", "--help", "info a.las"] {
        let mut child = bench.command(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let mut stderr = String::new();
        child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(0), "{args}: {stderr}");
    }
}

#[test]
fn a_gpu_that_is_not_there_is_said() {
    let bench = Bench::new();
    bench.scan("a.las", Scene::Planes, 100);
    let run = |args: &str| {
        // No driver can be loaded from these places.
        let nowhere = bench.path("no-driver.json");
        let mut command = bench.command(args);
        let output = command.env("VK_DRIVER_FILES", &nowhere).env("VK_ICD_FILENAMES", &nowhere).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    if cfg!(target_os = "linux") {
        let (code, message) = run("render a.las -o x.png --backend gpu");
        assert_eq!(code, Some(6), "{message}");
        assert!(message.contains("no GPU adapter") && message.contains("--backend cpu"), "{message}");
        let (code, message) = run("render a.las -o x.png --method points");
        assert_eq!(code, Some(6), "{message}");
        assert!(!bench.path("x.png").exists());
        let (code, message) = run("render a.las -o x.png");
        assert_eq!(code, Some(0), "{message}");
        assert!(message.contains("drawn on the processor"), "{message}");
        assert!(bench.path("x.png").exists());
    }
}

#[test]
#[cfg(all(unix, not(target_os = "macos")))]
fn without_a_display_there_is_a_picture_beside_the_scan() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("deep")).unwrap();
    bench.scan("deep/scan.laz", Scene::Planes, 1_000);
    let run = bench.run("deep/scan.laz").expect(0);
    assert!(run.messages()[0].contains("no display"), "{}", run.stderr);
    assert!(run.messages()[0].contains("deep/scan.png"), "{}", run.stderr);
    bench.run("deep/scan.laz").expect(0);
    assert!(bench.path("deep/scan.png").exists());
    assert!(bench.path("deep/scan-1.png").exists(), "the first picture is not replaced");

    let run = bench.run("").expect(2);
    assert!(run.stderr.contains("no display") && run.stderr.contains("render"), "{}", run.stderr);
    let run = bench.run("deep/none.laz").expect(3);
    assert_eq!(run.messages().len(), 1, "{}", run.stderr);
    assert!(!bench.path("deep/none.png").exists());

    // A scan called like a command.
    std::fs::copy(bench.path("deep/scan.laz"), bench.path("render")).unwrap();
    bench.run("./render").expect(0);
    assert!(bench.path("render.png").exists());
    bench.run("deep/scan.laz render").expect(0);
    assert!(bench.path("deep/scan-2.png").exists());
}

#[test]
fn outputs_replace_files_and_leave_devices() {
    let bench = Bench::new();
    bench.scan("a.las", Scene::Planes, 100);
    bench.write("x.png", "an older picture");
    bench.run("render a.las -o x.png --backend cpu --quiet").expect(0);
    assert!(std::fs::read(bench.path("x.png")).unwrap().starts_with(b"\x89PNG"));
    assert_eq!(bench.names(), ["a.las", "x.png"]);
    if cfg!(unix) {
        bench.run("render a.las -o /dev/null --backend cpu --quiet").expect(0);
        assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
    }
    let run = bench.run("render a.las -o - --backend cpu --quiet").expect(0);
    assert!(run.stdout.starts_with(b"\x89PNG"));
}
