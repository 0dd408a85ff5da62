//! How positions lie in memory: as three 32-bit integers, or, where a box of them needs no more than 64 bits, as one
//! word of these, without loss. Twin of `shaders/packed.wgsl`.

use serde::Serialize;

use crate::scene::{Bounds, Grid};

/// How a position lies in memory. By default packed, where that fits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Encoding {
    /// Three 32-bit integers.
    Wide,
    #[default]
    /// 8 bytes: distances from a lowest corner, in as few bits as the box needs.
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

    /// Words of 32 bits that a position takes.
    pub fn position_words(self) -> u32 {
        match self {
            Encoding::Wide => 3,
            Encoding::Packed => 2,
        }
    }
}

/// A box that needs more than 64 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("8 bytes hold 64 bits of position, and this cloud needs {} + {} + {}; choose the wide encoding",
    .bits[0], .bits[1], .bits[2])]
pub struct TooWide {
    pub bits: [u32; 3],
}

/// A box in bits.
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
    /// If it takes more than 64 bits.
    pub fn of([low, high]: [[i32; 3]; 2]) -> Result<Packing, TooWide> {
        let bits: [u32; 3] = std::array::from_fn(|a| u32::BITS - high[a].abs_diff(low[a]).leading_zeros());
        if bits.iter().sum::<u32>() > u64::BITS { Err(TooWide { bits }) } else { Ok(Packing { base: low, bits }) }
    }

    /// A packing of the box that headers promise. Bits left over make it larger on all sides: headers are often off by
    /// a little.
    ///
    /// # Errors
    /// If it takes more than 64 bits, or the promise is none.
    pub fn of_scene(grid: &Grid, bounds: &Bounds) -> Result<Packing, TooWide> {
        if !bounds.is_sane() {
            return Err(TooWide { bits: [u32::BITS; 3] });
        }
        let corners = [grid.steps(bounds.min), grid.steps(bounds.max)];
        let corner = |pick: fn(f64, f64) -> f64| -> [f64; 3] {
            std::array::from_fn(|a| pick(corners[0][a].round(), corners[1][a].round()))
        };
        // The conversion saturates: what lies outside of the integers holds no point.
        let [low, high] = [corner(f64::min), corner(f64::max)].map(|steps| steps.map(|step| step as i32));
        Ok(Packing::of([low, high])?.with_all_bits(high))
    }

    /// The same box, which ends at `high`, in the middle of the largest that has 64 bits.
    fn with_all_bits(self, high: [i32; 3]) -> Packing {
        let mut bits = self.bits;
        // At most 96 in all, so that there is always an axis to give one to.
        for _ in bits.iter().sum::<u32>()..u64::BITS {
            if let Some(least) = bits.iter_mut().min() {
                *least += 1;
            }
        }
        let base = std::array::from_fn(|a| {
            let room = (1_u64 << bits[a]) - 1 - u64::from(high[a].abs_diff(self.base[a]));
            self.base[a].wrapping_sub((room / 2) as i32)
        });
        Packing { base, bits }
    }

    /// How far a position is above the base, modulo 2³².
    fn above(&self, position: [i32; 3]) -> [u32; 3] {
        std::array::from_fn(|a| position[a].wrapping_sub(self.base[a]) as u32)
    }

    /// Whether a position has a word of its own.
    pub fn holds(&self, position: [i32; 3]) -> bool {
        let above = self.above(position);
        (0..3).all(|a| u64::from(above[a]) >> self.bits[a] == 0)
    }

    /// Whether all positions have words of their own.
    pub fn holds_all(&self, positions: &[[i32; 3]]) -> bool {
        // Without a way out half-way, so that it goes through several at a time.
        let outside = positions.iter().fold([0; 3], |outside: [u32; 3], &position| {
            let above = self.above(position);
            std::array::from_fn(|a| outside[a] | above[a])
        });
        (0..3).all(|a| u64::from(outside[a]) >> self.bits[a] == 0)
    }

    /// A position within the box as a word.
    pub fn pack(&self, position: [i32; 3]) -> u64 {
        let [x, y, z] = self.above(position).map(u64::from);
        let [bits_x, bits_y, _] = self.bits;
        // An axis without bits may begin at bit 64: its distance is 0, wherever it is put.
        x | y << bits_x | z.wrapping_shl(bits_x + bits_y)
    }

    /// The position of a word.
    pub fn unpack(&self, word: u64) -> [i32; 3] {
        let mut at = 0;
        std::array::from_fn(|a| {
            let above = word.wrapping_shr(at) & ((1 << self.bits[a]) - 1);
            at += self.bits[a];
            self.base[a].wrapping_add(above as u32 as i32)
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn bits_are_those_of_the_box() {
        let bits = |low, high| Packing::of([low, high]).map(|p| p.bits);
        assert_eq!(bits([0; 3], [0; 3]), Ok([0, 0, 0]));
        assert_eq!(bits([5, -5, i32::MIN], [5, -5, i32::MIN]), Ok([0, 0, 0]));
        assert_eq!(bits([0, 0, 0], [1, 255, 256]), Ok([1, 8, 9]));
        assert_eq!(bits([i32::MIN, i32::MIN, 0], [i32::MAX, i32::MAX, 0]), Ok([32, 32, 0]));
        let error = bits([i32::MIN, i32::MIN, 0], [i32::MAX, i32::MAX, 1]).expect_err("65 bits");
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
        assert!(packing.holds([6, 13, i32::MIN]) && !packing.holds([7, 13, 0]) && !packing.holds([-2, 13, 0]));
    }

    #[test]
    fn a_promise_is_kept_with_room_around() {
        let grid = Grid { scale: [0.001, -0.001, 0.01], origin: [500e3, 5000e3, 0.0] };
        let bounds = Bounds { min: [500e3, 4999e3, -1.0], max: [500.1e3, 5000e3, 300.0] };
        let packing = Packing::of_scene(&grid, &bounds).unwrap();
        assert_eq!(packing.bits, [22, 21, 21], "17, 20 and 15 bits are needed");
        for z in [-100, 30_000] {
            assert!(packing.holds([0, 0, z]) && packing.holds([100_000, 1_000_000, z]));
            // As much room on either side.
            assert!(packing.holds([-2_000_000, -500_000, z]) && packing.holds([2_100_000, 1_500_000, z]));
        }
        assert!(!packing.holds([0, -600_000, 0]) && !packing.holds([0, 1_600_000, 0]));
        let all = Bounds { min: [-1e9; 3], max: [1e9; 3] };
        assert_eq!(
            Packing::of_scene(&Grid { scale: [0.01; 3], origin: [0.0; 3] }, &all),
            Err(TooWide { bits: [32; 3] })
        );
        let none = Bounds { min: [0.0, f64::NAN, 0.0], max: [1.0; 3] };
        assert!(Packing::of_scene(&grid, &none).is_err());
        let flat = Bounds {
            min: [f64::from(i32::MIN), f64::from(i32::MIN), 7.0],
            max: [f64::from(i32::MAX), f64::from(i32::MAX), 7.0],
        };
        let packing = Packing::of_scene(&Grid { scale: [1.0; 3], origin: [0.0; 3] }, &flat).unwrap();
        assert_eq!(packing, Packing { base: [i32::MIN, i32::MIN, 7], bits: [32, 32, 0] });
        assert_eq!(packing.unpack(packing.pack([i32::MAX, 3, 7])), [i32::MAX, 3, 7]);
    }

    proptest! {
        #[test]
        fn no_position_of_the_box_is_lost(
            corners in [[any::<i32>(), any::<i32>(), any::<i32>()], [any::<i32>(), any::<i32>(), any::<i32>()]],
            shift in [0..33_u32, 0..33, 0..33],
            within in [any::<u32>(), any::<u32>(), any::<u32>()],
        ) {
            let [base, other] = corners;
            // Boxes of all sizes.
            let side = |a: usize| other[a].abs_diff(base[a]).checked_shr(shift[a]).unwrap_or(0);
            let high: [i32; 3] = std::array::from_fn(|a| base[a].saturating_add_unsigned(side(a)));
            let Ok(tight) = Packing::of([base, high]) else { return Ok(()) };
            for packing in [tight, tight.with_all_bits(high)] {
                let position: [i32; 3] = std::array::from_fn(|a| {
                    let size = u64::from(high[a].abs_diff(base[a])) + 1;
                    base[a].wrapping_add((u64::from(within[a]) % size) as u32 as i32)
                });
                for position in [base, high, position] {
                    prop_assert!(packing.holds(position));
                    prop_assert_eq!(packing.unpack(packing.pack(position)), position);
                }
                let anywhere = within.map(|x| x as i32);
                prop_assert_eq!(packing.holds(anywhere), packing.unpack(packing.pack_any(anywhere)) == anywhere);
            }
        }
    }

    impl Packing {
        /// As [`Packing::pack`] of the part of a position that has room.
        fn pack_any(&self, position: [i32; 3]) -> u64 {
            let within: [i32; 3] = std::array::from_fn(|a| {
                let mask = ((1_u64 << self.bits[a]) - 1) as u32;
                self.base[a].wrapping_add((self.above(position)[a] & mask) as i32)
            });
            self.pack(within)
        }
    }
}
