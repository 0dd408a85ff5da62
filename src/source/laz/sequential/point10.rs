//! The point item of formats 0 to 5 (`Point10`, 20 bytes): version 2 with contexts by return number,
//! and the older version 1.

use super::{
    super::{
        coder::Coder,
        integer::IntegerDecoder,
        median::StreamingMedian,
        model::{LazyModels, Model},
    },
    Field,
};

/// The 20 bytes of a `Point10`.
#[derive(Debug, Clone, Copy, Default)]
struct Point {
    x: i32,
    y: i32,
    z: i32,
    intensity: u16,
    /// Return number (3 bits), number of returns (3), scan direction, edge of flight line.
    returns: u8,
    classification: u8,
    scan_angle: u8,
    user_data: u8,
    source: u16,
}

impl Point {
    fn read(record: &[u8; 20]) -> Point {
        let [x, y, z] = [0, 4, 8].map(|i| i32::from_le_bytes([record[i], record[i + 1], record[i + 2], record[i + 3]]));
        Point {
            x,
            y,
            z,
            intensity: u16::from_le_bytes([record[12], record[13]]),
            returns: record[14],
            classification: record[15],
            scan_angle: record[16],
            user_data: record[17],
            source: u16::from_le_bytes([record[18], record[19]]),
        }
    }

    #[inline]
    fn write(&self, record: &mut [u8; 20]) {
        record[0..4].copy_from_slice(&self.x.to_le_bytes());
        record[4..8].copy_from_slice(&self.y.to_le_bytes());
        record[8..12].copy_from_slice(&self.z.to_le_bytes());
        record[12..14].copy_from_slice(&self.intensity.to_le_bytes());
        record[14..18].copy_from_slice(&[self.returns, self.classification, self.scan_angle, self.user_data]);
        record[18..20].copy_from_slice(&self.source.to_le_bytes());
    }
}

/// Most bytes that a point can take, in either version: four symbols and six integers.
pub(super) const MOST_BYTES: usize = 4 * super::SYMBOL_BYTES + 6 * super::INTEGER_BYTES;

/// Contexts by number of returns and return number. Files that number from 0, or mix up the two, get
/// contexts, too.
const RETURN_MAP: [[u8; 8]; 8] = [
    [15, 14, 13, 12, 11, 10, 9, 8],
    [14, 0, 1, 3, 6, 10, 10, 9],
    [13, 1, 2, 4, 7, 11, 11, 10],
    [12, 3, 4, 5, 8, 12, 12, 11],
    [11, 6, 7, 8, 9, 13, 13, 12],
    [10, 10, 11, 12, 13, 14, 14, 13],
    [9, 10, 11, 12, 13, 14, 15, 14],
    [8, 9, 10, 11, 12, 13, 14, 15],
];

/// Version 2.
#[derive(Debug)]
pub(super) struct Point10 {
    last: Point,
    /// By return context: intensity, and the last differences in x and y.
    intensities: [u16; 16],
    x_differences: [StreamingMedian; 16],
    y_differences: [StreamingMedian; 16],
    /// By level: number of returns less return number.
    heights: [i32; 8],
    changed: Model,
    intensity: IntegerDecoder,
    returns: LazyModels,
    classification: LazyModels,
    scan_angle: LazyModels,
    user_data: LazyModels,
    source: IntegerDecoder,
    dx: IntegerDecoder,
    dy: IntegerDecoder,
    z: IntegerDecoder,
}

impl Point10 {
    pub(super) fn new() -> Point10 {
        Point10 {
            last: Point::default(),
            intensities: [0; 16],
            x_differences: [StreamingMedian::NEW; 16],
            y_differences: [StreamingMedian::NEW; 16],
            heights: [0; 8],
            changed: Model::new(64),
            intensity: IntegerDecoder::new(16, 4),
            returns: LazyModels::new(256, 256),
            classification: LazyModels::new(256, 256),
            scan_angle: LazyModels::new(2, 256),
            user_data: LazyModels::new(256, 256),
            source: IntegerDecoder::new(16, 1),
            dx: IntegerDecoder::new(32, 2),
            dy: IntegerDecoder::new(32, 22),
            z: IntegerDecoder::new(32, 20),
        }
    }
}

impl Field<20> for Point10 {
    fn first(&mut self, record: &[u8; 20]) {
        self.last = Point { intensity: 0, ..Point::read(record) };
    }

    #[inline]
    fn next(&mut self, coder: &mut Coder, bytes: &[u8], record: &mut [u8; 20]) {
        let last = &mut self.last;
        let changed = coder.symbol(bytes, &mut self.changed);
        if changed & 32 != 0 {
            last.returns = coder.symbol(bytes, self.returns.get(last.returns.into())) as u8;
        }
        let (r, n) = (last.returns & 7, last.returns >> 3 & 7);
        let m = usize::from(RETURN_MAP[usize::from(n)][usize::from(r)] & 15);
        if changed != 0 {
            if changed & 16 != 0 {
                let pred = i32::from(self.intensities[m]);
                self.intensities[m] = self.intensity.decode(coder, bytes, pred, m.min(3) as u32) as u16;
            }
            last.intensity = self.intensities[m];
            if changed & 8 != 0 {
                last.classification = coder.symbol(bytes, self.classification.get(last.classification.into())) as u8;
            }
            if changed & 4 != 0 {
                let difference = coder.symbol(bytes, self.scan_angle.get((last.returns >> 6 & 1).into()));
                last.scan_angle = last.scan_angle.wrapping_add(difference as u8);
            }
            if changed & 2 != 0 {
                last.user_data = coder.symbol(bytes, self.user_data.get(last.user_data.into())) as u8;
            }
            if changed & 1 != 0 {
                last.source = self.source.decode(coder, bytes, last.source.into(), 0) as u16;
            }
        }
        let single = u32::from(n == 1);
        let median = &mut self.x_differences[m];
        let difference = self.dx.decode(coder, bytes, median.get(), single);
        last.x = last.x.wrapping_add(difference);
        median.add(difference);

        let median = &mut self.y_differences[m];
        let k = self.dx.k();
        let difference = self.dy.decode(coder, bytes, median.get(), single + (k & !1).min(20));
        last.y = last.y.wrapping_add(difference);
        median.add(difference);

        let k = (k + self.dy.k()) / 2;
        let height = &mut self.heights[usize::from(n.abs_diff(r))];
        last.z = self.z.decode(coder, bytes, *height, single + (k & !1).min(18));
        *height = last.z;
        last.write(record);
    }

    fn memory_bytes(&self) -> usize {
        let lazy = [&self.returns, &self.classification, &self.scan_angle, &self.user_data];
        let integers = [&self.intensity, &self.source, &self.dx, &self.dy, &self.z];
        self.changed.memory_bytes()
            + lazy.iter().map(|m| m.memory_bytes()).sum::<usize>()
            + integers.iter().map(|i| i.memory_bytes()).sum::<usize>()
    }
}

/// Version 1.
#[derive(Debug)]
pub(super) struct OldPoint10 {
    last: Point,
    x_differences: [i32; 3],
    y_differences: [i32; 3],
    /// Which of the three differences is the oldest.
    oldest: usize,
    changed: Model,
    intensity: IntegerDecoder,
    returns: LazyModels,
    classification: LazyModels,
    scan_angle: IntegerDecoder,
    user_data: LazyModels,
    source: IntegerDecoder,
    dx: IntegerDecoder,
    dy: IntegerDecoder,
    z: IntegerDecoder,
}

impl OldPoint10 {
    pub(super) fn new() -> OldPoint10 {
        OldPoint10 {
            last: Point::default(),
            x_differences: [0; 3],
            y_differences: [0; 3],
            oldest: 0,
            changed: Model::new(64),
            intensity: IntegerDecoder::new(16, 1),
            returns: LazyModels::new(256, 256),
            classification: LazyModels::new(256, 256),
            scan_angle: IntegerDecoder::new(8, 2),
            user_data: LazyModels::new(256, 256),
            source: IntegerDecoder::new(16, 1),
            dx: IntegerDecoder::new(32, 1),
            dy: IntegerDecoder::new(32, 20),
            z: IntegerDecoder::new(32, 20),
        }
    }
}

impl Field<20> for OldPoint10 {
    fn first(&mut self, record: &[u8; 20]) {
        self.last = Point::read(record);
    }

    fn next(&mut self, coder: &mut Coder, bytes: &[u8], record: &mut [u8; 20]) {
        let last = &mut self.last;
        let x_difference = self.dx.decode(coder, bytes, median(self.x_differences), 0);
        last.x = last.x.wrapping_add(x_difference);
        let k = self.dx.k();
        let y_difference = self.dy.decode(coder, bytes, median(self.y_differences), k.min(19));
        last.y = last.y.wrapping_add(y_difference);
        let k = (k + self.dy.k()) / 2;
        last.z = self.z.decode(coder, bytes, last.z, k.min(19));

        // Version 2 has the first two of these swapped.
        let changed = coder.symbol(bytes, &mut self.changed);
        if changed & 32 != 0 {
            last.intensity = self.intensity.decode(coder, bytes, last.intensity.into(), 0) as u16;
        }
        if changed & 16 != 0 {
            last.returns = coder.symbol(bytes, self.returns.get(last.returns.into())) as u8;
        }
        if changed & 8 != 0 {
            last.classification = coder.symbol(bytes, self.classification.get(last.classification.into())) as u8;
        }
        if changed & 4 != 0 {
            let pred = i32::from(last.scan_angle as i8);
            last.scan_angle = self.scan_angle.decode(coder, bytes, pred, u32::from(k < 3)) as u8;
        }
        if changed & 2 != 0 {
            last.user_data = coder.symbol(bytes, self.user_data.get(last.user_data.into())) as u8;
        }
        if changed & 1 != 0 {
            last.source = self.source.decode(coder, bytes, last.source.into(), 0) as u16;
        }
        self.x_differences[self.oldest] = x_difference;
        self.y_differences[self.oldest] = y_difference;
        self.oldest = (self.oldest + 1) % 3;
        last.write(record);
    }

    fn memory_bytes(&self) -> usize {
        let lazy = [&self.returns, &self.classification, &self.user_data];
        let integers = [&self.intensity, &self.scan_angle, &self.source, &self.dx, &self.dy, &self.z];
        self.changed.memory_bytes()
            + lazy.iter().map(|m| m.memory_bytes()).sum::<usize>()
            + integers.iter().map(|i| i.memory_bytes()).sum::<usize>()
    }
}

fn median([a, b, c]: [i32; 3]) -> i32 {
    a.min(b).max(a.max(b).min(c))
}
