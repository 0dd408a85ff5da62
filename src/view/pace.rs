//! How fast window frames follow each other, and how many there were.

use std::time::Instant;

#[derive(Debug, Default)]
pub struct Pace {
    /// Smoothed time from one frame to the next, while they follow at once.
    pub secs: f64,
    began: Option<Instant>,
    follows: bool,
    frames: u64,
    drawn: u64,
}

impl Pace {
    pub fn begin(&mut self) {
        let now = Instant::now();
        if let Some(before) = self.began.replace(now)
            && self.follows
        {
            let secs = (now - before).as_secs_f64();
            self.secs = if self.secs == 0.0 { secs } else { self.secs + 0.2 * (secs - self.secs) };
        }
        self.frames += 1;
    }

    pub fn note_drawn(&mut self, drawn: bool) {
        self.drawn += u64::from(drawn);
    }

    pub fn end(&mut self, follows: bool) {
        if self.follows && !follows {
            log::debug!("at rest after {} window frames, {} drawn", self.frames, self.drawn);
        }
        self.follows = follows;
    }
}
