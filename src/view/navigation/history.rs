//! Camera moves that can be undone, one gesture at a time.

use crate::render::Camera;

/// Moves of the same kind that follow each other within so many seconds are one gesture.
const PAUSE_SECS: f64 = 0.7;
/// Older moves are forgotten.
const KEPT: usize = 500;

/// What moves the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gesture {
    /// The mouse, from pressing a button to releasing it: all moves with one number are one gesture.
    Drag(u64),
    Wheel,
    /// Keys that are held.
    Keys,
    /// To a view that was asked for; always a gesture of its own.
    Jump,
}

/// The cameras before each gesture, and those that were undone.
#[derive(Debug, Default)]
pub struct History {
    past: Vec<Camera>,
    future: Vec<Camera>,
    last: Option<(Gesture, f64)>,
}

impl History {
    /// The camera was `before` until this gesture, or a part of it, moved it at `now` (seconds).
    pub fn note(&mut self, gesture: Gesture, before: Camera, now: f64) {
        let goes_on = match (self.last, gesture) {
            (Some((last @ Gesture::Drag(_), _)), Gesture::Drag(_)) => last == gesture,
            (Some((last, at)), Gesture::Wheel | Gesture::Keys) => last == gesture && now - at < PAUSE_SECS,
            _ => false,
        };
        self.last = Some((gesture, now));
        self.future.clear();
        if !goes_on && self.past.last() != Some(&before) {
            if self.past.len() == KEPT {
                self.past.remove(0);
            }
            self.past.push(before);
        }
    }

    /// The camera before the last gesture.
    pub fn undo(&mut self, current: Camera) -> Option<Camera> {
        self.last = None;
        // A gesture that ended where it began is no step.
        while self.past.last() == Some(&current) {
            self.past.pop();
        }
        let before = self.past.pop()?;
        self.future.push(current);
        Some(before)
    }

    /// The camera after the gesture that was undone last.
    pub fn redo(&mut self, current: Camera) -> Option<Camera> {
        self.last = None;
        let after = self.future.pop()?;
        self.past.push(current);
        Some(after)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(x: f64) -> Camera {
        Camera {
            eye: [x, 0.0, 0.0],
            target: [0.0, 1.0, 0.0],
            up: [0.0, 0.0, 1.0],
            fov_y_deg: 60.0,
            projection: Default::default(),
        }
    }

    #[test]
    fn a_gesture_is_one_step_back_and_one_forth() {
        let mut history = History::default();
        let moves = [
            (Gesture::Drag(1), 0.0, 0.0),
            // Held still for long: the same drag.
            (Gesture::Drag(1), 1.0, 9.0),
            (Gesture::Drag(2), 2.0, 9.1),
            (Gesture::Wheel, 3.0, 9.2),
            (Gesture::Wheel, 4.0, 9.6),
            (Gesture::Wheel, 5.0, 10.6),
            (Gesture::Keys, 6.0, 10.7),
            (Gesture::Keys, 7.0, 10.8),
            (Gesture::Jump, 8.0, 10.9),
            (Gesture::Jump, 9.0, 10.91),
        ];
        for (gesture, before, at) in moves {
            history.note(gesture, camera(before), at);
        }
        let mut current = camera(10.0);
        let mut seen = Vec::new();
        while let Some(before) = history.undo(current) {
            seen.push(before.eye[0]);
            current = before;
        }
        assert_eq!(seen, [9.0, 8.0, 6.0, 5.0, 3.0, 2.0, 0.0]);
        let mut seen = Vec::new();
        while let Some(after) = history.redo(current) {
            seen.push(after.eye[0]);
            current = after;
        }
        assert_eq!(seen, [2.0, 3.0, 5.0, 6.0, 8.0, 9.0, 10.0]);
    }

    #[test]
    fn a_new_move_forgets_what_was_undone() {
        let mut history = History::default();
        history.note(Gesture::Jump, camera(0.0), 0.0);
        assert_eq!(history.undo(camera(1.0)), Some(camera(0.0)));
        history.note(Gesture::Jump, camera(0.0), 1.0);
        assert_eq!(history.redo(camera(5.0)), None);
        assert_eq!(history.undo(camera(5.0)), Some(camera(0.0)));
    }

    #[test]
    fn wheel_turns_before_and_after_an_undo_are_two_gestures() {
        let mut history = History::default();
        history.note(Gesture::Wheel, camera(0.0), 0.0);
        history.note(Gesture::Wheel, camera(1.0), 0.1);
        assert_eq!(history.undo(camera(2.0)), Some(camera(0.0)));
        history.note(Gesture::Wheel, camera(0.0), 0.2);
        assert_eq!(history.undo(camera(3.0)), Some(camera(0.0)));
    }

    #[test]
    fn memory_is_bounded() {
        let mut history = History::default();
        for i in 0..3 * KEPT {
            history.note(Gesture::Jump, camera(i as f64), i as f64);
        }
        assert_eq!(history.past.len(), KEPT);
    }
}
