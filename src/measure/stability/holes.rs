//! What hole filling gets right and wrong: a scene is thinned out, filled, and compared with the picture of all points.

use super::{
    StabilityError,
    experiment::{Claim, Outcome, Setup},
    picture::{Image, Strip},
    scenes::{Scene, request},
};
use crate::render::{Camera, CpuBackend, HOLE_MASK, HOLE_REACH, Picture, Reprojection, StoreOptions, hole_source};

const SIZE: [u32; 2] = [320, 240];

/// How holes are told from background.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// Not at all: they stay open.
    Open,
    /// Whatever has a point in reach is one.
    All,
    /// By the masks.
    Masks,
}

/// Which pixel each background pixel of a picture takes its colour from, if any.
fn sources(way: Way, picture: &Picture) -> Vec<Option<usize>> {
    let size = [picture.width as usize, picture.height as usize];
    let mask = if way == Way::Masks { HOLE_MASK } else { 9 };
    let source = |at: usize| match way {
        _ if picture.records[at] >= 0 => None,
        Way::Open => None,
        Way::All | Way::Masks => hole_source(size, at, HOLE_REACH, mask, |at| picture.depth[at]),
    };
    (0..picture.records.len()).map(source).collect()
}

/// Shares of pixels, but for `color`.
struct Errors {
    /// Of the holes: left open.
    open: f64,
    /// Of the holes: no depth, or one that is over 2 % wrong.
    depth: f64,
    /// Mean distance of a hole's colour from the truth, levels.
    color: f64,
    /// Of the true background that has a point in reach: filled.
    background: f64,
    picture: Image,
}

fn errors(way: Way, thin: &Picture, truth: &Picture) -> Errors {
    let (filled, beside) = (sources(way, thin), sources(Way::All, thin));
    let pixels = || 0..thin.records.len();
    let holes: Vec<usize> = pixels().filter(|&at| thin.records[at] < 0 && truth.records[at] >= 0).collect();
    let background: Vec<usize> = pixels().filter(|&at| truth.records[at] < 0 && beside[at].is_some()).collect();
    let share =
        |of: &[usize], is: &dyn Fn(usize) -> bool| of.iter().filter(|&&at| is(at)).count() as f64 / of.len() as f64;
    let mut picture = thin.clone();
    for (at, from) in filled.iter().enumerate() {
        if let Some(from) = *from {
            picture.rgba[at] = thin.rgba[from];
        }
    }
    let off = |at: usize| (0..3).map(|c| f64::from(picture.rgba[at][c].abs_diff(truth.rgba[at][c]))).sum::<f64>() / 3.0;
    let is_deep = |at: usize| filled[at].is_some_and(|from| (thin.depth[from] / truth.depth[at] - 1.0).abs() <= 0.02);
    Errors {
        open: share(&holes, &|at| filled[at].is_none()),
        depth: share(&holes, &|at| !is_deep(at)),
        color: holes.iter().map(|&at| off(at)).sum::<f64>() / holes.len() as f64,
        background: share(&background, &|at| filled[at].is_some()),
        picture: Image::of(&picture),
    }
}

/// A town under a sky, seen from a low place, thinned out until two pixels of three that show it are left.
pub fn holes(setup: &Setup) -> Result<Outcome, StabilityError> {
    let scene = Scene::town(setup.pick(120_000, 480_000));
    let fit = scene.camera(SIZE);
    let eye = [fit.eye[0], fit.eye[1], fit.target[2] + 0.35 * (fit.eye[2] - fit.target[2])];
    let camera = Camera { eye, ..fit };
    let view = scene.view(&camera, SIZE, 1)?;
    let mut progressive = scene.load(CpuBackend::new(None), StoreOptions::default(), &view)?;
    progressive.set_reprojection(Reprojection::Never);
    let seen = scene.view(&camera.turned(1.0), SIZE, 1)?;
    let covered = |picture: &Picture| picture.records.iter().filter(|&&record| record >= 0).count();
    let truth = progressive.truth(&request(seen, scene.len()))?;
    // Two points for each pixel that shows the town leave about a third of them empty.
    progressive.frame(&request(seen, 2 * covered(&truth) as u32))?;
    let thin = progressive.read()?;
    let of = |way| errors(way, &thin, &truth);
    let (open, all) = (of(setup.failing(Way::Open, Way::Masks)), of(setup.failing(Way::All, Way::Masks)));
    let (ours, beside) = (of(setup.ours(Way::Open, Way::Masks)), of(setup.ours(Way::All, Way::Masks)));
    let left = "share of the holes that stay open";
    let part = "distance of a hole's colour from the truth, in that without filling";
    let unfilled = of(Way::Open).color;
    let background = "share of the background beside points that is filled";
    Ok(Outcome {
        claims: vec![
            Claim::fails("no filling", left, open.open, 0.9, "nothing fills them"),
            Claim::fails("no filling", part, open.color / unfilled, 0.95, "the background is dark, the town is not"),
            Claim::fails("no masks", background, all.background, 0.9, "every pixel beside a point is taken for a hole"),
            Claim::holds("masks", left, ours.open, 0.65, "those wider than the reach, and those at the rims, stay"),
            Claim::holds(
                "masks",
                part,
                ours.color / unfilled,
                0.8,
                "with those that stay open; neighbouring points differ by up to 64 levels",
            ),
            Claim::holds(
                "masks",
                background,
                beside.background,
                0.16,
                "notches of a sparse silhouette look like holes",
            ),
        ],
        notes: vec![
            format!(
                "{} of {} pixels show a point, and {} with all points.",
                covered(&thin),
                thin.records.len(),
                covered(&truth)
            ),
            format!(
                "Colours of holes are {:.0} levels off, {unfilled:.0} without filling. Depths are not to be trusted: of {:.0} % of \
                 the holes there is none, or it is over 2 % off, since the nearest point around is nearer than a sloping \
                 surface is.",
                ours.color,
                100.0 * ours.depth
            ),
        ],
        pictures: vec![Strip::new(
            "Thinned out",
            vec![
                ("no filling", of(Way::Open).picture),
                ("every pixel beside a point", of(Way::All).picture),
                ("masks", of(Way::Masks).picture),
                ("truth: all points", Image::of(&truth)),
            ],
        )],
        ..Default::default()
    })
}
