//! From raw point records to the columns of a [`PointBatch`]: positions on the scene's grid, colours,
//! record numbers, and what they say of the file.

use super::{
    attributes::{self, heads},
    bytes::{i32_at, u16_at},
    fields::Fields,
    grid::Placement,
    layout::RecordLayout,
};
use crate::scene::{PointBatch, SAMPLED, intensity_bin, sample_of};

/// Records that go through all steps together, so that they and their columns stay in the first-level
/// cache (48 kB): 512 take 30 kB in format 7. Some 5 % faster than a batch at a time.
const BLOCK: usize = 512;

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
    /// Where the fields of a record are.
    pub layout: RecordLayout,
    /// Fields that are read; the colour columns hold zero for the others.
    pub fields: Fields,
    /// From the record's integers to the scene's grid.
    pub placement: Placement,
    /// The header's box in the record's integers, half a step wider; `None` if it makes no sense.
    pub bounds: Option<([i32; 3], [i32; 3])>,
    /// Record number, in the scene, of the file's first point.
    pub first_record: u32,
}

impl RecordReader {
    /// Appends whole records to a batch; `index` is the first one's number within the file.
    pub fn append(&self, bytes: &[u8], index: u32, batch: &mut PointBatch) -> Oddities {
        let mut oddities = Oddities::default();
        let before = batch.len();
        for block in bytes.chunks(BLOCK * self.layout.length) {
            let start = batch.len();
            self.columns(block, batch);
            attributes::append(block, &self.layout, &self.fields, &mut batch.attributes);
            let odd = self.finish(start, index + (start - before) as u32, batch);
            oddities.outside_bounds += odd.outside_bounds;
            oddities.beyond_grid += odd.beyond_grid;
        }
        let first = self.first_record + index;
        batch.records.extend(first..first + (batch.len() - before) as u32);
        oddities
    }

    /// Bytes of a batch's columns per point.
    pub fn bytes_per_point(&self) -> usize {
        let always = size_of::<[i32; 3]>() + size_of::<[u16; 4]>() + size_of::<u32>();
        always + attributes::bytes_per_point(&self.layout, &self.fields)
    }

    fn columns(&self, bytes: &[u8], batch: &mut PointBatch) {
        let rgb_at = self.layout.rgb_at.filter(|_| self.fields.rgb);
        // A field that is not wanted is not read: a layered decoder leaves anything there.
        let intensity = if self.fields.intensity { u16::MAX } else { 0 };
        // A record length known to the compiler is worth about a factor of two.
        match (self.layout.length, rgb_at) {
            (20, None) => columns::<20, 0>(bytes.as_chunks().0.iter(), intensity, batch),
            (28, None) => columns::<28, 0>(bytes.as_chunks().0.iter(), intensity, batch),
            (26, Some(20)) => columns::<26, 20>(bytes.as_chunks().0.iter(), intensity, batch),
            (34, Some(28)) => columns::<34, 28>(bytes.as_chunks().0.iter(), intensity, batch),
            (30, None) => columns::<30, 0>(bytes.as_chunks().0.iter(), intensity, batch),
            (36, Some(30)) => columns::<36, 30>(bytes.as_chunks().0.iter(), intensity, batch),
            (38, Some(30)) => columns::<38, 30>(bytes.as_chunks().0.iter(), intensity, batch),
            (_, None) => columns::<20, 0>(heads(bytes, &self.layout), intensity, batch),
            (_, Some(20)) => columns::<26, 20>(heads(bytes, &self.layout), intensity, batch),
            (_, Some(28)) => columns::<34, 28>(heads(bytes, &self.layout), intensity, batch),
            (_, Some(_)) => columns::<36, 30>(heads(bytes, &self.layout), intensity, batch),
        }
    }

    /// How many records there are before the first one outside of the header's box.
    pub fn inside_bounds(&self, bytes: &[u8]) -> usize {
        let records = bytes.len() / self.layout.length;
        let Some((low, high)) = self.bounds else { return records };
        let outside = |r: &[u8]| {
            (0..3).any(|a| {
                let i = i32_at(r, 4 * a);
                i < low[a] || i > high[a]
            })
        };
        bytes.chunks_exact(self.layout.length).position(outside).unwrap_or(records)
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
        let (smallest, largest) = channel_extent(colors);
        stats.rgb_max = stats.rgb_max.max(largest[0]).max(largest[1]).max(largest[2]);
        stats.intensity_max = stats.intensity_max.max(largest[3]);
        if !self.fields.intensity {
            return oddities;
        }
        stats.intensity_min = stats.intensity_min.min(smallest[3]);
        // Sampled by the number in the file: it does not matter where batches begin.
        for row in index / SAMPLED..(index + colors.len() as u32).div_ceil(SAMPLED) {
            if let Some(color) = sample_of(row).checked_sub(index).and_then(|at| colors.get(at as usize)) {
                stats.intensity[intensity_bin(color[3])] += 1;
            }
        }
        oddities
    }
}

/// Smallest and largest coordinate per axis.
fn extent(positions: &[[i32; 3]]) -> ([i32; 3], [i32; 3]) {
    let (fours, rest) = positions.as_chunks::<4>();
    let (mut low, mut high) = ([i32::MAX; 3], [i32::MIN; 3]);
    let mut widen = |least: &[i32; 3], most: &[i32; 3]| {
        for axis in 0..3 {
            low[axis] = low[axis].min(least[axis]);
            high[axis] = high[axis].max(most[axis]);
        }
    };
    // A preview's runs may have one record.
    if !fours.is_empty() {
        let (least, most) = extent_in_lanes(fours.as_flattened().as_flattened());
        least.as_chunks().0.iter().zip(most.as_chunks().0).for_each(|(least, most)| widen(least, most));
    }
    rest.iter().for_each(|position| widen(position, position));
    (low, high)
}

/// Four points at a time, in as many lanes: the compiler makes vector instructions of that. It must
/// stay a function of its own: together with its caller's last steps over the lanes, the compiler made
/// twelve scalars of them, which took three times as long (1.5 instead of 0.5 ns per point).
#[inline(never)]
fn extent_in_lanes(values: &[i32]) -> ([i32; 12], [i32; 12]) {
    let (mut least, mut most) = ([i32::MAX; 12], [i32::MIN; 12]);
    for four in values.as_chunks::<12>().0 {
        for lane in 0..12 {
            least[lane] = least[lane].min(four[lane]);
            most[lane] = most[lane].max(four[lane]);
        }
    }
    (least, most)
}

/// Smallest and largest value per channel.
fn channel_extent(colors: &[[u16; 4]]) -> ([u16; 4], [u16; 4]) {
    let (eights, rest) = colors.as_chunks::<8>();
    let (mut low, mut high) = ([u16::MAX; 4], [0; 4]);
    let mut widen = |least: &[u16; 4], most: &[u16; 4]| {
        for channel in 0..4 {
            low[channel] = low[channel].min(least[channel]);
            high[channel] = high[channel].max(most[channel]);
        }
    };
    if !eights.is_empty() {
        let (least, most) = channel_extent_in_lanes(eights.as_flattened().as_flattened());
        least.as_chunks().0.iter().zip(most.as_chunks().0).for_each(|(least, most)| widen(least, most));
    }
    rest.iter().for_each(|color| widen(color, color));
    (low, high)
}

/// Eight colours at a time; a function of its own like [`extent_in_lanes`].
#[inline(never)]
fn channel_extent_in_lanes(values: &[u16]) -> ([u16; 32], [u16; 32]) {
    let (mut least, mut most) = ([u16::MAX; 32], [0; 32]);
    for eight in values.as_chunks::<32>().0 {
        for lane in 0..32 {
            least[lane] = least[lane].min(eight[lane]);
            most[lane] = most[lane].max(eight[lane]);
        }
    }
    (least, most)
}

/// Appends position and colour columns; `RGB` is the byte offset of red, 0 if there is none.
fn columns<'a, const H: usize, const RGB: usize>(
    records: impl ExactSizeIterator<Item = &'a [u8; H]> + Clone,
    intensity_mask: u16,
    batch: &mut PointBatch,
) {
    batch.positions.extend(records.clone().map(|r| [i32_at(r, 0), i32_at(r, 4), i32_at(r, 8)]));
    batch.colors.extend(records.map(|r| {
        let intensity = u16_at(r, 12) & intensity_mask;
        if RGB == 0 {
            [0, 0, 0, intensity]
        } else {
            [u16_at(r, RGB), u16_at(r, RGB + 2), u16_at(r, RGB + 4), intensity]
        }
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::INTENSITY_BINS;

    fn reader(layout: RecordLayout, fields: Fields) -> RecordReader {
        let bounds = Some(([0, 0, 0], [100, 100, 100]));
        RecordReader { layout, fields, placement: Placement::IDENTITY, bounds, first_record: 1000 }
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
                let layout = RecordLayout::new(format, extra);
                let (length, rgb) = (layout.length, layout.rgb_at);
                let bytes = records(2050, length, rgb);
                let reader = reader(layout, Fields { classification: true, ..Fields::COLORS });
                let mut batch = PointBatch::default();
                // Runs of one record, of less than a block, and of several blocks.
                for run in [0..1, 1..2, 2..20, 20..2050] {
                    reader.append(&bytes[run.start * length..run.end * length], run.start as u32, &mut batch);
                }
                for i in 0..2050u16 {
                    let p = i32::from(i);
                    assert_eq!(batch.positions[usize::from(i)], [p, p + 1, p + 2], "format {format} + {extra}");
                    let rgb = if rgb.is_some() { [i, i + 10, i + 20] } else { [0; 3] };
                    assert_eq!(batch.colors[usize::from(i)], [rgb[0], rgb[1], rgb[2], i + 7]);
                    assert_eq!(batch.records[usize::from(i)], 1000 + u32::from(i));
                }
                assert_eq!(batch.attributes.classification.len(), 2050);
                assert_eq!(reader.bytes_per_point(), 12 + 8 + 4 + 1);
                let stats = &batch.stats;
                assert_eq!((stats.z_min, stats.z_max, stats.intensity_max), (2, 2051, 2056));
                assert_eq!(stats.rgb_max, if rgb.is_some() { 2069 } else { 0 });
                assert_eq!(stats.intensity_min, 7);
                // One of every sixteen, although the batch was filled in runs and blocks.
                let mut expected = [0; INTENSITY_BINS];
                for record in (0..=2050 / SAMPLED).map(sample_of).filter(|&record| record < 2050) {
                    expected[intensity_bin(record as u16 + 7)] += 1;
                }
                assert_eq!(*stats.intensity, expected);
            }
        }
    }

    #[test]
    fn a_colour_that_is_not_wanted_is_not_read() {
        for format in [2, 7] {
            let layout = RecordLayout::new(format, 0);
            let bytes = records(40, layout.length, layout.rgb_at);
            let read = |fields| {
                let mut batch = PointBatch::default();
                reader(layout, fields).append(&bytes, 0, &mut batch);
                (batch.colors[3], batch.stats)
            };
            let (color, stats) = read(Fields { rgb: true, ..Fields::NONE });
            assert_eq!((color, stats.rgb_max, stats.intensity_max), ([3, 13, 23, 0], 59, 0));
            assert_eq!((stats.intensity.iter().sum::<u32>(), stats.intensity_min), (0, u16::MAX));
            let (color, stats) = read(Fields { intensity: true, ..Fields::NONE });
            assert_eq!((color, stats.rgb_max, stats.intensity_max), ([0, 0, 0, 10], 0, 46));
            assert_eq!(read(Fields::NONE).0, [0; 4]);
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
            let (smallest, largest) = channel_extent(&colors);
            for a in 0..3 {
                assert_eq!(least[a], positions.iter().map(|p| p[a]).min().unwrap_or(i32::MAX), "{n} points");
                assert_eq!(most[a], positions.iter().map(|p| p[a]).max().unwrap_or(i32::MIN), "{n} points");
            }
            for c in 0..4 {
                assert_eq!(smallest[c], colors.iter().map(|v| v[c]).min().unwrap_or(u16::MAX), "{n} points");
                assert_eq!(largest[c], colors.iter().map(|v| v[c]).max().unwrap_or(0), "{n} points");
            }
        }
    }

    #[test]
    fn points_outside_the_box_are_counted_and_kept() {
        let mut batch = PointBatch::default();
        let odd = reader(RecordLayout::new(0, 0), Fields::COLORS).append(&records(102, 20, None), 0, &mut batch);
        assert_eq!(batch.len(), 102);
        assert_eq!(odd.outside_bounds, 3, "z of points 99, 100 and 101 is above 100");
    }
}
