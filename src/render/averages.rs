//! How far the averages of high-quality shading have come: which slots are in the sums.

use std::sync::Arc;

use super::{backend::Averaging, color::PointColors};
use crate::store::Coverage;

/// Sums mean something beyond their frame only while the depths are final and stay so.
#[derive(Debug, Default)]
pub struct Averages {
    coverage: Coverage,
    /// The colours that the sums were made with; none if they are of one frame alone.
    colors: Option<Arc<PointColors>>,
}

impl Averages {
    /// The next frame with final depths begins anew.
    pub fn invalidate(&mut self) {
        self.colors = None;
    }

    /// Points in sums that are to stay.
    pub fn points(&self) -> u64 {
        if self.colors.is_some() { self.coverage.tried().into() } else { 0 }
    }

    /// True if all points stored are in the sums, in these colours.
    pub fn are_complete(&self, stored: u32, colors: &Arc<PointColors>) -> bool {
        self.colors.as_ref() == Some(colors) && self.coverage.is_complete(stored)
    }

    /// The next `budget` slots for sums that stay: the depths are final once the frame has drawn its own.
    pub fn go_on(&mut self, stored: u32, budget: u32, colors: &Arc<PointColors>) -> Averaging {
        let begins = self.colors.as_ref() != Some(colors);
        if begins {
            self.coverage.restart();
            self.colors = Some(colors.clone());
        }
        Averaging { begins, lists: false, slots: self.coverage.advance(stored, budget) }
    }

    /// The next `budget` slots for sums of one frame.
    pub fn sample(&mut self, stored: u32, budget: u32) -> Averaging {
        self.invalidate();
        self.coverage.restart();
        Averaging { begins: true, lists: true, slots: self.coverage.advance(stored, budget) }
    }
}
