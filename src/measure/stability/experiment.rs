//! What an experiment is given, what it claims, and what it hands back.

use serde::Serialize;

use super::{StabilityError, picture::Strip};
use crate::{
    measure::chart::{Chart, Draw, Series},
    methods::{Cloud, Drawn, Encoding, Gpu, Method, MethodError, Runner, twin},
    render::{Backend, CpuBackend, GpuBackend, Raster, RenderError, View},
};

/// A known failure, and what must not fail. A row of [`super::EXPERIMENTS`].
#[derive(Debug)]
pub struct Experiment {
    /// As the command line calls it.
    pub name: &'static str,
    /// The situation.
    pub what: &'static str,
    /// Where the failure, or the method that fails, is described.
    pub source: &'static str,
    /// Which method fails, and how.
    pub fails: &'static str,
    /// What must hold.
    pub holds: &'static str,
    pub(super) run: fn(&Setup) -> Result<Outcome, StabilityError>,
}

/// How large an experiment is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// For tests: seconds without optimization.
    Small,
    /// What the command runs.
    Full,
}

/// A backend and its name in claims.
type NamedBackend = (&'static str, Box<dyn Backend>);

/// The GPU's backend with the method that it would begin with, and stay with.
pub(super) fn gpu_backend() -> Result<Box<dyn Backend>, StabilityError> {
    let backend = GpuBackend::headless(Raster::EarlyZ.into()).or_else(|error| match error {
        RenderError::Unsupported { .. } => GpuBackend::headless(Raster::TwoPass32.into()),
        error => Err(error),
    });
    Ok(Box::new(backend?))
}

/// What is exchanged to show that an experiment can fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Swap {
    Nothing,
    /// The failing method stands where this program's should: nothing holds any more.
    RemedyOff,
    /// This program's method stands where the failing one should: nothing fails any more.
    FailureCured,
}

/// What an experiment is given.
pub struct Setup {
    /// Without one, experiments that need a GPU say so.
    pub gpu: Option<Gpu>,
    pub size: Size,
    pub swap: Swap,
}

impl Setup {
    /// What stands in the place of the failing method.
    pub(super) fn failing<T>(&self, failing: T, ours: T) -> T {
        if self.swap == Swap::FailureCured { ours } else { failing }
    }

    /// What stands in the place of this program's method.
    pub(super) fn ours<T>(&self, failing: T, ours: T) -> T {
        if self.swap == Swap::RemedyOff { failing } else { ours }
    }

    pub(super) fn pick<T>(&self, small: T, full: T) -> T {
        if self.size == Size::Small { small } else { full }
    }

    /// The processor's backend, and the GPU's if there is one, by name.
    pub(super) fn backends(&self) -> Result<Vec<NamedBackend>, StabilityError> {
        let mut backends: Vec<NamedBackend> = vec![("cpu", Box::new(CpuBackend::new(None)))];
        if self.gpu.is_some() {
            backends.push(("gpu", gpu_backend()?));
        }
        Ok(backends)
    }

    /// The picture of a method: the GPU's if there is one that can draw it, else its definition's.
    pub(super) fn draw(
        &self,
        method: &Method,
        cloud: &Cloud,
        view: &View,
        size: [u32; 2],
    ) -> Result<Drawn, MethodError> {
        match &self.gpu {
            Some(gpu) if gpu.supports(method).is_ok() => {
                Runner::new(gpu, cloud, Encoding::Wide, size)?.draw(method, view)
            }
            _ => Ok(twin::draw(method, cloud, view, size)),
        }
    }
}

/// Whose claim it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// That a method fails.
    Fails,
    /// That this program's choice holds.
    Holds,
}

impl Role {
    pub fn name(self) -> &'static str {
        match self {
            Role::Fails => "fails",
            Role::Holds => "holds",
        }
    }
}

/// Where a value must lie.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    AtLeast(f64),
    AtMost(f64),
}

impl Bound {
    /// Not a number is within no bound.
    pub fn contains(self, value: f64) -> bool {
        match self {
            Bound::AtLeast(bound) => value >= bound,
            Bound::AtMost(bound) => value <= bound,
        }
    }
}

/// One number against its bound.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Claim {
    pub role: Role,
    pub method: String,
    /// What `value` is, with its unit.
    pub quantity: String,
    pub value: f64,
    pub bound: Bound,
    /// Why the bound is where it is.
    pub reason: &'static str,
    /// What `value` sums up: its largest, mean, … as `quantity` says.
    pub samples: Vec<f64>,
    /// Null: not counted, see `not_counted`.
    pub is_true: Option<bool>,
    /// Why it means nothing on this device.
    pub not_counted: Option<String>,
}

impl Claim {
    fn new(role: Role, method: &str, quantity: &str, value: f64, bound: Bound, reason: &'static str) -> Claim {
        Claim {
            role,
            method: method.into(),
            quantity: quantity.into(),
            value,
            bound,
            reason,
            samples: vec![value],
            is_true: Some(bound.contains(value)),
            not_counted: None,
        }
    }

    /// `method` fails by at least so much.
    pub fn fails(method: &str, quantity: &str, value: f64, at_least: f64, reason: &'static str) -> Claim {
        Claim::new(Role::Fails, method, quantity, value, Bound::AtLeast(at_least), reason)
    }

    /// `method` is off by no more than so much.
    pub fn holds(method: &str, quantity: &str, value: f64, at_most: f64, reason: &'static str) -> Claim {
        Claim::new(Role::Holds, method, quantity, value, Bound::AtMost(at_most), reason)
    }

    /// With the numbers that the value sums up.
    pub fn samples(mut self, samples: Vec<f64>) -> Claim {
        self.samples = samples;
        self
    }

    /// Shown, and not judged.
    pub fn not_counted(mut self, why: &str) -> Claim {
        self.is_true = None;
        self.not_counted = Some(why.into());
        self
    }
}

/// What an experiment found.
#[derive(Debug, Default)]
pub struct Outcome {
    pub claims: Vec<Claim>,
    pub notes: Vec<String>,
    pub charts: Vec<Chart>,
    pub pictures: Vec<Strip>,
}

impl Outcome {
    /// A chart of lines with dots.
    pub(super) fn chart(&mut self, title: &str, x: &str, y: &str, lines: Vec<(&str, Vec<(f64, f64)>)>) {
        let series = lines.into_iter().map(|(name, points)| {
            let draw = if points.len() <= 12 { Draw::LineAndDots } else { Draw::Line };
            Series { name: name.into(), points, draw }
        });
        self.charts.push(Chart {
            title: title.into(),
            x: x.into(),
            y: y.into(),
            x_at_least: 0.0,
            y_at_least: 0.0,
            x_is_whole: false,
            series: series.collect(),
        });
    }
}

/// The largest of some numbers; 0 of none, NaN if one is not a number.
pub(super) fn largest(samples: &[f64]) -> f64 {
    samples.iter().fold(0.0, |most, &v| if v.is_nan() || v > most { v } else { most })
}

/// Numbered samples, as points of a chart.
pub(super) fn numbered(samples: &[f64]) -> Vec<(f64, f64)> {
    (0..).map(f64::from).zip(samples.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_number_is_no_success() {
        assert_eq!(Claim::holds("m", "q", f64::NAN, 1.0, "").is_true, Some(false));
        assert_eq!(Claim::fails("m", "q", f64::NAN, 1.0, "").is_true, Some(false));
        assert_eq!(Claim::holds("m", "q", 1.0, 1.0, "").is_true, Some(true));
        assert_eq!(Claim::fails("m", "q", 0.9, 1.0, "").is_true, Some(false));
        assert_eq!(Claim::fails("m", "q", 0.9, 1.0, "").not_counted("why").is_true, None);
        assert!(largest(&[1.0, f64::NAN, 2.0]).is_nan(), "what comes later does not hide it");
        assert_eq!((largest(&[]), largest(&[1.0, 3.0, 2.0])), (0.0, 3.0));
    }
}
