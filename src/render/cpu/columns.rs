//! Values by record number in memory. Twin of `shaders/fill_column.wgsl`.

use std::collections::TryReserveError;

use crate::render::{ColumnId, Keys};

/// Keys by record, as far as any came; 0 for those that did not.
enum Column {
    Small(Vec<u32>),
    Wide(Vec<u64>),
}

/// All columns of a scene.
#[derive(Default)]
pub struct Columns {
    columns: Vec<Option<Column>>,
}

impl Columns {
    /// Puts keys in their places. If memory runs out, nothing has changed.
    pub fn fill(&mut self, column: ColumnId, records: &[u32], keys: Keys<'_>) -> Result<(), TryReserveError> {
        if self.columns.len() <= column {
            self.columns.resize_with(column + 1, || None);
        }
        let place = self.columns[column].get_or_insert_with(|| match keys {
            Keys::Small(_) => Column::Small(Vec::new()),
            Keys::Wide(_) => Column::Wide(Vec::new()),
        });
        match (place, keys) {
            (Column::Small(column), Keys::Small(keys)) => fill(column, records, keys),
            (Column::Wide(column), Keys::Wide(keys)) => fill(column, records, keys),
            _ => unreachable!("a column's keys are of one kind"),
        }
    }

    pub fn drop_column(&mut self, column: ColumnId) {
        if let Some(place) = self.columns.get_mut(column) {
            *place = None;
        }
    }

    /// The key of a record; 0 if there is none.
    pub fn key(&self, column: ColumnId, record: u32) -> u64 {
        match self.columns.get(column) {
            Some(Some(Column::Small(keys))) => keys.get(record as usize).map_or(0, |&key| key.into()),
            Some(Some(Column::Wide(keys))) => keys.get(record as usize).copied().unwrap_or(0),
            _ => 0,
        }
    }
}

fn fill<K: Copy + Default>(column: &mut Vec<K>, records: &[u32], keys: &[K]) -> Result<(), TryReserveError> {
    assert_eq!(records.len(), keys.len());
    let needed = records.iter().max().map_or(0, |&record| record as usize + 1);
    if needed > column.len() {
        column.try_reserve(needed - column.len())?;
        column.resize(needed, K::default());
    }
    for (&record, &key) in records.iter().zip(keys) {
        column[record as usize] = key;
    }
    Ok(())
}
