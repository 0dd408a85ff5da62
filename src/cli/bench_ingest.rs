//! `firstlight bench-ingest`.

use std::{
    env,
    ffi::OsStr,
    io::{self, Write},
    path::PathBuf,
    thread,
};

use clap::Args;

use super::{
    CliError, ExitStatus,
    render::{BackendArg, backend_choice},
    say, values,
};
use crate::measure::{
    ReportDir,
    ingest::{
        AgainstCommand, BenchIngest, FieldSet, LazDecoder, ReadOrder, ScreenSettings, TITLE, bench_ingest, markdown,
        page, write_csv,
    },
};
use crate::render::RasterChoice;

/// Shown after the options.
pub const HELP: &str = "\
Each file is measured on its own. In every round, each of these runs once, every second round backwards:
  reader      everything decoded, nothing drawn: per number of threads, order, decoder and field set
  read alone  the same bytes read in blocks of 4 MiB, by as many threads: no reader can be faster
  memcpy      as many bytes as the decoded points take, copied from memory to memory
  against     other programs (--against)
  coverage    how soon the points so far show the whole extent: cells of a 64x64 grid over x and y
  screen      from opening the file to the converged picture, the camera in motion while points arrive
The first run of each file is not counted: it brings the file into memory.

Other programs: --against \"python3 tests/reference/laspy_seconds.py laszip\" runs LASzip through laspy
(pip install laspy laszip lazrs), with lazrs at the end the laz crate; `laszip xyz,rgb` decodes only these fields. Any program will do that
takes a file as its last argument and prints, on its last line, the seconds that decoding took, without
its own start-up. If it prints a line `points N` too, N must be right; a line `processor SECONDS` is its processor
time, by which programs can be compared on a machine that is busy with other work.

REPORT_DIR gets ingest.json (every sample), ingest.csv (a line per run) and index.html (tables and charts);
the tables are printed as Markdown too. They are written at the end: what stops the program before
leaves an older report as it was.

Exit codes:
  0  done
  1  internal error
  2  the command line is wrong, or a program of --against cannot be compared with
  3  no input can be read: missing, or not LAS/LAZ
  4  partly read: the report is written, but points are missing
  5  the report cannot be written
  6  no device does what was asked (--backend, --method, --size)";

#[derive(Debug, Args)]
pub struct BenchIngestArgs {
    /// LAS and LAZ files, and folders of them
    #[arg(value_name = "IN", required = true)]
    inputs: Vec<PathBuf>,
    /// Folder for the report: new, empty, or an older report of this command
    #[arg(short, long, value_name = "REPORT_DIR")]
    output: PathBuf,
    /// Rounds: how often each run is repeated
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    /// Decoder threads to measure with; by default 1, 2, 4, … up to one per core
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', value_parser = values::parse_threads)]
    threads: Vec<usize>,
    /// Orders in which points are read
    #[arg(long, value_enum, value_name = "ORDER,…", value_delimiter = ',', default_value = "preview,file")]
    order: Vec<ReadOrder>,
    /// Decoders of LAZ
    #[arg(long, value_enum, value_name = "DECODER,…", value_delimiter = ',', default_value = "own")]
    decoder: Vec<LazDecoder>,
    /// Fields that are decoded besides the position
    #[arg(long, value_enum, value_name = "FIELDS,…", value_delimiter = ',', default_value = "auto")]
    fields: Vec<FieldSet>,
    /// Another program to compare with, see below; may be given several times
    #[arg(long, value_name = "COMMAND")]
    against: Vec<AgainstCommand>,
    /// Leave out the screen: only read
    #[arg(long)]
    no_screen: bool,
    /// Width and height of the picture, pixels
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = values::parse_size)]
    size: [u32; 2],
    /// Width of a point, pixels, 1 to 8
    #[arg(long, value_name = "PX", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=8))]
    point_size: u32,
    /// Frame time that fill and loading aim at, milliseconds
    #[arg(long, value_name = "MS", default_value_t = 16.0, value_parser = values::parse_millis)]
    target_ms: f64,
    /// How the GPU turns points into pixels: a method's name, or NAME:64 (:128, :256) with its workgroup
    /// size; auto measures which is the fastest
    #[arg(long, value_name = "auto|NAME", default_value = "auto", value_parser = values::parse_method)]
    method: RasterChoice,
    /// Where to draw; auto takes a GPU if there is one
    #[arg(long, value_enum, default_value_t)]
    backend: BackendArg,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

pub fn run(args: BenchIngestArgs) -> Result<ExitStatus, CliError> {
    let screen = ScreenSettings {
        backend: backend_choice(args.backend, args.method)?,
        method: args.method,
        size: args.size,
        point_size: args.point_size,
        target_secs: args.target_ms * 1e-3,
    };
    let folder = ReportDir::prepare(&args.output, "ingest.json", TITLE)?;
    let settings = BenchIngest {
        inputs: args.inputs,
        repeat: args.repeat as usize,
        threads: threads(args.threads),
        orders: once(args.order),
        decoders: once(args.decoder),
        fields: once(args.fields),
        against: args.against,
        screen: (!args.no_screen).then_some(screen),
        command: command_line(env::args_os()),
    };
    let quiet = args.quiet;
    let report = bench_ingest(&settings, &mut |line| {
        if !quiet {
            say(line);
        }
    })?;
    let written = folder
        .write("ingest.csv", |out| write_csv(out, &report))
        .and_then(|()| folder.write("index.html", |out| out.write_all(page(&report).as_bytes())))
        // Last: it is what says that the folder holds a report.
        .and_then(|()| folder.write("ingest.json", |out| Ok(serde_json::to_writer_pretty(out, &report)?)));
    written.map_err(crate::measure::ReportDirError::from)?;
    if !quiet {
        // If nobody reads the tables, the report is written all the same.
        let _ = write!(io::stdout(), "{}", markdown(&report));
        say(&format!("wrote {}", folder.path().join("index.html").display()));
    }
    // Not silenced: points are missing.
    report.problems.iter().for_each(|problem| say(&format!("firstlight: {problem}")));
    Ok(if report.problems.is_empty() { ExitStatus::Ok } else { ExitStatus::Partial })
}

/// Ascending; by default doublings up to one per core.
fn threads(mut asked: Vec<usize>) -> Vec<usize> {
    if asked.is_empty() {
        let cores = thread::available_parallelism().map_or(1, usize::from);
        asked = (0..usize::BITS).map(|bit| 1 << bit).take_while(|&n| n < cores).collect();
        asked.push(cores);
    }
    asked.sort_unstable();
    asked.dedup();
    asked
}

/// Without repetitions, in the order given.
pub fn once<T: PartialEq>(list: Vec<T>) -> Vec<T> {
    list.into_iter().fold(Vec::new(), |mut kept, item| {
        if !kept.contains(&item) {
            kept.push(item);
        }
        kept
    })
}

/// The words, quoted where a shell would split them.
pub fn command_line<S: AsRef<OsStr>>(words: impl Iterator<Item = S>) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+@%".contains(c);
    let quote = |word: S| {
        let word = word.as_ref().to_string_lossy().into_owned();
        if !word.is_empty() && word.chars().all(plain) { word } else { format!("'{}'", word.replace('\'', r"'\''")) }
    };
    words.map(quote).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_double_up_to_the_cores() {
        let default = threads(vec![]);
        assert_eq!(default[0], 1);
        assert!(default.is_sorted() && default.windows(2).all(|w| w[1] <= 2 * w[0]));
        assert_eq!(threads(vec![4, 1, 4]), [1, 4]);
        assert_eq!(once(vec![2, 1, 2]), [2, 1]);
    }

    #[test]
    fn a_command_line_can_be_typed_again() {
        let words = ["firstlight", "a b.laz", "it's", "", "--against", "x --y"];
        assert_eq!(command_line(words.iter()), r"firstlight 'a b.laz' 'it'\''s' '' --against 'x --y'");
    }
}
