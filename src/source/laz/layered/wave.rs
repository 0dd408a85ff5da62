//! Wave packets: descriptor, offset and size of the waveform, return point, and direction.

use super::super::{coder::Coder, integer::IntegerDecoder};
use super::contexts::{Context, Contexts, Facts, Lazy, made, models_bytes};
use super::stream::{Field, Part};

/// Bytes of a packet in a record.
const PACKET_BYTES: usize = 29;

pub struct WavePacket {
    at: usize,
    contexts: Contexts<WaveModels, Packet>,
}

/// A packet; its floating-point numbers are coded as integers of the same bits.
#[derive(Clone, Copy)]
struct Packet {
    descriptor: u8,
    offset: u64,
    size: i32,
    return_point: i32,
    direction: [i32; 3],
}

impl Packet {
    fn from_bytes(b: &[u8]) -> Packet {
        let i32_at = |at: usize| i32::from_le_bytes([b[at], b[at + 1], b[at + 2], b[at + 3]]);
        Packet {
            descriptor: b[0],
            offset: u64::from_le_bytes([b[1], b[2], b[3], b[4], b[5], b[6], b[7], b[8]]),
            size: i32_at(9),
            return_point: i32_at(13),
            direction: [i32_at(17), i32_at(21), i32_at(25)],
        }
    }

    fn write(&self, b: &mut [u8]) {
        b[0] = self.descriptor;
        b[1..9].copy_from_slice(&self.offset.to_le_bytes());
        let values = [self.size, self.return_point, self.direction[0], self.direction[1], self.direction[2]];
        values.iter().zip(b[9..].chunks_exact_mut(4)).for_each(|(v, b)| b.copy_from_slice(&v.to_le_bytes()));
    }
}

struct WaveModels {
    difference: i32,
    /// How the last offset was coded: not, as the end of the last packet, as a difference, in full.
    how: u32,
    descriptor: Lazy,
    hows: [Lazy; 4],
    differences: IntegerDecoder,
    sizes: IntegerDecoder,
    return_points: IntegerDecoder,
    directions: IntegerDecoder,
}

impl Context<Packet> for WaveModels {
    fn start(_: &Packet) -> Self {
        WaveModels {
            difference: 0,
            how: 0,
            descriptor: None,
            hows: [const { None }; 4],
            differences: IntegerDecoder::new(32, 1),
            sizes: IntegerDecoder::new(32, 1),
            return_points: IntegerDecoder::new(32, 1),
            directions: IntegerDecoder::new(32, 3),
        }
    }

    fn memory_bytes(&self) -> usize {
        let integers = [&self.differences, &self.sizes, &self.return_points, &self.directions];
        models_bytes(self.hows.iter().chain([&self.descriptor]))
            + integers.iter().map(|i| i.memory_bytes()).sum::<usize>()
    }
}

impl WaveModels {
    fn next(&mut self, last: &Packet, coder: &mut Coder, bytes: &[u8]) -> Packet {
        let descriptor = coder.symbol(bytes, made(&mut self.descriptor, 256)) as u8;
        self.how = coder.symbol(bytes, made(&mut self.hows[self.how as usize & 3], 4));
        let offset = match self.how {
            0 => last.offset,
            1 => last.offset.wrapping_add(u64::from(last.size as u32)),
            2 => {
                self.difference = self.differences.decode(coder, bytes, self.difference, 0);
                last.offset.wrapping_add_signed(i64::from(self.difference))
            }
            _ => coder.int64(bytes),
        };
        let size = self.sizes.decode(coder, bytes, last.size, 0);
        let return_point = self.return_points.decode(coder, bytes, last.return_point, 0);
        let mut direction = last.direction;
        for (value, axis) in direction.iter_mut().zip(0..) {
            *value = self.directions.decode(coder, bytes, *value, axis);
        }
        Packet { descriptor, offset, size, return_point, direction }
    }
}

impl WavePacket {
    pub fn new(first: &[u8], channel: usize, at: usize) -> Self {
        WavePacket { at, contexts: Contexts::new(Packet::from_bytes(&first[at..at + PACKET_BYTES]), channel) }
    }
}

impl Part for WavePacket {
    /// Two symbols, an offset of 8 bytes, five integers.
    const MOST_BYTES: usize = 2 * 2 + 8 + 5 * (2 * 2 + 3);

    fn memory_bytes(&self) -> usize {
        self.contexts.memory_bytes()
    }
}

impl Field for WavePacket {
    #[inline(always)]
    fn step(&mut self, coder: &mut Coder, bytes: &[u8], facts: Facts, record: &mut [u8]) -> bool {
        let at = self.at;
        let (models, last) = self.contexts.enter(facts.item());
        *last = models.next(last, coder, bytes);
        last.write(&mut record[at..at + PACKET_BYTES]);
        true
    }
}
