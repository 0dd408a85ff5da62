//! The values of points by the definition, for the tests of colours and filters.

use firstlight::scene::{Attribute, Decimal, ExtraKind, FileFacts, Grid, Number, PointBatch, Scaled};

/// The value of point `i` of a batch, which is of `file`. `None` if it is no number, or if the file marks it as no data.
pub fn value(attribute: &Attribute, batch: &PointBatch, i: usize, file: &FileFacts, grid: &Grid) -> Option<f64> {
    let a = &batch.attributes;
    Some(match attribute {
        Attribute::Intensity => batch.colors[i][3].into(),
        Attribute::Elevation => grid.world(batch.positions[i])[2],
        Attribute::Classification => a.classification[i].into(),
        Attribute::ReturnNumber => (a.returns[i] & 15).into(),
        Attribute::NumberOfReturns => (a.returns[i] >> 4).into(),
        Attribute::LastReturn => u8::from(a.returns[i] & 15 == a.returns[i] >> 4).into(),
        Attribute::PointSource => a.point_source[i].into(),
        Attribute::UserData => a.user_data[i].into(),
        Attribute::ScanAngle => f64::from(a.scan_angle[i]) * file.record.scan_angle_step,
        Attribute::GpsTime => a.gps_time.get(i).copied().filter(|v| !v.is_nan())?,
        Attribute::File => batch.file.into(),
        Attribute::Extra(name) => {
            let dimension = file.record.extra_dimensions.iter().find(|d| d.name == *name)?;
            dimension.value(a.extra_of(i, file.record.extra_bytes)).filter(|v| !v.is_nan())?
        }
    })
}

/// The same in the digits that a card of the point shows.
pub fn digits(attribute: &Attribute, batch: &PointBatch, i: usize, file: &FileFacts, grid: &Grid) -> Option<Decimal> {
    let value = value(attribute, batch, i, file, grid)?;
    match attribute {
        Attribute::ScanAngle => {
            Some(Scaled::new(file.record.scan_angle_step, 0.0)?.exact(batch.attributes.scan_angle[i].into()))
        }
        Attribute::Elevation => Some(Scaled::new(grid.scale[2], grid.origin[2])?.exact(batch.positions[i][2].into())),
        Attribute::Extra(name) => {
            let dimension = file.record.extra_dimensions.iter().find(|d| d.name == *name)?;
            let of = |values: &Option<Vec<f64>>, default| values.as_ref().map_or(default, |values| values[0]);
            let scaled = Scaled::new(of(&dimension.scale, 1.0), of(&dimension.offset, 0.0))?;
            match dimension.number(batch.attributes.extra_of(i, file.record.extra_bytes), 0)? {
                Number::Signed(n) => Some(scaled.exact(n.into())),
                Number::Unsigned(n) => Some(scaled.exact(n.into())),
                Number::Float(n) if dimension.kind == ExtraKind::F32 => Decimal::from_f32(n as f32),
                Number::Float(n) => Decimal::from_f64(n),
            }
        }
        _ => Decimal::from_f64(value),
    }
}
