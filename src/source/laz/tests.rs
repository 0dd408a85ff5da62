//! The coder, the models and the integers against the `laz` crate's, over random streams.

use std::io::Cursor;

use laz::{
    compressors::IntegerCompressorBuilder,
    decoders::ArithmeticDecoder,
    decompressors::IntegerDecompressorBuilder,
    encoders::ArithmeticEncoder,
    models::{ArithmeticBitModel, ArithmeticModelBuilder},
};

use super::{
    coder::Coder,
    integer::IntegerDecoder,
    model::{BitModel, LazyModels, Model},
};

/// xorshift: the same numbers everywhere.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 20) % u64::from(n)) as u32
    }

    /// Mostly small: what models are good for.
    fn skewed(&mut self, n: u32) -> u32 {
        let most = 1 + self.below(n);
        self.below(most)
    }
}

/// One thing in a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Item {
    /// A model's number, and the symbol.
    Symbol(usize, u32),
    Bit(u32),
    /// How many bits, and the bits.
    Bits(u32, u32),
    Int(u32),
    Int64(u64),
}

const SIZES: [u32; 19] = [2, 3, 6, 9, 15, 16, 17, 31, 32, 33, 64, 128, 255, 256, 257, 512, 516, 2047, 2048];

fn items(random: &mut Random, count: usize) -> Vec<Item> {
    let item = |random: &mut Random| match random.below(20) {
        0 => Item::Bit(random.skewed(2)),
        1 => {
            // The encoder's own check overflows at 32.
            let count = 1 + random.below(31);
            Item::Bits(count, random.below(u32::MAX) & (u32::MAX >> (32 - count)))
        }
        2 if random.below(4) == 0 => Item::Int(random.below(u32::MAX)),
        3 if random.below(4) == 0 => Item::Int64(u64::from(random.below(u32::MAX)) << 32 | 7),
        _ => {
            let model = random.below(SIZES.len() as u32) as usize;
            // The last symbol alone gets what is left of the interval: it must come often.
            let symbol = random.skewed(SIZES[model]);
            Item::Symbol(model, if random.below(4) == 0 { SIZES[model] - 1 } else { symbol })
        }
    };
    (0..count).map(|_| item(random)).collect()
}

fn encoded(items: &[Item]) -> Vec<u8> {
    let mut models: Vec<_> =
        SIZES.iter().map(|&s| ArithmeticModelBuilder::new(s).with_compression(true).build()).collect();
    let mut bit = ArithmeticBitModel::new();
    let mut encoder = ArithmeticEncoder::new(Cursor::new(Vec::new()));
    for item in items {
        match *item {
            Item::Symbol(m, s) => encoder.encode_symbol(&mut models[m], s),
            Item::Bit(b) => encoder.encode_bit(&mut bit, b),
            Item::Bits(n, b) => encoder.write_bits(n, b),
            Item::Int(i) => encoder.write_int(i),
            Item::Int64(i) => encoder.write_int64(i),
        }
        .expect("memory");
    }
    encoder.done().expect("memory");
    encoder.into_inner().into_inner()
}

/// What is decoded from bytes when asked for things of these kinds; with the offsets after each.
fn decoded(bytes: &[u8], kinds: &[Item]) -> Vec<(Item, usize)> {
    let mut models: Vec<_> = SIZES.iter().map(|&s| Model::new(s)).collect();
    let mut bit = BitModel::default();
    let mut coder = Coder::start(bytes, 0);
    let mut one = |kind: &Item| {
        let item = match *kind {
            Item::Symbol(m, _) => Item::Symbol(m, coder.symbol(bytes, &mut models[m])),
            Item::Bit(_) => Item::Bit(coder.bit(bytes, &mut bit)),
            Item::Bits(n, _) => Item::Bits(n, coder.bits(bytes, n)),
            Item::Int(_) => Item::Int(coder.int(bytes)),
            Item::Int64(_) => Item::Int64(coder.int64(bytes)),
        };
        (item, coder.next())
    };
    kinds.iter().map(&mut one).collect()
}

/// The same from the `laz` crate, up to where its bytes end.
fn decoded_by_laz(bytes: &[u8], kinds: &[Item]) -> Vec<(Item, usize)> {
    let mut models: Vec<_> = SIZES.iter().map(|&s| ArithmeticModelBuilder::new(s).build()).collect();
    let mut bit = ArithmeticBitModel::new();
    let mut decoder = ArithmeticDecoder::new(Cursor::new(bytes));
    let mut out = Vec::new();
    if decoder.read_init_bytes().is_err() {
        return out;
    }
    for kind in kinds {
        let item = match *kind {
            Item::Symbol(m, _) => decoder.decode_symbol(&mut models[m]).map(|s| Item::Symbol(m, s)),
            Item::Bit(_) => decoder.decode_bit(&mut bit).map(Item::Bit),
            Item::Bits(n, _) => decoder.read_bits(n).map(|b| Item::Bits(n, b)),
            Item::Int(_) => decoder.read_int().map(Item::Int),
            Item::Int64(_) => decoder.read_int_64().map(Item::Int64),
        };
        let Ok(item) = item else { break };
        out.push((item, decoder.get_ref().position() as usize));
    }
    out
}

#[test]
fn what_was_encoded_is_decoded() {
    let mut random = Random(11);
    // The long one halves counts many times over, in models of every size but the two largest.
    for count in [0, 1, 2, 100, 5_000, 900_000] {
        let items = items(&mut random, count);
        let bytes = encoded(&items);
        let got = decoded(&bytes, &items);
        assert!(got.iter().map(|g| g.0).eq(items.iter().copied()), "{count} items");
        // All is read but what the encoder adds at the end, which the decoder has looked ahead by.
        let end = got.last().map_or(4, |g| g.1);
        assert!(end <= bytes.len() && bytes.len() - end <= 1, "{end} of {}", bytes.len());
    }
}

#[test]
fn the_largest_models_halve_their_counts_alike() {
    for size in [516, 2048] {
        let model = SIZES.iter().position(|&s| s == size).expect("a size");
        let mut random = Random(5);
        let items: Vec<_> = (0..150_000).map(|_| Item::Symbol(model, random.skewed(size))).collect();
        assert!(decoded(&encoded(&items), &items).iter().map(|g| g.0).eq(items.iter().copied()), "{size}");
    }
}

#[test]
fn a_wrong_byte_is_noticed() {
    let items = items(&mut Random(3), 2_000);
    let mut bytes = encoded(&items);
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    assert!(!decoded(&bytes, &items).iter().map(|g| g.0).eq(items.iter().copied()));
}

/// Bytes that nobody encoded: the same garbage, up to the end of the bytes.
#[test]
fn garbage_is_the_same_garbage() {
    let mut random = Random(17);
    for round in 0..200u32 {
        // Kinds that laz's decoder does not panic at in a debug build: it asserts that bits are few.
        let kinds: Vec<_> =
            items(&mut random, 3_000).into_iter().filter(|i| matches!(i, Item::Symbol(..) | Item::Bit(_))).collect();
        let length = random.below(1_500) as usize;
        let mut bytes: Vec<u8> = (0..length).map(|_| random.below(256) as u8).collect();
        // A first value that is no smaller than the interval is in no encoder's power.
        if bytes.starts_with(&[255, 255, 255, 255]) {
            bytes[0] = 0;
        }
        let theirs = decoded_by_laz(&bytes, &kinds);
        let ours = decoded(&bytes, &kinds);
        assert_eq!(ours[..theirs.len()], theirs, "round {round}");
        assert!(theirs.len() == kinds.len() || ours[theirs.len()].1 > bytes.len(), "round {round}: the end");
    }
}

#[test]
fn no_bytes_make_it_panic() {
    let mut random = Random(23);
    for round in 0..300usize {
        let kinds = items(&mut random, 2_000);
        let length = round % 40;
        let bytes: Vec<u8> = (0..length).map(|_| if round < 80 { 255 } else { random.below(256) as u8 }).collect();
        assert_eq!(decoded(&bytes, &kinds).len(), kinds.len());
    }
}

#[test]
fn integers_are_those_of_laz() {
    let mut random = Random(29);
    for bits in [8u32, 16, 32] {
        let range = (1u64 << bits) as i64;
        for spread in [1i64, 3, 200, 70_000, 1 << 33] {
            let value = |random: &mut Random| match bits {
                32 => random.below(u32::MAX) as i32,
                _ => random.below(1 << bits) as i32,
            };
            let all: Vec<(i32, i32, u32)> = (0..20_000)
                .map(|_| {
                    let pred = value(&mut random);
                    let off = i64::from(random.below(u32::MAX)) % (2 * spread.min(range)) - spread.min(range);
                    let real = i64::from(pred) + off;
                    let real = if bits == 32 { real as i32 } else { real.rem_euclid(range) as i32 };
                    (pred, real, random.skewed(5))
                })
                .collect();
            let mut encoder = ArithmeticEncoder::new(Cursor::new(Vec::new()));
            let mut compressor = IntegerCompressorBuilder::new().bits(bits).contexts(5).build_initialized();
            for &(pred, real, context) in &all {
                compressor.compress(&mut encoder, pred, real, context).expect("memory");
            }
            encoder.done().expect("memory");
            let bytes = encoder.into_inner().into_inner();

            let mut theirs = ArithmeticDecoder::new(Cursor::new(&bytes));
            theirs.read_init_bytes().expect("memory");
            let mut decompressor = IntegerDecompressorBuilder::new().bits(bits).contexts(5).build_initialized();
            let mut coder = Coder::start(&bytes, 0);
            let mut integers = IntegerDecoder::new(bits, 5);
            for (i, &(pred, real, context)) in all.iter().enumerate() {
                let their = decompressor.decompress(&mut theirs, pred, context).expect("enough bytes");
                let our = integers.decode(&mut coder, &bytes, pred, context);
                assert_eq!((our, integers.k()), (their, decompressor.k()), "{bits} bits, number {i}");
                assert_eq!(our, real, "{bits} bits, number {i}");
            }
        }
    }
}

#[test]
fn models_are_made_when_they_are_used() {
    let mut models = LazyModels::new(256, 256);
    let none = models.memory_bytes();
    let _ = models.get(7);
    let one = models.memory_bytes() - none;
    assert!((1_000..2_000).contains(&one), "{one} bytes");
    let _ = models.get(7);
    assert_eq!(models.memory_bytes(), none + one);
    let _ = models.get(1_000);
    assert_eq!(models.memory_bytes(), none + 2 * one);
}
