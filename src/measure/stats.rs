//! Numbers that stand for many samples. Reports keep the samples too.

use serde::Serialize;

/// The value below which a share of the samples lies (nearest rank); NaN without samples.
pub fn quantile(samples: &[f64], share: f64) -> f64 {
    let mut samples = samples.to_vec();
    let rank = (share * samples.len() as f64).ceil().max(1.0) as usize - 1;
    if rank >= samples.len() {
        return f64::NAN;
    }
    // Errors of two million pixels are many to sort.
    *samples.select_nth_unstable_by(rank, f64::total_cmp).1
}

/// Median and quartiles (nearest rank), with the extremes; in the samples' own unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Summary {
    pub samples: usize,
    pub min: f64,
    pub lower_quartile: f64,
    pub median: f64,
    pub upper_quartile: f64,
    pub max: f64,
}

impl Summary {
    /// `None` without samples.
    pub fn of(samples: &[f64]) -> Option<Summary> {
        if samples.is_empty() {
            return None;
        }
        let at = |share| quantile(samples, share);
        Some(Summary {
            samples: samples.len(),
            min: at(0.0),
            lower_quartile: at(0.25),
            median: at(0.5),
            upper_quartile: at(0.75),
            max: at(1.0),
        })
    }

    /// The same, of a quantity that falls as the samples rise (a rate from seconds).
    pub fn per(&self, amount: f64) -> Summary {
        Summary {
            samples: self.samples,
            min: amount / self.max,
            lower_quartile: amount / self.upper_quartile,
            median: amount / self.median,
            upper_quartile: amount / self.lower_quartile,
            max: amount / self.min,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_the_nearest_rank() {
        let samples: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!(quantile(&samples, 0.5), 50.0);
        assert_eq!(quantile(&samples, 0.99), 99.0);
        assert_eq!(quantile(&samples, 1.0), 100.0);
        assert_eq!(quantile(&[7.0], 0.5), 7.0);
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn rates_turn_the_quartiles_round() {
        let secs = Summary::of(&[4.0, 1.0, 2.0, 8.0]).unwrap();
        assert_eq!((secs.lower_quartile, secs.median, secs.upper_quartile), (1.0, 2.0, 4.0));
        let rates = secs.per(8.0);
        assert_eq!((rates.min, rates.lower_quartile, rates.median), (1.0, 2.0, 4.0));
        assert_eq!((rates.upper_quartile, rates.max, rates.samples), (8.0, 8.0, 4));
        assert_eq!(Summary::of(&[]), None);
    }
}
