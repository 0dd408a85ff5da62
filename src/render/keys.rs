//! A batch's values as the keys of a column.

use super::{column::Keys, scale::key_of, wide::WideKeys};
use crate::scene::{Attribute, FileFacts, Grid, PointBatch, Scaled};

/// Keys of a batch, one per point; the memory is used again.
#[derive(Debug, Default)]
pub struct KeyBuffer {
    small: Vec<u32>,
    wide: Vec<u64>,
}

impl KeyBuffer {
    /// The keys of an attribute; `None` if no point of the batch has any: its file does not have the attribute, or it
    /// was not read.
    pub fn fill(
        &mut self,
        attribute: &Attribute,
        batch: &PointBatch,
        file: &FileFacts,
        grid: &Grid,
        wide: &WideKeys,
    ) -> Option<Keys<'_>> {
        let a = &batch.attributes;
        match attribute {
            Attribute::Intensity => self.small(batch.colors.iter().map(|c| c[3].into())),
            Attribute::Classification => self.small(a.classification.iter().map(|&v| v.into())),
            Attribute::ReturnNumber => self.small(a.returns.iter().map(|&v| (v & 15).into())),
            Attribute::NumberOfReturns => self.small(a.returns.iter().map(|&v| (v >> 4).into())),
            Attribute::LastReturn => self.small(a.returns.iter().map(|&v| u32::from(v & 15 == v >> 4))),
            Attribute::PointSource => self.small(a.point_source.iter().map(|&v| v.into())),
            Attribute::UserData => self.small(a.user_data.iter().map(|&v| v.into())),
            Attribute::File => self.small(batch.records.iter().map(|_| batch.file)),
            Attribute::Elevation => self.wide(batch.positions.iter().map(|p| key_of(grid.world(*p)[2]))),
            Attribute::ScanAngle => {
                let degrees = Scaled::new(file.record.scan_angle_step, 0.0)?;
                self.wide(a.scan_angle.iter().map(|&v| key_of(degrees.nearest(v.into()))))
            }
            Attribute::GpsTime => self.wide(a.gps_time.iter().map(|&v| key_of(v))),
            Attribute::Extra(name) => {
                let key = wide.of_extra(file, name)?;
                let points = if a.extra.is_empty() { 0 } else { batch.len() };
                self.wide((0..points).map(|i| key(a.extra_of(i, file.record.extra_bytes))))
            }
        }
    }

    fn small(&mut self, values: impl Iterator<Item = u32>) -> Option<Keys<'_>> {
        self.small.clear();
        self.small.extend(values.map(|value| value + 1));
        (!self.small.is_empty()).then_some(Keys::Small(&self.small))
    }

    fn wide(&mut self, keys: impl Iterator<Item = u64>) -> Option<Keys<'_>> {
        self.wide.clear();
        self.wide.extend(keys);
        (!self.wide.is_empty()).then_some(Keys::Wide(&self.wide))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Attributes, ExtraDimension, ExtraKind, Number, RecordFacts, SceneFacts};

    fn file() -> FileFacts {
        let height = ExtraDimension {
            name: "height".into(),
            description: String::new(),
            at: 1,
            kind: ExtraKind::I16,
            elements: 1,
            no_data: Some(vec![Number::Signed(-1)]),
            min: None,
            max: None,
            scale: Some(vec![0.01]),
            offset: Some(vec![-3.0]),
        };
        let record = RecordFacts {
            format: 7,
            scan_angle_step: 0.006,
            extra_bytes: 3,
            extra_dimensions: vec![height],
            ..Default::default()
        };
        FileFacts { record, ..Default::default() }
    }

    fn batch() -> PointBatch {
        let n = 200u32;
        let attributes = Attributes {
            returns: (0..n).map(|i| i as u8).collect(),
            classification: (0..n).map(|i| i as u8).collect(),
            scan_angle: (0..n).map(|i| (i as i32 * 301 - 30_000) as i16).collect(),
            user_data: (0..n).map(|i| i as u8 ^ 0xff).collect(),
            point_source: (0..n).map(|i| (i * 329) as u16).collect(),
            gps_time: (0..n).map(|i| if i == 7 { f64::NAN } else { f64::from(i) * 0.1 - 5.0 }).collect(),
            extra: (0..n).flat_map(|i| [9, if i == 3 { 255 } else { i as u8 }, if i == 3 { 255 } else { 2 }]).collect(),
            ..Default::default()
        };
        PointBatch {
            file: 4,
            positions: (0..n as i32).map(|i| [0, 0, i * 1000 - 70_000]).collect(),
            colors: (0..n).map(|i| [0, 0, 0, (i * 300) as u16]).collect(),
            records: (0..n).collect(),
            attributes: Box::new(attributes),
            ..Default::default()
        }
    }

    #[test]
    fn keys_are_those_of_the_attributes_values() {
        let (file, batch) = (file(), batch());
        let grid = Grid { scale: [0.001; 3], origin: [0.0, 0.0, -12.5] };
        let scene = SceneFacts { grid, bounds: Default::default(), files: vec![file.clone()], warnings: Vec::new() };
        let value = |attribute: &Attribute, i: usize| {
            let a = &batch.attributes;
            Some(match attribute {
                Attribute::Intensity => batch.colors[i][3].into(),
                Attribute::Elevation => grid.world(batch.positions[i])[2],
                Attribute::Classification => a.classification[i].into(),
                Attribute::ReturnNumber => (a.returns[i] % 16).into(),
                Attribute::NumberOfReturns => (a.returns[i] / 16).into(),
                Attribute::LastReturn => u8::from(a.returns[i] % 16 == a.returns[i] / 16).into(),
                Attribute::PointSource => a.point_source[i].into(),
                Attribute::UserData => a.user_data[i].into(),
                Attribute::ScanAngle => f64::from(6 * i32::from(a.scan_angle[i])) / 1000.0,
                Attribute::GpsTime if i == 7 => return None,
                Attribute::GpsTime => a.gps_time[i],
                Attribute::File => 4.0,
                Attribute::Extra(_) if i == 3 => return None,
                Attribute::Extra(_) => f64::from(i as i32 + 512 - 300) / 100.0,
            })
        };
        let mut buffer = KeyBuffer::default();
        let extra = Attribute::Extra("height".into());
        for attribute in Attribute::NAMED.into_iter().map(|(_, a)| a).chain([extra]) {
            let wide = WideKeys::new(&attribute, &scene);
            let keys = buffer.fill(&attribute, &batch, &file, &grid, &wide).expect("values");
            assert_eq!(keys.len(), batch.len());
            for i in 0..batch.len() {
                let found = match keys {
                    Keys::Small(keys) => Some(f64::from(keys[i]) - 1.0),
                    Keys::Wide(keys) => wide.value(keys[i]),
                };
                assert_eq!(found, value(&attribute, i), "{attribute} of {i}");
                assert_eq!(attribute.is_small(), matches!(keys, Keys::Small(_)));
            }
        }
        let mut keys_of = |attribute: Attribute, batch: &PointBatch| {
            buffer.fill(&attribute, batch, &file, &grid, &WideKeys::new(&attribute, &scene)).is_some()
        };
        assert!(!keys_of(Attribute::Extra("width".into()), &batch));
        let empty = PointBatch { attributes: Box::default(), ..batch.clone() };
        for attribute in [Attribute::GpsTime, Attribute::Classification, Attribute::Extra("height".into())] {
            assert!(
                keys_of(attribute.clone(), &batch) && !keys_of(attribute.clone(), &empty),
                "{attribute} was not read"
            );
        }
    }
}
