//! Decoders that the preview has started and the full pass goes on with, so that no point is decoded
//! twice.

use std::{
    collections::HashMap,
    sync::{
        Condvar, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use super::{laz::ChunkDecoder, order::MAX_KEPT};

/// A started decoder with more heap memory than this is dropped, and its chunk decoded again: of real
/// files' decoders after their first points, all have less.
const MAX_BYTES: usize = 256 << 10;

/// Most heap memory that all kept decoders have together.
pub const BOUND_BYTES: u64 = MAX_KEPT as u64 * MAX_BYTES as u64;

/// How long a wait lasts before the cancel flag is looked at.
const LOOK_UP: Duration = Duration::from_millis(10);

/// What became of a chunk's start.
#[derive(Default)]
pub struct Started {
    /// Points of the chunk that were already sent.
    pub sent: u64,
    /// The decoder behind the last of them; `None` if decoding must begin anew.
    pub decoder: Option<Box<dyn ChunkDecoder>>,
}

/// Chunks that were started early, by file and number.
#[derive(Default)]
pub struct Kept {
    started: Mutex<HashMap<(u32, u32), Started>>,
    changed: Condvar,
}

impl Kept {
    /// Keeps a decoder, whose bytes are unloaded, for [`Kept::take`].
    pub fn put(&self, chunk: (u32, u32), mut started: Started) {
        started.decoder = started.decoder.filter(|decoder| decoder.memory_bytes() <= MAX_BYTES);
        if let Ok(mut all) = self.started.lock() {
            all.insert(chunk, started);
        }
        self.changed.notify_all();
    }

    /// Takes what [`Kept::put`] has kept, or will keep: every chunk that is started early is put once,
    /// and the task that does it was taken before the one that asks. `None` if cancelled.
    pub fn take(&self, chunk: (u32, u32), cancel: &AtomicBool) -> Option<Started> {
        let mut all = self.started.lock().ok()?;
        loop {
            if let Some(started) = all.remove(&chunk) {
                return Some(started);
            }
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            all = self.changed.wait_timeout(all, LOOK_UP).ok()?.0;
        }
    }
}
