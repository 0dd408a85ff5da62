//! What exists for measuring: pictures aside, after which frames go on as if nothing had been drawn, and other ways
//! to reproject than a viewer's.

use firstlight::{
    render::{
        Backend, BackendInfo, CpuBackend, FramePlan, FrameRequest, PassTimes, RenderError, Reprojection, Shading,
    },
    scene::PointBatch,
    store::Insertion,
};

use crate::{
    cloud::Cloud,
    convergence::{Session, covered, difference, options, request},
};

/// What a session does when another one does the same with a picture aside after every frame.
struct Undisturbed {
    /// Frames whose picture is another than that aside.
    unlike: usize,
    /// Frames that only add to the sums of high-quality shading.
    averaging: usize,
    /// The first difference, if there is one.
    disturbed: Option<String>,
}

/// Points arrive while the camera moves; then it rests until the picture has converged.
fn watch(cloud: &Cloud, watched: &mut Session, alone: &mut Session, high_quality: bool) -> Undisturbed {
    let at = |step: usize| {
        let request = request(cloud, &cloud.camera_moved(step), 2, 3000);
        FrameRequest { shading: Shading { high_quality, ..request.shading }, ..request }
    };
    let mut found = Undisturbed { unlike: 0, averaging: 0, disturbed: None };
    for step in 0..200 {
        let request = at(step.min(30) / 3);
        for session in [&mut *watched, &mut *alone] {
            match step {
                0..10 => session.offer(cloud, step * 3000..(step + 1) * 3000, 1000),
                _ => session.progressive.end_of_input(),
            }
        }
        let [seen, expected] = [&mut *watched, &mut *alone].map(|session| (session.frame(&request), session.read()));
        found.averaging += usize::from(seen.0.drawn && seen.0.has_all_depths() && seen.0.points_averaged > 0);
        let pictures = difference(&seen.1, &expected.1);
        let reports = (seen.0 != expected.0).then(|| format!("{:?} {:?}", seen.0, expected.0));
        found.disturbed = pictures.or(reports).map(|difference| format!("{}, step {step}: {difference}", watched.name));
        // Nothing more is drawn over the picture aside.
        if found.disturbed.is_some() || (expected.0.is_converged() && step > 30) {
            break;
        }
        // At rest from another side: from the same one, all depths are those of the frame.
        let aside = if step > 30 { at(12) } else { request };
        let truth = watched.progressive.truth(&aside).unwrap();
        found.unlike += usize::from(difference(&seen.1, &truth).is_some());
    }
    let truth = watched.progressive.truth(&at(1)).unwrap();
    let mut plain = at(1);
    plain.shading.high_quality = false;
    if found.disturbed.is_none() {
        assert_eq!(difference(&truth, &alone.brute_force(&plain)), None, "{}", watched.name);
    }
    found
}

#[test]
fn a_picture_aside_leaves_no_trace() {
    let cloud = Cloud::town(30_000).in_random_order();
    for high_quality in [false, true] {
        let sessions = || Session::all(&cloud, options(1000)).into_iter();
        for (mut watched, mut alone) in sessions().zip(sessions()) {
            let found = watch(&cloud, &mut watched, &mut alone, high_quality);
            assert_eq!(found.disturbed, None, "high quality {high_quality}");
            assert!(found.unlike > 10, "{}: it is another picture than the frame's", watched.name);
            assert!((found.averaging > 5) == high_quality, "{}: {} frames", watched.name, found.averaging);
        }
    }
}

#[test]
fn what_is_not_kept_aside_is_noticed() {
    let cloud = Cloud::town(30_000).in_random_order();
    let cpu = || CpuBackend::new(Some(2));
    let session = |backend| Session::new("cpu".into(), backend, &cloud.facts, options(1000));
    for wrong in [Wrong::TakenForAFrame, Wrong::KeepsWords] {
        for high_quality in [false, true] {
            let mut watched = session(Box::new(Heedless { cpu: cpu(), wrong, was_aside: false }));
            let found = watch(&cloud, &mut watched, &mut session(Box::new(cpu())), high_quality);
            // Only high-quality shading keeps words.
            let is_noticed = high_quality || wrong == Wrong::TakenForAFrame;
            assert_eq!(found.disturbed.is_some(), is_noticed, "{wrong:?}, {high_quality}: {:?}", found.disturbed);
        }
    }
}

#[test]
fn other_ways_to_reproject_are_worse() {
    let cloud = Cloud::town(30_000).in_random_order();
    let covered_after = |reprojection| {
        let mut session = Session::new("cpu".into(), Box::new(CpuBackend::new(Some(2))), &cloud.facts, options(30_000));
        session.progressive.set_reprojection(reprojection);
        session.offer(&cloud, 0..cloud.len(), cloud.len());
        session.progressive.end_of_input();
        let at = |step| request(&cloud, &cloud.camera_moved(step), 2, 700);
        session.converge(&at(0), |_| ());
        session.frame(&at(1));
        let moved = covered(&session.read());
        session.frame(&at(1));
        (moved, covered(&session.read()))
    };
    let always = covered_after(Reprojection::Always);
    let while_still = covered_after(Reprojection::WhileStill);
    let never = covered_after(Reprojection::Never);
    assert!(2 * always.0 > 3 * while_still.0, "{always:?} {while_still:?}");
    assert_eq!(while_still.0, never.0, "the first frame of another view is a sample");
    assert!(5 * while_still.1 > 6 * never.1, "{while_still:?} gathers, {never:?} does not");
    assert!(never.1 < while_still.1);
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wrong {
    /// A picture aside changes all that a frame changes.
    TakenForAFrame,
    /// The frame behind a picture aside keeps its depths, as it keeps a frame's.
    KeepsWords,
}

/// A processor that draws pictures aside wrongly.
struct Heedless {
    cpu: CpuBackend,
    wrong: Wrong,
    was_aside: bool,
}

impl Backend for Heedless {
    crate::backends::as_the_processor!();
    fn info(&self) -> &BackendInfo {
        self.cpu.info()
    }
    fn insert(&mut self, insertion: &Insertion, points: &PointBatch) -> Result<(), RenderError> {
        self.cpu.insert(insertion, points)
    }
    fn draw(&mut self, plan: &FramePlan) -> Result<(), RenderError> {
        let mut plan = plan.clone();
        match self.wrong {
            Wrong::TakenForAFrame => plan.aside = false,
            Wrong::KeepsWords => {
                let goes_on = plan.averaging.as_ref().is_some_and(|averaging| !averaging.begins && !averaging.lists);
                plan.keeps_depths |= self.was_aside && goes_on;
            }
        }
        self.was_aside = plan.aside;
        self.cpu.draw(&plan)
    }
    fn pass_times(&mut self) -> Option<PassTimes> {
        self.cpu.pass_times()
    }
}
