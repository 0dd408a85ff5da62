//! [`Progressive`] with some of its points hidden: which are shown, and when their bits are made anew.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use super::{
    Backend, Progressive,
    filter::{Clip, Filter, MaskRules, Place},
};
use crate::{device::RenderError, scene::Attribute};

/// While values arrive that a filter needs, all points are looked at anew so often and no more: on a software rasterizer
/// that takes a few frames' time.
const REFRESH: Duration = Duration::from_millis(500);

/// What is shown.
#[derive(Default)]
pub struct Selection {
    filter: Filter,
    clip: Clip,
    /// What these come to on the scene; none: all points are shown.
    pub mask: Option<Arc<MaskRules>>,
    /// Another scene, another filter, or more values.
    pub is_stale: bool,
    made: Option<Instant>,
}

impl<B: Backend> Progressive<B> {
    /// Which points are shown from the next frame on, in this scene and those to come. What was visible and still is
    /// stays in the picture; all points are tried again. Of points whose values have not come (see
    /// [`Progressive::lacking`]) nothing is shown.
    pub fn set_filter(&mut self, filter: &Filter, clip: &Clip) {
        let selection = &mut self.selection;
        if (&selection.filter, &selection.clip) != (filter, clip) {
            selection.filter.clone_from(filter);
            selection.clip = *clip;
            selection.is_stale = true;
            // At once, and not only when the next values come.
            selection.made = None;
            self.values.forget_refusals();
        }
    }

    /// Points that the last frame's filter shows of those stored then, as soon as the device has told; without a
    /// filter all.
    pub fn points_shown(&mut self) -> Option<u64> {
        if self.selection.mask.is_none() { Some(self.stored.into()) } else { self.backend.points_shown() }
    }

    /// The same, waited for: the device tells in two steps.
    ///
    /// # Errors
    /// A lost device.
    pub fn wait_for_points_shown(&mut self) -> Result<Option<u64>, RenderError> {
        for _ in 0..2 {
            let _ = self.points_shown();
            self.backend.wait()?;
        }
        Ok(self.points_shown())
    }

    /// Brings the rules up to date. Other ones make every point be tried again.
    pub(super) fn refresh_mask(&mut self) {
        let Some(scene) = self.scene.as_ref().filter(|_| self.selection.is_stale) else { return };
        let Selection { filter, clip, .. } = &self.selection;
        let is_arriving = filter.attributes().any(|attribute| self.values.is_being_read(attribute));
        if is_arriving && self.selection.made.is_some_and(|made| made.elapsed() < REFRESH) {
            return;
        }
        self.values.protect(filter.attributes().cloned().collect());
        let values = &self.values;
        let place = |attribute: &Attribute| match values.column_of(attribute) {
            _ if values.is_in_slots(attribute) => Place::Slots,
            Some((column, version)) if values.is_being_read(attribute) => Place::Column { column, version },
            // All have come, or they come with the points, and are there before these are stored.
            Some((column, _)) => Place::Column { column, version: u64::MAX },
            None => Place::Nowhere,
        };
        let rules = MaskRules::new(filter, clip, scene, place);
        self.selection.is_stale = false;
        self.selection.made = Some(Instant::now());
        if self.selection.mask.as_deref() != rules.as_ref() {
            self.selection.mask = rules.map(Arc::new);
            self.restart();
        }
    }
}
