//! Searching a row of 16 rising numbers by comparing all of them at once.

use wide::{i8x16, i16x16};

/// Numbers in a row.
pub(super) const ROW: usize = 16;

/// How many of a row's rising numbers are not above `value`: the place of the first that is, or 16.
/// All must be below 2^15, to be compared as signed ones, as SSE2 does.
#[inline(always)]
pub(super) fn first_above(row: &[u16; ROW], value: u16) -> usize {
    (above(row, value) | 1 << ROW).trailing_zeros() as usize
}

/// Rows that are searched all at once, rather than the right one after a row above them.
pub(super) const FLAT: usize = 4;

/// The same of four rows.
#[inline(always)]
pub(super) fn first_above_of_four(rows: &[[u16; ROW]; FLAT], value: u16) -> usize {
    let [a, b, c, d] = rows.each_ref().map(|row| u64::from(above(row, value)));
    (a | b << 16 | (c << 32 | d << 48)).trailing_zeros() as usize
}

/// A bit per number: whether it is above `value`.
#[inline(always)]
fn above(row: &[u16; ROW], value: u16) -> u32 {
    let row: i16x16 = bytemuck::cast(*row);
    let above = row.simd_gt(i16x16::splat(value as i16));
    i8x16::from_i16x16_saturate(above).to_bitmask() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_searched() {
        let row: [u16; ROW] = std::array::from_fn(|i| if i < 13 { (i * i * 150) as u16 } else { 32_767 });
        for value in 0..32_767 {
            let right = row.iter().position(|&n| n > value).unwrap_or(ROW);
            assert_eq!(first_above(&row, value), right, "{value}");
        }
        assert_eq!(first_above(&[3; ROW], 3), ROW);
    }

    #[test]
    fn four_rows_are_searched_as_one() {
        let numbers: [u16; 4 * ROW] = std::array::from_fn(|i| (i * i * 7) as u16);
        for value in 0..32_767 {
            let right = numbers.iter().position(|&n| n > value).unwrap_or(4 * ROW);
            assert_eq!(first_above_of_four(&bytemuck::cast(numbers), value), right, "{value}");
        }
    }
}
