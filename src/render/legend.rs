//! What the colours of a picture mean.

use serde::Serialize;

use super::{
    coloring::{ColorBy, Coloring},
    scale::Scale,
};
use crate::scene::{Attribute, GpsClock, SceneFacts, Unit};

/// What the colours of a picture mean, to be drawn beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct Legend {
    /// What the points are coloured by, and its unit.
    pub title: String,
    pub key: LegendKey,
}

#[derive(Debug, Clone, PartialEq)]
pub enum LegendKey {
    /// Colours in order, low to high, and what values some of them have.
    Scale { colors: Vec<[u8; 3]>, scale: Scale, ticks: Vec<Tick> },
    /// A colour for each value that there is, in the order of the values.
    Classes(Vec<LegendClass>),
}

/// A value at its place on a scale.
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// 0 at the first colour, 1 at the last.
    pub place: f64,
    pub value: f64,
    pub text: String,
}

/// One of the values that are told apart.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LegendClass {
    pub value: u16,
    pub name: String,
    pub color: [u8; 3],
    /// Points that have it, so far.
    pub points: u64,
}

/// About so many ticks.
const TICKS: f64 = 5.0;

/// What an attribute is called in a legend, with its unit.
pub fn title(attribute: &Attribute, scene: &SceneFacts) -> String {
    match attribute {
        // Heights above longitudes and latitudes are not in degrees.
        Attribute::Elevation => match Unit::of(scene).symbol().filter(|_| Unit::of(scene) != Unit::Degree) {
            Some(unit) => format!("elevation, {unit}"),
            None => "elevation".into(),
        },
        Attribute::ScanAngle => "scan angle, °".into(),
        Attribute::GpsTime => format!("GPS time, {}", clock(scene).map_or("of several clocks", GpsClock::name)),
        Attribute::Extra(name) => name.clone(),
        named => named.to_string().replace('-', " "),
    }
}

/// The clock of all files that have GPS times, if it is one.
fn clock(scene: &SceneFacts) -> Option<GpsClock> {
    let mut clocks = scene.files.iter().filter(|f| Attribute::GpsTime.is_in(f)).map(|f| f.record.gps_clock);
    let first = clocks.next()?;
    clocks.all(|clock| clock == first).then_some(first)
}

/// A value as a legend or a histogram shows it: with as many decimals as tell it from one that is `step` away.
pub fn value_text(attribute: &Attribute, value: f64, step: f64, scene: &SceneFacts) -> String {
    let dated = || (*attribute == Attribute::GpsTime).then(|| clock(scene)?.text(value)).flatten();
    dated().unwrap_or_else(|| {
        // Of a step that rounding has left just below a power of ten, as many as of that power.
        let decimals = (-(step * 1.001).log10().floor()).clamp(0.0, 9.0) as usize;
        format!("{value:.decimals$}")
    })
}

/// Round values on a scale: multiples of 1, 2 or 5 times a power of ten.
pub fn ticks(attribute: &Attribute, scale: &Scale, scene: &SceneFacts) -> Vec<Tick> {
    let tick = |value: f64, step: f64| Tick {
        place: scale.place(value),
        value,
        text: value_text(attribute, value, step, scene),
    };
    let span = scale.high - scale.low;
    if !(span > 0.0 && span.is_finite()) {
        return vec![tick(scale.low, 0.01)];
    }
    let rough = span / TICKS;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|n| n * power).find(|&step| step >= rough).unwrap_or(power);
    // Steps too small for the digits of an f64 would never end.
    let first = (scale.low / step).ceil();
    let count = ((scale.high / step).floor() - first).clamp(0.0, 2.0 * TICKS) as u32 + 1;
    (0..count).map(|n| tick((first + f64::from(n)) * step, step)).filter(|tick| tick.value <= scale.high).collect()
}

/// The values that there are, with their colours.
pub fn classes(
    coloring: &Coloring,
    attribute: &Attribute,
    counts: &[(u16, u64)],
    color: impl Fn(u16) -> [u8; 3],
    scene: &SceneFacts,
) -> Vec<LegendClass> {
    let name = |value: u16| match attribute {
        Attribute::Classification => coloring.classes.get(value as u8).name.into_owned(),
        Attribute::File => scene.files.get(usize::from(value)).map_or_else(String::new, |file| {
            file.path.file_name().unwrap_or(file.path.as_os_str()).to_string_lossy().into_owned()
        }),
        Attribute::LastReturn => if value == 1 { "last" } else { "not last" }.into(),
        _ => value.to_string(),
    };
    let class = |&(value, points): &(u16, u64)| LegendClass { value, name: name(value), color: color(value), points };
    counts.iter().map(class).collect()
}

/// The attribute that the colours of these settings mean, if they mean one.
pub fn subject(coloring: &Coloring) -> Option<&Attribute> {
    match &coloring.by {
        ColorBy::Auto | ColorBy::Rgb => None,
        ColorBy::Attribute(attribute) => Some(attribute),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        render::Transfer,
        scene::{Bounds, FileFacts, Grid, RecordFacts},
    };

    fn scene(gps_clock: GpsClock) -> SceneFacts {
        let record = RecordFacts { format: 7, gps_clock, ..Default::default() };
        let files = vec![FileFacts { record, ..Default::default() }];
        SceneFacts {
            grid: Grid { scale: [1.0; 3], origin: [0.0; 3] },
            bounds: Bounds::default(),
            files,
            warnings: vec![],
        }
    }

    fn texts(attribute: &Attribute, low: f64, high: f64) -> Vec<String> {
        let scale = Scale { low, high, transfer: Transfer::Linear };
        let scene = scene(GpsClock::ADJUSTED);
        ticks(attribute, &scale, &scene).into_iter().map(|tick| tick.text).collect()
    }

    #[test]
    fn ticks_are_round_and_within_the_range() {
        assert_eq!(texts(&Attribute::Elevation, 406.26, 615.5), ["450", "500", "550", "600"]);
        assert_eq!(texts(&Attribute::ScanAngle, -0.12, 0.12), ["-0.10", "-0.05", "0.00", "0.05", "0.10"]);
        assert_eq!(texts(&Attribute::UserData, 3.0, 3.0), ["3.00"]);
        assert_eq!(texts(&Attribute::UserData, 0.0, 255.0), ["0", "100", "200"]);
        assert_eq!(texts(&Attribute::GpsTime, 100.0, 110.0)[0], "2011-09-14 01:48:05 UTC");
        for (low, high) in [(1e9, 1e9 + 1e-6), (-1e300, 1e300), (0.0, 5e-324), (f64::MIN, f64::MAX)] {
            assert!(texts(&Attribute::Elevation, low, high).len() < 20, "{low} {high}");
        }
    }

    #[test]
    fn titles_say_the_unit() {
        assert_eq!(title(&Attribute::GpsTime, &scene(GpsClock::Week)), "GPS time, of the week");
        assert_eq!(title(&Attribute::NumberOfReturns, &scene(GpsClock::Week)), "number of returns");
        let mut foot = scene(GpsClock::Week);
        assert_eq!(title(&Attribute::Elevation, &foot), "elevation", "no file says");
        foot.files[0].metres_per_unit = Some(1200.0 / 3937.0);
        assert_eq!(title(&Attribute::Elevation, &foot), "elevation, ftUS");
        foot.files[0].is_geographic = true;
        assert_eq!(title(&Attribute::Elevation, &foot), "elevation");
        let mut two = scene(GpsClock::Week);
        two.files.extend(scene(GpsClock::ADJUSTED).files);
        assert_eq!(title(&Attribute::GpsTime, &two), "GPS time, of several clocks");
        assert_eq!(value_text(&Attribute::GpsTime, 302.5, 1.0, &two), "302", "no clock tells what it means");
    }
}
