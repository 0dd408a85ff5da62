//! One bit per slot: which points a filter hides. Twin of `shaders/mask.wgsl`.

use std::{collections::TryReserveError, sync::Arc};

use super::{POINTS_PER_THREAD, columns::Columns, store::PointStore, threads::map_parts};
use crate::render::MaskRules;

/// The bits, and what they were made with.
#[derive(Default)]
pub struct Mask {
    rules: Option<Arc<MaskRules>>,
    /// 32 slots in a word, the first in the lowest bit; empty without a filter.
    words: Vec<u32>,
    /// Slots whose bits are right, from the first on.
    known: usize,
}

impl Mask {
    /// Brings the bits up to date: all of them if the rules are others, else those of the slots that insertions since
    /// the last time have touched, `fresh` and the tail.
    pub fn update(
        &mut self,
        rules: Option<&Arc<MaskRules>>,
        store: &PointStore,
        columns: &Columns,
        fresh: &[u32],
        threads: usize,
    ) -> Result<(), TryReserveError> {
        if self.rules.as_ref() != rules {
            *self = Mask { rules: rules.cloned(), ..Mask::default() };
        }
        let Some(rules) = &self.rules else { return Ok(()) };
        let stored = store.records.len();
        self.words.try_reserve(stored.div_ceil(32) - self.words.len())?;
        self.words.resize(stored.div_ceil(32), 0);
        let is_hidden = |slot: usize| {
            let record = store.records[slot];
            let key = |column| columns.key(column, record);
            !rules.show(store.positions[slot], store.attributes[slot], record, key)
        };
        if self.known > 0 {
            let told = map_parts(threads, fresh.len(), POINTS_PER_THREAD, |part| {
                fresh[part].iter().map(|&slot| is_hidden(slot as usize)).collect::<Vec<bool>>()
            });
            for (&slot, is_hidden) in fresh.iter().zip(told.into_iter().flatten()) {
                let (word, bit) = (&mut self.words[slot as usize / 32], 1 << (slot % 32));
                *word = if is_hidden { *word | bit } else { *word & !bit };
            }
        }
        let first = self.known / 32;
        let tail = map_parts(threads, self.words.len() - first, POINTS_PER_THREAD / 32, |part| {
            let word = |word: usize| {
                let slots = 32 * word..stored.min(32 * word + 32);
                slots.rev().fold(0, |bits, slot| bits << 1 | u32::from(is_hidden(slot)))
            };
            part.map(|at| word(first + at)).collect::<Vec<u32>>()
        });
        for (word, bits) in self.words[first..].iter_mut().zip(tail.into_iter().flatten()) {
            *word = bits;
        }
        self.known = stored;
        Ok(())
    }

    /// No filter: every point is shown.
    pub fn is_off(&self) -> bool {
        self.rules.is_none()
    }

    pub fn shows(&self, slot: u32) -> bool {
        self.is_off() || self.words[slot as usize / 32] >> (slot % 32) & 1 == 0
    }

    /// Points shown; none without a filter.
    pub fn points_shown(&self) -> Option<u64> {
        let hidden: u64 = self.words.iter().map(|word| u64::from(word.count_ones())).sum();
        (!self.is_off()).then_some(self.known as u64 - hidden)
    }
}
