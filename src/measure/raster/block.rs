//! A block: all methods on one cloud in one order and encoding, from one viewpoint.

use std::time::{Duration, Instant};

use super::{
    Accuracy, RasterError,
    orders::Order,
    processor::{Agreement, Processor},
    report::{Block, Row, Sample},
    run::{BenchRaster, Shot, in_turn},
};
use crate::methods::{Arranged, Method, MethodError, Paced, Runner, by_name};

/// All counted frames of a row together last about so long, however many were asked for: what a hundred frames
/// of 3 ms tell is no more than what ten of 30 ms do.
const ROW_SECS: f64 = 0.3;

/// The same on a processor that stands in for a GPU.
const SOFTWARE_ROW_SECS: f64 = 3.0;

/// A first frame is abandoned after so many times [`BenchRaster::max_frame_secs`].
const PATIENCE: f64 = 10.0;

/// A GPU draws for so long before anything of a block is timed: while the host compared pictures, its clock went
/// down (H200: a first block at 201 billion points/s where the others were at 529).
const WARM_SECS: f64 = 0.15;

/// What is known of a method after its first frame.
pub(super) struct Trial {
    /// Frames of each turn; with none, the method is not measured any further.
    pub frames: u32,
    /// The first frame was longer than allowed: it is the only one.
    pub is_single: bool,
}

impl Trial {
    /// After a first frame that took `first_secs` by the wall clock and a second of `secs`.
    pub fn of(settings: &BenchRaster, is_software: bool, first_secs: f64, secs: f64) -> Trial {
        if first_secs.min(secs) > settings.max_frame_secs {
            return Trial { frames: 0, is_single: true };
        }
        let all = if is_software { SOFTWARE_ROW_SECS } else { ROW_SECS };
        let fit = all / (f64::from(settings.repeat) * secs.max(1e-9));
        // A cast of a large number ends at the largest.
        Trial { frames: (fit as u32).clamp(1, settings.frames), is_single: false }
    }
}

pub(super) fn patience(settings: &BenchRaster) -> Duration {
    Duration::try_from_secs_f64(PATIENCE * settings.max_frame_secs).unwrap_or(Duration::MAX)
}

/// Measures a block.
///
/// # Errors
/// If the device cannot draw.
pub(super) fn block(
    settings: &BenchRaster,
    runner: &mut Runner,
    methods: &[&'static Method],
    arranged: Arranged<'_>,
    order: Order,
    shot: &Shot,
    processor: &Processor,
) -> Result<Block, RasterError> {
    let view = &shot.view;
    let fragments = processor.fragments;
    // Both show the nearest point, the first of equals; any device can run the second.
    let is_able = |method: &&Method| runner.supports(method).is_ok();
    let nearest = ["atomic-min", "two-pass-32"].into_iter().filter_map(by_name).find(is_able);
    let nearest = nearest.ok_or_else(|| MethodError::Unsupported("the device runs no exact method".into()))?;
    let right = runner.draw(nearest, view)?;
    let Agreement { differ, excused } = processor.compare(&right, arranged);
    let (mut rows, mut trials) = (Vec::new(), Vec::new());
    for method in methods {
        let bytes = method.bytes(runner.encoding(), runner.points(), fragments);
        let mut row = Row::new(method.name, bytes);
        let trial = match runner.draw_paced(method, view, patience(settings))? {
            Paced::Abandoned(abandoned) => {
                row.abandoned = Some(abandoned);
                Trial { frames: 0, is_single: false }
            }
            Paced::Drawn { drawn, secs } => {
                row.accuracy = Some(Accuracy::of(&drawn, &right, method.blends));
                let times = runner.time(method, view, 1)?;
                let second = times.first().map_or(secs, |time| time.total_secs());
                let trial = Trial::of(settings, runner.gpu.is_software(), secs, second);
                row.is_single = trial.is_single;
                if trial.is_single {
                    row.samples.extend(times.iter().map(|time| Sample::new(1, time)));
                }
                trial
            }
        };
        rows.push(row);
        trials.push(trial);
    }
    let start = Instant::now();
    while !runner.gpu.is_software() && start.elapsed().as_secs_f64() < WARM_SECS {
        runner.time(nearest, view, settings.frames)?;
    }
    for round in 1..=settings.repeat {
        for i in in_turn(methods.len(), round) {
            let times = runner.time(methods[i], view, trials[i].frames)?;
            rows[i].samples.extend(times.iter().map(|time| Sample::new(round, time)));
        }
    }
    rows.iter_mut().for_each(|row| row.summarize(runner.points()));
    Ok(Block {
        order,
        encoding: runner.encoding(),
        view: shot.name.clone(),
        camera: shot.camera,
        fragments,
        covered_pixels: processor.covered(),
        reference: nearest.name,
        reference_differs: differ,
        reference_excused: excused,
        rows,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::raster::curves::tests::settings;

    #[test]
    fn slow_methods_draw_fewer_frames() {
        let settings = BenchRaster { frames: 10, repeat: 3, max_frame_secs: 1.0, ..settings(&[]) };
        let frames = |first, secs| {
            let trial = Trial::of(&settings, false, first, secs);
            (trial.frames, trial.is_single)
        };
        assert_eq!(frames(0.001, 0.001), (10, false), "as many as asked for");
        assert_eq!(frames(0.019, 0.019), (5, false));
        assert_eq!(frames(0.9, 0.9), (1, false), "one in each round");
        assert_eq!(frames(3.0, 0.049), (2, false), "only the first was slow: pipelines were made");
        assert_eq!(frames(1.1, 1.2), (0, true), "too long: once");
        assert_eq!(patience(&settings), Duration::from_secs(10));
        let endless = BenchRaster { max_frame_secs: f64::INFINITY, ..settings };
        assert_eq!(patience(&endless), Duration::MAX);
    }
}
