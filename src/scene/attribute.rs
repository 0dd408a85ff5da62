//! The attributes by name: what points can be coloured and filtered by.

use std::{
    fmt::{self, Display, Formatter},
    str::FromStr,
};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{FileFacts, Grid, PointBatch};

/// One number per point: a field of its record, or what follows from it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Attribute {
    Intensity,
    /// The third world coordinate, in the file's unit.
    Elevation,
    /// ASPRS class.
    Classification,
    ReturnNumber,
    NumberOfReturns,
    PointSource,
    UserData,
    /// Degrees.
    ScanAngle,
    /// Seconds, of the week or "adjusted standard" (the header says which).
    GpsTime,
    /// Index of the file in [`SceneFacts::files`](super::SceneFacts::files).
    File,
    /// First element of the extra dimension of this name, scaled.
    Extra(String),
}

impl Attribute {
    /// All but the extra dimensions, as they are typed and listed.
    pub const NAMED: [(&'static str, Attribute); 10] = [
        ("intensity", Attribute::Intensity),
        ("elevation", Attribute::Elevation),
        ("classification", Attribute::Classification),
        ("return-number", Attribute::ReturnNumber),
        ("number-of-returns", Attribute::NumberOfReturns),
        ("point-source", Attribute::PointSource),
        ("user-data", Attribute::UserData),
        ("scan-angle", Attribute::ScanAngle),
        ("gps-time", Attribute::GpsTime),
        ("file", Attribute::File),
    ];

    /// What its numbers are names of: they are told apart, not compared.
    pub fn is_categorical(&self) -> bool {
        use Attribute::*;
        matches!(self, Classification | ReturnNumber | NumberOfReturns | PointSource | File)
    }

    /// True if every value is a whole number that 16 bits hold.
    pub fn is_small(&self) -> bool {
        self.is_categorical() || matches!(self, Attribute::Intensity | Attribute::UserData)
    }

    /// The value of point `i` of a batch, which is of `file`. `None` if the file does not have the attribute, if it
    /// was not read, if it is no number, or if the file marks it as no data.
    pub fn value(&self, batch: &PointBatch, i: usize, file: &FileFacts, grid: &Grid) -> Option<f64> {
        let a = &batch.attributes;
        match self {
            Attribute::Intensity => batch.colors.get(i).map(|c| c[3].into()),
            Attribute::Elevation => batch.positions.get(i).map(|p| grid.world(*p)[2]),
            Attribute::Classification => a.classification.get(i).map(|&v| v.into()),
            Attribute::ReturnNumber => a.returns.get(i).map(|&v| (v & 15).into()),
            Attribute::NumberOfReturns => a.returns.get(i).map(|&v| (v >> 4).into()),
            Attribute::PointSource => a.point_source.get(i).map(|&v| v.into()),
            Attribute::UserData => a.user_data.get(i).map(|&v| v.into()),
            Attribute::ScanAngle => a.scan_angle.get(i).map(|&v| f64::from(v) * file.record.scan_angle_step),
            Attribute::GpsTime => a.gps_time.get(i).copied().filter(|v| !v.is_nan()),
            Attribute::File => Some(batch.file.into()),
            Attribute::Extra(name) => {
                let dimension = file.record.extra_dimensions.iter().find(|d| d.name == *name)?;
                dimension.value(a.extra_of(i, file.record.extra_bytes)).filter(|v| !v.is_nan())
            }
        }
    }

    /// Whether points of this file can have it.
    pub fn is_in(&self, file: &FileFacts) -> bool {
        match self {
            // Formats 0 and 2 have no time; 4 is 1 with a wave packet.
            Attribute::GpsTime => !matches!(file.record.format, 0 | 2),
            Attribute::Extra(name) => file.record.extra_dimensions.iter().any(|d| d.name == *name),
            _ => true,
        }
    }
}

impl Display for Attribute {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Attribute::Extra(name) => write!(f, "extra:{name}"),
            named => {
                let name =
                    Attribute::NAMED.iter().find(|(_, attribute)| attribute == named).map_or("", |(name, _)| name);
                f.write_str(name)
            }
        }
    }
}

/// There is no attribute of this name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown attribute {0:?}: expected {names} or extra:NAME", names = Attribute::NAMED.map(|(name, _)| name).join(", "))]
pub struct UnknownAttribute(String);

impl FromStr for Attribute {
    type Err = UnknownAttribute;

    fn from_str(text: &str) -> Result<Attribute, UnknownAttribute> {
        if let Some(name) = text.strip_prefix("extra:").filter(|name| !name.is_empty()) {
            return Ok(Attribute::Extra(name.to_owned()));
        }
        let named = Attribute::NAMED.into_iter().find(|(name, _)| *name == text);
        named.map(|(_, attribute)| attribute).ok_or_else(|| UnknownAttribute(text.to_owned()))
    }
}

impl Serialize for Attribute {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Attribute {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Attribute, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for (name, attribute) in Attribute::NAMED {
            assert_eq!(attribute.to_string(), name);
            assert_eq!(name.parse(), Ok(attribute));
        }
        let extra = Attribute::Extra("Deviation: x".into());
        assert_eq!(extra.to_string().parse(), Ok(extra));
        for wrong in ["", "Intensity", "extra:", "colour"] {
            let message = wrong.parse::<Attribute>().unwrap_err().to_string();
            assert!(message.contains("number-of-returns, point-source") && message.contains("extra:NAME"), "{message}");
        }
    }
}
