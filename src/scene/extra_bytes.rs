//! What the extra bytes of a point mean.

use std::fmt::{self, Display, Formatter};

use serde::Serialize;

/// One named dimension among a file's extra bytes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExtraDimension {
    pub name: String,
    pub description: String,
    /// First byte, counted from the start of the point's extra bytes.
    pub at: usize,
    pub kind: ExtraKind,
    /// Numbers per point: 1, or 2 or 3 in types that LAS 1.4 R14 has deprecated.
    pub elements: usize,
    /// Per element, unscaled; `None` where the file does not say.
    pub no_data: Option<Vec<Number>>,
    pub min: Option<Vec<Number>>,
    pub max: Option<Vec<Number>>,
    /// Per element: `value = scale * number + offset`.
    pub scale: Option<Vec<f64>>,
    pub offset: Option<Vec<f64>>,
}

/// Type of a dimension's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ExtraKind {
    /// So many bytes that mean nothing to a general reader.
    Bytes(usize),
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

/// A number exactly as stored.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Number {
    Unsigned(u64),
    Signed(i64),
    Float(f64),
}

impl Number {
    pub fn as_f64(self) -> f64 {
        match self {
            Number::Unsigned(n) => n as f64,
            Number::Signed(n) => n as f64,
            Number::Float(n) => n,
        }
    }

    /// Equal as numbers of one kind; NaN marks missing data, so it equals itself.
    fn is(self, other: Number) -> bool {
        self == other || matches!((self, other), (Number::Float(a), Number::Float(b)) if a.is_nan() && b.is_nan())
    }
}

impl Display for Number {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Number::Unsigned(n) => n.fmt(f),
            Number::Signed(n) => n.fmt(f),
            Number::Float(n) => n.fmt(f),
        }
    }
}

impl ExtraKind {
    /// The smallest and the largest number of an integer type.
    pub fn integers(self) -> Option<[i128; 2]> {
        Some(match self {
            ExtraKind::U8 => [0, u8::MAX.into()],
            ExtraKind::I8 => [i8::MIN.into(), i8::MAX.into()],
            ExtraKind::U16 => [0, u16::MAX.into()],
            ExtraKind::I16 => [i16::MIN.into(), i16::MAX.into()],
            ExtraKind::U32 => [0, u32::MAX.into()],
            ExtraKind::I32 => [i32::MIN.into(), i32::MAX.into()],
            ExtraKind::U64 => [0, u64::MAX.into()],
            ExtraKind::I64 => [i64::MIN.into(), i64::MAX.into()],
            ExtraKind::Bytes(_) | ExtraKind::F32 | ExtraKind::F64 => return None,
        })
    }

    /// Bytes of one number (or of all bytes that mean nothing).
    pub fn bytes(self) -> usize {
        match self {
            ExtraKind::Bytes(n) => n,
            ExtraKind::U8 | ExtraKind::I8 => 1,
            ExtraKind::U16 | ExtraKind::I16 => 2,
            ExtraKind::U32 | ExtraKind::I32 | ExtraKind::F32 => 4,
            ExtraKind::U64 | ExtraKind::I64 | ExtraKind::F64 => 8,
        }
    }
}

impl ExtraDimension {
    /// Bytes per point.
    pub fn bytes(&self) -> usize {
        self.kind.bytes() * self.elements
    }

    /// The dimension's own bytes among a point's extra bytes; `None` if there are too few.
    pub fn raw<'a>(&self, extra: &'a [u8]) -> Option<&'a [u8]> {
        extra.get(self.at..)?.get(..self.bytes())
    }

    /// A number exactly as stored, no-data or not. `None` for bytes without a meaning, and for an
    /// element that does not exist.
    pub fn number(&self, extra: &[u8], element: usize) -> Option<Number> {
        if element >= self.elements {
            return None;
        }
        let size = self.kind.bytes();
        let b = self.raw(extra)?.get(element * size..(element + 1) * size)?;
        Some(match self.kind {
            ExtraKind::Bytes(_) => return None,
            ExtraKind::U8 => Number::Unsigned(b[0].into()),
            ExtraKind::I8 => Number::Signed(b[0].cast_signed().into()),
            ExtraKind::U16 => Number::Unsigned(u16::from_le_bytes(*b.first_chunk()?).into()),
            ExtraKind::I16 => Number::Signed(i16::from_le_bytes(*b.first_chunk()?).into()),
            ExtraKind::U32 => Number::Unsigned(u32::from_le_bytes(*b.first_chunk()?).into()),
            ExtraKind::I32 => Number::Signed(i32::from_le_bytes(*b.first_chunk()?).into()),
            ExtraKind::U64 => Number::Unsigned(u64::from_le_bytes(*b.first_chunk()?)),
            ExtraKind::I64 => Number::Signed(i64::from_le_bytes(*b.first_chunk()?)),
            ExtraKind::F32 => Number::Float(f32::from_le_bytes(*b.first_chunk()?).into()),
            ExtraKind::F64 => Number::Float(f64::from_le_bytes(*b.first_chunk()?)),
        })
    }

    /// The first element's value, scaled and offset; `None` if the file marks it as no data, or if it
    /// is no number.
    ///
    /// ```
    /// use firstlight::scene::{ExtraDimension, ExtraKind, Number};
    ///
    /// let height = ExtraDimension {
    ///     name: "height".into(),
    ///     description: "above ground, m".into(),
    ///     at: 1,
    ///     kind: ExtraKind::I16,
    ///     elements: 1,
    ///     no_data: Some(vec![Number::Signed(-1)]),
    ///     min: None,
    ///     max: None,
    ///     scale: Some(vec![0.01]),
    ///     offset: None,
    /// };
    /// assert_eq!(height.value(&[9, 250, 0]), Some(2.5));
    /// assert_eq!(height.value(&[9, 255, 255]), None);
    /// ```
    pub fn value(&self, extra: &[u8]) -> Option<f64> {
        self.value_of(extra, 0)
    }

    /// Scale and offset of an element, if they are more than 1 and 0.
    pub fn scaling(&self, element: usize) -> Option<(f64, f64)> {
        let of =
            |values: &Option<Vec<f64>>, default| values.as_ref().and_then(|v| v.get(element)).map_or(default, |v| *v);
        Some((of(&self.scale, 1.0), of(&self.offset, 0.0))).filter(|scaling| *scaling != (1.0, 0.0))
    }

    /// A number exactly as stored; `None` where [`ExtraDimension::number`] is, and for no data.
    pub fn data(&self, extra: &[u8], element: usize) -> Option<Number> {
        let number = self.number(extra, element)?;
        let no_data = self.no_data.as_ref().and_then(|n| n.get(element));
        (!no_data.is_some_and(|n| n.is(number))).then_some(number)
    }

    /// Any element's value, like [`ExtraDimension::value`]. Scaling rounds: see [`Scaled`](super::Scaled) for the digits.
    pub fn value_of(&self, extra: &[u8], element: usize) -> Option<f64> {
        let (scale, offset) = self.scaling(element).unwrap_or((1.0, 0.0));
        Some(self.data(extra, element)?.as_f64() * scale + offset)
    }

    /// e.g. "u16", "f32 × 3", "12 bytes".
    pub fn type_name(&self) -> String {
        let name = match self.kind {
            ExtraKind::Bytes(n) => return format!("{n} bytes"),
            kind => format!("{kind:?}").to_lowercase(),
        };
        if self.elements > 1 { format!("{name} × {}", self.elements) } else { name }
    }
}
