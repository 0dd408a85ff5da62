//! What points are coloured by, by name.

use std::{
    fmt::{self, Display, Formatter},
    str::FromStr,
};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::scene::{Attribute, FileFacts};

/// What decides the colour of a point.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub enum ColorBy {
    /// File by file: RGB if it has any, else intensity, else elevation.
    #[default]
    Auto,
    Rgb,
    Attribute(Attribute),
}

impl ColorBy {
    /// What [`ColorBy::from_str`] takes, but for the extra dimensions.
    pub fn names() -> Vec<&'static str> {
        ["auto", "rgb"].into_iter().chain(Attribute::NAMED.map(|(name, _)| name)).collect()
    }

    /// The attribute, if it is one.
    pub fn attribute(&self) -> Option<&Attribute> {
        match self {
            ColorBy::Attribute(attribute) => Some(attribute),
            ColorBy::Auto | ColorBy::Rgb => None,
        }
    }

    /// Whether points of this file can have it.
    pub fn is_in(&self, file: &FileFacts) -> bool {
        match self {
            ColorBy::Auto => true,
            ColorBy::Rgb => matches!(file.record.format, 2 | 3 | 5 | 7 | 8 | 10),
            ColorBy::Attribute(attribute) => attribute.is_in(file),
        }
    }
}

impl From<Attribute> for ColorBy {
    fn from(attribute: Attribute) -> ColorBy {
        ColorBy::Attribute(attribute)
    }
}

impl Display for ColorBy {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            ColorBy::Auto => f.write_str("auto"),
            ColorBy::Rgb => f.write_str("rgb"),
            ColorBy::Attribute(attribute) => attribute.fmt(f),
        }
    }
}

/// Nothing of this name to colour by.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected {names} or extra:NAME, found `{0}`", names = ColorBy::names().join(", "))]
pub struct UnknownColor(String);

impl FromStr for ColorBy {
    type Err = UnknownColor;

    fn from_str(text: &str) -> Result<ColorBy, UnknownColor> {
        match text {
            "auto" => Ok(ColorBy::Auto),
            "rgb" => Ok(ColorBy::Rgb),
            _ => text.parse().map(ColorBy::Attribute).map_err(|_| UnknownColor(text.to_owned())),
        }
    }
}

impl Serialize for ColorBy {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for ColorBy {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<ColorBy, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        let named = Attribute::NAMED.map(|(_, attribute)| ColorBy::Attribute(attribute));
        let extra = ColorBy::Attribute(Attribute::Extra("Deviation".into()));
        for by in [ColorBy::Auto, ColorBy::Rgb, extra].into_iter().chain(named) {
            assert_eq!(by.to_string().parse(), Ok(by.clone()));
            let json = serde_json::to_string(&by).unwrap();
            assert_eq!(serde_json::from_str::<ColorBy>(&json).unwrap(), by);
        }
        let message = "colour".parse::<ColorBy>().unwrap_err().to_string();
        assert!(
            message.starts_with("expected auto, rgb, intensity, ") && message.ends_with("found `colour`"),
            "{message}"
        );
    }
}
