//! Which point is at a pixel.

use std::collections::VecDeque;

/// A question for the last frame: which point is at a pixel, or within so many pixels of it?
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PickAt {
    /// Column and row, from the upper left.
    pub pixel: [u32; 2],
    /// At most [`MAX_REACH`].
    pub reach: u32,
}

/// Pixels that a pick reaches at most.
pub const MAX_REACH: u32 = 64;

/// A point that the last frame showed: that of the pixel nearest to the one asked for that shows any, however far
/// behind its neighbours it lies; of several pixels as near, the one that shows the nearest point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pick {
    /// Record number, counted through all files of the scene.
    pub record: u32,
    /// On the scene's grid.
    pub position: [i32; 3],
    /// Distance along the viewing direction, in the file's unit.
    pub depth: f32,
    /// The pixel that shows it.
    pub pixel: [u32; 2],
}

/// What an answer is asked for with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PickTicket(u64);

/// Questions that may be open at a time; of more, the oldest are given up.
pub const OPEN_PICKS: usize = 8;

/// Questions by their tickets, from the oldest on. `Q` is what a backend keeps of a question until it is answered.
pub struct Picks<Q> {
    next: u64,
    open: VecDeque<(PickTicket, Q)>,
}

impl<Q> Default for Picks<Q> {
    fn default() -> Self {
        Picks { next: 0, open: VecDeque::new() }
    }
}

impl<Q> Picks<Q> {
    /// A new question's ticket, and what was given up for it.
    pub fn open(&mut self, question: Q) -> (PickTicket, Option<Q>) {
        let ticket = PickTicket(self.next);
        self.next += 1;
        self.open.push_back((ticket, question));
        let oldest = if self.open.len() > OPEN_PICKS { self.open.pop_front() } else { None };
        (ticket, oldest.map(|(_, question)| question))
    }

    pub fn get(&self, ticket: PickTicket) -> Option<&Q> {
        self.open.iter().find(|(open, _)| *open == ticket).map(|(_, question)| question)
    }

    pub fn close(&mut self, ticket: PickTicket) -> Option<Q> {
        let at = self.open.iter().position(|(open, _)| *open == ticket)?;
        self.open.remove(at).map(|(_, question)| question)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tickets_are_their_questions_and_the_oldest_give_way() {
        let mut picks = Picks::default();
        let tickets: Vec<_> = (0..OPEN_PICKS).map(|i| picks.open(i).0).collect();
        assert_eq!(picks.get(tickets[3]), Some(&3));
        assert_eq!(picks.close(tickets[3]), Some(3));
        assert_eq!(picks.close(tickets[3]), None);
        assert_eq!(picks.open(100).1, None);
        let (last, oldest) = picks.open(101);
        assert_eq!((oldest, picks.get(tickets[0])), (Some(0), None));
        assert_eq!(picks.close(last), Some(101));
    }
}
