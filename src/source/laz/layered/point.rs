//! The layers of the point itself behind the first: Z, classification, flags, intensity, scan angle,
//! user data and point source.

use super::super::{coder::Coder, integer::IntegerDecoder};
use super::contexts::{Context, Contexts, Facts, Lazy, made, models_bytes, put_i32, put_u16};
use super::stream::{Field, Part};

/// Bytes of an integer: two symbols, and raw bits beyond eight.
const INTEGER_32_BYTES: usize = 2 * 2 + 3;
const INTEGER_16_BYTES: usize = 2 * 2 + 1;

/// Z, predicted from the last point of the same return level.
pub struct Z(Contexts<ZContext, i32>);

struct ZContext {
    levels: [i32; 8],
    integers: IntegerDecoder,
}

impl Context<i32> for ZContext {
    fn start(last: &i32) -> Self {
        ZContext { levels: [*last; 8], integers: IntegerDecoder::new(32, 20) }
    }

    fn memory_bytes(&self) -> usize {
        self.integers.memory_bytes()
    }
}

impl Z {
    pub fn new(first: &[u8], channel: usize) -> Self {
        Z(Contexts::new(i32::from_le_bytes([first[8], first[9], first[10], first[11]]), channel))
    }
}

impl Part for Z {
    const MOST_BYTES: usize = INTEGER_32_BYTES;

    fn memory_bytes(&self) -> usize {
        self.0.memory_bytes()
    }
}

impl Field for Z {
    #[inline(always)]
    fn step(&mut self, coder: &mut Coder, bytes: &[u8], facts: Facts, record: &mut [u8]) -> bool {
        let (context, last) = self.0.enter(facts.point());
        let level = &mut context.levels[facts.level()];
        *last = context.integers.decode(coder, bytes, *level, facts.z_context().min(19));
        *level = *last;
        put_i32(record, 8, *last);
        true
    }
}

/// Classification, its model chosen by the last one.
pub struct Classification(Contexts<Models64, u8>);

/// Models of a byte, of which most are never used.
struct Models64([Lazy; 64]);

impl Context<u8> for Models64 {
    fn start(_: &u8) -> Self {
        Models64([const { None }; 64])
    }

    fn memory_bytes(&self) -> usize {
        models_bytes(&self.0)
    }
}

impl Classification {
    pub fn new(first: &[u8], channel: usize) -> Self {
        Classification(Contexts::new(first[16], channel))
    }
}

impl Part for Classification {
    const MOST_BYTES: usize = 2;

    fn memory_bytes(&self) -> usize {
        self.0.memory_bytes()
    }
}

impl Field for Classification {
    #[inline(always)]
    fn step(&mut self, coder: &mut Coder, bytes: &[u8], facts: Facts, record: &mut [u8]) -> bool {
        let (models, last) = self.0.enter(facts.point());
        let context = usize::from(*last & 31) << 1 | usize::from(facts.place() == 3);
        *last = coder.symbol(bytes, made(&mut models.0[context], 256)) as u8;
        record[16] = *last;
        true
    }
}

/// The four classification flags, scan direction and edge of flight line: as they are coded, six bits.
pub struct Flags(Contexts<Models64, u8>);

impl Flags {
    pub fn new(first: &[u8], channel: usize) -> Self {
        Flags(Contexts::new(first[15] & 15 | first[15] >> 2 & 0x30, channel))
    }
}

impl Part for Flags {
    const MOST_BYTES: usize = 2;

    fn memory_bytes(&self) -> usize {
        self.0.memory_bytes()
    }
}

impl Field for Flags {
    #[inline(always)]
    fn step(&mut self, coder: &mut Coder, bytes: &[u8], facts: Facts, record: &mut [u8]) -> bool {
        let (models, last) = self.0.enter(facts.point());
        *last = coder.symbol(bytes, made(&mut models.0[usize::from(*last & 63)], 64)) as u8;
        // Between them in the record is the scanner channel.
        record[15] = record[15] & 0x30 | *last & 15 | (*last & 0x30) << 2;
        true
    }
}

/// Intensity, predicted from the last point at the same place among its returns.
pub struct Intensity(Contexts<IntensityContext, u16>);

struct IntensityContext {
    places: [u16; 8],
    integers: IntegerDecoder,
}

impl Context<u16> for IntensityContext {
    fn start(last: &u16) -> Self {
        IntensityContext { places: [*last; 8], integers: IntegerDecoder::new(16, 4) }
    }

    fn memory_bytes(&self) -> usize {
        self.integers.memory_bytes()
    }
}

impl Intensity {
    pub fn new(first: &[u8], channel: usize) -> Self {
        Intensity(Contexts::new(u16::from_le_bytes([first[12], first[13]]), channel))
    }
}

impl Part for Intensity {
    const MOST_BYTES: usize = INTEGER_16_BYTES;

    fn memory_bytes(&self) -> usize {
        self.0.memory_bytes()
    }
}

impl Field for Intensity {
    #[inline(always)]
    fn step(&mut self, coder: &mut Coder, bytes: &[u8], facts: Facts, record: &mut [u8]) -> bool {
        let (context, last) = self.0.enter(facts.point());
        let place = &mut context.places[facts.place() << 1 | usize::from(facts.time_changed())];
        *last = context.integers.decode(coder, bytes, i32::from(*place), facts.place() as u32) as u16;
        *place = *last;
        put_u16(record, 12, *last);
        true
    }
}

/// Scan angle, coded where the first layer says that it changed.
pub struct ScanAngle(Contexts<Integers<2>, u16>);

/// Integers of 16 bits in `N` contexts.
struct Integers<const N: u32>(IntegerDecoder);

impl<const N: u32> Context<u16> for Integers<N> {
    fn start(_: &u16) -> Self {
        Integers(IntegerDecoder::new(16, N as usize))
    }

    fn memory_bytes(&self) -> usize {
        self.0.memory_bytes()
    }
}

impl ScanAngle {
    pub fn new(first: &[u8], channel: usize) -> Self {
        ScanAngle(Contexts::new(u16::from_le_bytes([first[18], first[19]]), channel))
    }
}

impl Part for ScanAngle {
    const MOST_BYTES: usize = INTEGER_16_BYTES;

    fn memory_bytes(&self) -> usize {
        self.0.memory_bytes()
    }
}

impl Field for ScanAngle {
    #[inline(always)]
    fn step(&mut self, coder: &mut Coder, bytes: &[u8], facts: Facts, record: &mut [u8]) -> bool {
        let (integers, last) = self.0.enter(facts.point());
        if facts.angle_changed() {
            // Signed: a prediction below zero is kept as such.
            let before = i32::from(*last as i16);
            *last = integers.0.decode(coder, bytes, before, u32::from(facts.time_changed())) as u16;
        }
        put_u16(record, 18, *last);
        true
    }
}

/// User data, its model chosen by the last one.
pub struct UserData(Contexts<Models64, u8>);

impl UserData {
    pub fn new(first: &[u8], channel: usize) -> Self {
        UserData(Contexts::new(first[17], channel))
    }
}

impl Part for UserData {
    const MOST_BYTES: usize = 2;

    fn memory_bytes(&self) -> usize {
        self.0.memory_bytes()
    }
}

impl Field for UserData {
    #[inline(always)]
    fn step(&mut self, coder: &mut Coder, bytes: &[u8], facts: Facts, record: &mut [u8]) -> bool {
        let (models, last) = self.0.enter(facts.point());
        *last = coder.symbol(bytes, made(&mut models.0[usize::from(*last / 4)], 256)) as u8;
        record[17] = *last;
        true
    }
}

/// Point source, coded where the first layer says that it changed.
pub struct PointSource(Contexts<Integers<1>, u16>);

impl PointSource {
    pub fn new(first: &[u8], channel: usize) -> Self {
        PointSource(Contexts::new(u16::from_le_bytes([first[20], first[21]]), channel))
    }
}

impl Part for PointSource {
    const MOST_BYTES: usize = INTEGER_16_BYTES;

    fn memory_bytes(&self) -> usize {
        self.0.memory_bytes()
    }
}

impl Field for PointSource {
    #[inline(always)]
    fn step(&mut self, coder: &mut Coder, bytes: &[u8], facts: Facts, record: &mut [u8]) -> bool {
        let (integers, last) = self.0.enter(facts.point());
        if facts.source_changed() {
            *last = integers.0.decode(coder, bytes, i32::from(*last), 0) as u16;
        }
        put_u16(record, 20, *last);
        true
    }
}
