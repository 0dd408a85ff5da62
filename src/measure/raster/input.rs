//! The cloud to measure with, all of it in memory and in the order of its files.

use std::{path::PathBuf, thread};

use super::RasterError;
use crate::{
    methods::{Cloud, parallel::threads},
    render::{FileColor, elevation_ramp},
    scene::{BATCH_POINTS, ColorRule, ColorStats, Grid},
    source::{self, Event, OpenOptions, Order, SourceError},
    synth::{Generator, SynthOptions},
};

/// Where the points come from.
#[derive(Debug, Clone)]
pub enum Input {
    /// Files and folders, as one scene.
    Files(Vec<PathBuf>),
    Synth(SynthOptions),
}

/// Points in the order of their files.
pub struct Scan {
    /// What was read, in words.
    pub name: String,
    pub grid: Grid,
    pub cloud: Cloud,
    /// One line each: what could not be read.
    pub problems: Vec<String>,
}

impl Input {
    /// Reads or makes all points.
    ///
    /// # Errors
    /// If nothing can be read, there are no points, or a synthetic scene cannot be made.
    pub fn load(&self) -> Result<Scan, RasterError> {
        let scan = match self {
            Input::Files(inputs) => from_files(inputs)?,
            Input::Synth(options) => from_generator(options)?,
        };
        if scan.cloud.positions.is_empty() { Err(RasterError::NoPoints) } else { Ok(scan) }
    }
}

fn from_generator(options: &SynthOptions) -> Result<Scan, RasterError> {
    let generator = Generator::new(options)?;
    let len = generator.len() as usize;
    let (mut positions, mut colors) = (vec![[0; 3]; len], vec![0; len]);
    let run = len.div_ceil(threads()).max(1).next_multiple_of(BATCH_POINTS);
    thread::scope(|scope| {
        let parts = positions.chunks_mut(run).zip(colors.chunks_mut(run)).enumerate();
        for (part, (positions, colors)) in parts {
            let (first, generator) = ((part * run) as u64, &generator);
            scope.spawn(move || {
                let mut slots = positions.iter_mut().zip(colors);
                generator.for_each(first..first + slots.len() as u64, |point| {
                    if let Some((position, color)) = slots.next() {
                        *position = point.position;
                        *color = rgba(point.rgb.map(|c| (c >> 8) as u8));
                    }
                });
            });
        }
    });
    let name = format!("synthetic {:?}, seed {}", options.scene, options.seed).to_lowercase();
    Ok(Scan { name, grid: generator.grid(), cloud: Cloud { positions, colors }, problems: Vec::new() })
}

fn from_files(inputs: &[PathBuf]) -> Result<Scan, RasterError> {
    let stream = source::open(inputs, OpenOptions { order: Order::File, ..Default::default() });
    let (mut facts, mut problems) = (None, Vec::new());
    let (mut positions, mut raw) = (Vec::new(), Vec::new());
    // Which file each run of points is of, and what its colours are.
    let mut runs: Vec<(usize, usize)> = Vec::new();
    let mut stats: Vec<ColorStats> = Vec::new();
    loop {
        match stream.events().recv() {
            Ok(Event::Opened(opened)) => {
                stats = vec![ColorStats::default(); opened.files.len()];
                positions.reserve_exact(usize::try_from(opened.points_in_header()).unwrap_or(0).min(1 << 32));
                facts = Some(opened);
            }
            Ok(Event::Batch(batch)) => {
                let file = batch.file as usize;
                if runs.last().is_none_or(|&(last, _)| last != file) {
                    runs.push((file, positions.len()));
                }
                positions.extend_from_slice(&batch.positions);
                raw.extend_from_slice(&batch.colors);
                if let Some(stats) = stats.get_mut(file) {
                    stats.merge(&batch.stats);
                }
                stream.recycle(batch);
            }
            Ok(Event::Finished(report)) => {
                problems.extend(report.files.iter().filter_map(|file| file.error.clone()));
                break;
            }
            Ok(Event::Failed(error)) => return Err(error.into()),
            Err(_) => {
                let reason = "the reader ended without saying why".into();
                let path = inputs.first().cloned().unwrap_or_default();
                return Err(SourceError::Io { path, doing: "read it", reason }.into());
            }
        }
    }
    let facts = facts.ok_or(RasterError::NoPoints)?;
    let ramp = elevation_ramp();
    let rules: Vec<FileColor> = stats.iter().map(|stats| FileColor::new(0, stats.rule())).collect();
    let ends = runs.iter().skip(1).map(|run| run.1).chain([positions.len()]);
    let mut colors = vec![0; positions.len()];
    for (&(file, first), end) in runs.iter().zip(ends) {
        let rule = rules.get(file).copied().unwrap_or(FileColor::new(0, ColorRule::Rgb16));
        for i in first..end {
            colors[i] = rgba(rule.color(raw[i], positions[i][2], &ramp));
        }
    }
    let names: Vec<String> = facts.files.iter().map(|file| file.path.display().to_string()).collect();
    Ok(Scan { name: names.join(", "), grid: facts.grid, cloud: Cloud { positions, colors }, problems })
}

/// Red in the lowest byte, opaque.
fn rgba([r, g, b]: [u8; 3]) -> u32 {
    u32::from_le_bytes([r, g, b, 255])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::{Scene, write};

    /// Enough for several threads and batches.
    const POINTS: u64 = 150_000;

    #[test]
    fn a_file_and_its_generator_give_the_same_cloud() {
        let options = SynthOptions { points: POINTS, ..SynthOptions::new(Scene::Town) };
        let made = Input::Synth(options.clone()).load().unwrap();
        assert_eq!(made.cloud.positions.len() as u64, POINTS);
        let generator = Generator::new(&options).unwrap();
        for i in [0, 65_535, 65_536, 99_999, POINTS - 1] {
            let point = generator.point(i);
            assert_eq!(made.cloud.positions[i as usize], point.position);
            assert_eq!(made.cloud.colors[i as usize].to_le_bytes()[..3], point.rgb.map(|c| (c >> 8) as u8));
        }
        let folder = tempfile::tempdir().unwrap();
        let files: Vec<PathBuf> = ["a.las", "b.laz"].map(|name| folder.path().join(name)).into();
        write(&options, &files[0], &mut |_| {}).unwrap();
        write(&options, &files[1], &mut |_| {}).unwrap();
        let read = Input::Files(vec![files[0].clone()]).load().unwrap();
        assert!(read.cloud == made.cloud && read.problems.is_empty(), "in the order of the file");
        let both = Input::Files(files).load().unwrap();
        assert_eq!(both.cloud.positions[POINTS as usize..], made.cloud.positions, "one file after the other");
        assert_eq!(both.cloud.colors[POINTS as usize..], made.cloud.colors);
    }

    #[test]
    fn nothing_to_read_is_an_error() {
        assert!(matches!(Input::Files(vec!["no such.las".into()]).load(), Err(RasterError::Source(_))));
        let options = SynthOptions { points: 0, ..SynthOptions::new(Scene::Planes) };
        assert!(matches!(Input::Synth(options).load(), Err(RasterError::NoPoints)));
    }
}
