//! From the decoders' channel into the store, a few milliseconds per frame; and how far that is.

use std::{
    collections::{BTreeSet, VecDeque},
    path::PathBuf,
    sync::Arc,
    time::{Duration, Instant},
};

use crossbeam_channel::{RecvTimeoutError, TryRecvError};

use crate::{
    render::{Backend, Progressive},
    scene::{Attribute, SceneFacts},
    source::{self, Event, Fields, OpenOptions, SourceReport, Stream, ThreadTimes},
};

/// Speed is shown as an average over this long.
const RATE_WINDOW: Duration = Duration::from_secs(1);

/// How long a frame waits for one more batch: of many small files, threads that wait for room in the channel pass the
/// next on within that, and a frame takes more than what the channel holds: 3,000 files of one point in 4 s.
const NEXT_BATCH: Duration = Duration::from_micros(200);

/// Said when the channel closes before its last event.
pub const LOST: &str = "the reader stopped without saying why; this is a defect of firstlight, please report it";

/// A scene on its way in. Dropping it stops the decoders.
pub struct Loading {
    stream: Option<Stream>,
    /// Attributes that all batches have.
    pub carried: Vec<Attribute>,
    scene: Option<Arc<SceneFacts>>,
    points_read: u64,
    started: Instant,
    ended: Option<Instant>,
    /// Points read at times of the last second.
    recent: VecDeque<(Instant, u64)>,
    /// Points read of each file.
    read_by_file: Vec<u64>,
    /// Files that the user has stopped.
    stopped: BTreeSet<usize>,
    /// Once all is read.
    report: Option<SourceReport>,
}

/// What [`Loading::take_first`] found.
pub enum First {
    /// Headers are still being read.
    Nothing,
    Opened(Arc<SceneFacts>),
    /// Nothing could be opened, and why.
    Failed(String),
}

/// What [`Loading::drain`] found.
pub enum Drained {
    /// Nothing more for now; the decoders wake the window when there is.
    Empty,
    /// There is, or may be, more than one frame takes.
    More,
    /// The input has ended.
    Ended(End),
}

pub enum End {
    Finished(SourceReport),
    /// It broke off, and why.
    Failed(String),
}

impl Loading {
    /// `carried`: attributes to read besides what the automatic colours depend on.
    pub fn start(
        inputs: &[PathBuf],
        threads: Option<usize>,
        carried: Vec<Attribute>,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> Loading {
        // The automatic colours too: back to them is a key away.
        let fields = (!carried.is_empty()).then(|| Fields::of(&carried).union(Fields::COLORS));
        let options = OpenOptions { threads, fields, wake: Some(wake), ..Default::default() };
        Loading {
            stream: Some(source::open(inputs, options)),
            carried,
            scene: None,
            points_read: 0,
            started: Instant::now(),
            ended: None,
            recent: VecDeque::new(),
            read_by_file: Vec::new(),
            stopped: BTreeSet::new(),
            report: None,
        }
    }

    /// Looks whether the headers are known; to be called until they are.
    pub fn take_first(&mut self) -> First {
        let Some(stream) = &self.stream else { return First::Nothing };
        match stream.events().try_recv() {
            Ok(Event::Opened(scene)) => {
                self.read_by_file = vec![0; scene.files.len()];
                self.scene = Some(scene.clone());
                First::Opened(scene)
            }
            Ok(Event::Failed(error)) => First::Failed(error.to_string()),
            Err(TryRecvError::Empty) => First::Nothing,
            // Batches and reports follow `Opened` only.
            Ok(Event::Batch(_) | Event::Finished(_)) | Err(TryRecvError::Disconnected) => First::Failed(LOST.into()),
        }
    }

    /// Takes batches until the store has enough for a frame or the time is up.
    pub fn drain<B: Backend>(&mut self, store: &mut Progressive<B>, most: Duration) -> Drained {
        let Some(stream) = &self.stream else {
            store.spent().for_each(drop);
            return Drained::Empty;
        };
        for batch in store.spent() {
            stream.recycle(batch);
        }
        let began = Instant::now();
        let end = loop {
            if !store.wants_points() || began.elapsed() > most {
                break None;
            }
            // The decoders of many small files wait for room in the channel and fill it at once.
            match stream.events().recv_timeout(NEXT_BATCH) {
                Ok(Event::Batch(batch)) => {
                    self.points_read += batch.len() as u64;
                    if let Some(read) = self.read_by_file.get_mut(batch.file as usize) {
                        *read += batch.len() as u64;
                    }
                    store.offer(batch);
                }
                Ok(Event::Finished(report)) => {
                    self.report = Some(report.clone());
                    break Some(End::Finished(report));
                }
                Ok(Event::Failed(error)) => break Some(End::Failed(error.to_string())),
                Ok(Event::Opened(_)) => {}
                Err(RecvTimeoutError::Timeout) => {
                    self.note_rate();
                    return Drained::Empty;
                }
                Err(RecvTimeoutError::Disconnected) => break Some(End::Failed(LOST.into())),
            }
        };
        self.note_rate();
        match end {
            Some(end) => {
                store.end_of_input();
                self.stop();
                Drained::Ended(end)
            }
            None => Drained::More,
        }
    }

    /// Stops the decoders.
    pub fn stop(&mut self) {
        self.stream = None;
        self.ended.get_or_insert_with(Instant::now);
    }

    /// Stops reading one file.
    pub fn stop_file(&mut self, file: usize) {
        if let Some(stream) = &self.stream {
            stream.cancel_file(file);
            self.stopped.insert(file);
        }
    }

    /// The user has stopped this file, or all of them.
    pub fn is_stopped(&self, file: usize) -> bool {
        self.stopped.contains(&file) || (self.stream.is_none() && self.report.is_none())
    }

    pub fn points_read_of(&self, file: usize) -> u64 {
        self.read_by_file.get(file).copied().unwrap_or(0)
    }

    /// What came of it, once all is read.
    pub fn report(&self) -> Option<&SourceReport> {
        self.report.as_ref()
    }

    /// Events that wait for the window, and for how many there is room; `None` once the channel is closed.
    pub fn channel(&self) -> Option<[usize; 2]> {
        let events = self.stream.as_ref()?.events();
        Some([events.len(), events.capacity().unwrap_or(usize::MAX)])
    }

    /// What the decoder threads did until now, or in all.
    pub fn thread_times(&self) -> Vec<ThreadTimes> {
        match (&self.stream, &self.report) {
            (Some(stream), _) => stream.thread_times(),
            (None, Some(report)) => report.threads.clone(),
            (None, None) => Vec::new(),
        }
    }

    /// Until all is read, at the speed of the last second; `None` where that says nothing yet.
    pub fn secs_to_go(&self) -> Option<f64> {
        let left = self.scene()?.points_in_header().saturating_sub(self.points_read);
        let rate = self.rate();
        (self.is_running() && rate > 0.0 && self.elapsed() > RATE_WINDOW).then(|| left as f64 / rate)
    }

    pub fn is_running(&self) -> bool {
        self.stream.is_some()
    }

    pub fn scene(&self) -> Option<&Arc<SceneFacts>> {
        self.scene.as_ref()
    }

    pub fn points_read(&self) -> u64 {
        self.points_read
    }

    /// From the start until now, or until all was read.
    pub fn elapsed(&self) -> Duration {
        self.ended.unwrap_or_else(Instant::now) - self.started
    }

    /// Points per second: of the last second while loading, of the whole afterwards.
    pub fn rate(&self) -> f64 {
        match (self.ended, self.recent.front()) {
            (None, Some((since, before))) if since.elapsed() > Duration::from_millis(100) => {
                (self.points_read - before) as f64 / since.elapsed().as_secs_f64()
            }
            _ => self.points_read as f64 / self.elapsed().as_secs_f64().max(1e-3),
        }
    }

    fn note_rate(&mut self) {
        let now = Instant::now();
        self.recent.push_back((now, self.points_read));
        // One sample older than the window stays, so that the window is always covered.
        while self.recent.get(1).is_some_and(|(at, _)| now - *at > RATE_WINDOW) {
            self.recent.pop_front();
        }
    }
}
