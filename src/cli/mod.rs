//! The command line: what the user typed → validated settings → run → an exit code.
//!
//! Every message is one line on standard error and every way to fail has its [`ExitStatus`]; a panic
//! is caught and becomes such a line too.

mod bench;
mod bench_frames;
mod bench_ingest;
mod exit;
mod info;
mod look;
mod measure;
mod open;
mod render;
mod stability;
mod steps;
mod values;

use std::{
    ffi::OsString,
    io::{self, Write},
    panic::{self, AssertUnwindSafe},
    process::ExitCode,
    sync::Mutex,
    time::Instant,
};

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::synth;

pub use exit::{CliError, ExitStatus};
pub use values::parse_count;

/// Ingest-while-render viewer for LAS/LAZ point clouds: no conversion, no index, no waiting.
#[derive(Debug, Parser)]
#[command(
    version,
    args_conflicts_with_subcommands = true,
    after_help = exit::HELP,
    override_usage = "firstlight [OPTIONS] IN…\n       firstlight render IN… -o OUT.png [OPTIONS]"
)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    open: open::OpenArgs,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Write the picture as a PNG, without a window
    #[command(after_help = render::help())]
    Render(Box<render::RenderArgs>),
    /// Print what files say of themselves: header, records, coordinate system, counts
    #[command(after_help = exit::HELP)]
    Info(info::InfoArgs),
    #[command(after_help = exit::HELP)]
    Synth(synth::SynthArgs),
    /// Measure every way to rasterize points on this device, and what each costs in accuracy
    #[command(after_help = bench::HELP)]
    Bench(Box<bench::BenchArgs>),
    /// Measure how wrong the picture is, frame by frame: while loading, at rest and in motion
    #[command(after_help = measure::HELP)]
    Measure(Box<measure::MeasureArgs>),
    /// Show where methods fail, and that this program's choices do not
    #[command(after_help = stability::HELP)]
    Stability(stability::StabilityArgs),
    /// Time frames while a scene grows: does the frame time stay flat?
    #[command(after_help = exit::HELP)]
    BenchFrames(bench_frames::BenchFramesArgs),
    /// Measure how fast points come from files to the screen, against ceilings and other programs
    #[command(after_help = bench_ingest::HELP)]
    BenchIngest(bench_ingest::BenchIngestArgs),
}

/// Runs the program. `started` is where reported seconds begin.
pub fn main(args: impl IntoIterator<Item = OsString>, started: Instant) -> ExitCode {
    // Silent unless asked: what a user has to know is said by `say` and by the errors.
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("off")).init();
    keep_panic_messages();
    let status = match panic::catch_unwind(AssertUnwindSafe(|| run(args, started))) {
        Ok(Ok(status)) => status,
        Ok(Err(error)) => {
            say(&format!("firstlight: {error}"));
            error.status()
        }
        Err(_) => {
            let what = LAST_PANIC.lock().map_or_else(|_| String::new(), |message| message.clone());
            say(&format!("firstlight: internal error, please report it: {what}"));
            ExitStatus::Internal
        }
    };
    ExitCode::from(status as u8)
}

fn run(args: impl IntoIterator<Item = OsString>, started: Instant) -> Result<ExitStatus, CliError> {
    let parsed = Cli::command().try_get_matches_from(args).and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(message) => {
            // `--help` and `--version` arrive here too. A closed pipe is no reason to fail.
            let _ = message.print();
            return Ok(if message.use_stderr() { ExitStatus::Usage } else { ExitStatus::Ok });
        }
    };
    match cli.command {
        Some(Command::Render(args)) => render::run(*args, started),
        Some(Command::Info(args)) => info::run(args),
        Some(Command::Bench(args)) => bench::run(*args),
        Some(Command::Measure(args)) => measure::run(*args),
        Some(Command::Stability(args)) => stability::run(args),
        Some(Command::BenchFrames(args)) => bench_frames::run(args, started),
        Some(Command::BenchIngest(args)) => bench_ingest::run(args),
        Some(Command::Synth(args)) => {
            synth::run(&args)?;
            Ok(ExitStatus::Ok)
        }
        None => open::run(cli.open, started),
    }
}

/// One line for the user, on standard error. If nobody listens, there is nobody to tell.
fn say(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

static LAST_PANIC: Mutex<String> = Mutex::new(String::new());

/// Damaged files can make decoders panic, which the reader catches and reports in its own words; the
/// default hook would print a back trace for each. So a panic is only remembered, unless somebody
/// is looking for its cause.
fn keep_panic_messages() {
    let default_hook = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        let message = info.to_string().replace('\n', " ");
        log::error!("{message}");
        if let Ok(mut last) = LAST_PANIC.lock() {
            *last = message;
        }
        if std::env::var_os("RUST_BACKTRACE").is_some() {
            default_hook(info);
        }
    }));
}
