//! The attributes by name: what points can be coloured and filtered by.

use std::{
    fmt::{self, Display, Formatter},
    str::FromStr,
};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::FileFacts;

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
    /// 1 if the return is the last of its pulse: if its number is the number of returns; else 0.
    LastReturn,
    PointSource,
    UserData,
    /// Degrees.
    ScanAngle,
    /// Seconds, of the week or "adjusted standard" (the header says which).
    GpsTime,
    /// Index of the file in [`SceneFacts::files`](super::SceneFacts::files).
    File,
    /// The extra dimension of this name, scaled; of several elements the first, or with `[1]` or `[2]` behind another.
    Extra(String),
}

impl Attribute {
    /// All but the extra dimensions, as they are typed and listed.
    pub const NAMED: [(&'static str, Attribute); 11] = [
        ("intensity", Attribute::Intensity),
        ("elevation", Attribute::Elevation),
        ("classification", Attribute::Classification),
        ("return-number", Attribute::ReturnNumber),
        ("number-of-returns", Attribute::NumberOfReturns),
        ("last-return", Attribute::LastReturn),
        ("point-source", Attribute::PointSource),
        ("user-data", Attribute::UserData),
        ("scan-angle", Attribute::ScanAngle),
        ("gps-time", Attribute::GpsTime),
        ("file", Attribute::File),
    ];

    /// Short names that are read as well.
    pub const SHORT: [(&'static str, Attribute); 6] = [
        ("class", Attribute::Classification),
        ("return", Attribute::ReturnNumber),
        ("returns", Attribute::NumberOfReturns),
        ("source", Attribute::PointSource),
        ("time", Attribute::GpsTime),
        ("z", Attribute::Elevation),
    ];

    /// What its numbers are names of: they are told apart, not compared.
    pub fn is_categorical(&self) -> bool {
        use Attribute::*;
        matches!(self, Classification | ReturnNumber | NumberOfReturns | LastReturn | PointSource | File)
    }

    /// True if every value is a whole number that 16 bits hold.
    pub fn is_small(&self) -> bool {
        self.is_categorical() || matches!(self, Attribute::Intensity | Attribute::UserData)
    }

    /// Least and largest value that a record can hold; `None` where that is any, or depends on the file.
    pub fn limits(&self) -> Option<[f64; 2]> {
        match self {
            Attribute::Classification | Attribute::UserData => Some([0.0, 255.0]),
            Attribute::ReturnNumber | Attribute::NumberOfReturns => Some([0.0, 15.0]),
            Attribute::LastReturn => Some([0.0, 1.0]),
            Attribute::Intensity | Attribute::PointSource => Some([0.0, 65_535.0]),
            // Steps of 0.006° in 16 bits; LAS allows no more than half a turn, but files have it.
            Attribute::ScanAngle => Some([-196.608, 196.602]),
            Attribute::Elevation | Attribute::GpsTime | Attribute::File | Attribute::Extra(_) => None,
        }
    }

    /// Whether points of this file can have it.
    pub fn is_in(&self, file: &FileFacts) -> bool {
        match self {
            // Formats 0 and 2 have no time; 4 is 1 with a wave packet.
            Attribute::GpsTime => !matches!(file.record.format, 0 | 2),
            Attribute::Extra(name) => file.record.extra(name).is_some(),
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
        let named = Attribute::NAMED.into_iter().chain(Attribute::SHORT).find(|(name, _)| *name == text);
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
        for (name, attribute) in Attribute::SHORT {
            assert_eq!(name.parse(), Ok(attribute));
        }
        let extra = Attribute::Extra("Deviation: x".into());
        assert_eq!(extra.to_string().parse(), Ok(extra));
        for wrong in ["", "Intensity", "extra:", "colour"] {
            let message = wrong.parse::<Attribute>().unwrap_err().to_string();
            assert!(
                message.contains("number-of-returns, last-return, point-source") && message.contains("extra:NAME"),
                "{message}"
            );
        }
    }
}
