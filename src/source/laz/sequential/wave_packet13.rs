//! Wave packets of formats 4 and 5 (`WavePacket13`, 29 bytes); versions 1 and 2 are the same.

use super::{
    super::{coder::Coder, integer::IntegerDecoder, model::Model},
    Field,
};

/// Most bytes that a wave packet can take.
pub(super) const MOST_BYTES: usize = 2 * super::SYMBOL_BYTES + 6 * super::INTEGER_BYTES + 8;

#[derive(Debug)]
pub(super) struct WavePacket13 {
    offset: u64,
    size: i32,
    return_point: i32,
    /// The vector x(t), y(t), z(t): bits of floats.
    xyz: [i32; 3],
    offset_difference: i32,
    /// How the offset was told last: unchanged, the last one's end, a difference, or in full.
    kind: u32,
    index: Model,
    kinds: [Model; 4],
    offset_differences: IntegerDecoder,
    sizes: IntegerDecoder,
    return_points: IntegerDecoder,
    xyzs: IntegerDecoder,
}

impl WavePacket13 {
    pub(super) fn new() -> WavePacket13 {
        WavePacket13 {
            offset: 0,
            size: 0,
            return_point: 0,
            xyz: [0; 3],
            offset_difference: 0,
            kind: 0,
            index: Model::new(256),
            kinds: std::array::from_fn(|_| Model::new(4)),
            offset_differences: IntegerDecoder::new(32, 1),
            sizes: IntegerDecoder::new(32, 1),
            return_points: IntegerDecoder::new(32, 1),
            xyzs: IntegerDecoder::new(32, 3),
        }
    }
}

fn i32_at(record: &[u8; 29], at: usize) -> i32 {
    i32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
}

impl Field<29> for WavePacket13 {
    fn first(&mut self, record: &[u8; 29]) {
        let [low, high] = [1, 5].map(|at| i32_at(record, at) as u32);
        self.offset = u64::from(high) << 32 | u64::from(low);
        self.size = i32_at(record, 9);
        self.return_point = i32_at(record, 13);
        self.xyz = [17, 21, 25].map(|at| i32_at(record, at));
    }

    fn next(&mut self, coder: &mut Coder, bytes: &[u8], record: &mut [u8; 29]) {
        record[0] = coder.symbol(bytes, &mut self.index) as u8;
        self.kind = coder.symbol(bytes, &mut self.kinds[self.kind as usize & 3]);
        match self.kind {
            0 => {}
            1 => self.offset = self.offset.wrapping_add(u64::from(self.size as u32)),
            2 => {
                self.offset_difference = self.offset_differences.decode(coder, bytes, self.offset_difference, 0);
                self.offset = self.offset.wrapping_add_signed(self.offset_difference.into());
            }
            _ => self.offset = coder.int64(bytes),
        }
        self.size = self.sizes.decode(coder, bytes, self.size, 0);
        self.return_point = self.return_points.decode(coder, bytes, self.return_point, 0);
        for (context, v) in self.xyz.iter_mut().enumerate() {
            *v = self.xyzs.decode(coder, bytes, *v, context as u32);
        }
        record[1..9].copy_from_slice(&self.offset.to_le_bytes());
        let integers = [self.size, self.return_point, self.xyz[0], self.xyz[1], self.xyz[2]];
        for (at, integer) in record[9..].chunks_exact_mut(4).zip(integers) {
            at.copy_from_slice(&integer.to_le_bytes());
        }
    }

    fn memory_bytes(&self) -> usize {
        let integers = [&self.offset_differences, &self.sizes, &self.return_points, &self.xyzs];
        self.index.memory_bytes()
            + self.kinds.iter().map(Model::memory_bytes).sum::<usize>()
            + integers.iter().map(|i| i.memory_bytes()).sum::<usize>()
    }
}
