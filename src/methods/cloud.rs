//! Points in the order to measure.

use super::{Encoding, parallel::extent};

/// Points in the order to measure.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Cloud {
    /// On the scene's grid.
    pub positions: Vec<[i32; 3]>,
    /// Red in the lowest byte, then green and blue; the highest byte is not looked at. As many as
    /// positions.
    pub colors: Vec<u32>,
}

impl Encoding {
    /// Bytes of a point in the buffer that every geometry pass reads: in the wide encoding the colour lies behind the
    /// position, in the packed one it has a buffer of its own.
    pub fn bytes(self) -> u64 {
        match self {
            Encoding::Wide => 16,
            Encoding::Packed => 8,
        }
    }
}

/// A cloud, and the order in which its points lie on the device. The cloud itself is not moved: at a
/// billion points a second copy of it would be 16 GB.
#[derive(Debug, Clone, Copy)]
pub struct Arranged<'a> {
    pub cloud: &'a Cloud,
    /// Slot → point; may leave points out. Without it, all points lie as they are.
    pub order: Option<&'a [u32]>,
}

impl<'a> From<&'a Cloud> for Arranged<'a> {
    fn from(cloud: &'a Cloud) -> Arranged<'a> {
        Arranged { cloud, order: None }
    }
}

impl Arranged<'_> {
    /// Lowest and highest corner of the cloud, or the origin twice if it has no points.
    pub fn extent(&self) -> [[i32; 3]; 2] {
        extent(&self.cloud.positions).map_or([[0; 3]; 2], |(low, high)| [low, high])
    }

    /// Number of slots.
    pub fn len(&self) -> usize {
        self.order.map_or(self.cloud.positions.len(), <[u32]>::len)
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The point in a slot.
    ///
    /// # Panics
    /// If there is no such slot.
    pub fn point(&self, slot: usize) -> usize {
        self.order.map_or(slot, |order| order[slot] as usize)
    }

    /// The position in a slot, if there is such a slot.
    pub fn position(&self, slot: usize) -> Option<[i32; 3]> {
        let point = match self.order {
            Some(order) => *order.get(slot)? as usize,
            None => slot,
        };
        self.cloud.positions.get(point).copied()
    }
}
