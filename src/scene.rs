//! The words that every room shares: the integer grid, the batch, and what is known of a scene before
//! its points arrive. Nothing here knows of files' formats or of a GPU.

use std::path::PathBuf;

use serde::Serialize;

mod attribute;
mod attributes;
mod decimal;
mod extra_bytes;
mod gps;
mod unit;

pub use attribute::{Attribute, UnknownAttribute};
pub use attributes::{Attributes, WAVE_PACKET_BYTES};
pub use decimal::{Decimal, Scaled, scaled, shortest, shortest_f32};
pub use extra_bytes::{ExtraDimension, ExtraKind, Number};
pub use gps::GpsClock;
pub use unit::Unit;

/// Most points that one [`PointBatch`] carries.
pub const BATCH_POINTS: usize = 65_536;

/// The integer grid that all positions of a scene lie on: `world = origin + scale * i`, per axis, in
/// the unit of the file's coordinate system.
///
/// For a scene of one file, `scale` and `origin` are the header's own scale and offset, so that `i` is
/// the record's X, Y, Z itself. Several files share the finest scale.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Grid {
    pub scale: [f64; 3],
    pub origin: [f64; 3],
}

impl Grid {
    /// World coordinates of a grid position.
    pub fn world(&self, i: [i32; 3]) -> [f64; 3] {
        std::array::from_fn(|a| self.origin[a] + self.scale[a] * f64::from(i[a]))
    }

    /// World coordinates in (fractional) grid steps from the origin.
    pub fn steps(&self, world: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| (world[a] - self.origin[a]) / self.scale[a])
    }
}

/// An axis-aligned box in world coordinates.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Bounds {
    pub min: [f64; 3],
    pub max: [f64; 3],
}

impl Bounds {
    /// The smallest box around both.
    pub fn union(&self, other: &Bounds) -> Bounds {
        Bounds {
            min: std::array::from_fn(|a| self.min[a].min(other.min[a])),
            max: std::array::from_fn(|a| self.max[a].max(other.max[a])),
        }
    }

    pub fn center(&self) -> [f64; 3] {
        std::array::from_fn(|a| 0.5 * (self.min[a] + self.max[a]))
    }

    /// Length of the box's diagonal.
    pub fn diagonal(&self) -> f64 {
        (0..3).map(|a| (self.max[a] - self.min[a]).powi(2)).sum::<f64>().sqrt()
    }

    /// True if every number is finite and no side is turned inside out.
    pub fn is_sane(&self) -> bool {
        (0..3).all(|a| self.min[a].is_finite() && self.max[a].is_finite() && self.min[a] <= self.max[a])
    }
}

/// Points in columns, the unit that decoder threads send. All columns have the same length,
/// at most [`BATCH_POINTS`]; all points are of one file. The vectors are reused: [`PointBatch::clear`]
/// keeps their memory.
#[derive(Debug, Clone, Default)]
pub struct PointBatch {
    /// Index of the file in [`SceneFacts::files`].
    pub file: u32,
    /// Positions on the scene's [`Grid`].
    pub positions: Vec<[i32; 3]>,
    /// Red, green, blue, intensity as stored in the record; zero where the format has no such field, or
    /// where it was not read.
    pub colors: Vec<[u16; 4]>,
    /// Record number: counted through all files of the scene in order, from 0.
    pub records: Vec<u32>,
    /// Attributes that were asked for. Unlike the columns above, each of them may be empty.
    pub attributes: Box<Attributes>,
    /// What this batch says of its file's colours.
    pub stats: ColorStats,
}

impl PointBatch {
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Bytes in all columns.
    pub fn bytes(&self) -> u64 {
        let PointBatch { file: _, positions, colors, records, attributes, stats: _ } = self;
        let always = size_of_val(&positions[..]) + size_of_val(&colors[..]) + size_of_val(&records[..]);
        always as u64 + attributes.bytes()
    }

    /// Empties all columns and keeps their memory.
    pub fn clear(&mut self) {
        self.positions.clear();
        self.colors.clear();
        self.records.clear();
        self.attributes.clear();
        self.stats = ColorStats::default();
    }
}

/// Number of bins of [`ColorStats::intensity`].
pub const INTENSITY_BINS: usize = 256;

/// What the points so far say about how a file stores colour; merging is associative and commutative.
#[derive(Debug, Clone, PartialEq)]
pub struct ColorStats {
    /// Largest of all red, green and blue values.
    pub rgb_max: u16,
    /// Smallest and largest intensity; the first is the larger one where none was read.
    pub intensity_min: u16,
    pub intensity_max: u16,
    /// Sampled intensities, counted in logarithmic bins ([`intensity_bin`]).
    pub intensity: Box<[u32; INTENSITY_BINS]>,
    /// Range of the grid's third coordinate.
    pub z_min: i32,
    pub z_max: i32,
}

impl Default for ColorStats {
    fn default() -> Self {
        ColorStats {
            rgb_max: 0,
            intensity_min: u16::MAX,
            intensity_max: 0,
            intensity: Box::new([0; INTENSITY_BINS]),
            z_min: i32::MAX,
            z_max: i32::MIN,
        }
    }
}

impl ColorStats {
    pub fn merge(&mut self, other: &ColorStats) {
        self.rgb_max = self.rgb_max.max(other.rgb_max);
        self.intensity_min = self.intensity_min.min(other.intensity_min);
        self.intensity_max = self.intensity_max.max(other.intensity_max);
        for (a, b) in self.intensity.iter_mut().zip(other.intensity.iter()) {
            *a += b;
        }
        self.z_min = self.z_min.min(other.z_min);
        self.z_max = self.z_max.max(other.z_max);
    }

    /// How to colour the file, judged by all points so far: RGB if any channel of any point is not
    /// zero (8-bit if no value exceeds 255: a 16-bit scan that dark would be black), else intensity
    /// if any is not zero, else elevation.
    pub fn rule(&self) -> ColorRule {
        if self.rgb_max > 255 {
            ColorRule::Rgb16
        } else if self.rgb_max > 0 {
            ColorRule::Rgb8
        } else if self.intensity_max > 0 {
            // The 1st and 99th percentile: one retro-reflector must not turn the rest black.
            let total: u64 = self.intensity.iter().map(|&n| u64::from(n)).sum();
            let value_at = |rank: u64| {
                let mut seen = 0;
                self.intensity.iter().position(|&n| {
                    seen += u64::from(n);
                    seen > rank
                })
            };
            let low = value_at(total / 100).map_or(0, intensity_of_bin);
            let high = value_at(total - total.div_ceil(100).min(total)).map_or(self.intensity_max, intensity_of_bin);
            ColorRule::Intensity { low, high: high.max(low.saturating_add(1)) }
        } else {
            ColorRule::Elevation { low: self.z_min, high: self.z_max }
        }
    }
}

/// Where not all records are counted, one of so many in a row is.
pub const SAMPLED: u32 = 16;

/// The record that is counted of the `row`-th [`SAMPLED`] ones: any of them, by chance. Scans have patterns, such as
/// lines of equal length, of which every 16th record would be a few places only.
pub fn sample_of(row: u32) -> u32 {
    // Chris Wellons' lowbias32.
    let mixed = (row ^ row >> 16).wrapping_mul(0x7feb_352d);
    let mixed = (mixed ^ mixed >> 15).wrapping_mul(0x846c_a68b);
    row.wrapping_mul(SAMPLED).wrapping_add((mixed ^ mixed >> 16) % SAMPLED)
}

/// The bin that an intensity is counted in: exact below 32, then 16 bins per power of two.
pub fn intensity_bin(value: u16) -> usize {
    if value < 32 {
        return usize::from(value);
    }
    let exponent = value.ilog2() as usize; // 5..=15
    16 * (exponent - 3) + usize::from(value >> (exponent - 4)) - 16
}

/// The smallest intensity of a bin; the inverse of [`intensity_bin`].
pub fn intensity_of_bin(bin: usize) -> u16 {
    if bin < 32 {
        return bin as u16;
    }
    let exponent = bin / 16 + 3;
    ((16 + bin % 16) << (exponent - 4)) as u16
}

/// The largest intensity of a bin.
pub fn last_of_bin(bin: usize) -> u16 {
    if bin + 1 < INTENSITY_BINS { intensity_of_bin(bin + 1).wrapping_sub(1) } else { u16::MAX }
}

/// How a file's points get their colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ColorRule {
    /// 16-bit RGB, shown by its upper eight bits.
    Rgb16,
    /// 8-bit values in the 16-bit fields.
    Rgb8,
    /// Grey, `low` darkest, `high` white.
    Intensity { low: u16, high: u16 },
    /// A colour ramp over the grid's third coordinate.
    Elevation { low: i32, high: i32 },
}

/// What is known of a scene before its first point: everything the camera and the store need.
#[derive(Debug, Clone)]
pub struct SceneFacts {
    pub grid: Grid,
    /// Union of the headers' boxes. Only a promise: points may lie outside.
    pub bounds: Bounds,
    pub files: Vec<FileFacts>,
    /// What is odd about the files together, one line each.
    pub warnings: Vec<String>,
}

impl SceneFacts {
    /// Sum of the points that the headers promise.
    pub fn points_in_header(&self) -> u64 {
        self.files.iter().map(|f| f.points_in_header).sum()
    }
}

/// What the header of one file says, as far as rooms beyond `source` need it.
#[derive(Debug, Clone, Default)]
pub struct FileFacts {
    pub path: PathBuf,
    /// Record number, in the scene, of the file's first point.
    pub first_record: u32,
    pub points_in_header: u64,
    pub bounds: Bounds,
    /// e.g. "LAZ 1.4, format 7".
    pub kind: String,
    /// Its coordinate system in few words: names and EPSG codes. `None` if the file does not say.
    pub crs: Option<String>,
    /// Length of the unit of its coordinates, metres, if the file says so.
    pub metres_per_unit: Option<f64>,
    /// The coordinates are longitudes and latitudes: differences of them are no lengths.
    pub is_geographic: bool,
    pub record: RecordFacts,
}

/// How to understand the [`Attributes`] of a file's points.
#[derive(Debug, Clone, Default)]
pub struct RecordFacts {
    /// Point record format, 0 to 10.
    pub format: u8,
    /// Degrees per step of the scan angle: 1 in formats 0 to 5, 0.006 in 6 to 10.
    pub scan_angle_step: f64,
    /// What GPS times count.
    pub gps_clock: GpsClock,
    /// The points' intensities are read; else they are zero.
    pub has_intensities: bool,
    /// Extra bytes per point.
    pub extra_bytes: usize,
    /// What they mean, as far as the file says.
    pub extra_dimensions: Vec<ExtraDimension>,
    /// Bytes of a batch's columns per point, with the attributes that were asked for.
    pub bytes_per_point: usize,
}

impl RecordFacts {
    /// The extra dimension of this name and which of its elements: `Normal` is the first of three, as `Normal[0]` is,
    /// `Normal[1]` the second. `None` if there is none with values: bytes without a meaning have none.
    pub fn extra(&self, name: &str) -> Option<(&ExtraDimension, usize)> {
        let find = |name: &str, element| {
            let of_name = |d: &&ExtraDimension| d.name == name && !matches!(d.kind, ExtraKind::Bytes(_));
            self.extra_dimensions.iter().find(of_name).filter(|d| element < d.elements).map(|d| (d, element))
        };
        // A dimension may be called so itself.
        find(name, 0).or_else(|| {
            let (name, element) = name.strip_suffix(']')?.rsplit_once('[')?;
            find(name, element.parse().ok()?)
        })
    }

    /// The names that [`RecordFacts::extra`] knows, one for each element.
    pub fn extra_names(&self) -> impl Iterator<Item = String> {
        let with_values = self.extra_dimensions.iter().filter(|d| self.extra(&d.name).is_some());
        with_values.flat_map(|d| {
            (0..d.elements).map(|element| if element == 0 { d.name.clone() } else { format!("{}[{element}]", d.name) })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intensity_bins_are_monotone_and_invertible() {
        let mut last = 0;
        for value in 0..=u16::MAX {
            let bin = intensity_bin(value);
            assert!(bin == last || bin == last + 1, "value {value}: bin {bin} after {last}");
            assert!(intensity_of_bin(bin) <= value);
            assert_eq!(intensity_bin(intensity_of_bin(bin)), bin);
            assert!(value <= last_of_bin(bin) && intensity_bin(last_of_bin(bin)) == bin);
            last = bin;
        }
        assert!(last < INTENSITY_BINS);
    }

    #[test]
    fn samples_see_every_place_of_a_line() {
        for line in [16, 64, 1424, 4096] {
            let mut seen = vec![0; line as usize];
            for row in 0..100 * line / SAMPLED {
                let record = sample_of(row);
                assert_eq!(record / SAMPLED, row);
                seen[(record % line) as usize] += 1;
            }
            // Of 100 lines a sixteenth: 6.25 at each place.
            let (least, most) = (*seen.iter().min().unwrap(), *seen.iter().max().unwrap());
            assert!(most < 25 && seen.iter().filter(|&&n| n == 0).count() * 100 <= 2 * line as usize, "{least} {most}");
        }
    }

    fn stats(rgb_max: u16, intensities: &[u16]) -> ColorStats {
        let mut stats = ColorStats { rgb_max, ..Default::default() };
        for &i in intensities {
            stats.intensity[intensity_bin(i)] += 1;
            stats.intensity_max = stats.intensity_max.max(i);
        }
        stats
    }

    #[test]
    fn rule_follows_what_was_seen() {
        assert_eq!(stats(255, &[]).rule(), ColorRule::Rgb8);
        assert_eq!(stats(3000, &[]).rule(), ColorRule::Rgb16, "a dark 16-bit scan stays dark");
        assert!(matches!(stats(0, &[0, 7]).rule(), ColorRule::Intensity { .. }));
        assert!(matches!(stats(0, &[0]).rule(), ColorRule::Elevation { .. }));
        let mut early = stats(200, &[]);
        early.merge(&stats(60000, &[]));
        assert_eq!(early.rule(), ColorRule::Rgb16, "later points overturn an early guess");
    }

    #[test]
    fn one_bright_return_does_not_set_the_range() {
        let mut values = vec![10; 5_000];
        values.extend(vec![20; 5_000]);
        values.push(60_000);
        assert_eq!(stats(0, &values).rule(), ColorRule::Intensity { low: 10, high: 20 });
    }
}
