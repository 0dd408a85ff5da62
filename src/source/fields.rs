//! Which fields of a point record are wanted.

use crate::scene::Attribute;

/// Fields of a point record besides its position, which is always read. Layered LAZ (formats 6 and up)
/// decodes the layers of these fields alone; everything else costs what it costs, wanted or not.
///
/// Return number, number of returns and scanner channel come with the position in every format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fields {
    pub rgb: bool,
    pub nir: bool,
    pub intensity: bool,
    /// Return number, number of returns, and the flags beside them (synthetic, key-point, withheld,
    /// overlap, scan direction, edge of flight line, scanner channel).
    pub returns: bool,
    pub classification: bool,
    pub scan_angle: bool,
    pub user_data: bool,
    pub point_source: bool,
    pub gps_time: bool,
    pub wave_packet: bool,
    pub extra_bytes: bool,
}

impl Fields {
    /// Positions alone.
    pub const NONE: Fields = Fields {
        rgb: false,
        nir: false,
        intensity: false,
        returns: false,
        classification: false,
        scan_angle: false,
        user_data: false,
        point_source: false,
        gps_time: false,
        wave_packet: false,
        extra_bytes: false,
    };

    pub const ALL: Fields = Fields {
        rgb: true,
        nir: true,
        intensity: true,
        returns: true,
        classification: true,
        scan_angle: true,
        user_data: true,
        point_source: true,
        gps_time: true,
        wave_packet: true,
        extra_bytes: true,
    };

    /// What the automatic colour rule looks at.
    pub const COLORS: Fields = Fields { rgb: true, intensity: true, ..Fields::NONE };
}

impl Fields {
    /// What is read to know these attributes of all points.
    pub fn of<'a>(attributes: impl IntoIterator<Item = &'a Attribute>) -> Fields {
        attributes.into_iter().fold(Fields::NONE, |mut fields, attribute| {
            match attribute {
                Attribute::Intensity => fields.intensity = true,
                Attribute::Classification => fields.classification = true,
                Attribute::ReturnNumber | Attribute::NumberOfReturns | Attribute::LastReturn => fields.returns = true,
                Attribute::PointSource => fields.point_source = true,
                Attribute::UserData => fields.user_data = true,
                Attribute::ScanAngle => fields.scan_angle = true,
                Attribute::GpsTime => fields.gps_time = true,
                Attribute::Extra(_) => fields.extra_bytes = true,
                Attribute::Elevation | Attribute::File => {}
            }
            fields
        })
    }

    /// All fields that either has.
    pub fn union(self, other: Fields) -> Fields {
        Fields {
            rgb: self.rgb || other.rgb,
            nir: self.nir || other.nir,
            intensity: self.intensity || other.intensity,
            returns: self.returns || other.returns,
            classification: self.classification || other.classification,
            scan_angle: self.scan_angle || other.scan_angle,
            user_data: self.user_data || other.user_data,
            point_source: self.point_source || other.point_source,
            gps_time: self.gps_time || other.gps_time,
            wave_packet: self.wave_packet || other.wave_packet,
            extra_bytes: self.extra_bytes || other.extra_bytes,
        }
    }
}

impl Default for Fields {
    fn default() -> Self {
        Fields::COLORS
    }
}
