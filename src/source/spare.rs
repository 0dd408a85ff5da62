//! Empty batches whose memory is used again.

use std::sync::Mutex;

use crate::scene::PointBatch;

/// A stack of batches: the last one given back is the next one taken, since its memory is still in the
/// processor's caches. (With a queue, a dozen batches of 1.5 MB go round.)
pub struct Spare {
    batches: Mutex<Vec<PointBatch>>,
    most: usize,
}

impl Spare {
    /// Keeps at most so many.
    pub fn new(most: usize) -> Spare {
        Spare { batches: Mutex::new(Vec::with_capacity(most)), most }
    }

    /// An empty batch, with memory if one was given back.
    pub fn take(&self) -> PointBatch {
        let mut batch = self.batches.lock().ok().and_then(|mut batches| batches.pop()).unwrap_or_default();
        batch.clear();
        batch
    }

    /// Keeps a batch's memory; with enough of them already, it goes back to the system.
    pub fn give(&self, batch: PointBatch) {
        if let Ok(mut batches) = self.batches.lock()
            && batches.len() < self.most
        {
            batches.push(batch);
        }
    }
}
