//! Which points are shown: clauses over attributes, a clipping box and a slab. What they say becomes integer tests
//! ([`MaskRules`]), and these one bit per slot, which is all that the geometry passes look at.

mod clip;
mod ranges;
mod rules;
mod steps;

use std::{
    fmt::{self, Display, Formatter},
    str::FromStr,
};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

pub use self::{
    clip::{Clip, ClipBox, ClipError, Slab},
    ranges::{Border, Ranges, RangesError},
    rules::{Key, MaskRules, Place, Test},
};
use crate::scene::{Attribute, FileFacts, SceneFacts, UnknownAttribute};

/// Clauses over attributes: a point is shown if all hold. A point of which an attribute is not known, since its file
/// lacks it, marks it as no data, or was not read that far, is hidden by any clause over it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Filter {
    pub clauses: Vec<Clause>,
}

impl Filter {
    /// What has to be known of the points.
    pub fn attributes(&self) -> impl Iterator<Item = &Attribute> {
        self.clauses.iter().map(|clause| &clause.attribute)
    }

    /// The first clause over an attribute.
    pub fn of(&self, attribute: &Attribute) -> Option<&Clause> {
        self.clauses.iter().find(|clause| clause.attribute == *attribute)
    }

    /// What hides all points of a file, one line each: the file does not have what a clause asks for.
    pub fn absences(&self, scene: &SceneFacts) -> Vec<String> {
        let lacks = |file: &FileFacts| {
            let clause = self.clauses.iter().find(|clause| !clause.attribute.is_in(file))?;
            let extra = file.record.extra_names().map(Attribute::Extra);
            let all = Attribute::NAMED.into_iter().map(|(_, attribute)| attribute).chain(extra);
            let has: Vec<String> = all.filter(|a| a.is_in(file)).map(|a| a.to_string()).collect();
            let (path, has) = (file.path.display(), has.join(", "));
            Some(format!("{path} has no {}: --filter {clause} hides all its points; it has {has}", clause.attribute))
        };
        let mut lines: Vec<String> = scene.files.iter().filter_map(lacks).collect();
        let is_file = |clause: &&Clause| clause.attribute == Attribute::File;
        let files = || (0..scene.files.len()).map(|file| file as f64);
        for clause in self.clauses.iter().filter(is_file).filter(|clause| !files().any(|file| clause.holds(file))) {
            lines.push(format!("--filter {clause} hides all: the files are 0 to {}", scene.files.len().max(1) - 1));
        }
        lines
    }

    /// Puts a clause in the place of those over the same attribute; `None` takes them away.
    pub fn set(&mut self, attribute: &Attribute, clause: Option<Clause>) {
        let at = self.clauses.iter().position(|clause| clause.attribute == *attribute);
        self.clauses.retain(|clause| clause.attribute != *attribute);
        if let Some(clause) = clause {
            self.clauses.insert(at.unwrap_or(self.clauses.len()).min(self.clauses.len()), clause);
        }
    }
}

/// What one attribute must be. As text: `classification=2,6`, `classification!=7`, `elevation=10..55.5`,
/// `return-number=last`; that is what `--filter` takes, and what settings hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Clause {
    pub attribute: Attribute,
    /// The values are those to hide.
    pub is_excluding: bool,
    pub values: Ranges,
}

/// What a return number may be besides numbers: that of its pulse's last return.
const LAST: &str = "last";

/// Why a text is no clause.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ClauseError {
    #[error("expected ATTRIBUTE=VALUES, such as class=2,6 or class!=7 or elevation=10..55.5, found {0:?}")]
    NoValues(String),
    #[error(transparent)]
    Attribute(#[from] UnknownAttribute),
    #[error("{attribute}: {error}")]
    Ranges { attribute: String, error: RangesError },
}

impl Clause {
    /// Shows points whose attribute is one of these numbers.
    pub fn one_of(attribute: Attribute, numbers: impl IntoIterator<Item = u32>) -> Clause {
        Clause { attribute, is_excluding: false, values: Ranges::numbers(numbers) }
    }

    /// Hides points whose attribute is one of these numbers.
    pub fn none_of(attribute: Attribute, numbers: impl IntoIterator<Item = u32>) -> Clause {
        Clause { is_excluding: true, ..Clause::one_of(attribute, numbers) }
    }

    /// Shows points whose attribute lies from `low` to `high`, both among them.
    pub fn between(attribute: Attribute, low: f64, high: f64) -> Clause {
        Clause { attribute, is_excluding: false, values: Ranges::new([[low, high]]) }
    }

    /// Whether a value of the attribute is one to show.
    pub fn holds(&self, value: f64) -> bool {
        self.values.contain(value) != self.is_excluding
    }
}

impl Display for Clause {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let sign = if self.is_excluding { "!=" } else { "=" };
        if self.attribute == Attribute::LastReturn && self.values == Ranges::numbers([1]) {
            return write!(f, "{}{sign}{LAST}", Attribute::ReturnNumber);
        }
        write!(f, "{}{sign}{}", self.attribute, self.values)
    }
}

impl FromStr for Clause {
    type Err = ClauseError;

    fn from_str(text: &str) -> Result<Clause, ClauseError> {
        // The name of an extra dimension may hold anything, the values cannot: the last sign divides.
        let (name, values) = text.rsplit_once('=').ok_or_else(|| ClauseError::NoValues(text.into()))?;
        let (name, is_excluding) = name.strip_suffix('!').map_or((name, false), |name| (name, true));
        let attribute: Attribute = name.parse()?;
        if attribute == Attribute::ReturnNumber && values == LAST {
            return Ok(Clause { is_excluding, ..Clause::one_of(Attribute::LastReturn, [1]) });
        }
        let values = values
            .parse()
            .and_then(|values: Ranges| if attribute.is_small() { values.whole() } else { Ok(values) })
            .and_then(|values| attribute.limits().map_or(Ok(values.clone()), |limits| values.within(limits)))
            .map_err(|error| ClauseError::Ranges { attribute: attribute.to_string(), error })?;
        Ok(Clause { attribute, is_excluding, values })
    }
}

impl Serialize for Clause {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Clause {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Clause, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clauses_are_read_as_they_are_written() {
        for (typed, written) in [
            ("class=2,6", "classification=2,6"),
            ("classification!=7", "classification!=7"),
            ("class=6,2..5,6", "classification=2..5,6"),
            ("elevation=10..55.5", "elevation=10..55.5"),
            ("z=..-0.25", "elevation=..-0.25"),
            ("gps-time=315964800.123456789..", "gps-time=315964800.123456789.."),
            ("time=..", "gps-time=.."),
            ("return=1", "return-number=1"),
            ("return=last", "return-number=last"),
            ("return!=last", "return-number!=last"),
            ("last-return=1", "return-number=last"),
            ("last-return=0", "last-return=0"),
            ("scan-angle=-15..15", "scan-angle=-15..15"),
            ("extra:height=above=1e-3..2", "extra:height=above=0.001..2"),
            ("extra:odd!!=5", "extra:odd!!=5"),
            ("extra:id=9007199254740993,1152921504606846977..", "extra:id=9007199254740993,1152921504606846977.."),
            ("file!=0,3", "file!=0,3"),
        ] {
            let clause: Clause = typed.parse().unwrap();
            assert_eq!(clause.to_string(), written);
            assert_eq!(written.parse(), Ok(clause.clone()));
            let json = serde_json::to_string(&Filter { clauses: vec![clause.clone()] }).unwrap();
            assert_eq!(serde_json::from_str::<Filter>(&json).unwrap().clauses, [clause]);
        }
        let extra: Clause = "extra:a=b!=5".parse().unwrap();
        assert_eq!((extra.attribute, extra.is_excluding), (Attribute::Extra("a=b".into()), true));
    }

    #[test]
    fn what_is_no_clause_is_told_in_one_line() {
        for (typed, hint) in [
            ("class", "such as class=2,6"),
            ("colour=5", "expected intensity"),
            ("class=", "expected a number"),
            ("class=2,x", "found \"x\""),
            ("class=2.5", "whole numbers"),
            ("elevation=9..1", "the first larger than the second"),
            ("elevation=nan", "expected a number"),
            ("class=300", "classification: values are 0 to 255, found 300"),
            ("class=2,6..256", "found 256"),
            ("return=16", "return-number: values are 0 to 15, found 16"),
            ("returns!=-1", "number-of-returns: values are 0 to 15, found -1"),
            ("user-data=256", "0 to 255"),
            ("source=65536", "0 to 65535"),
            ("intensity=..65536", "0 to 65535"),
            ("scan-angle=-200..", "scan-angle: values are -196.608 to 196.602, found -200"),
        ] {
            let message = typed.parse::<Clause>().unwrap_err().to_string();
            assert!(message.contains(hint) && !message.contains('\n'), "{typed}: {message}");
        }
    }

    #[test]
    fn what_no_point_can_pass_is_told() {
        let file = FileFacts { path: "a.las".into(), ..Default::default() };
        let scene = SceneFacts {
            grid: crate::scene::Grid { scale: [1.0; 3], origin: [0.0; 3] },
            bounds: Default::default(),
            files: vec![file.clone(), file],
            warnings: Vec::new(),
        };
        let told = |clause: &str| Filter { clauses: vec![clause.parse().unwrap()] }.absences(&scene);
        assert_eq!(told("gps-time=1..2").len(), 2);
        assert!(told("gps-time=1..2")[0].starts_with("a.las has no gps-time: --filter gps-time=1..2 hides all its"));
        assert!(told("extra:height=1")[0].contains("it has intensity, elevation"));
        assert_eq!(told("file=2"), ["--filter file=2 hides all: the files are 0 to 1"]);
        assert!(told("file=1").is_empty() && told("class=9").is_empty());
    }

    #[test]
    fn a_clause_takes_the_place_of_another() {
        let mut filter = Filter { clauses: vec!["class=2".parse().unwrap(), "z=1..2".parse().unwrap()] };
        filter.set(&Attribute::Classification, Some(Clause::none_of(Attribute::Classification, [7])));
        let text = |filter: &Filter| filter.clauses.iter().map(|c| c.to_string()).collect::<Vec<_>>().join(" ");
        assert_eq!(text(&filter), "classification!=7 elevation=1..2");
        filter.set(&Attribute::File, Some(Clause::one_of(Attribute::File, [1])));
        filter.set(&Attribute::Classification, None);
        assert_eq!(text(&filter), "elevation=1..2 file=1");
        assert!(filter.of(&Attribute::File).unwrap().holds(1.0) && !filter.of(&Attribute::File).unwrap().holds(2.0));
    }
}
