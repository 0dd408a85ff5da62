//! Points in the order to measure, and their encodings in memory.

use super::{MethodError, parallel::extent};

/// Points in the order to measure.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Cloud {
    /// On the scene's grid.
    pub positions: Vec<[i32; 3]>,
    /// Red in the lowest byte, then green and blue; the highest byte is not looked at. As many as
    /// positions.
    pub colors: Vec<u32>,
}

/// How a position lies in memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Encoding {
    /// 16 bytes: three 32-bit integers and the colour.
    Wide,
    /// 8 bytes: distances from the cloud's lowest corner, in as few bits as its box needs; colours have
    /// a buffer of their own.
    Packed,
}

impl Encoding {
    /// As the command line calls it.
    pub fn name(self) -> &'static str {
        match self {
            Encoding::Wide => "wide",
            Encoding::Packed => "packed",
        }
    }

    /// Bytes of a point in the buffer that every geometry pass reads.
    pub fn bytes(self) -> u64 {
        match self {
            Encoding::Wide => 16,
            Encoding::Packed => 8,
        }
    }
}

/// The box of a cloud in bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packing {
    /// Lowest corner.
    pub base: [i32; 3],
    /// For each axis, 0 to 32.
    pub bits: [u32; 3],
}

impl Packing {
    /// The smallest packing of a box with this lowest and highest corner.
    ///
    /// # Errors
    /// [`MethodError::TooWide`] if it takes more than 64 bits.
    pub fn of([low, high]: [[i32; 3]; 2]) -> Result<Packing, MethodError> {
        let bits: [u32; 3] = std::array::from_fn(|a| u32::BITS - high[a].abs_diff(low[a]).leading_zeros());
        if bits.iter().sum::<u32>() > u64::BITS {
            return Err(MethodError::TooWide { bits });
        }
        Ok(Packing { base: low, bits })
    }

    /// A position within the box as a word.
    pub fn pack(&self, position: [i32; 3]) -> u64 {
        let mut at = 0;
        let axes = position.iter().zip(&self.base).zip(&self.bits);
        axes.fold(0, |word, ((value, base), bits)| {
            // An axis without bits may begin at bit 64; its distance is 0.
            let above = u64::from(value.abs_diff(*base)).checked_shl(at).unwrap_or(0);
            at += bits;
            word | above
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_those_of_the_box() {
        let bits = |positions: &[[i32; 3]]| {
            Packing::of(extent(positions).map_or([[0; 3]; 2], |(low, high)| [low, high])).map(|p| p.bits)
        };
        assert_eq!(bits(&[]).unwrap_or([9; 3]), [0, 0, 0]);
        assert_eq!(bits(&[[5, -5, i32::MIN]]).unwrap_or([9; 3]), [0, 0, 0]);
        assert_eq!(bits(&[[0, 0, 0], [1, 255, 256]]).unwrap_or([9; 3]), [1, 8, 9]);
        assert_eq!(bits(&[[i32::MIN, i32::MIN, 0], [i32::MAX, i32::MAX, 0]]).unwrap_or([9; 3]), [32, 32, 0]);
        let error = bits(&[[i32::MIN, i32::MIN, 0], [i32::MAX, i32::MAX, 1]]).expect_err("65 bits");
        assert_eq!(
            error.to_string(),
            "8 bytes hold 64 bits of position, and this cloud needs 32 + 32 + 1; choose the wide encoding"
        );
    }

    #[test]
    fn axes_do_not_overlap() {
        let packing = Packing { base: [-1, 10, 0], bits: [3, 2, 32] };
        assert_eq!(packing.pack([-1, 10, 0]), 0);
        assert_eq!(packing.pack([6, 10, 0]), 0b111);
        assert_eq!(packing.pack([-1, 13, 0]), 0b11_000);
        assert_eq!(packing.pack([-1, 10, i32::MAX]), u64::from(i32::MAX as u32) << 5);
    }
}
