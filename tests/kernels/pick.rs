//! Picking, held to the record of every pixel that a picture brings back.

use std::sync::Arc;

use firstlight::render::{Backend, MAX_REACH, Pick, PickAt, PickTicket, Picture};

use crate::{
    cloud::Cloud,
    convergence::{Session, options, request},
};

/// Asked again when the kernels are compiled.
fn asked(session: &mut Session, at: PickAt) -> Option<PickTicket> {
    session.progressive.pick(at).or_else(|| {
        session.progressive.backend_mut().wait().unwrap();
        session.progressive.pick(at)
    })
}

/// The answer, waited for.
fn picked(session: &mut Session, at: PickAt) -> Option<Pick> {
    let ticket = asked(session, at).unwrap_or_else(|| panic!("{}: {at:?} is in no picture", session.name));
    session.progressive.backend_mut().wait().unwrap();
    session.progressive.picked(ticket).unwrap_or_else(|| panic!("{}: no answer after waiting", session.name))
}

/// By the words of the issue, over a picture that was brought back: the nearest pixel that shows a point, then the
/// nearest point.
fn expected(picture: &Picture, at: PickAt) -> Option<usize> {
    let [column, row] = at.pixel.map(i64::from);
    let distance = |pixel: usize| {
        let (x, y) = (pixel as i64 % i64::from(picture.width), pixel as i64 / i64::from(picture.width));
        (x - column).pow(2) + (y - row).pow(2)
    };
    let near =
        (0..picture.records.len()).filter(|&p| picture.records[p] >= 0 && distance(p) <= i64::from(at.reach).pow(2));
    near.min_by(|&a, &b| {
        distance(a).cmp(&distance(b)).then(picture.depth[a].total_cmp(&picture.depth[b])).then(a.cmp(&b))
    })
}

/// What differs from a pick of this picture, if anything does.
fn difference(picture: &Picture, cloud: &Cloud, at: PickAt, found: Option<Pick>) -> Option<String> {
    let wanted = expected(picture, at).map(|pixel| {
        let record = u32::try_from(picture.records[pixel]).expect("a record");
        Pick {
            record,
            position: cloud.positions()[record as usize],
            depth: picture.depth[pixel],
            pixel: [pixel as u32 % picture.width, pixel as u32 / picture.width],
        }
    });
    (found != wanted).then(|| format!("{at:?}: {found:?} instead of {wanted:?}"))
}

/// Pixels all over the picture, its corners among them.
fn places(picture: &Picture) -> Vec<[u32; 2]> {
    let (last_x, last_y) = (picture.width - 1, picture.height - 1);
    let spread = (0..40u32).map(|i| [i * 7_919 % picture.width, i * 104_729 / 13 % picture.height]);
    [[0, 0], [last_x, 0], [0, last_y], [last_x, last_y]].into_iter().chain(spread).collect()
}

#[test]
fn a_pick_is_the_record_of_the_nearest_pixel() {
    let cloud = Cloud::town(6_000);
    for mut session in Session::all(&cloud, options(1_000)) {
        let request = request(&cloud, &cloud.camera_moved(3), 1, 2_000);
        // While points arrive and move to other slots, and at the end.
        let mut beside = 0;
        for step in 0..8 {
            match step {
                0..6 => session.offer(&cloud, step * 1_000..(step + 1) * 1_000, 1_000),
                _ => session.progressive.end_of_input(),
            }
            session.frame(&request);
            if ![0, 3, 7].contains(&step) {
                continue;
            }
            let picture = session.read();
            for pixel in places(&picture) {
                for reach in [0, 4] {
                    let at = PickAt { pixel, reach };
                    let found = picked(&mut session, at);
                    assert_eq!(difference(&picture, &cloud, at, found), None, "{}, step {step}", session.name);
                    beside += usize::from(found.is_some_and(|pick| pick.pixel != pixel));
                }
            }
        }
        assert!(beside > 10, "{}: {beside} picks of a pixel beside", session.name);
        let picture = session.read();
        let far = PickAt { pixel: [0, 0], reach: MAX_REACH };
        let found = picked(&mut session, PickAt { reach: u32::MAX, ..far });
        assert_eq!(difference(&picture, &cloud, far, found), None, "{}: a reach is cut", session.name);
        // Of the next pixel, which is not what was asked for, something differs.
        let differing = places(&picture).into_iter().filter(|&pixel| {
            let at = PickAt { pixel, reach: 1 };
            let beside = PickAt { pixel: [(pixel[0] + 1) % picture.width, pixel[1]], reach: 1 };
            difference(&picture, &cloud, at, picked(&mut session, beside)).is_some()
        });
        assert!(differing.count() > 5, "{}", session.name);
    }
}

#[test]
fn nothing_is_picked_where_the_words_no_longer_stand() {
    let cloud = Cloud::town(3_000);
    for mut session in Session::all(&cloud, options(1_000)) {
        let at = PickAt { pixel: [80, 60], reach: 4 };
        assert_eq!(asked(&mut session, at), None, "{}: nothing was drawn yet", session.name);
        session.offer(&cloud, 0..3_000, 1_000);
        session.progressive.end_of_input();
        let request = request(&cloud, &cloud.camera(), 1, 3_000);
        session.converge(&request, |_| ());
        assert!(picked(&mut session, at).is_some(), "{}", session.name);
        assert_eq!(asked(&mut session, PickAt { pixel: [160, 60], reach: 4 }), None, "{}: outside", session.name);
        session.progressive.truth(&request).unwrap();
        assert_eq!(asked(&mut session, at), None, "{}: a picture aside", session.name);
        // Nothing changed, so nothing is drawn; but a move of the camera draws again.
        let moved = crate::convergence::request(&cloud, &cloud.camera_moved(1), 1, 3_000);
        session.frame(&moved);
        assert!(asked(&mut session, at).is_some(), "{}", session.name);
        session.progressive.open(Arc::new(cloud.facts.clone()));
        assert_eq!(asked(&mut session, at), None, "{}: another scene", session.name);
    }
}

#[test]
fn questions_that_nobody_asks_about_again_give_way() {
    let cloud = Cloud::town(3_000);
    for mut session in Session::all(&cloud, options(3_000)) {
        session.offer(&cloud, 0..3_000, 1_000);
        session.frame(&request(&cloud, &cloud.camera(), 1, 3_000));
        let at = PickAt { pixel: [80, 60], reach: 4 };
        let tickets: Vec<_> = (0..20).map(|_| asked(&mut session, at).unwrap()).collect();
        session.progressive.backend_mut().wait().unwrap();
        let answers: Vec<_> = tickets.iter().map(|&ticket| session.progressive.picked(ticket).unwrap()).collect();
        assert!(answers[..12].iter().all(Option::is_none), "{}: given up", session.name);
        assert!(answers[12..].iter().all(|answer| *answer == answers[12] && answer.is_some()), "{}", session.name);
        assert_eq!(session.progressive.picked(tickets[15]), Some(None), "{}: taken before", session.name);
    }
}
