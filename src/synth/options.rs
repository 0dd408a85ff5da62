//! What to make, which combinations are valid, and what can go wrong.

use std::path::PathBuf;

use crate::scene::Grid;

/// What a scan shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Scene {
    /// Airborne scan lines over terrain, a river, streets, buildings, trees; from 48 m square for a
    /// few points to 2,048 m square, at 8 points per square metre, for 34 million; denser above.
    Town,
    /// Twelve stacked horizontal squares of known spacing, for depth tests.
    Planes,
}

/// A scan to be made. The same options give the same points on every platform.
#[derive(Debug, Clone, PartialEq)]
pub struct SynthOptions {
    pub scene: Scene,
    /// Exactly this many points come out.
    pub points: u64,
    pub seed: u64,
    /// Point record format: 0–3 or 6–8.
    pub point_format: u8,
    /// LAS version, major and minor: 1.0–1.4.
    pub las_version: (u8, u8),
    /// Grid step in metres, the header's scale on all axes.
    pub scale: f64,
    /// Where the scene's (0, 0, 0) lies in the file's coordinate system, in metres.
    pub origin: [f64; 3],
    /// The header's offset, in metres; by default the origin. With another offset the same scene has
    /// other record integers: `[0.0; 3]` puts the whole shift into the records.
    pub offset: Option<[f64; 3]>,
}

impl SynthOptions {
    /// 1,000,000 points of a scene, seed 1, as LAS 1.4 format 7, in steps of 1 mm, at 500 km east,
    /// 5,000 km north of UTM zone 32's origin.
    pub fn new(scene: Scene) -> SynthOptions {
        SynthOptions {
            scene,
            points: 1_000_000,
            seed: 1,
            point_format: 7,
            las_version: (1, 4),
            scale: 0.001,
            origin: [500_000.0, 5_000_000.0, 0.0],
            offset: None,
        }
    }

    /// The grid that record integers lie on.
    pub fn grid(&self) -> Grid {
        Grid { scale: [self.scale; 3], origin: self.offset.unwrap_or(self.origin) }
    }

    /// The point format that fits a LAS version best: 7, 3 or 1.
    pub fn default_format(version: (u8, u8)) -> u8 {
        match version {
            (1, 4) => 7,
            (1, 2 | 3) => 3,
            _ => 1,
        }
    }

    /// The LAS version that fits a point format best: 1.4 or 1.2.
    pub fn default_version(format: u8) -> (u8, u8) {
        if format >= 6 { (1, 4) } else { (1, 2) }
    }

    /// Says whether a file of these options can exist.
    ///
    /// # Errors
    /// [`SynthError::Format`], [`SynthError::Version`], [`SynthError::FormatNeedsVersion`],
    /// [`SynthError::TooManyPoints`] and [`SynthError::Scale`].
    pub fn check(&self) -> Result<(), SynthError> {
        let (format, version) = (self.point_format, self.las_version);
        let needed = match format {
            0 | 1 => (1, 0),
            2 | 3 => (1, 2),
            6..=8 => (1, 4),
            _ => return Err(SynthError::Format(format)),
        };
        if version.0 != 1 || version.1 > 4 {
            return Err(SynthError::Version(version.0, version.1));
        }
        if version < needed {
            return Err(SynthError::FormatNeedsVersion { format, needed: needed.1, found: version.1 });
        }
        if version < (1, 4) && self.points > u64::from(u32::MAX) {
            return Err(SynthError::TooManyPoints { points: self.points, minor: version.1 });
        }
        if !(self.scale.is_finite() && self.scale > 0.0) {
            return Err(SynthError::Scale(self.scale));
        }
        Ok(())
    }
}

/// Why a scan could not be made.
#[derive(Debug, thiserror::Error)]
pub enum SynthError {
    #[error("point format {0} cannot be made: expected 0, 1, 2, 3, 6, 7 or 8{hint}", hint = waveform_hint(*.0))]
    Format(u8),
    #[error("LAS version {0}.{1} cannot be made: expected 1.0, 1.1, 1.2, 1.3 or 1.4")]
    Version(u8, u8),
    #[error(
        "point format {format} needs LAS 1.{needed} or later, found 1.{found}: raise --las-version or choose another --point-format"
    )]
    FormatNeedsVersion { format: u8, needed: u8, found: u8 },
    #[error("{points} points do not fit LAS 1.{minor}, which counts to 4,294,967,295: use --las-version 1.4")]
    TooManyPoints { points: u64, minor: u8 },
    #[error("scale {0} is no grid step: expected a number of metres above zero, such as 0.001")]
    Scale(f64),
    #[error(
        "the {axis} coordinates, {low} to {high} m from the offset, do not fit 32-bit integers in steps of {scale} m: use a coarser --scale or an --offset near the --origin"
    )]
    Range { axis: char, low: f64, high: f64, scale: f64 },
    #[error("{}: expected a name that ends in .las or .laz", path.display())]
    Extension { path: PathBuf },
    #[error("{}: {action}: {source}", path.display())]
    Io { path: PathBuf, action: &'static str, source: std::io::Error },
    #[error("{}: compressing chunk {chunk}: {source}", path.display())]
    Compress { path: PathBuf, chunk: u64, source: laz::LasZipError },
}

fn waveform_hint(format: u8) -> &'static str {
    if matches!(format, 4 | 5 | 9 | 10) { " (4, 5, 9 and 10 hold waveforms)" } else { "" }
}
