//! All experiments in turn.

use std::time::Instant;

use super::{
    StabilityError,
    experiment::{Experiment, Setup},
    report::{Entry, StabilityReport, TITLE},
};
use crate::measure::{machine::Machine, report_dir::ReportDirError};

/// Who follows a run.
pub trait Watcher {
    /// `done` of `total` experiments; `what` goes on.
    fn step(&mut self, done: usize, total: usize, what: &str);
    /// Keeps what there is so far.
    ///
    /// # Errors
    /// If it cannot be written.
    fn save(&mut self, report: &StabilityReport) -> Result<(), ReportDirError>;
}

/// Runs these experiments, and keeps the report after each.
///
/// # Errors
/// A device that stops working, memory that runs out, a report that cannot be kept.
pub fn stability(
    experiments: &[&'static Experiment],
    setup: &Setup,
    device: &str,
    command: &str,
    watcher: &mut dyn Watcher,
) -> Result<StabilityReport, StabilityError> {
    let mut report = StabilityReport {
        report: TITLE,
        version: env!("CARGO_PKG_VERSION"),
        command: command.into(),
        machine: Machine::find(),
        device: device.into(),
        complete: experiments.is_empty(),
        experiments: Vec::new(),
    };
    for (done, experiment) in experiments.iter().enumerate() {
        watcher.step(done, experiments.len(), experiment.name);
        let start = Instant::now();
        let outcome = (experiment.run)(setup)?;
        report.experiments.push(Entry::new(experiment, outcome, start.elapsed().as_secs_f64()));
        report.complete = done + 1 == experiments.len();
        if report.complete {
            report.machine.finish();
        }
        watcher.save(&report)?;
    }
    Ok(report)
}
