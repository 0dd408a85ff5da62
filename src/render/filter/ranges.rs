//! Sets of numbers as closed ranges, and how they are written.

use std::{
    cmp::Ordering,
    fmt::{self, Display, Formatter},
    str::FromStr,
};

use crate::scene::Decimal;

/// A set of numbers: closed ranges in order, none of which overlap. As text: `2,6`, `2..5,9`, `10..`, `..55.5`; `..` is
/// every number. Borders are kept in all the digits that were typed: 64-bit integers have more than an f64.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Ranges {
    exact: Vec<[Border; 2]>,
    /// The nearest to these.
    ranges: Vec<[f64; 2]>,
}

/// The first or the last number of a range; `None`: there is no such border.
pub type Border = Option<Decimal>;

/// Why a text is no set of numbers.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RangesError {
    #[error("expected a number, a range such as 10..55.5, 10.. or ..55.5, or several with commas between, found {0:?}")]
    NoNumber(String),
    #[error("expected whole numbers, found {0:?}")]
    NotWhole(String),
    #[error("the range {0:?} has the first larger than the second")]
    InsideOut(String),
    #[error("values are {least} to {most}, found {found}")]
    Beyond { least: f64, most: f64, found: f64 },
}

impl Ranges {
    /// Ranges from the first number to the second, both among them; those inside out hold nothing.
    pub fn new(ranges: impl IntoIterator<Item = [f64; 2]>) -> Ranges {
        let upright =
            ranges.into_iter().filter(|[low, high]| low <= high && *low < f64::INFINITY && *high > f64::NEG_INFINITY);
        // What is not finite has no digits.
        Ranges::of(upright.map(|range| range.map(Decimal::from_f64)).collect())
    }

    /// None of these is inside out.
    fn of(mut ranges: Vec<[Border; 2]>) -> Ranges {
        ranges.sort_by(|a, b| compare(&a[0], &b[0], Ordering::Less));
        let mut exact: Vec<[Border; 2]> = Vec::new();
        for range in ranges {
            match exact.last_mut() {
                // To the end of all numbers, or to this range's first.
                Some([_, None]) => {}
                Some([_, last]) if compare(&range[0], last, Ordering::Less).is_le() => {
                    if compare(last, &range[1], Ordering::Greater).is_lt() {
                        *last = range[1].clone();
                    }
                }
                _ => exact.push(range),
            }
        }
        let nearest = |border: &Border, open| border.as_ref().map_or(open, Decimal::nearest);
        let ranges = exact.iter().map(|[low, high]| [nearest(low, f64::NEG_INFINITY), nearest(high, f64::INFINITY)]);
        Ranges { ranges: ranges.collect(), exact }
    }

    pub fn numbers(numbers: impl IntoIterator<Item = u32>) -> Ranges {
        Ranges::new(numbers.into_iter().map(|n| [f64::from(n); 2]))
    }

    /// The same borders to their last digit.
    pub fn exact(&self) -> &[[Border; 2]] {
        &self.exact
    }

    /// In order.
    pub fn ranges(&self) -> &[[f64; 2]] {
        &self.ranges
    }

    pub fn contain(&self, value: f64) -> bool {
        self.ranges.iter().any(|[low, high]| (*low..=*high).contains(&value))
    }

    /// The same, if every border is a whole number.
    pub(super) fn whole(self) -> Result<Ranges, RangesError> {
        match self.exact.iter().flatten().flatten().find(|border| border.places() > 0) {
            Some(border) => Err(RangesError::NotWhole(border.to_string())),
            None => Ok(self),
        }
    }

    /// The same, if every border is one that values may have.
    pub(super) fn within(self, [least, most]: [f64; 2]) -> Result<Ranges, RangesError> {
        let is_beyond = |border: &&f64| border.is_finite() && !(least..=most).contains(*border);
        match self.ranges.iter().flatten().find(is_beyond) {
            Some(border) => Err(RangesError::Beyond { least, most, found: *border }),
            None => Ok(self),
        }
    }
}

/// Compares borders, of which an open one is less or greater than all numbers.
fn compare(a: &Border, b: &Border, open: Ordering) -> Ordering {
    match (a, b) {
        (Some(a), Some(b)) => a.compare(b),
        (None, None) => Ordering::Equal,
        (None, Some(_)) => open,
        (Some(_), None) => open.reverse(),
    }
}

impl Display for Ranges {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let write = |f: &mut Formatter<'_>, border: &Border| border.as_ref().map_or(Ok(()), |border| border.fmt(f));
        for (i, [low, high]) in self.exact.iter().enumerate() {
            f.write_str(if i > 0 { "," } else { "" })?;
            write(f, low)?;
            if low != high || low.is_none() {
                f.write_str("..")?;
                write(f, high)?;
            }
        }
        Ok(())
    }
}

impl FromStr for Ranges {
    type Err = RangesError;

    fn from_str(text: &str) -> Result<Ranges, RangesError> {
        let ranges: Result<Vec<_>, _> = text.split(',').map(|item| range(item.trim())).collect();
        Ok(Ranges::of(ranges?))
    }
}

fn range(item: &str) -> Result<[Border; 2], RangesError> {
    let number = |text: &str| Decimal::parse(text).ok_or_else(|| RangesError::NoNumber(item.into()));
    let Some((low, high)) = item.split_once("..") else { return number(item).map(|n| [Some(n.clone()), Some(n)]) };
    let border = |text: &str| if text.is_empty() { Ok(None) } else { number(text).map(Some) };
    let range = [border(low)?, border(high)?];
    match &range {
        [Some(low), Some(high)] if low.compare(high).is_gt() => Err(RangesError::InsideOut(item.into())),
        _ => Ok(range),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlapping_ranges_are_one() {
        let ranges: Ranges = "5..9,1,2..6,1,20..".parse().unwrap();
        assert_eq!(ranges.ranges(), [[1.0, 1.0], [2.0, 9.0], [20.0, f64::INFINITY]]);
        assert_eq!(ranges.to_string(), "1,2..9,20..");
        for (value, is_in) in [(0.9, false), (1.0, true), (1.5, false), (9.0, true), (9.1, false), (1e300, true)] {
            assert_eq!(ranges.contain(value), is_in, "{value}");
        }
        assert!(!"..".parse::<Ranges>().unwrap().contain(f64::NAN));
        let long: Ranges = "9007199254740993,9007199254740992,9007199254740994..".parse().unwrap();
        assert_eq!(
            long.to_string(),
            "9007199254740992,9007199254740993,9007199254740994..",
            "three, though one as f64"
        );
        assert_eq!("3..,..1,5..7,..2".parse::<Ranges>().unwrap().to_string(), "..2,3..");
        assert_eq!("4..,..4".parse::<Ranges>().unwrap().to_string(), "..");
        assert_eq!("1.50".parse::<Ranges>(), Ok(Ranges::new([[1.5, 1.5]])));
        assert_eq!("-0".parse::<Ranges>().unwrap().to_string(), "0");
    }
}
