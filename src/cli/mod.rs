//! The command line: what the user typed → validated settings → run → an exit code.
//!
//! Every message is one line on standard error and every way to fail has its [`ExitStatus`]; a panic
//! is caught and becomes such a line too.

mod bench;
mod bench_frames;
mod bench_ingest;
mod examples;
mod exit;
mod info;
mod look;
mod manual;
mod measure;
mod open;
mod pick;
mod point;
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
    after_help = examples::before_codes(examples::OPEN),
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
    #[command(after_help = examples::before_codes(examples::RENDER))]
    Render(Box<render::RenderArgs>),
    /// Print what files say of themselves: header, records, coordinate system, counts
    #[command(after_help = examples::before_codes(examples::INFO))]
    Info(info::InfoArgs),
    /// Print all that the file says of a point, by the number of its record
    #[command(after_help = examples::before_codes(examples::POINT))]
    Point(point::PointArgs),
    /// Print all that the file says of the points that a picture shows at some pixels
    #[command(after_help = examples::before_codes(examples::PICK))]
    Pick(Box<pick::PickArgs>),
    #[command(after_help = examples::before_codes(examples::SYNTH))]
    Synth(synth::SynthArgs),
    /// Measure every way to rasterize points on this device, and what each costs in accuracy
    #[command(after_help = examples::before(examples::BENCH, bench::HELP))]
    Bench(Box<bench::BenchArgs>),
    /// Measure how wrong the picture is, frame by frame: while loading, at rest and in motion
    #[command(after_help = examples::before(examples::MEASURE, measure::HELP))]
    Measure(Box<measure::MeasureArgs>),
    /// Show where methods fail, and that this program's choices do not
    #[command(after_help = examples::before(examples::STABILITY, stability::HELP))]
    Stability(stability::StabilityArgs),
    /// Time frames while a scene grows: does the frame time stay flat?
    #[command(after_help = examples::before_codes(examples::BENCH_FRAMES))]
    BenchFrames(Box<bench_frames::BenchFramesArgs>),
    /// Measure how fast points come from files to the screen, against ceilings and other programs
    #[command(after_help = examples::before(examples::BENCH_INGEST, bench_ingest::HELP))]
    BenchIngest(bench_ingest::BenchIngestArgs),
    /// Print a script that completes commands and options in a shell
    #[command(after_help = examples::COMPLETIONS)]
    Completions(manual::CompletionsArgs),
    /// Print the manual page, or write the pages of all commands
    #[command(after_help = examples::MAN)]
    Man(manual::ManArgs),
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
    let matches = Cli::command().try_get_matches_from(args);
    let parsed = matches.and_then(|matches| Ok((Cli::from_arg_matches(&matches)?, matches)));
    let (cli, matches) = match parsed {
        Ok(parsed) => parsed,
        Err(message) => {
            // `--help` and `--version` arrive here too. A closed pipe is no reason to fail.
            let _ = message.print();
            return Ok(if message.use_stderr() { ExitStatus::Usage } else { ExitStatus::Ok });
        }
    };
    match cli.command {
        Some(Command::Render(args)) => render::run(*args, started),
        Some(Command::Info(args)) => info::run(args),
        Some(Command::Pick(args)) => pick::run(*args, started),
        Some(Command::Point(args)) => point::run(args),
        Some(Command::Bench(args)) => bench::run(*args),
        Some(Command::Measure(args)) => measure::run(*args),
        Some(Command::Stability(args)) => stability::run(args),
        Some(Command::BenchFrames(args)) => bench_frames::run(*args, started),
        Some(Command::BenchIngest(args)) => bench_ingest::run(args),
        Some(Command::Completions(args)) => manual::completions(args, Cli::command()),
        Some(Command::Man(args)) => manual::man(args, Cli::command()),
        Some(Command::Synth(args)) => {
            synth::run(&args)?;
            Ok(ExitStatus::Ok)
        }
        None => open::run(cli.open, look::given(&matches), started),
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

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::render::{Camera, Look, Shading};

    /// A POSIX shell's words, as far as plain and single-quoted text goes; up to the first pipe, redirection or comment.
    fn words(line: &str) -> Vec<String> {
        let mut words = Vec::new();
        let mut word: Option<String> = None;
        let (mut is_quoted, mut is_escaped) = (false, false);
        for c in line.chars() {
            match c {
                _ if is_escaped => {
                    word.get_or_insert_default().push(c);
                    is_escaped = false;
                }
                '\'' => {
                    is_quoted = !is_quoted;
                    word.get_or_insert_default();
                }
                _ if is_quoted => word.get_or_insert_default().push(c),
                '\\' => is_escaped = true,
                '|' | '>' | '#' if word.is_none() => break,
                ' ' => words.extend(word.take()),
                c => word.get_or_insert_default().push(c),
            }
        }
        words.extend(word);
        words
    }

    /// A heading holds for all options that follow: those of a look, and no others, are under one of its.
    #[test]
    fn options_stand_under_their_own_headings() {
        let mut command = Cli::command();
        command.build();
        let mut under = 0;
        for command in command.get_subcommands().chain([&command]) {
            // Others have options of the same names.
            let has_look = command.get_arguments().any(|argument| argument.get_id() == "slab");
            for argument in command.get_arguments() {
                let id = argument.get_id().as_str();
                let expected = match look::FIELDS.iter().find(|(option, _)| has_look && *option == id) {
                    None => None,
                    Some((_, field)) if field.starts_with("/filter") || field.starts_with("/clip") => {
                        Some("What is shown")
                    }
                    Some((_, field)) if field.starts_with("/coloring") => Some("How it is coloured"),
                    Some(_) => Some("How it looks"),
                };
                assert_eq!(argument.get_help_heading(), expected, "{} {id}", command.get_name());
                under += usize::from(expected.is_some());
            }
        }
        assert!(under > 50, "{under}");
    }

    #[test]
    fn every_command_has_examples_that_parse() {
        let mut command = Cli::command();
        command.build();
        let commands: Vec<clap::Command> =
            command.get_subcommands().filter(|c| c.get_name() != "help").cloned().chain([command.clone()]).collect();
        for command in commands {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let examples: Vec<&str> = help.lines().filter(|line| line.starts_with("  firstlight ")).collect();
            assert!(!examples.is_empty(), "{}", command.get_name());
            for example in examples {
                let parsed = Cli::try_parse_from(words(example.trim()));
                assert!(parsed.is_ok(), "{example}: {}", parsed.unwrap_err());
            }
        }
        assert!(Cli::try_parse_from(words("firstlight render scan.laz --no-such-option")).is_err());
    }

    #[test]
    fn the_command_of_a_view_gives_that_view() {
        let camera = Camera {
            eye: [637_012.24, -0.1 + 0.2, 1e-300],
            target: [637_010.0, 849_000.125, 4.0 / 3.0],
            up: [0.0, 0.6, 0.8],
            fov_y_deg: 59.999_999_999_999_99,
            ..Camera::fit(&Default::default(), &crate::scene::Grid { scale: [1.0; 3], origin: [0.0; 3] }, 1.0)
        };
        let inputs: Vec<PathBuf> =
            ["scan.laz", "it's my \"scan\" $1.laz", "-o.las", "größe/"].map(PathBuf::from).into();
        let mut classes = crate::render::ClassTable::default();
        classes.set_color(6, [255, 0, 16]);
        classes.set_color(200, [1, 2, 3]);
        let looks = [
            Look::default(),
            Look {
                point_size: "3".parse().unwrap(),
                shading: Shading { edl_strength: 0.1, background: [1, 2, 255], high_quality: true, fill_holes: true },
                projection: crate::render::Projection::Orthographic,
                decor: "box,north".parse().unwrap(),
                ..Default::default()
            },
            Look { point_size: "0.05m".parse().unwrap(), ..Default::default() },
            Look { point_size: "0.2ft".parse().unwrap(), ..Default::default() },
            Look { point_size: "1e-7u".parse().unwrap(), ..Default::default() },
            Look {
                coloring: crate::render::Coloring {
                    by: "extra:a b".parse().unwrap(),
                    map: Some("turbo".parse().unwrap()),
                    range: Some([-1.5, 1e9 / 7.0]),
                    clip_percent: 0.3,
                    classes,
                    files: [(0, [0, 255, 9]), (12, [1, 2, 3])].into(),
                    tone: crate::render::Tone { brightness: -0.1, contrast: 1.0 / 3.0, gamma: 2.2 },
                },
                ..Default::default()
            },
            Look {
                filter: crate::render::Filter {
                    clauses: vec!["class!=7,18".parse().unwrap(), "elevation=-1.5..1e9".parse().unwrap()],
                },
                clip: crate::render::Clip {
                    bounds: Some("-1,-2,-3,4,5,6,30".parse().unwrap()),
                    slab: Some("1,2,3,0,0,1,0.5".parse().unwrap()),
                },
                ..Default::default()
            },
        ];
        for look in looks {
            let command = crate::headless::command(&look, &camera, [641, 479], &inputs);
            let cli = Cli::try_parse_from(words(&command)).unwrap_or_else(|e| panic!("{command}: {e}"));
            let Some(Command::Render(args)) = cli.command else { panic!("{command}") };
            let (found, paths) = args.view();
            assert_eq!(found, (look, Some(camera), [641, 479]), "{command}");
            let dashed: Vec<PathBuf> =
                inputs.iter().map(|p| if p.starts_with("-o.las") { "./-o.las".into() } else { p.clone() }).collect();
            assert_eq!(paths, dashed, "{command}");
        }
    }
}
