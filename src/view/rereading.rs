//! Values that a look needs and that the points came without: a second reader fetches them, beside the one that may
//! still be reading the points. They find their places by record number.

use std::{
    path::PathBuf,
    sync::Arc,
    time::{Duration, Instant},
};

use crossbeam_channel::TryRecvError;

use super::loading::LOST;
use crate::{
    render::{Backend, Progressive},
    scene::{Attribute, SceneFacts},
    source::{self, Event, Fields, OpenOptions, Stream},
};

/// A second reader, while there is one. Dropping it stops its threads.
#[derive(Default)]
pub struct Rereading {
    running: Option<Running>,
    /// What could not be read; not tried again unless the user asks for it.
    failed: Vec<Attribute>,
}

struct Running {
    stream: Stream,
    attributes: Vec<Attribute>,
    points: u64,
}

impl Rereading {
    /// What is being read, and how many of its points have come.
    pub fn progress(&self) -> Option<(&[Attribute], u64)> {
        self.running.as_ref().map(|running| (&running.attributes[..], running.points))
    }

    /// Tries this again if it is wanted, although it could not be read.
    pub fn retry(&mut self, attribute: &Attribute) {
        self.failed.retain(|failed| failed != attribute);
    }

    /// Begins to read what is wanted and lacking, together with what is wanted and being read.
    pub fn follow<B: Backend>(
        &mut self,
        progressive: &mut Progressive<B>,
        wanted: &[Attribute],
        threads: Option<usize>,
        wake: impl FnOnce() -> Arc<dyn Fn() + Send + Sync>,
    ) {
        let lacking = progressive.lacking(wanted.iter().filter(|attribute| !self.failed.contains(attribute)));
        let Some(scene) = progressive.scene().filter(|_| !lacking.is_empty()) else { return };
        let mut attributes = lacking;
        if let Some(running) = self.running.take() {
            attributes.extend(running.attributes.into_iter().filter(|attribute| wanted.contains(attribute)));
        }
        // Those that could be opened, in the order of their records.
        let inputs: Vec<PathBuf> = scene.files.iter().map(|file| file.path.clone()).collect();
        let options =
            OpenOptions { threads, fields: Some(Fields::of(&attributes)), wake: Some(wake()), ..Default::default() };
        let stream = source::open(&inputs, options);
        progressive.begin_values(attributes.clone());
        self.running = Some(Running { stream, attributes, points: 0 });
    }

    /// Lets values in until the time is up; true if there may be more.
    ///
    /// # Errors
    /// Why there are no more, in one line. What has come stays.
    pub fn drain<B: Backend>(&mut self, progressive: &mut Progressive<B>, most: Duration) -> Result<bool, String> {
        let Some(running) = &mut self.running else { return Ok(false) };
        let began = Instant::now();
        let ended = loop {
            if began.elapsed() > most {
                return Ok(true);
            }
            match running.stream.events().try_recv() {
                Ok(Event::Opened(facts)) => {
                    if !progressive.scene().is_some_and(|scene| has_same_records(scene, &facts)) {
                        break Err("the files have changed since they were opened; open them again".to_owned());
                    }
                }
                Ok(Event::Batch(batch)) => {
                    running.points += batch.len() as u64;
                    let taken = progressive.offer_values(&batch);
                    running.stream.recycle(batch);
                    if let Err(error) = taken {
                        break Err(error.to_string());
                    }
                }
                // What is wrong with a file was said when its points were read.
                Ok(Event::Finished(_)) => break Ok(()),
                Ok(Event::Failed(error)) => break Err(error.to_string()),
                Err(TryRecvError::Empty) => return Ok(false),
                Err(TryRecvError::Disconnected) => break Err(LOST.to_owned()),
            }
        };
        match &ended {
            Ok(()) => {
                progressive.end_values();
                log::debug!("read the values of {} points", running.points);
                self.running = None;
            }
            Err(_) => {
                progressive.drop_values();
                self.failed.append(&mut running.attributes);
                self.running = None;
            }
        }
        ended.map(|()| true)
    }
}

/// Whether record numbers mean the same points in both.
fn has_same_records(a: &SceneFacts, b: &SceneFacts) -> bool {
    let records = |facts: &SceneFacts| -> Vec<(PathBuf, u32, u64)> {
        facts.files.iter().map(|file| (file.path.clone(), file.first_record, file.points_in_header)).collect()
    };
    records(a) == records(b)
}
