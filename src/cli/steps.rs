//! Steps of a long measurement, told on standard error: a bar on a terminal, else a line for each.

use std::io::{self, IsTerminal};

use indicatif::{ProgressBar, ProgressStyle};

use super::say;

/// Follows `done` of `total` steps.
pub struct Steps {
    bar: ProgressBar,
    quiet: bool,
    /// The last line, which is not told twice.
    told: String,
}

impl Steps {
    /// `template` is indicatif's, for the bar.
    pub fn new(quiet: bool, template: &str) -> Steps {
        let bar = if quiet || !io::stderr().is_terminal() { ProgressBar::hidden() } else { ProgressBar::new(1) };
        let bar = match ProgressStyle::with_template(template) {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        };
        Steps { bar, quiet, told: String::new() }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// `what` comes next.
    pub fn step(&mut self, done: usize, total: usize, what: &str) {
        self.bar.set_length(total as u64);
        self.bar.set_position(done as u64);
        self.bar.set_message(what.to_owned());
        let line = format!("{done} of {total}: {what}");
        if !self.quiet && self.bar.is_hidden() && self.told != line {
            say(&line);
            self.told = line;
        }
    }
}
