//! From raw point records to the columns of a [`PointBatch`]: positions on the scene's grid, colours,
//! record numbers, and what they say of the file.

use super::{
    bytes::{i32_at, u16_at},
    fields::Fields,
    grid::Placement,
};
use crate::scene::{PointBatch, intensity_bin};

/// One of so many points is counted in the intensity histogram.
const INTENSITY_EVERY: usize = 16;

/// What converting a run of records has met.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Oddities {
    /// Points outside of the header's box.
    pub outside_bounds: u64,
    /// Points that the scene's grid cannot hold: moved to its border.
    pub beyond_grid: u64,
}

/// How a file's records become points.
#[derive(Debug, Clone)]
pub struct RecordReader {
    /// Bytes of a record, at least as many as its format needs.
    pub record_length: usize,
    /// Byte offset of red, green, blue; only offsets that a point format has.
    pub rgb_at: Option<usize>,
    /// From the record's integers to the scene's grid.
    pub placement: Placement,
    /// The header's box in the record's integers, half a step wider; `None` if it makes no sense.
    pub bounds: Option<([i32; 3], [i32; 3])>,
    /// Record number, in the scene, of the file's first point.
    pub first_record: u32,
    pub fields: Fields,
}

impl RecordReader {
    /// Bytes of a batch's columns per point.
    pub fn bytes_per_point(&self) -> usize {
        size_of::<[i32; 3]>() + size_of::<[u16; 4]>() + size_of::<u32>()
    }

    /// Appends whole records to a batch; `index` is the first one's number within the file.
    pub fn append(&self, bytes: &[u8], index: u32, batch: &mut PointBatch) -> Oddities {
        let start = batch.len();
        // A record length known to the compiler is worth about a factor of two.
        match (self.record_length, self.rgb_at) {
            (20, None) => columns::<20, 0>(bytes.as_chunks().0.iter(), batch),
            (28, None) => columns::<28, 0>(bytes.as_chunks().0.iter(), batch),
            (26, Some(20)) => columns::<26, 20>(bytes.as_chunks().0.iter(), batch),
            (34, Some(28)) => columns::<34, 28>(bytes.as_chunks().0.iter(), batch),
            (30, None) => columns::<30, 0>(bytes.as_chunks().0.iter(), batch),
            (36, Some(30)) => columns::<36, 30>(bytes.as_chunks().0.iter(), batch),
            (38, Some(30)) => columns::<38, 30>(bytes.as_chunks().0.iter(), batch),
            (n, None) => columns::<20, 0>(heads(bytes, n), batch),
            (n, Some(20)) => columns::<26, 20>(heads(bytes, n), batch),
            (n, Some(28)) => columns::<34, 28>(heads(bytes, n), batch),
            (n, Some(_)) => columns::<36, 30>(heads(bytes, n), batch),
        }
        let first = self.first_record + index;
        batch.records.extend(first..first + (batch.len() - start) as u32);
        self.finish(start, index, batch)
    }

    /// How many records there are before the first one outside of the header's box.
    pub fn inside_bounds(&self, bytes: &[u8]) -> usize {
        let records = bytes.len() / self.record_length;
        let Some((low, high)) = self.bounds else { return records };
        let outside = |r: &[u8]| {
            (0..3).any(|a| {
                let i = i32_at(r, 4 * a);
                i < low[a] || i > high[a]
            })
        };
        bytes.chunks_exact(self.record_length).position(outside).unwrap_or(records)
    }

    /// Statistics and the grid, over the points from `start` on.
    fn finish(&self, start: usize, index: u32, batch: &mut PointBatch) -> Oddities {
        let mut oddities = Oddities::default();
        let positions = &mut batch.positions[start..];
        let (mut least, mut most) = extent(positions);
        if let Some((low, high)) = self.bounds
            && (0..3).any(|a| least[a] < low[a] || most[a] > high[a])
        {
            let outside = |p: &&[i32; 3]| (0..3).any(|a| p[a] < low[a] || p[a] > high[a]);
            oddities.outside_bounds = positions.iter().filter(outside).count() as u64;
        }
        if self.placement != Placement::IDENTITY {
            oddities.beyond_grid = self.placement.apply(positions);
            (least, most) = extent(positions);
        }

        let stats = &mut batch.stats;
        stats.z_min = stats.z_min.min(least[2]);
        stats.z_max = stats.z_max.max(most[2]);
        let colors = &batch.colors[start..];
        let largest = largest(colors);
        stats.rgb_max = stats.rgb_max.max(largest[0]).max(largest[1]).max(largest[2]);
        stats.intensity_max = stats.intensity_max.max(largest[3]);
        // Counted by the number in the file: the samples do not depend on where batches begin.
        let to_next = (INTENSITY_EVERY - index as usize % INTENSITY_EVERY) % INTENSITY_EVERY;
        for color in colors.iter().skip(to_next).step_by(INTENSITY_EVERY) {
            stats.intensity[intensity_bin(color[3])] += 1;
        }
        oddities
    }
}

/// Smallest and largest coordinate per axis. Four points at a time, in as many lanes: the compiler
/// makes vector instructions of that, which it does not of a loop over points (three times as slow).
fn extent(positions: &[[i32; 3]]) -> ([i32; 3], [i32; 3]) {
    let (mut least, mut most) = ([i32::MAX; 12], [i32::MIN; 12]);
    let (fours, rest) = positions.as_flattened().as_chunks::<12>();
    for four in fours {
        for lane in 0..12 {
            least[lane] = least[lane].min(four[lane]);
            most[lane] = most[lane].max(four[lane]);
        }
    }
    for (lane, &value) in rest.iter().enumerate() {
        least[lane] = least[lane].min(value);
        most[lane] = most[lane].max(value);
    }
    let over = |lanes: &[i32; 12], pick: fn(i32, i32) -> i32| -> [i32; 3] {
        std::array::from_fn(|a| (1..4).fold(lanes[a], |m, i| pick(m, lanes[a + 3 * i])))
    };
    (over(&least, i32::min), over(&most, i32::max))
}

/// Largest value per channel, in lanes like [`extent`].
fn largest(colors: &[[u16; 4]]) -> [u16; 4] {
    let mut most = [0; 32];
    let (eights, rest) = colors.as_flattened().as_chunks::<32>();
    for eight in eights {
        for lane in 0..32 {
            most[lane] = eight[lane].max(most[lane]);
        }
    }
    for (lane, &value) in rest.iter().enumerate() {
        most[lane] = value.max(most[lane]);
    }
    std::array::from_fn(|c| (0..8).fold(0, |m, i| m.max(most[c + 4 * i])))
}

/// The first `H` bytes of each record.
fn heads<const H: usize>(bytes: &[u8], record_length: usize) -> impl ExactSizeIterator<Item = &[u8; H]> + Clone {
    debug_assert!(record_length >= H);
    bytes.chunks_exact(record_length).map(|r| r.first_chunk().expect("a record is at least as long as its format"))
}

/// Appends position and colour columns; `RGB` is the byte offset of red, 0 if there is none.
fn columns<'a, const H: usize, const RGB: usize>(
    records: impl ExactSizeIterator<Item = &'a [u8; H]> + Clone,
    batch: &mut PointBatch,
) {
    batch.positions.extend(records.clone().map(|r| [i32_at(r, 0), i32_at(r, 4), i32_at(r, 8)]));
    batch.colors.extend(records.map(|r| {
        if RGB == 0 {
            [0, 0, 0, u16_at(r, 12)]
        } else {
            [u16_at(r, RGB), u16_at(r, RGB + 2), u16_at(r, RGB + 4), u16_at(r, 12)]
        }
    }));
}

#[cfg(test)]
mod tests {
    use super::{
        super::header::{RECORD_LENGTHS, rgb_at},
        *,
    };

    fn reader(record_length: usize, rgb_at: Option<usize>) -> RecordReader {
        let bounds = Some(([0, 0, 0], [100, 100, 100]));
        RecordReader {
            record_length,
            rgb_at,
            placement: Placement::IDENTITY,
            bounds,
            first_record: 1000,
            fields: Fields::COLORS,
        }
    }

    /// Records whose every field says which record it is.
    fn records(count: u16, length: usize, rgb: Option<usize>) -> Vec<u8> {
        let mut bytes = vec![0xee; usize::from(count) * length];
        for (i, record) in (0..count).zip(bytes.chunks_exact_mut(length)) {
            for axis in 0..3 {
                record[4 * axis..][..4].copy_from_slice(&(i32::from(i) + axis as i32).to_le_bytes());
            }
            record[12..14].copy_from_slice(&(i + 7).to_le_bytes());
            for channel in 0..3 {
                if let Some(at) = rgb {
                    record[at + 2 * channel..][..2].copy_from_slice(&(i + 10 * channel as u16).to_le_bytes());
                }
            }
        }
        bytes
    }

    #[test]
    fn every_format_with_and_without_extra_bytes_gives_the_same_columns() {
        for format in 0..=10u8 {
            for extra in [0, 1, 5, 192] {
                let length = usize::from(RECORD_LENGTHS[usize::from(format)]) + extra;
                let rgb = rgb_at(format);
                let mut batch = PointBatch::default();
                let reader = reader(length, rgb);
                let bytes = records(50, length, rgb);
                let odd = reader.append(&bytes[..20 * length], 0, &mut batch);
                assert_eq!(odd, Oddities::default());
                reader.append(&bytes[20 * length..], 20, &mut batch);
                for i in 0..50u16 {
                    let p = i32::from(i);
                    assert_eq!(batch.positions[usize::from(i)], [p, p + 1, p + 2], "format {format} + {extra}");
                    let rgb = if rgb.is_some() { [i, i + 10, i + 20] } else { [0; 3] };
                    assert_eq!(batch.colors[usize::from(i)], [rgb[0], rgb[1], rgb[2], i + 7]);
                    assert_eq!(batch.records[usize::from(i)], 1000 + u32::from(i));
                }
                let stats = &batch.stats;
                assert_eq!((stats.z_min, stats.z_max, stats.intensity_max), (2, 51, 56));
                assert_eq!(stats.rgb_max, if rgb.is_some() { 69 } else { 0 });
                // Points 0, 16, 32, 48, although the batch was filled in two runs.
                assert_eq!(stats.intensity.iter().sum::<u32>(), 4);
                assert_eq!(stats.intensity[intensity_bin(16 + 7)], 1);
            }
        }
    }

    #[test]
    fn lanes_give_what_a_plain_loop_gives() {
        let mut x = 1u32;
        let mut next = || {
            x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            x
        };
        for n in (0..40).chain([255, 256, 257]) {
            let positions: Vec<[i32; 3]> = (0..n).map(|_| [next() as i32, next() as i32, next() as i32]).collect();
            let colors: Vec<[u16; 4]> = (0..n).map(|_| [0; 4].map(|_: u16| (next() >> 16) as u16)).collect();
            let (least, most) = extent(&positions);
            for a in 0..3 {
                assert_eq!(least[a], positions.iter().map(|p| p[a]).min().unwrap_or(i32::MAX), "{n} points");
                assert_eq!(most[a], positions.iter().map(|p| p[a]).max().unwrap_or(i32::MIN), "{n} points");
            }
            for c in 0..4 {
                assert_eq!(largest(&colors)[c], colors.iter().map(|v| v[c]).max().unwrap_or(0), "{n} points");
            }
        }
    }

    #[test]
    fn points_outside_the_box_are_counted_and_kept() {
        let mut batch = PointBatch::default();
        let odd = reader(20, None).append(&records(102, 20, None), 0, &mut batch);
        assert_eq!(batch.len(), 102);
        assert_eq!(odd.outside_bounds, 3, "z of points 99, 100 and 101 is above 100");
    }
}
