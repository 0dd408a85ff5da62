//! How far it is: a bar on a terminal, now and then a line elsewhere.

use std::{
    io::Write,
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle as BarStyle};

/// How to tell.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ProgressStyle {
    #[default]
    Silent,
    /// A bar on the terminal behind standard error.
    Bar,
    /// A line on standard error, a few seconds apart.
    Lines,
}

/// Time between two lines: a log of a long run stays short.
const LINE_EVERY: Duration = Duration::from_secs(5);

pub(super) struct Progress {
    style: ProgressStyle,
    bar: ProgressBar,
    last_line: Instant,
}

impl Progress {
    pub fn new(style: ProgressStyle) -> Progress {
        let target = match style {
            ProgressStyle::Bar => ProgressDrawTarget::stderr(),
            ProgressStyle::Silent | ProgressStyle::Lines => ProgressDrawTarget::hidden(),
        };
        let bar = ProgressBar::with_draw_target(None, target);
        if let Ok(style) =
            BarStyle::with_template("{bar:30} {human_pos} of {human_len} points, {per_sec}, {elapsed} {msg}")
        {
            bar.set_style(style);
        }
        Progress { style, bar, last_line: Instant::now() }
    }

    pub fn expect(&self, points: u64) {
        self.bar.set_length(points);
    }

    pub fn update(&mut self, stored: u64, tried: u64, expected: u64) {
        match self.style {
            ProgressStyle::Silent => {}
            ProgressStyle::Bar => {
                self.bar.set_position(stored);
                if tried < stored && stored >= expected {
                    self.bar.set_message(format!("({} % drawn)", 100 * tried / stored));
                }
            }
            ProgressStyle::Lines if self.last_line.elapsed() >= LINE_EVERY => {
                self.last_line = Instant::now();
                let percent = (100 * stored).checked_div(expected).unwrap_or(100);
                let line = format!(
                    "{} of {} points loaded ({percent} %), {} in the picture",
                    grouped(stored),
                    grouped(expected),
                    grouped(tried)
                );
                // Nobody reads it: no reason to stop.
                let _ = writeln!(std::io::stderr(), "{line}");
            }
            ProgressStyle::Lines => {}
        }
    }

    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// `1234567` as `1,234,567`.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    #[test]
    fn thousands_are_grouped() {
        let numbers = [0, 12, 999, 1000, 45_678, 123_456, 1_234_567];
        let grouped: Vec<String> = numbers.into_iter().map(super::grouped).collect();
        assert_eq!(grouped, ["0", "12", "999", "1,000", "45,678", "123,456", "1,234,567"]);
    }
}
