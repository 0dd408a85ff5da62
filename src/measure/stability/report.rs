//! The report: every experiment with all its samples.

use serde::Serialize;

use super::{
    experiment::{Claim, Experiment, Outcome, Role},
    picture::{Image, Strip, sheet},
};
use crate::measure::machine::Machine;

/// What the report calls itself.
pub const TITLE: &str = "firstlight stability";

/// All experiments of a run.
#[derive(Debug, Serialize)]
pub struct StabilityReport {
    /// [`TITLE`].
    pub report: &'static str,
    pub version: &'static str,
    pub command: String,
    pub machine: Machine,
    /// The GPU, or why there is none.
    pub device: String,
    /// False while experiments are still to come.
    pub complete: bool,
    pub experiments: Vec<Entry>,
}

/// One experiment's results.
#[derive(Debug, Serialize)]
pub struct Entry {
    pub name: &'static str,
    pub what: &'static str,
    pub source: &'static str,
    pub fails: &'static str,
    pub holds: &'static str,
    pub secs: f64,
    pub claims: Vec<Claim>,
    pub notes: Vec<String>,
    /// Charts and pictures, for the page.
    #[serde(skip)]
    pub outcome: Outcome,
}

impl Entry {
    pub fn new(experiment: &Experiment, mut outcome: Outcome, secs: f64) -> Entry {
        Entry {
            name: experiment.name,
            what: experiment.what,
            source: experiment.source,
            fails: experiment.fails,
            holds: experiment.holds,
            secs,
            claims: std::mem::take(&mut outcome.claims),
            notes: std::mem::take(&mut outcome.notes),
            outcome,
        }
    }

    /// Whether the failing methods fail, or this program's hold: false if any claim is not true, `None` if none counts.
    pub fn verdict(&self, role: Role) -> Option<bool> {
        let judged = self.claims.iter().filter(|claim| claim.role == role).filter_map(|claim| claim.is_true);
        judged.reduce(|all, one| all && one)
    }

    /// Claims that are not true.
    pub fn broken(&self) -> impl Iterator<Item = &Claim> {
        self.claims.iter().filter(|claim| claim.is_true == Some(false))
    }
}

impl StabilityReport {
    /// A row of pictures for each experiment that has some: failing, holding, truth.
    pub fn sheet(&self) -> Option<Image> {
        let strips: Vec<&Strip> = self.experiments.iter().filter_map(|entry| entry.outcome.pictures.first()).collect();
        sheet(&strips)
    }

    /// True if nothing that counts is wrong.
    pub fn is_stable(&self) -> bool {
        self.experiments.iter().all(|entry| entry.broken().next().is_none())
    }
}
