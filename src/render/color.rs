//! Attributes to colour: per file a rule, shared with the resolve kernel.

use super::{
    column::ColumnColors,
    scale::{grid_key, level},
};
use crate::scene::ColorRule;

/// The colour of points that do not have what they are to be coloured by. `shaders/color.wgsl` has the same.
pub const NO_DATA: [u8; 3] = [110, 110, 110];

/// A file's colour rule. Layout shared with `shaders/color.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct FileColor {
    /// Record number of the file's first point.
    pub first_record: u32,
    /// 0: 16-bit RGB, 1: 8-bit RGB, 2: intensity as grey, 3: elevation; 4, 5, 6: as 0, 1, 2 with the scale's
    /// thresholds for a tone; 7, 8: intensity and elevation by the scale; 9: `low` is the colour.
    pub kind: u32,
    /// Range that is shown: of the intensity, or of the grid's third coordinate (as i32).
    pub low: u32,
    pub high: u32,
}

/// All colours of a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PointColors {
    /// Colour rule of each file, in order of their first records.
    pub files: Vec<FileColor>,
    /// The tone's, or the scale's of intensity or elevation, where a rule asks for them.
    pub thresholds: [u32; 256],
    /// Red, green, blue, 255; of elevation and the scale.
    pub ramp: [[u8; 4]; 256],
    /// The colours are those of a column of values instead.
    pub column: Option<ColumnColors>,
}

impl From<Vec<FileColor>> for PointColors {
    fn from(files: Vec<FileColor>) -> PointColors {
        PointColors { files, thresholds: [u32::MAX; 256], ramp: elevation_ramp(), column: None }
    }
}

impl PointColors {
    /// Red, green, blue of a point with these values, by its file's rule.
    pub fn color(&self, record: u32, attributes: [u16; 4], z: i32) -> [u8; 3] {
        self.file_of(record).color_by(attributes, z, &self.ramp, &self.thresholds)
    }

    /// The file that a record is of: the last that begins at or before it.
    fn file_of(&self, record: u32) -> &FileColor {
        &self.files[self.files.partition_point(|file| file.first_record <= record).max(1) - 1]
    }
}

impl FileColor {
    /// The same colour for all points of a file.
    pub fn constant(first_record: u32, [r, g, b]: [u8; 3]) -> FileColor {
        FileColor { first_record, kind: 9, low: u32::from_le_bytes([r, g, b, 0]), high: 0 }
    }

    /// What [`FileColor::constant`] was made of.
    pub fn constant_color(&self) -> [u8; 3] {
        let [r, g, b, _] = self.low.to_le_bytes();
        [r, g, b]
    }

    /// Intensity by the scale of [`PointColors`].
    pub fn intensity(first_record: u32) -> FileColor {
        FileColor { first_record, kind: 7, low: 0, high: 0 }
    }

    /// Elevation by the scale of [`PointColors`].
    pub fn elevation(first_record: u32) -> FileColor {
        FileColor { first_record, kind: 8, low: 0, high: 0 }
    }

    /// With the tone that the thresholds of [`PointColors`] are of. Elevation has none but in its ramp.
    pub fn toned(self) -> FileColor {
        FileColor { kind: if self.kind < 3 { self.kind + 4 } else { self.kind }, ..self }
    }

    pub fn new(first_record: u32, rule: ColorRule) -> FileColor {
        let (kind, low, high) = match rule {
            ColorRule::Rgb16 => (0, 0, 0),
            ColorRule::Rgb8 => (1, 0, 0),
            ColorRule::Intensity { low, high } => (2, low.into(), high.into()),
            ColorRule::Elevation { low, high } => (3, low.cast_unsigned(), high.cast_unsigned()),
        };
        FileColor { first_record, kind, low, high }
    }

    /// Red, green, blue of a point with these attributes, by a rule that needs no thresholds. `ramp` is
    /// [`elevation_ramp`].
    pub fn color(&self, attributes: [u16; 4], z: i32, ramp: &[[u8; 4]; 256]) -> [u8; 3] {
        self.color_by(attributes, z, ramp, &[u32::MAX; 256])
    }

    /// Twin of `point_color` in `shaders/color.wgsl`.
    fn color_by(&self, attributes: [u16; 4], z: i32, ramp: &[[u8; 4]; 256], thresholds: &[u32; 256]) -> [u8; 3] {
        let [r, g, b, intensity] = attributes;
        let rgb = [r, g, b];
        let toned = |value: u32| level(thresholds, value) as u8;
        let grey = || grey(u32::from(intensity).saturating_sub(self.low), self.high - self.low);
        let of_ramp = |at: usize| [ramp[at][0], ramp[at][1], ramp[at][2]];
        match self.kind {
            0 => rgb.map(|c| (c >> 8) as u8),
            1 => rgb.map(|c| (c & 255) as u8),
            2 => [grey(); 3],
            4 => rgb.map(|c| toned(c.into())),
            5 => rgb.map(|c| toned(u32::from(c & 255) * 257)),
            6 => [toned(u32::from(grey()) * 257); 3],
            7 => of_ramp(level(thresholds, u32::from(intensity) + 1)),
            8 => of_ramp(level(thresholds, grid_key(z))),
            9 => self.constant_color(),
            _ => {
                let (low, high) = (self.low.cast_signed(), self.high.cast_signed());
                let above = z.max(low).wrapping_sub(low).cast_unsigned();
                of_ramp(share(above, high.wrapping_sub(low).cast_unsigned()).into())
            }
        }
    }
}

/// `above / range` as a grey. The root makes equal steps of reflectance look equal on a display, and
/// the darkest points are still lighter than the background.
fn grey(above: u32, range: u32) -> u8 {
    let share = if range == 0 { 0.0 } else { (above as f32 / range as f32).min(1.0) };
    (share.sqrt() * 223.0 + 32.5) as u8
}

/// `above / range` as 0 to 255; 0 for an empty range.
fn share(above: u32, range: u32) -> u8 {
    if range == 0 {
        return 0;
    }
    ((above as f32 / range as f32).min(1.0) * 255.0 + 0.5) as u8
}

/// Colours for elevation, low to high: viridis (Smith & van der Walt 2015) through nine of its
/// colours, even in lightness and readable by the colour-blind. Red, green, blue, 255.
pub fn elevation_ramp() -> [[u8; 4]; 256] {
    const STOPS: [[f32; 3]; 9] = [
        [68.0, 1.0, 84.0],
        [71.0, 44.0, 122.0],
        [59.0, 81.0, 139.0],
        [44.0, 113.0, 142.0],
        [33.0, 144.0, 141.0],
        [39.0, 173.0, 129.0],
        [92.0, 200.0, 99.0],
        [170.0, 220.0, 50.0],
        [253.0, 231.0, 37.0],
    ];
    std::array::from_fn(|i| {
        let at = i as f32 / 255.0 * (STOPS.len() - 1) as f32;
        let stop = (at as usize).min(STOPS.len() - 2);
        let t = at - stop as f32;
        let channel = |c: usize| (STOPS[stop][c] * (1.0 - t) + STOPS[stop + 1][c] * t).round() as u8;
        [channel(0), channel(1), channel(2), 255]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_rule_colours_as_it_says() {
        let ramp = elevation_ramp();
        let color = |rule, attributes, z| FileColor::new(0, rule).color(attributes, z, &ramp);
        assert_eq!(color(ColorRule::Rgb16, [0x1234, 0xff00, 0, 9], 0), [0x12, 0xff, 0]);
        assert_eq!(color(ColorRule::Rgb8, [0x34, 0xff, 0, 9], 0), [0x34, 0xff, 0]);
        let grey = ColorRule::Intensity { low: 100, high: 300 };
        assert_eq!(color(grey, [0, 0, 0, 50], 0), [32; 3]);
        assert_eq!(color(grey, [0, 0, 0, 150], 0), [144; 3], "a quarter of the range, half the way");
        assert_eq!(color(grey, [0, 0, 0, 9999], 0), [255; 3]);
        let height = ColorRule::Elevation { low: i32::MIN, high: i32::MAX };
        assert_eq!(color(height, [0; 4], i32::MIN), [68, 1, 84]);
        assert_eq!(color(height, [0; 4], i32::MAX), [253, 231, 37]);
        assert_eq!(color(ColorRule::Elevation { low: 5, high: 5 }, [0; 4], 5), [68, 1, 84]);
    }
}
