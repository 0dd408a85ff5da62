//! Order, threads, cancelling, several files: what holds whatever the format.

use std::{
    path::PathBuf,
    time::{Duration, Instant},
};

use firstlight::{
    scene::{BATCH_POINTS, PointBatch},
    source::{Event, OpenOptions, SourceError},
};

use super::{
    data,
    made::{As, Scan},
    options, read, read_with, start,
};

fn same(a: &[PointBatch], b: &[PointBatch]) -> bool {
    let equal = |(a, b): (&PointBatch, &PointBatch)| {
        a.file == b.file
            && a.positions == b.positions
            && a.colors == b.colors
            && a.records == b.records
            && a.stats == b.stats
    };
    a.len() == b.len() && a.iter().zip(b).all(equal)
}

#[test]
fn made_scans_come_back_as_they_were() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scan.laz");
    for format in [0, 1, 2, 3, 6, 7, 8] {
        for extra_bytes in [0, 3] {
            for how in [As::Las, As::Laz(700), As::LazVarying(100)] {
                let scan = Scan { extra_bytes, ..Scan::new(format, 5_000) };
                std::fs::write(&path, scan.bytes(how)).unwrap();
                let read = read(std::slice::from_ref(&path), 2).unwrap();
                let found = read.positions_in_order();
                assert_eq!(found, scan.positions(), "format {format} + {extra_bytes}, {how:?}");
                let file = &read.report.files[0];
                assert_eq!((file.error.as_deref(), file.points_outside_bounds), (None, 0));
                assert!(file.warnings.is_empty(), "{:?}", file.warnings);
            }
        }
    }
}

#[test]
fn batches_do_not_depend_on_the_number_of_threads() {
    let dir = tempfile::tempdir().unwrap();
    let mut inputs: Vec<PathBuf> = Vec::new();
    for (i, how) in [As::Las, As::Laz(10_000), As::LazVarying(1_000), As::Laz(150_000)].into_iter().enumerate() {
        let path = dir.path().join(format!("{i}.laz"));
        std::fs::write(&path, Scan::new(7, 200_000 + i as u32).bytes(how)).unwrap();
        inputs.push(path);
    }
    if let Some(data) = data() {
        inputs.push(data.join("scans/pdal-lone-star.copc.laz"));
        inputs.push(data.join("formats"));
    }
    let one = read(&inputs, 1).unwrap();
    assert!(one.batches.iter().any(|b| b.len() == BATCH_POINTS));
    for threads in [2, 4] {
        let more = read(&inputs, threads).unwrap();
        assert!(same(&one.batches, &more.batches), "{threads} threads");
    }
    let mut changed = read(&inputs, 2).unwrap().batches;
    changed.last_mut().unwrap().colors[0][3] ^= 1;
    assert!(!same(&one.batches, &changed), "the comparison must see a changed value");
}

/// A big scan, and what is needed to make reading it take a while.
fn big(dir: &std::path::Path, how: As) -> PathBuf {
    let path = dir.join(format!("{how:?}.laz"));
    std::fs::write(&path, Scan::new(7, 600_000).bytes(how)).unwrap();
    path
}

#[test]
fn dropping_the_stream_stops_all_threads() {
    let dir = tempfile::tempdir().unwrap();
    let inputs = [big(dir.path(), As::Las), big(dir.path(), As::Laz(50_000)), big(dir.path(), As::LazVarying(300_000))];
    for input in inputs.map(|i| vec![i]) {
        for wait in [0, 1, 20, 150] {
            for keep_receiver in [false, true] {
                let stream = start(&input, 3);
                let kept = keep_receiver.then(|| stream.events().clone());
                // Half of the time, take something first; then let the channel fill up.
                if wait % 2 == 0 {
                    let _ = stream.events().recv();
                }
                std::thread::sleep(Duration::from_millis(wait));
                let before = Instant::now();
                drop(stream);
                let took = before.elapsed();
                assert!(took < Duration::from_millis(200), "{took:?} after {wait} ms");
                drop(kept);
            }
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn no_thread_outlives_its_stream() {
    // Other tests run beside this one: names alone do not tell whose threads they are.
    let dir = tempfile::tempdir().unwrap();
    let path = big(dir.path(), As::Laz(50_000));
    let marker = std::sync::Arc::new(());
    let held = std::sync::Arc::clone(&marker);
    let wake: std::sync::Arc<dyn Fn() + Send + Sync> = std::sync::Arc::new(move || {
        let _ = &held;
    });
    let options = OpenOptions { threads: Some(2), wake: Some(wake), ..Default::default() };
    drop(firstlight::source::open(&[path], options));
    assert_eq!(std::sync::Arc::strong_count(&marker), 1, "the thread and its callback are gone");
}

#[test]
fn recycled_buffers_change_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let path = big(dir.path(), As::Laz(20_000));
    let kept = read(std::slice::from_ref(&path), 2).unwrap();
    let stream = start(&[path], 2);
    let mut number = 0;
    for event in stream.events() {
        if let Event::Batch(batch) = event {
            assert!(same(&kept.batches[number..=number], std::slice::from_ref(&batch)));
            stream.recycle(batch);
            number += 1;
        }
    }
    assert_eq!(number, kept.batches.len());
}

/// Decoders started in the preview are waited for by whoever goes on with them: with one thread, or as
/// many files as threads, nobody must wait for what comes after.
#[test]
fn many_chunks_are_started_and_finished_by_any_number_of_threads() {
    let dir = tempfile::tempdir().unwrap();
    let scans = [Scan::new(7, 70 * 8_192), Scan::new(1, 65 * 8_192)];
    let paths = ["a.laz", "b.laz"].map(|name| dir.path().join(name));
    for (scan, path) in scans.iter().zip(&paths) {
        std::fs::write(path, scan.bytes(As::Laz(8_192))).unwrap();
    }
    let expected: Vec<_> = scans.iter().flat_map(Scan::positions).collect();
    let mut first: Option<Vec<u32>> = None;
    for threads in [1, 2, 3, 7] {
        let read = read(&paths, threads).unwrap();
        assert!(read.positions_in_order() == expected, "{threads} threads");
        let order: Vec<u32> = read.batches.iter().flat_map(|b| b.records.iter().copied()).collect();
        assert!(first.get_or_insert_with(|| order.clone()) == &order, "{threads} threads: another order");
        // The preview: the first record of each chunk, then the first points.
        assert!(order[..70].iter().zip(0..).all(|(&record, chunk)| record == chunk * 8_192));
    }
}

#[test]
fn chunks_with_more_points_than_the_header_counts_are_said_and_not_called_damaged() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scan.laz");
    for (format, how) in [(1, As::Laz(500)), (1, As::LazVarying(200)), (7, As::Laz(500)), (7, As::LazVarying(200))] {
        for count in [0u32, 1_250, 2_999] {
            let mut bytes = Scan::new(format, 3_000).bytes(how);
            bytes[107..111].copy_from_slice(&if format < 6 { count } else { 0 }.to_le_bytes());
            if format >= 6 {
                bytes[247..255].copy_from_slice(&u64::from(count).to_le_bytes());
            }
            std::fs::write(&path, bytes).unwrap();
            let read = read(std::slice::from_ref(&path), 2).unwrap();
            let file = &read.report.files[0];
            assert_eq!((read.points(), read.error()), (count as usize, ""), "format {format} {how:?}");
            // That a last chunk of fixed size holds one point more, nothing tells.
            let told = file.warnings.iter().any(|w| w.contains("the rest is not read"));
            assert!(told || (count == 2_999 && how == As::Laz(500)), "{how:?} {count}: {:?}", file.warnings);
            assert!(!file.warnings.iter().any(|w| w.contains("damaged")), "{:?}", file.warnings);
        }
    }
}

#[test]
fn an_empty_file_has_no_say_in_the_grid() {
    let dir = tempfile::tempdir().unwrap();
    let paths = ["a.las", "b.las"].map(|name| dir.path().join(name));
    let scan = Scan { scale: 0.001, offset: 5_000_000.0, ..Scan::new(7, 100) };
    std::fs::write(&paths[0], scan.bytes(As::Las)).unwrap();
    std::fs::write(&paths[1], Scan { scale: 1e-7, ..Scan::new(7, 0) }.bytes(As::Las)).unwrap();
    let read = read(&paths, 1).unwrap();
    assert_eq!(read.facts.grid.scale, [0.001; 3]);
    assert!(read.positions_in_order() == scan.positions());
}

#[test]
fn a_preview_that_a_slow_disk_puts_off_loses_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let path = big(dir.path(), As::Las);
    let early = read(std::slice::from_ref(&path), 2).unwrap();
    for threads in [1, 2, 4] {
        // Every read is too slow.
        let options = OpenOptions { slow_read: Some(Duration::ZERO), ..options(threads) };
        let late = read_with(std::slice::from_ref(&path), options).unwrap();
        assert!(late.in_record_order() == early.in_record_order(), "{threads} threads");
        assert_eq!(late.error(), "");
        // A dozen samples come early, the others last.
        assert!(late.batches[0].len() < early.batches[0].len());
        let last = late.batches.last().unwrap();
        assert_eq!(last.len(), early.batches[0].len() - late.batches[0].len());
    }
}

#[test]
fn an_octree_shows_its_coarsest_level_first() {
    let Some(data) = data() else { return };
    // Both files have their root at the end, or near it.
    for (name, root) in [("potree-lion_takanawa", 306_086..341_989), ("pdal-lone-star", 354_869..413_262)] {
        let path = data.join(format!("scans/{name}.copc.laz"));
        let found = read(std::slice::from_ref(&path), 1).unwrap();
        let first = found.batches.iter().find(|b| b.len() > 1_000).unwrap();
        assert!(first.records.iter().all(|r| root.contains(r)), "{name}: records {:?}", &first.records[..3]);
        // A hierarchy that names itself without end, and one that is not there.
        let whole = std::fs::read(&path).unwrap();
        let info = 375 + 54;
        let page = u64::from_le_bytes(whole[info + 40..info + 48].try_into().unwrap());
        for (at, value) in [(page as usize + 28, (-1i32).to_le_bytes().to_vec()), (info + 40, vec![0xff; 8])] {
            let mut damaged = whole.clone();
            damaged[at..at + value.len()].copy_from_slice(&value);
            if value.len() == 4 {
                damaged[at - 12..at - 4].copy_from_slice(&page.to_le_bytes());
            }
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("damaged.copc.laz");
            std::fs::write(&path, damaged).unwrap();
            let again = read(&[path], 2).unwrap();
            assert!(again.in_record_order() == found.in_record_order(), "{name}");
        }
    }
}

#[test]
fn several_files_share_one_grid_and_one_count() {
    let dir = tempfile::tempdir().unwrap();
    let scans = [
        Scan { offset: 500_000.0, ..Scan::new(1, 1_000) },
        Scan { scale: 0.001, offset: 500_100.0, ..Scan::new(7, 70_000) },
        Scan { offset: 499_000.0, ..Scan::new(2, 10) },
    ];
    let folder = dir.path().join("folder");
    std::fs::create_dir(&folder).unwrap();
    let inputs: Vec<PathBuf> = vec![dir.path().join("first.las"), folder.clone(), dir.path().join("nothing.las")];
    std::fs::write(&inputs[0], scans[0].bytes(As::Las)).unwrap();
    std::fs::write(folder.join("a.laz"), scans[1].bytes(As::Laz(5_000))).unwrap();
    std::fs::write(folder.join("b.las"), scans[2].bytes(As::Las)).unwrap();
    std::fs::write(folder.join("c.las"), b"no scan at all").unwrap();

    let read = read(&inputs, 2).unwrap();
    let firsts: Vec<u32> = read.facts.files.iter().map(|f| f.first_record).collect();
    assert_eq!(firsts, [0, 1_000, 71_000]);
    assert_eq!(read.facts.grid.scale, [0.001; 3]);
    let expected = scans.iter().flat_map(|s| s.positions().into_iter().map(|p| (*s, p)));
    let found = read.in_record_order();
    let mut points = 0;
    for ((scan, position), (_, found, _)) in expected.zip(found) {
        let found = read.facts.grid.world(found);
        for axis in 0..3 {
            let expected = scan.offset + scan.scale * f64::from(position[axis]);
            assert!((found[axis] - expected).abs() < 1e-6);
        }
        points += 1;
    }
    assert_eq!(points, 71_010);
    let errors: Vec<&str> = read.report.files.iter().filter_map(|f| f.error.as_deref()).collect();
    assert_eq!(errors.len(), 2, "{errors:?}");
    assert!(errors.iter().any(|e| e.ends_with("nothing.las: no such file or folder")));
    assert!(errors.iter().any(|e| e.contains("expected «LASF» in the first four bytes, found «no s»")));
}

#[test]
fn inputs_that_give_nothing_fail_with_one_line() {
    let dir = tempfile::tempdir().unwrap();
    let text = dir.path().join("empty.las");
    std::fs::write(&text, b"").unwrap();
    let folder = dir.path().join("folder.las");
    std::fs::create_dir(&folder).unwrap();
    let fail = |inputs: &[PathBuf]| match read(inputs, 1) {
        Err(error) => error,
        Ok(_) => panic!("{inputs:?} was read"),
    };
    assert_eq!(fail(&[]), SourceError::NoInput);
    assert!(matches!(fail(&["/no/such/file.las".into()]), SourceError::NotFound { .. }));
    assert!(matches!(fail(std::slice::from_ref(&folder)), SourceError::EmptyFolder { .. }));
    assert!(fail(std::slice::from_ref(&text)).to_string().contains("found an empty file"));
    assert!(fail(&["/dev/null".into()]).to_string().contains("expected a regular file"));
    let all = fail(&[text, folder]).to_string();
    assert!(all.starts_with("none of 2 inputs could be opened: "), "{all}");
}

/// One file of three is left while it is read: the others come whole, and the report says so.
#[test]
fn a_cancelled_file_ends_early_and_the_others_come_whole() {
    let dir = tempfile::tempdir().unwrap();
    let inputs = [big(dir.path(), As::Las), big(dir.path(), As::Laz(50_000)), big(dir.path(), As::LazVarying(300_000))];
    for cancelled in 0..3 {
        let stream = start(&inputs, 2);
        let mut points = [0; 3];
        let mut report = None;
        for event in stream.events() {
            match event {
                // Most is still to come.
                Event::Opened(_) => {}
                Event::Batch(batch) => {
                    points[batch.file as usize] += batch.len() as u64;
                    if batch.file as usize == cancelled {
                        stream.cancel_file(cancelled);
                    }
                    // As long as a picture takes: the threads fill all channels meanwhile.
                    std::thread::sleep(Duration::from_millis(1));
                }
                Event::Finished(finished) => report = Some(finished),
                Event::Failed(error) => panic!("{error}"),
            }
        }
        let report = report.unwrap();
        let decoded: Vec<u64> = report.files.iter().map(|f| f.points_decoded).collect();
        assert_eq!(decoded, points);
        for (i, file) in report.files.iter().enumerate() {
            if i == cancelled {
                assert!(file.points_decoded < 500_000, "{} points of a cancelled file", file.points_decoded);
                assert!(file.error.as_ref().unwrap().contains("stopped"), "{:?}", file.error);
            } else {
                assert_eq!((file.points_decoded, file.error.as_deref()), (600_000, None));
            }
        }
        // The same figures as the report's, up to the last batch.
        let live: u64 = stream.thread_times().iter().map(|t| t.points).sum();
        assert_eq!(live, report.threads.iter().map(|t| t.points).sum::<u64>());
        // There is none of that number: nothing happens.
        stream.cancel_file(99);
    }
}
