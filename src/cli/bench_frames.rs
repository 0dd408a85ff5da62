//! `firstlight bench-frames`.

use std::{
    fs,
    io::{self, Write},
    path::PathBuf,
    time::Instant,
};

use clap::Args;

use super::{
    CliError, ExitStatus,
    look::LookArgs,
    render::{BackendArg, backend_choice},
    say,
    values::{self, EncodingChoice},
};
use crate::{
    headless::{Destination, HeadlessError, OutputError, fields_of, make_backend},
    measure::{BenchError, BenchFrames, Fed, Feed, bench_frames, markdown},
    render::{FillBudget, Look, PointSize, RasterChoice},
    synth::SynthOptions,
};

#[derive(Debug, Args)]
pub struct BenchFramesArgs {
    /// LAS and LAZ files, and folders of them
    #[arg(value_name = "IN", required_unless_present = "synth")]
    inputs: Vec<PathBuf>,
    /// A synthetic scan straight from memory: town:100M, planes:1M
    #[arg(long, value_name = "SCENE:N", conflicts_with = "inputs", value_parser = values::parse_synth)]
    synth: Option<SynthOptions>,
    /// Numbers of points at which loading pauses and frames are timed; the end is always one
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', default_value = "1M,4M,16M", value_parser = values::parse_count)]
    at: Vec<u64>,
    /// Frames to time at each
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,
    /// Width and height of the picture, pixels
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = values::parse_size)]
    size: [u32; 2],
    /// Frame time that the fill budget aims at, milliseconds
    #[arg(long, value_name = "MS", default_value_t = 16.0, value_parser = values::parse_millis)]
    target_ms: f64,
    /// Random points that each frame tries, instead of a target
    #[arg(long, value_name = "N", value_parser = values::parse_points)]
    fill: Option<u32>,
    /// How the GPU turns points into pixels: a method's name, or NAME:64 (:128, :256) with its workgroup
    /// size; auto measures which is the fastest
    #[arg(long, value_name = "auto|NAME", default_value = "auto", value_parser = values::parse_method)]
    method: RasterChoice,
    /// How positions lie in memory
    #[arg(long, value_enum, default_value_t)]
    encoding: EncodingChoice,
    /// Where to draw; auto takes a GPU if there is one
    #[arg(long, value_enum, default_value_t)]
    backend: BackendArg,
    /// Fixes the order of the points in the store
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Reader threads; by default one per core, less one
    #[arg(long, value_name = "N", value_parser = values::parse_threads)]
    threads: Option<usize>,
    /// Write every sample as JSON
    #[arg(long, value_name = "REPORT.json")]
    json: Option<PathBuf>,
    #[command(flatten)]
    look: LookArgs,
}

pub fn run(args: BenchFramesArgs, started: Instant) -> Result<ExitStatus, CliError> {
    let json = args.json.as_deref().map(Destination::check).transpose().map_err(HeadlessError::from)?;
    let decoded = if args.synth.is_none() { Some(decode_alone(&args)?) } else { None };
    // The time to the first picture is that of a program which does not measure its reader first.
    let started = if decoded.is_some() { Instant::now() } else { started };
    let feed = match &args.synth {
        Some(options) => Feed::synth(options, args.threads)?,
        None => Feed::files(&args.inputs, args.threads, fields_of(&args.look())),
    };
    let (backend, _, notes) = make_backend(backend_choice(args.backend, args.method)?, args.method, args.threads)
        .map_err(BenchError::from)?;
    notes.iter().for_each(|note| say(note));
    let settings = BenchFrames {
        size: args.size,
        look: args.look(),
        seed: args.seed,
        fill: args.fill.map_or(FillBudget::Target(args.target_ms * 1e-3), FillBudget::Fixed),
        at: args.at,
        frames: args.frames,
        encoding: args.encoding.encoding(),
    };
    let report = bench_frames(&settings, feed, backend, decoded, started)?;
    // If nobody reads the table, the report is still written.
    let _ = write!(io::stdout(), "{}", markdown(&report));
    if let Some(json) = json {
        let written = json.write(|out| Ok(serde_json::to_writer_pretty(out, &report)?));
        written.map_err(|error: OutputError| HeadlessError::from(error))?;
    }
    Ok(ExitStatus::Ok)
}

impl BenchFramesArgs {
    fn look(&self) -> Look {
        self.look.look(PointSize::default())
    }
}

/// Points per second of the reader with nobody to wait for.
fn decode_alone(args: &BenchFramesArgs) -> Result<f64, BenchError> {
    // Once without a clock, so that the files are in memory.
    for input in &args.inputs {
        if input.is_file() {
            let _ = fs::read(input);
        }
    }
    let mut feed = Feed::files(&args.inputs, args.threads, fields_of(&args.look()));
    let start = Instant::now();
    let mut points = 0;
    loop {
        match feed.next(true)? {
            Fed::Batch(batch) => {
                points += batch.len();
                feed.recycle(batch);
            }
            Fed::Ended => return Ok(points as f64 / start.elapsed().as_secs_f64()),
            Fed::Opened(_) | Fed::Nothing => {}
        }
    }
}
