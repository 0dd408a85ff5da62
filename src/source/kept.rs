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
    /// Keeps a decoder that has decoded so many points, its bytes unloaded, for [`Kept::take`]; of the
    /// chunk's points `first` were sent before it began (its raw first record). A decoder that is not even
    /// past those (a record longer than what was loaded) is of no use.
    pub fn put(&self, chunk: (u32, u32), first: u64, decoded: u64, decoder: Option<Box<dyn ChunkDecoder>>) {
        let decoder = decoder.filter(|decoder| decoded >= first && decoder.memory_bytes() <= MAX_BYTES);
        let started = Started { sent: first.max(decoded), decoder };
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

#[cfg(test)]
mod tests {
    use super::{
        super::laz::{Decoded, End, Share},
        *,
    };

    struct Dummy(usize);

    impl ChunkDecoder for Dummy {
        fn load(&mut self, _: Share, _: &mut Vec<Vec<u8>>) -> Result<(), String> {
            Ok(())
        }
        fn decode(&mut self, _: &mut [u8]) -> Decoded {
            Decoded { records: 0, end: End::NeedsBytes }
        }
        fn unload(&mut self, _: &mut Vec<Vec<u8>>) {}
        fn unused(&self) -> Option<u64> {
            None
        }
        fn memory_bytes(&self) -> usize {
            self.0
        }
    }

    #[test]
    fn only_a_small_decoder_that_is_past_what_was_sent_goes_on() {
        let kept = Kept::default();
        let taken = |first, decoded, bytes| {
            kept.put((0, 7), first, decoded, Some(Box::new(Dummy(bytes))));
            let started = kept.take((0, 7), &AtomicBool::new(true)).unwrap();
            (started.sent, started.decoder.is_some())
        };
        assert_eq!(taken(1, 250, 1_000), (250, true));
        assert_eq!(taken(1, 1, 1_000), (1, true));
        assert_eq!(taken(0, 0, 1_000), (0, true));
        // Going on would number each point one too low.
        assert_eq!(taken(1, 0, 1_000), (1, false));
        assert_eq!(taken(1, 250, MAX_BYTES + 1), (250, false));
        assert!(kept.take((0, 7), &AtomicBool::new(true)).is_none(), "cancelled, and taken before");
    }
}
