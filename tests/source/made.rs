//! Scans made by the tests themselves: small, of any format, LAS or LAZ.

use std::io::{Cursor, Write};

use las::{
    Version,
    raw::header::{Evlr, LargeFile},
};
use laz::{LasZipCompressor, LazVlr, LazVlrBuilder};

/// A small generator of numbers (xorshift), the same everywhere.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }
}

/// What to make.
#[derive(Clone, Copy)]
pub struct Scan {
    pub format: u8,
    pub points: u32,
    pub extra_bytes: u16,
    pub scale: f64,
    pub offset: f64,
    pub seed: u64,
}

/// How to write it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum As {
    Las,
    /// LAZ with chunks of so many points.
    Laz(u32),
    /// LAZ whose chunks have 1, 2, 3, … times so many points.
    LazVarying(u32),
}

impl Scan {
    pub fn new(format: u8, points: u32) -> Scan {
        Scan { format, points, extra_bytes: 0, scale: 0.01, offset: 0.0, seed: 1 }
    }

    pub fn record_length(&self) -> usize {
        [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67][usize::from(self.format)] + usize::from(self.extra_bytes)
    }

    /// Positions: a walk along scan lines within ±1,000,000.
    pub fn positions(&self) -> Vec<[i32; 3]> {
        let mut random = Random(self.seed * 77_777 + 13);
        let step = |i: u32| (i32::try_from(i).unwrap() * 37) % 1_000_000;
        let mut jitter = || random.below(50) as i32;
        (0..self.points).map(|i| [step(i) + jitter(), step(i / 100) + jitter(), jitter() * 10]).collect()
    }

    fn records(&self) -> Vec<u8> {
        let mut random = Random(self.seed * 99_991 + 7);
        let mut bytes = Vec::new();
        for position in self.positions() {
            let start = bytes.len();
            position.iter().for_each(|p| bytes.extend(p.to_le_bytes()));
            bytes.extend((random.below(3000) as u16).to_le_bytes());
            bytes.extend(if self.format < 6 { [0x09, 2] } else { [0x11, 0] });
            while bytes.len() < start + self.record_length() {
                bytes.push(random.below(9) as u8);
            }
        }
        bytes
    }

    /// The file's bytes.
    pub fn bytes(&self, how: As) -> Vec<u8> {
        let version = if self.format < 6 { Version::new(1, 2) } else { Version::new(1, 4) };
        let vlr = (how != As::Las).then(|| {
            let builder = LazVlrBuilder::default().with_point_format(self.format, self.extra_bytes).unwrap();
            match how {
                As::Laz(size) => builder.with_fixed_chunk_size(size).build(),
                _ => builder.with_variable_chunk_size().build(),
            }
        });
        let mut vlr_bytes = Vec::new();
        if let Some(vlr) = &vlr {
            vlr_bytes.extend([0, 0]);
            vlr_bytes.extend(LazVlr::USER_ID.as_bytes());
            vlr_bytes.resize(18, 0);
            vlr_bytes.extend(LazVlr::RECORD_ID.to_le_bytes());
            let mut body = Vec::new();
            vlr.write_to(&mut body).unwrap();
            vlr_bytes.extend((body.len() as u16).to_le_bytes());
            vlr_bytes.resize(54, 0);
            vlr_bytes.extend(body);
        }
        let (low, high) = (self.offset, self.offset + self.scale * 1_000_050.0);
        let header = las::raw::Header {
            version,
            header_size: version.header_size(),
            offset_to_point_data: u32::from(version.header_size()) + vlr_bytes.len() as u32,
            number_of_variable_length_records: u32::from(vlr.is_some()),
            point_data_record_format: self.format | if vlr.is_some() { 0x80 } else { 0 },
            point_data_record_length: self.record_length() as u16,
            number_of_point_records: self.points,
            x_scale_factor: self.scale,
            y_scale_factor: self.scale,
            z_scale_factor: self.scale,
            x_offset: self.offset,
            y_offset: self.offset,
            z_offset: self.offset,
            min_x: low,
            min_y: low,
            min_z: low,
            max_x: high,
            max_y: high,
            max_z: high,
            evlr: Some(Evlr::default()),
            large_file: (self.format >= 6).then(|| LargeFile {
                number_of_point_records: self.points.into(),
                number_of_points_by_return: [0; 15],
            }),
            ..Default::default()
        };
        let mut bytes = Vec::new();
        header.write_to(&mut bytes).unwrap();
        bytes.write_all(&vlr_bytes).unwrap();
        let records = self.records();
        let Some(vlr) = vlr else {
            bytes.extend(records);
            return bytes;
        };
        let mut cursor = Cursor::new(bytes);
        cursor.set_position(cursor.get_ref().len() as u64);
        let mut compressor = LasZipCompressor::new(&mut cursor, vlr).unwrap();
        let mut rest = records.as_slice();
        let mut size = 0;
        while !rest.is_empty() {
            let points = match how {
                As::LazVarying(step) => {
                    size += step as usize;
                    size
                }
                _ => usize::MAX,
            };
            let (now, later) = rest.split_at(rest.len().min(points.saturating_mul(self.record_length())));
            compressor.compress_many(now).unwrap();
            if points != usize::MAX && !later.is_empty() {
                compressor.finish_current_chunk().unwrap();
            }
            rest = later;
        }
        compressor.done().unwrap();
        drop(compressor);
        cursor.into_inner()
    }
}
