//! What can be asked of a running reader, and told to it, from another thread.

use std::sync::{
    Mutex, OnceLock,
    atomic::{AtomicBool, Ordering},
};

use super::ThreadTimes;

#[derive(Default)]
pub struct Control {
    /// Which files nobody wants any more; known once the headers are read.
    cancelled: OnceLock<Box<[AtomicBool]>>,
    times: Mutex<Vec<ThreadTimes>>,
}

impl Control {
    /// To be called once, before the first task.
    pub fn set_files(&self, files: usize) {
        self.cancelled.get_or_init(|| (0..files).map(|_| AtomicBool::new(false)).collect());
    }

    /// Does nothing to a file that is not there.
    pub fn cancel(&self, file: usize) {
        if let Some(flag) = self.cancelled.get().and_then(|files| files.get(file)) {
            flag.store(true, Ordering::Relaxed);
        }
    }

    pub fn is_cancelled(&self, file: usize) -> bool {
        self.cancelled.get().and_then(|files| files.get(file)).is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// What a thread did so far. Called about once per batch: the lock costs nothing beside it.
    pub fn publish(&self, times: &ThreadTimes) {
        let Ok(mut all) = self.times.lock() else { return };
        match all.iter_mut().find(|t| t.name == times.name) {
            Some(known) => known.clone_from(times),
            None => all.push(times.clone()),
        }
    }

    /// By the threads' names.
    pub fn thread_times(&self) -> Vec<ThreadTimes> {
        let mut times = self.times.lock().map(|times| times.clone()).unwrap_or_default();
        // "laz-9" before "laz-10".
        times.sort_by(|a, b| (a.name.len(), &a.name).cmp(&(b.name.len(), &b.name)));
        times
    }
}
