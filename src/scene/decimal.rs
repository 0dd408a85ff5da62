//! Decimal numbers of any length: a coordinate is a whole number of steps of the file's scale, and has exactly as
//! many digits as scale and offset have. In f64, 63,701,224 steps of 0.01 are 637,012.24 and something.

use std::{
    cmp::Ordering,
    fmt::{self, Display, Formatter},
};

/// A whole number times a power of ten.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Decimal {
    negative: bool,
    /// From the least significant on, 0 to 9 each; none for zero.
    digits: Vec<u8>,
    exponent: i32,
}

impl Decimal {
    /// The shortest decimal number that reads back as `x`: what was meant, where somebody typed 0.01. `None` if it
    /// is not finite.
    pub fn from_f64(x: f64) -> Option<Decimal> {
        x.is_finite().then(|| Decimal::of_scientific(&format!("{x:e}"))).flatten()
    }

    /// As [`Decimal::from_f64`], with the fewer digits that an `f32` needs.
    pub fn from_f32(x: f32) -> Option<Decimal> {
        x.is_finite().then(|| Decimal::of_scientific(&format!("{x:e}"))).flatten()
    }

    /// Of a number as people type it, to its last digit: `-12.50`, `1e-3`. `None` if it is no number, or none that an
    /// f64 can be near to.
    pub fn parse(text: &str) -> Option<Decimal> {
        let near = text.parse::<f64>().ok().filter(|near| near.is_finite())?;
        if near == 0.0 {
            // Among them those of which only zeros would be left, such as 1e-999999999.
            return Some(Decimal::from_integer(0));
        }
        let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
        let mantissa = mantissa.strip_prefix('+').unwrap_or(mantissa);
        Decimal::of_scientific(&format!("{mantissa}e{exponent}")).map(Decimal::without_zeros_below)
    }

    pub fn from_integer(n: i128) -> Decimal {
        let digits = n.unsigned_abs().to_string().bytes().rev().map(|b| b - b'0').collect();
        Decimal { negative: n < 0, digits, exponent: 0 }.without_leading_zeros()
    }

    /// Of `-1.25e-3`, as Rust writes numbers.
    fn of_scientific(text: &str) -> Option<Decimal> {
        let (mantissa, exponent) = text.split_once('e')?;
        let (negative, mantissa) = mantissa.strip_prefix('-').map_or((false, mantissa), |rest| (true, rest));
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits = whole.bytes().chain(fraction.bytes()).rev().map(|b| b - b'0').collect();
        let exponent = exponent.parse::<i32>().ok()? - fraction.len() as i32;
        Some(Decimal { negative, digits, exponent }.without_leading_zeros())
    }

    fn without_leading_zeros(mut self) -> Decimal {
        while self.digits.last() == Some(&0) {
            self.digits.pop();
        }
        self.negative &= !self.digits.is_empty();
        self
    }

    /// The same number without the zeros that follow its last other digit: 12.50 is 12.5 then, and 1000 is 1e3.
    fn without_zeros_below(mut self) -> Decimal {
        let zeros = self.digits.iter().take_while(|&&digit| digit == 0).count();
        self.digits.drain(..zeros);
        self.exponent = if self.digits.is_empty() { 0 } else { self.exponent + zeros as i32 };
        self
    }

    /// Which of two numbers is larger; 12.50 and 12.5 are equal, though they are not the same digits.
    pub fn compare(&self, other: &Decimal) -> Ordering {
        let difference = self.minus(other);
        match (difference.digits.is_empty(), difference.negative) {
            (true, _) => Ordering::Equal,
            (false, true) => Ordering::Less,
            (false, false) => Ordering::Greater,
        }
    }

    /// The nearest f64.
    pub fn nearest(&self) -> f64 {
        self.scientific().parse().unwrap_or(f64::NAN)
    }

    /// The nearest f32.
    pub fn nearest_f32(&self) -> f32 {
        self.scientific().parse().unwrap_or(f32::NAN)
    }

    /// As Rust reads numbers.
    fn scientific(&self) -> String {
        let digits: String = self.digits.iter().rev().map(|digit| char::from(b'0' + digit)).collect();
        let sign = if self.negative { "-" } else { "" };
        format!("{sign}0{digits}e{}", self.exponent)
    }

    /// How many times it holds 10 to the minus `places`; `None` if that is no whole number of 128 bits.
    fn units(&self, places: i32) -> Option<i128> {
        if self.exponent < -places {
            return None;
        }
        let digits = self.digits_from(-places);
        let append = |n: i128, &digit: &u8| n.checked_mul(10)?.checked_add(digit.into());
        let size = digits.iter().rev().try_fold(0, append)?;
        Some(if self.negative { -size } else { size })
    }

    pub fn times(&self, other: &Decimal) -> Decimal {
        let mut sums = vec![0u32; self.digits.len() + other.digits.len()];
        for (i, a) in self.digits.iter().enumerate() {
            for (j, b) in other.digits.iter().enumerate() {
                sums[i + j] += u32::from(*a) * u32::from(*b);
            }
        }
        let mut carry = 0;
        let digits = sums
            .iter()
            .map(|sum| {
                let sum = sum + carry;
                carry = sum / 10;
                (sum % 10) as u8
            })
            .collect();
        let exponent = self.exponent + other.exponent;
        Decimal { negative: self.negative != other.negative, digits, exponent }.without_leading_zeros()
    }

    pub fn plus(&self, other: &Decimal) -> Decimal {
        let exponent = self.exponent.min(other.exponent);
        let (a, b) = (self.digits_from(exponent), other.digits_from(exponent));
        let (negative, digits) = if self.negative == other.negative {
            (self.negative, sum(&a, &b))
        } else if larger(&a, &b) == Ordering::Less {
            (other.negative, difference(&b, &a))
        } else {
            (self.negative, difference(&a, &b))
        };
        Decimal { negative, digits, exponent }.without_leading_zeros()
    }

    pub fn minus(&self, other: &Decimal) -> Decimal {
        self.plus(&Decimal { negative: !other.negative, ..other.clone() })
    }

    /// Its digits with zeros below, down to this power of ten.
    fn digits_from(&self, exponent: i32) -> Vec<u8> {
        let mut digits = vec![0; (self.exponent - exponent).max(0) as usize];
        digits.extend(&self.digits);
        digits
    }

    /// Digits behind the point.
    pub fn places(&self) -> usize {
        (-self.exponent).max(0) as usize
    }
}

/// Compares numbers without leading zeros above.
fn larger(a: &[u8], b: &[u8]) -> Ordering {
    let used = |digits: &[u8]| digits.iter().rposition(|&d| d != 0).map_or(0, |last| last + 1);
    used(a).cmp(&used(b)).then_with(|| a[..used(a)].iter().rev().cmp(b[..used(b)].iter().rev()))
}

fn sum(a: &[u8], b: &[u8]) -> Vec<u8> {
    let mut carry = 0;
    let digit = |digits: &[u8], i| digits.get(i).copied().unwrap_or(0);
    (0..a.len().max(b.len()) + 1)
        .map(|i| {
            let sum = digit(a, i) + digit(b, i) + carry;
            carry = sum / 10;
            sum % 10
        })
        .collect()
}

/// Of numbers of which `a` is not the smaller one.
fn difference(a: &[u8], b: &[u8]) -> Vec<u8> {
    let mut borrowed = 0;
    a.iter()
        .enumerate()
        .map(|(i, &digit)| {
            let take = b.get(i).copied().unwrap_or(0) + borrowed;
            borrowed = u8::from(digit < take);
            digit + 10 * borrowed - take
        })
        .collect()
}

/// Without an exponent, with as many digits behind the point as it was made of: 12.50 stays 12.50.
impl Display for Decimal {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if self.negative {
            f.write_str("-")?;
        }
        let places = self.places();
        let digits = self.digits_from(self.exponent.min(0));
        let text = |digits: &[u8]| digits.iter().rev().map(|d| char::from(b'0' + d)).collect::<String>();
        let (fraction, whole) = digits.split_at(places.min(digits.len()));
        f.write_str(if whole.is_empty() { "0" } else { "" })?;
        f.write_str(&text(whole))?;
        if places > 0 {
            write!(f, ".{:0>places$}", text(fraction))?;
        }
        Ok(())
    }
}

/// What whole numbers mean of which a file says a scale and an offset: `scale * n + offset`, of the decimal numbers that
/// scale and offset are written as. In f64, 0.1 · 10001 − 1000 is 0.1 and something.
#[derive(Debug, Clone, PartialEq)]
pub struct Scaled {
    scale: Decimal,
    offset: Decimal,
    /// Both in units of the last digit of either, and how many of these are 1.
    units: Option<(i128, i128, f64)>,
}

impl Scaled {
    /// `None` if scale or offset is not finite.
    pub fn new(scale: f64, offset: f64) -> Option<Scaled> {
        let (scale, offset) = (Decimal::from_f64(scale)?, Decimal::from_f64(offset)?);
        let places = scale.places().max(offset.places()) as i32;
        // Powers of ten that an f64 holds exactly.
        let units = || (places <= 22).then_some((scale.units(places)?, offset.units(places)?, 10f64.powi(places)));
        Some(Scaled { units: units(), scale, offset })
    }

    /// To the last digit.
    pub fn exact(&self, n: i128) -> Decimal {
        self.of(&Decimal::from_integer(n))
    }

    /// The same of a number with a fraction.
    pub fn of(&self, number: &Decimal) -> Decimal {
        number.times(&self.scale).plus(&self.offset)
    }

    /// To the nearest f64.
    pub fn nearest(&self, n: i128) -> f64 {
        self.short(n).unwrap_or_else(|| self.exact(n).nearest())
    }

    /// The same where no long arithmetic is needed.
    pub fn short(&self, n: i128) -> Option<f64> {
        let (scale, offset, per_one) = self.units?;
        let units = n.checked_mul(scale)?.checked_add(offset)?;
        // The quotient of two numbers without an error is rounded once.
        (units.unsigned_abs() <= 1 << 53).then_some(units as f64 / per_one)
    }
}

/// `scale * n + offset`, exactly; `None` if scale or offset is not finite.
pub fn scaled(n: i128, scale: f64, offset: f64) -> Option<Decimal> {
    Some(Scaled::new(scale, offset)?.exact(n))
}

/// The shortest text that reads back as `x`, without an exponent where that is not too long.
pub fn shortest(x: f64) -> String {
    if x == 0.0 || (1e-5..1e17).contains(&x.abs()) || !x.is_finite() { x.to_string() } else { format!("{x:e}") }
}

/// As [`shortest`], with the fewer digits that an `f32` needs.
pub fn shortest_f32(x: f32) -> String {
    if x == 0.0 || (1e-5..1e17).contains(&x.abs()) || !x.is_finite() { x.to_string() } else { format!("{x:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coordinate(n: i32, scale: f64, offset: f64) -> String {
        scaled(n.into(), scale, offset).unwrap().to_string()
    }

    #[test]
    fn coordinates_have_the_digits_of_scale_and_offset() {
        // In f64 this is 637012.2400000000002 and the like.
        assert_eq!(coordinate(63_701_224, 0.01, 0.0), "637012.24");
        assert_eq!(coordinate(63_701_220, 0.01, 0.0), "637012.20");
        assert_eq!(coordinate(1, 0.001, 2_000_000.0), "2000000.001");
        assert_eq!(coordinate(-1, 0.001, 2_000_000.0), "1999999.999");
        assert_eq!(coordinate(5, 0.01, -0.125), "-0.075");
        assert_eq!(coordinate(-5, 0.01, 0.05), "0.00");
        assert_eq!(coordinate(i32::MIN, 1e-7, 180.0), "-34.7483648");
        assert_eq!(coordinate(7, 1.0, 0.0), "7");
        assert_eq!(coordinate(7, 10.0, 3.0), "73");
        assert_eq!(coordinate(0, 10.0, 0.0), "0");
        assert_eq!(coordinate(3, -0.5, 1.0), "-0.5");
        assert_eq!(coordinate(3, 1e-15, 1e15), "1000000000000000.000000000000003");
        assert_eq!(coordinate(2, 0.300_000_000_000_000_04, 0.0), "0.60000000000000008");
        assert_eq!(scaled(1, f64::NAN, 0.0), None);
    }

    #[test]
    fn numbers_have_the_shortest_text_that_reads_back() {
        for x in [0.1, -1.5e300, 5e-324, 123_456_789.123_456_79, 0.0, 1e16, f64::MAX] {
            assert_eq!(shortest(x).parse::<f64>().unwrap().to_bits(), f64::to_bits(x), "{x}");
        }
        assert_eq!((shortest(0.1), shortest(1e300), shortest(-0.0)), ("0.1".into(), "1e300".into(), "-0".into()));
        assert_eq!((shortest_f32(0.1), shortest(f64::from(0.1_f32))), ("0.1".into(), "0.10000000149011612".into()));
        assert_eq!(Decimal::from_f32(0.1).unwrap().to_string(), "0.1");
    }

    #[test]
    fn typed_numbers_are_read_to_their_last_digit() {
        for (typed, written) in [
            ("-12.50", "-12.5"),
            ("+7", "7"),
            ("1e-3", "0.001"),
            ("1.5E3", "1500"),
            (".5", "0.5"),
            ("5.", "5"),
            ("-0", "0"),
            ("0.000", "0"),
            ("9007199254740993", "9007199254740993"),
            ("0.10000000000000000555111512312578", "0.10000000000000000555111512312578"),
            ("1e-999999999", "0"),
        ] {
            assert_eq!(Decimal::parse(typed).unwrap().to_string(), written);
        }
        for wrong in ["", "x", "nan", "inf", "1e999999999", "1,5", "0x10", "1e"] {
            assert_eq!(Decimal::parse(wrong), None, "{wrong}");
        }
        assert_eq!(Decimal::parse("1e3"), Decimal::parse("1000.0"));
    }

    #[test]
    fn scaled_numbers_are_rounded_once() {
        let cases = [(0.1, -1000.0), (0.006, 0.0), (1e-7, 180.0), (-0.5, 1.0), (1.0, 0.0), (3e5, 1e-20), (0.3, 1e300)];
        for (scale, offset) in cases {
            let scaled = Scaled::new(scale, offset).unwrap();
            for n in [0, 1, -1, 10_001, i32::MAX.into(), i64::MIN.into(), u64::MAX.into(), (1 << 53) + 1] {
                let digits = scaled.exact(n).to_string();
                assert_eq!(digits.parse(), Ok(scaled.nearest(n)), "{n} · {scale} + {offset}");
                assert_eq!(digits.parse(), Ok(scaled.exact(n).nearest_f32()));
            }
        }
        assert_eq!(Scaled::new(0.1, -1000.0).unwrap().nearest(10_001), 0.1);
        assert_eq!(Scaled::new(1.0, f64::INFINITY), None);
    }

    #[test]
    fn numbers_are_compared_by_value() {
        let decimal = |text| Decimal::parse(text).unwrap();
        let ordered = ["-1e300", "-2", "-1.5", "0", "1e-300", "0.1", "9007199254740992", "9007199254740993", "1e17"];
        for (i, a) in ordered.iter().enumerate() {
            for (j, b) in ordered.iter().enumerate() {
                assert_eq!(decimal(a).compare(&decimal(b)), i.cmp(&j), "{a} {b}");
            }
        }
        assert_eq!(Decimal::from_integer(12).compare(&decimal("12.0")), Ordering::Equal);
    }

    proptest::proptest! {
        /// Against whole numbers of 128 bits.
        #[test]
        fn sums_and_products_are_exact(a in -1_000_000_000_000i64.., b in -1_000_000_000i64..1_000_000_000, shift in 0i32..9) {
            let (wide_a, wide_b) = (i128::from(a), i128::from(b));
            let decimal = |n: i64| Decimal::from_integer(n.into());
            let scaled = Decimal { exponent: -shift, ..decimal(b) };
            let power = 10i128.pow(shift as u32);
            let check = |found: Decimal, units: i128| {
                let sign = if units < 0 { "-" } else { "" };
                let (whole, fraction) = (units.abs() / power, units.abs() % power);
                let places = shift as usize;
                let text = if shift > 0 { format!("{sign}{whole}.{fraction:0>places$}") } else { format!("{sign}{whole}") };
                assert_eq!(found.to_string(), text);
            };
            check(decimal(a).plus(&scaled), wide_a * power + wide_b);
            check(decimal(a).minus(&scaled), wide_a * power - wide_b);
            check(decimal(a).times(&scaled), wide_a * wide_b);
        }
    }
}
