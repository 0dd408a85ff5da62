//! `firstlight stability`.

use std::{
    env,
    io::{self, Write},
    path::PathBuf,
};

use clap::Args;

use super::{CliError, ExitStatus, bench_ingest::command_line, say, steps::Steps};
use crate::{
    measure::{
        ReportDir, ReportDirError,
        stability::{
            EXPERIMENTS, Experiment, Setup, Size, StabilityReport, Swap, TITLE, Watcher, by_name, markdown, page,
            stability, write_csv,
        },
    },
    methods::Gpu,
};

/// Shown after the options.
pub const HELP: &str = "\
Each experiment is a failure that is known from the literature or from other programs. It shows the failing method
failing, by a number, and this program's own choice holding in the same place; if either is no longer so, the exit
code is 4. --list says what they are and where they are from.

What a device cannot show is said and not counted: without a GPU there are no racing threads and no contention, and on
a software rasterizer such as lavapipe the times of the experiment `one-pixel` are shown and not judged, since a
processor runs a few threads at once, and they hardly wait for each other.

REPORT_DIR gets stability.json (every sample), stability.csv (a line per sample), index.html (tables, charts and
pictures: failing, holding, truth) and stability.png (of each experiment that has any, the first three pictures). The report is written after every experiment, so that Ctrl-C keeps what is done.
All experiments take about half a minute on two cores.

Exit codes:
  0  every failing method fails, and this program's choices hold
  1  internal error
  2  the command line is wrong
  4  a failing method no longer fails, or a choice of this program does not hold
  5  the report cannot be written
  6  the device cannot do what the experiments need (memory)";

#[derive(Debug, Args)]
pub struct StabilityArgs {
    /// Folder for the report: new, empty, or an older report of this command; without, only the table is printed
    #[arg(short, long, value_name = "REPORT_DIR")]
    output: Option<PathBuf>,
    /// Run only these experiments (--list names them)
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', value_parser = parse_experiment)]
    only: Vec<&'static Experiment>,
    /// Say what each experiment is and where it is from, and end
    #[arg(long)]
    list: bool,
    /// Do without a GPU
    #[arg(long)]
    no_gpu: bool,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

fn parse_experiment(name: &str) -> Result<&'static Experiment, String> {
    by_name(name).ok_or_else(|| {
        let names: Vec<&str> = EXPERIMENTS.iter().map(|experiment| experiment.name).collect();
        format!("expected one of {} (see --list)", names.join(", "))
    })
}

pub fn run(args: StabilityArgs) -> Result<ExitStatus, CliError> {
    if args.list {
        return Ok(list());
    }
    let folder = args.output.as_deref().map(|path| ReportDir::prepare(path, "stability.json", TITLE)).transpose()?;
    // In the order of the table.
    let is_asked = |e: &&Experiment| args.only.is_empty() || args.only.iter().any(|asked| asked.name == e.name);
    let experiments: Vec<&'static Experiment> = EXPERIMENTS.iter().filter(is_asked).collect();
    let (gpu, device) = match (!args.no_gpu).then(Gpu::headless) {
        None => (None, "none asked for (--no-gpu)".into()),
        Some(Ok(gpu)) => {
            let device = format!("{} ({})", gpu.info.name, gpu.info.backend);
            (Some(gpu), device)
        }
        Some(Err(error)) => (None, error.to_string()),
    };
    let setup = Setup { gpu, size: Size::Full, swap: Swap::Nothing };
    let mut follow = Follow { folder, steps: Steps::new(args.quiet, "{bar:30} {pos}/{len}, {elapsed}: {msg}") };
    let report = stability(&experiments, &setup, &device, &command_line(env::args_os()), &mut follow);
    follow.steps.finish();
    let report = report?;
    if !args.quiet {
        // If nobody reads the table, the report is written all the same.
        let _ = write!(io::stdout(), "{}", markdown(&report));
        if let Some(folder) = &follow.folder {
            say(&format!("wrote {}", folder.path().join("index.html").display()));
        }
    }
    Ok(tell(&report))
}

/// Says, past --quiet, what is not as it should be.
fn tell(report: &StabilityReport) -> ExitStatus {
    for entry in &report.experiments {
        for claim in entry.broken() {
            let (role, method, quantity, value) = (claim.role.name(), &claim.method, &claim.quantity, claim.value);
            let what = format!("{method} {role} is not so: {quantity}: {value} ({:?})", claim.bound);
            say(&format!("firstlight: {}: {what}", entry.name));
        }
    }
    if report.is_stable() { ExitStatus::Ok } else { ExitStatus::Partial }
}

fn list() -> ExitStatus {
    let mut out = io::stdout().lock();
    for e in EXPERIMENTS {
        // A closed pipe is no reason to fail.
        let _ = writeln!(
            out,
            "{}\n    {}\n    fails: {}\n    holds: {}\n    from:  {}",
            e.name, e.what, e.fails, e.holds, e.source
        );
    }
    ExitStatus::Ok
}

struct Follow {
    folder: Option<ReportDir>,
    steps: Steps,
}

impl Watcher for Follow {
    fn step(&mut self, done: usize, total: usize, what: &str) {
        self.steps.step(done, total, what);
    }

    fn save(&mut self, report: &StabilityReport) -> Result<(), ReportDirError> {
        let Some(folder) = &self.folder else { return Ok(()) };
        folder.write("stability.csv", |out| write_csv(out, report))?;
        folder.write("index.html", |out| out.write_all(page(report).as_bytes()))?;
        if let Some(sheet) = report.sheet() {
            folder.write("stability.png", |out| sheet.write_png(out))?;
        }
        // Last: it is what says that the folder holds a report.
        Ok(folder.write("stability.json", |out| Ok(serde_json::to_writer_pretty(out, report)?))?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The command runs with nothing exchanged: what it says of a failure is shown here.
    #[test]
    fn what_does_not_hold_ends_with_exit_code_4() {
        let status = |swap| {
            let setup = Setup { gpu: None, size: Size::Small, swap };
            let mut follow = Follow { folder: None, steps: Steps::new(true, "{bar:30} {pos}/{len}, {elapsed}: {msg}") };
            let report = stability(&[by_name("slot-zero").unwrap()], &setup, "", "", &mut follow).unwrap();
            tell(&report) as u8
        };
        assert_eq!([Swap::Nothing, Swap::RemedyOff, Swap::FailureCured].map(status), [0, 4, 4]);
    }
}
