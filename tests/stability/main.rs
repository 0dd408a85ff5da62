//! Every experiment of `firstlight stability`: as it is, it shows what it says; with its remedy switched off, nothing
//! holds any more; with the failing method cured, nothing fails any more.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a test fails where it stands, says what it measured, and that it is skipped"
)]

use firstlight::{
    measure::stability::{
        Claim, EXPERIMENTS, Entry, Role, Setup, Size, StabilityReport, Swap, Watcher, by_name, markdown, page,
        stability, write_csv,
    },
    methods::Gpu,
};

struct Silent;

impl Watcher for Silent {
    fn step(&mut self, _: usize, _: usize, _: &str) {}
    fn save(&mut self, _: &StabilityReport) -> Result<(), firstlight::measure::ReportDirError> {
        Ok(())
    }
}

/// The GPU at hand. Without one, what needs it is skipped, loudly, or fails if FIRSTLIGHT_REQUIRE_GPU is set.
fn gpu() -> Option<Gpu> {
    match Gpu::headless() {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            assert!(std::env::var_os("FIRSTLIGHT_REQUIRE_GPU").is_none(), "a GPU is required: {error}");
            eprintln!("SKIPPED on a GPU: {error}");
            None
        }
    }
}

fn run(name: &str, gpu: Option<Gpu>, swap: Swap) -> StabilityReport {
    let setup = Setup { gpu, size: Size::Small, swap };
    stability(&[by_name(name).unwrap()], &setup, "device", "command", &mut Silent).unwrap()
}

fn claims(entry: &Entry, role: Role) -> impl Iterator<Item = &Claim> {
    entry.claims.iter().filter(move |claim| claim.role == role && claim.is_true.is_some())
}

fn tell(claim: &Claim) -> String {
    format!("{} {}: {} is {} of {:?}", claim.method, claim.role.name(), claim.quantity, claim.value, claim.bound)
}

/// What holds without its remedy too, since nothing is wrong there yet: not a fault of the experiment.
fn is_easy(name: &str, claim: &Claim) -> bool {
    name == "close-planes" && claim.quantity.ends_with("from 1 m")
}

fn check(name: &str) {
    let gpu = gpu();
    let report = run(name, gpu.clone(), Swap::Nothing);
    let entry = &report.experiments[0];
    entry.claims.iter().for_each(|claim| println!("{name}: {} ({:?})", tell(claim), claim.is_true));
    for claim in &entry.claims {
        assert_ne!(claim.is_true, Some(false), "{name}: {}", tell(claim));
    }
    assert!(report.is_stable() && report.complete);
    if entry.verdict(Role::Holds).is_none() {
        assert!(
            entry.claims.iter().all(|claim| claim.not_counted.is_some()),
            "{name}: whoever does not count says why"
        );
        eprintln!("SKIPPED: {name} is not judged on this device");
        return;
    }

    let without = run(name, gpu.clone(), Swap::RemedyOff);
    for claim in claims(&without.experiments[0], Role::Holds).filter(|claim| !is_easy(name, claim)) {
        assert_eq!(claim.is_true, Some(false), "{name} without its remedy: {}", tell(claim));
    }
    assert!(!without.is_stable(), "{name}");
    let cured = run(name, gpu.clone(), Swap::FailureCured);
    for claim in claims(&cured.experiments[0], Role::Fails) {
        assert_eq!(claim.is_true, Some(false), "{name} with its failure cured: {}", tell(claim));
    }
    assert!(!cured.is_stable(), "{name}");

    // A processor alone can run it as well, and what it cannot show it says.
    if gpu.is_some() {
        let alone = run(name, None, Swap::Nothing);
        assert!(alone.is_stable(), "{name}, without a GPU");
        assert!(alone.experiments[0].claims.iter().all(|claim| claim.is_true.is_some() || claim.not_counted.is_some()));
    }
}

macro_rules! experiments {
    ($($test:ident $name:literal),* $(,)?) => {
        $(#[test] fn $test() { check($name); })*
        const TESTED: &[&str] = &[$($name),*];
    };
}

experiments! {
    far_coordinates "far-coordinates",
    moving_origin "moving-origin",
    close_planes "close-planes",
    shuffles "shuffles",
    unshuffled "unshuffled",
    moved_slots "moved-slots",
    many_fragments "many-fragments",
    one_pixel "one-pixel",
    racing_threads "racing-threads",
    slot_zero "slot-zero",
    point_size "point-size",
    equal_depths "equal-depths",
    degenerate "degenerate",
    exposure "exposure",
    starved_fill "starved-fill",
    holes "holes",
}

#[test]
fn every_experiment_is_tested_and_says_what_it_is() {
    let names: Vec<&str> = EXPERIMENTS.iter().map(|experiment| experiment.name).collect();
    assert_eq!(names, TESTED);
    for e in EXPERIMENTS {
        assert!([e.what, e.source, e.fails, e.holds].iter().all(|text| text.len() > 10), "{}", e.name);
    }
}

/// No clock, no chance: two runs say the same.
#[test]
fn results_repeat() {
    for name in ["far-coordinates", "moving-origin", "unshuffled", "point-size", "slot-zero", "exposure"] {
        let [a, b] = [(); 2].map(|()| run(name, None, Swap::Nothing));
        assert_eq!(a.experiments[0].claims, b.experiments[0].claims, "{name}");
    }
}

#[test]
fn a_report_has_all_samples_and_says_what_is_wrong() {
    let good = run("exposure", None, Swap::Nothing);
    let mut csv = Vec::new();
    write_csv(&mut csv, &good).unwrap();
    let csv = String::from_utf8(csv).unwrap();
    let samples: usize = good.experiments[0].claims.iter().map(|claim| claim.samples.len()).sum();
    assert_eq!(csv.lines().count(), 1 + samples);
    let json = serde_json::to_value(&good).unwrap();
    assert_eq!((&json["report"], &json["complete"]), (&"firstlight stability".into(), &true.into()));
    assert_eq!(json["experiments"][0]["claims"].as_array().unwrap().len(), good.experiments[0].claims.len());
    let html = page(&good);
    assert!(html.contains("data:image/png;base64,") && html.contains("as expected"));
    assert!(markdown(&good).contains("| exposure |"));

    let bad = run("exposure", None, Swap::RemedyOff);
    assert!(page(&bad).contains("OURS DOES NOT HOLD") && markdown(&bad).contains("OURS DOES NOT HOLD"));
    let cured = run("exposure", None, Swap::FailureCured);
    assert!(markdown(&cured).contains("NO LONGER FAILS"));
}
