//! Values by record number: what attributes that no picture needs by itself are coloured by.
//!
//! A *column* holds one key per record of the scene (see [`super::scale`]; 0: not read, or no value). It is not in the
//! order of the store's slots: insertions move nothing in it, and a file that is read once more fills it in any order.
//! The resolve pass goes from a pixel's slot to its record, and from there to the key, for visible points alone.

use super::scale::level;

/// Which of a backend's columns.
pub type ColumnId = usize;

/// Keys on their way into a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keys<'a> {
    /// Of whole numbers of 16 bits, one more than these.
    Small(&'a [u32]),
    /// As [`key_of`](super::scale::key_of).
    Wide(&'a [u64]),
}

impl Keys<'_> {
    pub fn len(&self) -> usize {
        match self {
            Keys::Small(keys) => keys.len(),
            Keys::Wide(keys) => keys.len(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// How the keys of a column become colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lookup {
    /// Small keys: see [`table_index`].
    Table,
    /// Small keys: the last threshold reached is.
    Small,
    /// The same with wide keys.
    Wide,
}

/// Which of 256 colours a whole number of 16 bits has that is only to be told apart: up to 255 its own, and numbers 256
/// apart, such as the ids of flight lines may be, do not share one: they are 61 steps of
/// the palette apart, whose hues differ by 0.7 of a turn. Twin of `by_table` in `shaders/column.wgsl`.
pub fn table_index(value: u16) -> usize {
    let value = usize::from(value);
    (value + 61 * (value >> 8)) & 255
}

/// The colours of a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnColors {
    pub column: ColumnId,
    pub lookup: Lookup,
    /// Of small keys, in the lower halves.
    pub thresholds: [u64; 256],
    pub colors: [[u8; 4]; 256],
    /// Counts what has come into the column, so that a picture of fewer values is not taken for this one.
    pub version: u64,
}

impl ColumnColors {
    /// Red, green, blue of a key that is not 0. Twin of `shaders/column.wgsl`.
    pub fn color(&self, key: u64) -> [u8; 3] {
        let at = match self.lookup {
            Lookup::Table => table_index((key - 1) as u16),
            Lookup::Small | Lookup::Wide => level(&self.thresholds, key),
        };
        let [r, g, b, _] = self.colors[at];
        [r, g, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_256_apart_have_different_colours() {
        assert!((0..256).all(|value| table_index(value) == usize::from(value)), "classes have their own");
        for low in [0, 1, 17, 255] {
            let mut found: Vec<usize> = (0..256).map(|high| table_index(256 * high + low)).collect();
            found.sort_unstable();
            assert_eq!(found, (0..256).collect::<Vec<_>>());
        }
    }
}
