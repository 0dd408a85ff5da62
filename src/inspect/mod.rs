//! One point and what lies between points, to the last digit that the file has.
//!
//! [`PointRecord`] is a record as it is in the file, found by its number: what a picture keeps of a point (a position on
//! the scene's grid, a colour) says where to look, and the rest is read when somebody asks. [`card`](PointRecord::card)
//! is what a window shows of it; text, JSON and CSV say the same.
//!
//! ```text
//! record     a record's fields, from its bytes
//! fields     the same as named values: JSON, CSV
//! card       the same for people
//! measure    distances, lengths and areas
//! ```

mod card;
mod fields;
mod measure;
mod record;

pub use crate::scene::{Decimal, scaled, shortest, shortest_f32};
pub use card::lines;
pub use fields::{Field, Value, csv_header, csv_row, json};
pub use measure::{Distance, Polyline, Ruler};
pub use record::{ExtraValue, Flags, PointRecord, WavePacket};
