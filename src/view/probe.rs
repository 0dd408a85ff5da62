//! What is the cursor on? Asked after each frame, answered a frame or two later: nobody waits for the GPU.

use glam::{DVec2, DVec3};

use super::navigation::Navigation;
use crate::render::{GpuBackend, Pick, PickAt, PickTicket, Progressive};

/// The nearest point within this many pixels counts as hit: between points one sees through.
pub const REACH: u32 = 4;

/// Asks one thing at a time.
#[derive(Default)]
pub struct Probe {
    asked: Option<Asked>,
}

struct Asked {
    ticket: PickTicket,
    navigation: Navigation,
    cursor: DVec2,
}

/// What the cursor was on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touched {
    pub pick: Pick,
    /// Where the cursor's ray reaches the depth of that point, in world coordinates.
    pub place: DVec3,
}

impl Probe {
    /// Asks what is at the cursor in the last frame, unless an answer is on its way; true if it was asked.
    pub fn ask(&mut self, progressive: &mut Progressive<GpuBackend>, cursor: DVec2, navigation: &Navigation) -> bool {
        if self.asked.is_some() || cursor.min_element() < 0.0 {
            return false;
        }
        let at = PickAt { pixel: [cursor.x as u32, cursor.y as u32], reach: REACH };
        let asked = progressive.pick(at);
        self.asked = asked.map(|ticket| Asked { ticket, navigation: navigation.clone(), cursor });
        self.asked.is_some()
    }

    /// An answer is on its way.
    pub fn is_waiting(&self) -> bool {
        self.asked.is_some()
    }

    /// The answer, once it is there; none of a point where the background shows.
    pub fn answer(&mut self, progressive: &mut Progressive<GpuBackend>) -> Option<Option<Touched>> {
        let found = progressive.picked(self.asked.as_ref()?.ticket)?;
        let asked = self.asked.take()?;
        Some(found.map(|pick| {
            let place = asked.navigation.grab(asked.cursor, Some(pick.depth.into()));
            Touched { pick, place }
        }))
    }
}
