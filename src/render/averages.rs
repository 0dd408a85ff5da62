//! How far the averages of high-quality shading have come: which slots are in the sums.

use super::{backend::Averaging, color::FileColor};
use crate::store::Coverage;

/// Sums mean something beyond their frame only while the depths are final and stay so.
#[derive(Debug, Default)]
pub struct Averages {
    coverage: Coverage,
    /// The colour rules that the sums were made with; none if they are of one frame alone.
    files: Option<Vec<FileColor>>,
}

impl Averages {
    /// The next frame with final depths begins anew.
    pub fn invalidate(&mut self) {
        self.files = None;
    }

    /// Points in sums that are to stay.
    pub fn points(&self) -> u64 {
        if self.files.is_some() { self.coverage.tried().into() } else { 0 }
    }

    /// True if all points stored are in the sums, in the colours that these rules give.
    pub fn are_complete(&self, stored: u32, files: &[FileColor]) -> bool {
        self.files.as_deref() == Some(files) && self.coverage.is_complete(stored)
    }

    /// The next `budget` slots for sums that stay: the depths are final once the frame has drawn its own.
    pub fn go_on(&mut self, stored: u32, budget: u32, files: &[FileColor]) -> Averaging {
        let begins = self.files.as_deref() != Some(files);
        if begins {
            self.coverage.restart();
            self.files = Some(files.to_vec());
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
