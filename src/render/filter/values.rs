//! Sets of numbers as closed ranges, and how they are written.

use std::{
    fmt::{self, Display, Formatter},
    str::FromStr,
};

/// A set of numbers: closed ranges in order, none of which overlap. As text: `2,6`, `2..5,9`, `10..`, `..55.5`; `..` is
/// every number.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Values {
    ranges: Vec<[f64; 2]>,
}

/// Why a text is no set of numbers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ValuesError {
    #[error("expected a number, a range such as 10..55.5, 10.. or ..55.5, or several with commas between, found {0:?}")]
    NoNumber(String),
    #[error("expected whole numbers, found {0:?}")]
    NotWhole(String),
    #[error("the range {0:?} has the first larger than the second")]
    InsideOut(String),
}

impl Values {
    /// Ranges from the first number to the second, both among them; those inside out hold nothing.
    pub fn new(ranges: impl IntoIterator<Item = [f64; 2]>) -> Values {
        let mut ranges: Vec<[f64; 2]> = ranges.into_iter().filter(|[low, high]| low <= high).collect();
        ranges.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut merged: Vec<[f64; 2]> = Vec::new();
        for range in ranges {
            match merged.last_mut() {
                Some(last) if range[0] <= last[1] => last[1] = last[1].max(range[1]),
                _ => merged.push(range),
            }
        }
        Values { ranges: merged }
    }

    pub fn numbers(numbers: impl IntoIterator<Item = u32>) -> Values {
        Values::new(numbers.into_iter().map(|n| [f64::from(n); 2]))
    }

    /// In order.
    pub fn ranges(&self) -> &[[f64; 2]] {
        &self.ranges
    }

    pub fn contain(&self, value: f64) -> bool {
        self.ranges.iter().any(|[low, high]| (*low..=*high).contains(&value))
    }

    /// The same, if every border is a whole number.
    pub(super) fn whole(self) -> Result<Values, ValuesError> {
        match self.ranges.iter().flatten().find(|border| border.is_finite() && border.fract() != 0.0) {
            Some(border) => Err(ValuesError::NotWhole(border.to_string())),
            None => Ok(self),
        }
    }
}

impl Display for Values {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let open = |border: f64| if border.is_finite() { border.to_string() } else { String::new() };
        for (i, &[low, high]) in self.ranges.iter().enumerate() {
            f.write_str(if i > 0 { "," } else { "" })?;
            if low == high {
                write!(f, "{low}")?;
            } else {
                write!(f, "{}..{}", open(low), open(high))?;
            }
        }
        Ok(())
    }
}

impl FromStr for Values {
    type Err = ValuesError;

    fn from_str(text: &str) -> Result<Values, ValuesError> {
        let ranges: Result<Vec<_>, _> = text.split(',').map(|item| range(item.trim())).collect();
        Ok(Values::new(ranges?))
    }
}

fn range(item: &str) -> Result<[f64; 2], ValuesError> {
    let number = |text: &str| {
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        // Minus zero is zero, and is written so.
        number.map(|number| number + 0.0).ok_or_else(|| ValuesError::NoNumber(item.into()))
    };
    let Some((low, high)) = item.split_once("..") else { return number(item).map(|number| [number; 2]) };
    let border = |text: &str, open| if text.is_empty() { Ok(open) } else { number(text) };
    let range = [border(low, f64::NEG_INFINITY)?, border(high, f64::INFINITY)?];
    if range[0] > range[1] { Err(ValuesError::InsideOut(item.into())) } else { Ok(range) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlapping_ranges_are_one() {
        let values: Values = "5..9,1,2..6,1,20..".parse().unwrap();
        assert_eq!(values.ranges(), [[1.0, 1.0], [2.0, 9.0], [20.0, f64::INFINITY]]);
        assert_eq!(values.to_string(), "1,2..9,20..");
        for (value, is_in) in [(0.9, false), (1.0, true), (1.5, false), (9.0, true), (9.1, false), (1e300, true)] {
            assert_eq!(values.contain(value), is_in, "{value}");
        }
        assert!(!"..".parse::<Values>().unwrap().contain(f64::NAN));
        assert_eq!("-0".parse::<Values>().unwrap().to_string(), "0");
    }
}
