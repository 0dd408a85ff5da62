//! Filters by attributes whose values are in columns: with the points, or read later and in any order.

use firstlight::{
    render::{Backend, Border, Clip, CpuBackend, Filter, Raster},
    scene::{Attribute, Decimal, PointBatch},
};

use crate::{
    backends::gpu,
    cloud::Cloud,
    colors::{cloud, with_attributes},
    convergence::{Session, covered, options, request},
    values::digits,
};

/// Borders are values that points have; every 37th point has no time, and some no height.
const CASES: [&[&str]; 14] = [
    &["class=2,6,9..40"],
    &["class!=0..200"],
    &["return-number=1..2", "number-of-returns!=3", "user-data=..100"],
    &["return=last", "class!=5"],
    &["return!=last", "returns=3.."],
    &["gps-time=302745223.0123..302745224.5001"],
    &["gps-time!=302745223.0123..302745224.5001"],
    &["scan-angle=-29.97..10.002", "point-source=1000.."],
    &["extra:height=-19.99..0.07", "intensity=..40000"],
    &["extra:shifted=-999.9..-20.3,20.1,100.7..105.3"],
    &["extra:single=0.1..0.3,0.7,1.1"],
    &["extra:single!=..0.8"],
    &["extra:id=1152921504606846977,1152921504606846980..1152921504606846982"],
    &["extra:height=..", "elevation=-1.0005..", "class!=3"],
];

fn filter(clauses: &[&str]) -> Filter {
    Filter { clauses: clauses.iter().map(|clause| clause.parse().expect("a clause")).collect() }
}

/// The definition; `is_known` says of which records values have come.
fn shows(filter: &Filter, cloud: &Cloud, points: &PointBatch, i: usize, is_known: bool) -> bool {
    filter.clauses.iter().all(|clause| {
        let in_slots = matches!(clause.attribute, Attribute::Intensity | Attribute::Elevation);
        let digits = digits(&clause.attribute, points, i, &cloud.facts.files[0], &cloud.facts.grid);
        let is_between = |digits: &Decimal| {
            let is_low = |low: &Border| low.as_ref().is_none_or(|low| low.compare(digits).is_le());
            let is_high = |high: &Border| high.as_ref().is_none_or(|high| high.compare(digits).is_ge());
            clause.values.exact().iter().any(|[low, high]| is_low(low) && is_high(high))
        };
        (is_known || in_slots) && digits.is_some_and(|digits| is_between(&digits) != clause.is_excluding)
    })
}

#[test]
fn values_that_come_with_the_points_filter_them() {
    let cloud = cloud(20_000);
    let points = with_attributes(&cloud, 0..cloud.len());
    for (n, case) in CASES.iter().enumerate() {
        let filter = filter(case);
        let shown: Vec<bool> = (0..cloud.len()).map(|i| shows(&filter, &cloud, &points, i, true)).collect();
        let count = shown.iter().filter(|shown| **shown).count();
        assert!(count > 200 && count < cloud.len() - 200, "{case:?}: {count}");
        for mut session in Session::all(&cloud, options(700)) {
            let request = request(&cloud, &cloud.camera(), 1 + n as u32 % 2, 1000);
            session.progressive.carry(filter.attributes().cloned().collect::<Vec<_>>());
            session.progressive.set_filter(&filter, &Clip::default());
            for start in (0..cloud.len()).step_by(1500) {
                let end = cloud.len().min(start + 1500);
                session.progressive.offer(with_attributes(&cloud, start..end));
                let stored = session.frame(&request).points_stored as usize;
                let expected = shown[..stored].iter().filter(|shown| **shown).count() as u64;
                assert_eq!(
                    session.progressive.wait_for_points_shown().unwrap().unwrap(),
                    expected,
                    "{}, {case:?}, {stored} points",
                    session.name
                );
            }
            session.progressive.end_of_input();
            let picture = session.assert_exact(&request, &format!("{case:?}"));
            assert_eq!(
                session.progressive.wait_for_points_shown().unwrap().unwrap(),
                count as u64,
                "{}, {case:?}",
                session.name
            );
            assert!(covered(&picture) > 50);
            let is_right = |record: &i64| usize::try_from(*record).map_or(true, |record| shown[record]);
            assert!(picture.records.iter().all(is_right), "{}, {case:?}", session.name);
        }
    }
}

/// Pages of the store and of columns that straddle each other.
fn backends() -> Vec<(String, Box<dyn Backend>)> {
    let mut all: Vec<(String, Box<dyn Backend>)> = vec![("cpu".into(), Box::new(CpuBackend::new(Some(2))))];
    for (records, points) in [(Some(1000), Some(4096)), (Some(4096), Some(992)), (None, None)] {
        let Some(mut backend) = gpu(Raster::EarlyZ) else { return all };
        backend.columns_mut().set_page_records(records);
        backend.store_mut().set_page_points(points);
        all.push((format!("gpu, pages of {records:?} records, {points:?} points"), Box::new(backend)));
    }
    all
}

#[test]
fn values_that_are_read_later_filter_as_far_as_they_have_come() {
    let cloud = cloud(12_000);
    let points = with_attributes(&cloud, 0..cloud.len());
    let request = request(&cloud, &cloud.camera(), 1, 100_000);
    // In pieces from the middle on, with a hole that is filled last.
    let pieces: Vec<usize> = [5, 6, 9, 11, 10, 0, 1, 2, 4, 7, 3, 8].map(|piece| piece * 1000).to_vec();
    for case in CASES {
        let filter = filter(case);
        for (name, backend) in backends() {
            let mut session = Session::new(name, backend, &cloud.facts, options(5000));
            session.offer(&cloud, 0..cloud.len(), 3000);
            session.progressive.end_of_input();
            session.converge(&request, |_| ());
            session.progressive.set_filter(&filter, &Clip::default());
            let lacking = session.progressive.lacking(filter.attributes());
            assert!(!lacking.is_empty());
            session.frame(&request);
            assert_eq!(
                session.progressive.wait_for_points_shown().unwrap().unwrap(),
                0,
                "{}: {case:?}, nothing is known",
                session.name
            );
            session.progressive.begin_values(lacking);
            for (n, &start) in pieces.iter().enumerate() {
                session.progressive.offer_values(&with_attributes(&cloud, start..start + 1000)).unwrap();
                if n % 5 == 3 {
                    // A filter that is set is looked at at once; otherwise now and then.
                    session.progressive.set_filter(&Filter::default(), &Clip::default());
                    session.progressive.set_filter(&filter, &Clip::default());
                    session.frame(&request);
                    let is_known = |i: usize| pieces[..=n].contains(&(i / 1000 * 1000));
                    let expected = (0..cloud.len()).filter(|&i| shows(&filter, &cloud, &points, i, is_known(i)));
                    let expected = expected.count() as u64;
                    assert_eq!(
                        session.progressive.wait_for_points_shown().unwrap().unwrap(),
                        expected,
                        "{}: {case:?}, {n}",
                        session.name
                    );
                }
            }
            session.progressive.end_values();
            let picture = session.assert_exact(&request, &format!("{case:?}"));
            let expected = (0..cloud.len()).filter(|&i| shows(&filter, &cloud, &points, i, true)).count() as u64;
            assert_eq!(
                session.progressive.wait_for_points_shown().unwrap().unwrap(),
                expected,
                "{}: {case:?}",
                session.name
            );
            let is_right =
                |record: &i64| usize::try_from(*record).map_or(true, |i| shows(&filter, &cloud, &points, i, true));
            assert!(picture.records.iter().all(is_right), "{}, {case:?}", session.name);
        }
    }
}
