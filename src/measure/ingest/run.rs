//! The rounds: all that is compared, in turn.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use super::{
    IngestError,
    against::AgainstCommand,
    ceilings::{self, PointData},
    coverage::{CoverageRuns, Watch},
    reader::{self, FieldSet, LazDecoder, ReadOrder, Way},
    report::{AgainstRuns, CeilingRuns, IngestFile, IngestReport, ReaderRuns, TITLE},
    screen::{self, ScreenRuns, ScreenSettings},
};
use crate::{
    headless::make_backend,
    measure::machine::Machine,
    source::{self, SourceError},
};

/// What to measure.
#[derive(Debug, Clone)]
pub struct BenchIngest {
    pub inputs: Vec<PathBuf>,
    /// Rounds, at least 1.
    pub repeat: usize,
    pub threads: Vec<usize>,
    pub orders: Vec<ReadOrder>,
    pub decoders: Vec<LazDecoder>,
    pub fields: Vec<FieldSet>,
    pub against: Vec<AgainstCommand>,
    /// Whether, where and how to draw.
    pub screen: Option<ScreenSettings>,
    /// The command line, for the report.
    pub command: String,
}

/// One run of a round, by its place in the report.
#[derive(Debug, Clone, Copy)]
enum Task {
    Reader(usize),
    ReadAlone(usize),
    Memcpy(usize),
    Against(usize),
    Coverage(usize),
    Screen,
}

/// Measures every input; `tell` gets a line now and then.
///
/// # Errors
/// If no input can be opened, another program cannot be compared with, or nothing can be drawn. An input
/// that cannot be opened beside others that can is a problem in the report.
pub fn bench_ingest(settings: &BenchIngest, tell: &mut dyn FnMut(&str)) -> Result<IngestReport, IngestError> {
    let mut report = IngestReport {
        report: TITLE,
        program: concat!("firstlight ", env!("CARGO_PKG_VERSION")).into(),
        command: settings.command.clone(),
        machine: Machine::find(),
        backend: None,
        size_px: settings.screen.map(|screen| screen.size),
        repeat: settings.repeat,
        files: Vec::new(),
        problems: Vec::new(),
    };
    if let Some(screen) = &settings.screen {
        // No device is said before hours of work; and whoever comes first pays for caches of drivers.
        let (backend, _, notes) = make_backend(screen.backend, screen.method, None)?;
        notes.iter().for_each(|note| tell(note));
        report.backend = Some(backend.info().clone());
    }
    let (paths, failed) = source::list_files(&settings.inputs);
    let mut errors: Vec<SourceError> = failed.into_iter().map(|(_, error)| error).collect();
    for path in paths {
        match measure_file(settings, &path, &mut report, tell) {
            Ok(file) => report.files.push(file),
            Err(IngestError::Source(error)) => errors.push(error),
            Err(error) => return Err(error),
        }
    }
    if report.files.is_empty() {
        let only = if errors.len() == 1 { errors.pop() } else { None };
        return Err(only.unwrap_or(SourceError::AllFailed { errors }).into());
    }
    report.machine.finish();
    report.problems.extend(errors.iter().map(SourceError::to_string));
    Ok(report)
}

fn measure_file(
    settings: &BenchIngest,
    path: &Path,
    report: &mut IngestReport,
    tell: &mut dyn FnMut(&str),
) -> Result<IngestFile, IngestError> {
    let data = PointData::find(path)?;
    let ways = ways(settings, &data);
    // Once without a clock: the file is in memory then, and its points are known.
    let warm = reader::read(path, &ways[0], |_, _, _| {})?;
    let name = path.display();
    report
        .problems
        .extend(warm.report.files.iter().filter_map(|file| Some(format!("{name}: {}", file.error.as_ref()?))));
    let mut file = empty(settings, path, &data, &ways, &warm.sample);
    let tasks = tasks(&file);
    for round in 0..settings.repeat {
        let begun = Instant::now();
        let mut order = tasks.clone();
        if round % 2 == 1 {
            order.reverse();
        }
        for task in order {
            run_task(task, settings, &data, &mut file)?;
        }
        tell(&format!(
            "{name}: round {} of {}, {} runs in {:.1} s",
            round + 1,
            settings.repeat,
            tasks.len(),
            begun.elapsed().as_secs_f64()
        ));
    }
    if file.screen.iter().flat_map(|runs| &runs.samples).any(|sample| sample.out_of_memory) {
        report.problems.push(format!("{name}: the device's memory did not hold all points"));
    }
    file.summarize();
    Ok(file)
}

/// The ways to read, most threads last, at least one. A file without compression has no decoder to choose.
fn ways(settings: &BenchIngest, data: &PointData) -> Vec<Way> {
    let most = if data.compressed { settings.decoders.len() } else { 1 };
    let decoders = &settings.decoders[..most.min(settings.decoders.len())];
    let mut ways = Vec::new();
    for &threads in &settings.threads {
        for &order in &settings.orders {
            for &decoder in decoders {
                let way = |&fields| Way { threads: Some(threads), order, decoder, fields };
                ways.extend(settings.fields.iter().map(way));
            }
        }
    }
    if ways.is_empty() {
        let (order, decoder, fields) = (ReadOrder::Preview, LazDecoder::Own, FieldSet::Auto);
        ways.push(Way { threads: None, order, decoder, fields });
    }
    ways
}

/// The report of a file before the first round.
fn empty(
    settings: &BenchIngest,
    path: &Path,
    data: &PointData,
    ways: &[Way],
    warm: &reader::ReaderSample,
) -> IngestFile {
    let ceiling = |bytes: u64| {
        let runs = |&threads| CeilingRuns { threads, bytes, seconds: None, bytes_per_sec: None, samples_secs: vec![] };
        settings.threads.iter().map(runs).collect::<Vec<_>>()
    };
    let reader =
        |&way| ReaderRuns { way, seconds: None, points_per_sec: None, bytes_per_sec: None, samples: Vec::new() };
    let against = |command: &AgainstCommand| AgainstRuns {
        command: command.text.clone(),
        seconds: None,
        points_per_sec: None,
        samples: Vec::new(),
    };
    // Coverage: each order once, read as the first decoder and field set do.
    let first = ways[0];
    let most = settings.threads.iter().copied().max();
    let coverage = settings
        .orders
        .iter()
        .map(|&order| CoverageRuns { way: Way { threads: most, order, ..first }, samples: Vec::new() });
    IngestFile {
        path: path.into(),
        kind: data.kind.clone(),
        compressed: data.compressed,
        points: warm.points,
        file_bytes: data.file_bytes,
        point_bytes: data.bytes(),
        batch_bytes: warm.batch_bytes,
        reader: ways.iter().map(reader).collect(),
        read_alone: ceiling(data.bytes()),
        memcpy: ceiling(warm.batch_bytes),
        against: settings.against.iter().map(against).collect(),
        coverage: coverage.collect(),
        // As a viewer opens it: the reader's own number of threads.
        screen: settings.screen.map(|screen| ScreenRuns {
            way: Way { threads: None, ..first },
            target_ms: screen.target_secs * 1e3,
            samples: Vec::new(),
        }),
    }
}

fn tasks(file: &IngestFile) -> Vec<Task> {
    let mut tasks: Vec<Task> = (0..file.reader.len()).map(Task::Reader).collect();
    tasks.extend((0..file.against.len()).map(Task::Against));
    tasks.extend((0..file.read_alone.len()).map(Task::ReadAlone));
    tasks.extend((0..file.memcpy.len()).map(Task::Memcpy));
    tasks.extend((0..file.coverage.len()).map(Task::Coverage));
    tasks.extend(file.screen.iter().map(|_| Task::Screen));
    tasks
}

fn run_task(task: Task, settings: &BenchIngest, data: &PointData, file: &mut IngestFile) -> Result<(), IngestError> {
    let path = file.path.clone();
    let expected = file.points;
    let steady = |found: u64| match found == expected {
        true => Ok(()),
        false => Err(IngestError::Unsteady { path: path.clone(), expected, found }),
    };
    match task {
        Task::Reader(i) => {
            let runs = &mut file.reader[i];
            let sample = reader::read(&path, &runs.way, |_, _, _| {})?.sample;
            steady(sample.points)?;
            runs.samples.push(sample);
        }
        Task::ReadAlone(i) => {
            let runs = &mut file.read_alone[i];
            let secs = ceilings::read_alone(&path, &data.range, runs.threads);
            let secs = secs.map_err(|source| IngestError::ReadAlone { path: path.clone(), source })?;
            runs.samples_secs.push(secs);
        }
        Task::Memcpy(i) => {
            let runs = &mut file.memcpy[i];
            runs.samples_secs.push(ceilings::copy_memory(runs.bytes, runs.threads));
        }
        Task::Against(i) => file.against[i].samples.push(settings.against[i].run(&path, expected)?),
        Task::Coverage(i) => {
            let runs = &mut file.coverage[i];
            let mut watch = Watch::default();
            let reading = reader::read(&path, &runs.way, |facts, batch, secs| {
                watch.arrive(facts, &batch.positions, secs);
            })?;
            steady(reading.sample.points)?;
            runs.samples.extend(watch.finish());
        }
        Task::Screen => {
            if let (Some(runs), Some(screen)) = (&mut file.screen, &settings.screen) {
                runs.samples.push(screen::run(&path, screen, &runs.way)?);
            }
        }
    }
    Ok(())
}
