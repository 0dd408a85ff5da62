//! Values as users type them.

use std::{error::Error, ffi::OsStr, marker::PhantomData, ops::RangeInclusive, str::FromStr};

use clap::{
    Arg, Command, ValueEnum,
    builder::{PossibleValue, TypedValueParser},
};

use crate::{
    device::Raster,
    headless::Stop,
    methods,
    render::{Candidate, GROUP_SIZES, RasterChoice},
    store::{Encoding, MAX_INSERTION_POINTS},
    synth::{Scene, SynthOptions},
};

/// How the store holds positions, on the command line.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum EncodingChoice {
    /// 8 bytes where the box that the header promises fits, else 12
    #[default]
    Auto,
    /// 12 bytes: three 32-bit integers
    Wide,
    /// 8 bytes, lossless; only where the box that the header promises fits 64 bits
    Packed,
}

impl EncodingChoice {
    /// `None`: as is best.
    pub fn encoding(self) -> Option<Encoding> {
        match self {
            EncodingChoice::Auto => None,
            EncodingChoice::Wide => Some(Encoding::Wide),
            EncodingChoice::Packed => Some(Encoding::Packed),
        }
    }
}

/// Reads a value by its `FromStr`, and names some for completions, which would offer files otherwise. Unlike with
/// clap's own list of values, there may be others (`extra:NAME`), and the message is that of `FromStr`.
#[derive(Debug, Clone)]
pub struct Named<T> {
    names: fn() -> Vec<&'static str>,
    read: PhantomData<T>,
}

pub fn named<T>(names: fn() -> Vec<&'static str>) -> Named<T> {
    Named { names, read: PhantomData }
}

impl<T> TypedValueParser for Named<T>
where
    T: FromStr<Err: Into<Box<dyn Error + Send + Sync>>> + Clone + Send + Sync + 'static,
{
    type Value = T;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<T, clap::Error> {
        T::from_str.parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue>>> {
        Some(Box::new((self.names)().into_iter().map(PossibleValue::new)))
    }
}

/// The number of a record, or `1200..1205`, both of which belong to it.
pub fn parse_records(text: &str) -> Result<RangeInclusive<u64>, String> {
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    match [first, last].map(|n| n.trim().parse::<u64>()) {
        [Ok(first), Ok(last)] if first <= last => Ok(first..=last),
        _ => Err(format!(
            "expected the number of a record, such as 1200, or FIRST..LAST, such as 1200..1205, found `{text}`"
        )),
    }
}

/// A number of points: `1500`, `1_500`, `1.5k`, `20M`, `1G`.
pub fn parse_count(text: &str) -> Result<u64, String> {
    let wrong = || format!("expected a number such as 250000, 250k or 1.5M, found `{text}`");
    let plain = text.replace('_', "");
    let (digits, exponent) = match plain.char_indices().last() {
        Some((at, 'k' | 'K')) => (&plain[..at], 3),
        Some((at, 'm' | 'M')) => (&plain[..at], 6),
        Some((at, 'g' | 'G' | 'b' | 'B')) => (&plain[..at], 9),
        _ => (&plain[..], 0),
    };
    // Digit by digit: a detour through f64 would round large numbers.
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let fraction = fraction.trim_end_matches('0');
    if whole.is_empty()
        || fraction.len() > exponent
        || !(whole.bytes().chain(fraction.bytes())).all(|b| b.is_ascii_digit())
    {
        return Err(wrong());
    }
    let zeros = "0".repeat(exponent - fraction.len());
    format!("{whole}{fraction}{zeros}").parse().map_err(|_| format!("`{text}` is more than 64 bits hold"))
}

/// As [`parse_count`], at least 1 and at most the 32 bits that slots have.
pub fn parse_points(text: &str) -> Result<u32, String> {
    match parse_count(text)? {
        0 => Err("expected at least 1".into()),
        n => u32::try_from(n).map_err(|_| format!("expected at most {}, found `{text}`", u32::MAX)),
    }
}

/// A frame time in milliseconds, above zero.
pub fn parse_millis(text: &str) -> Result<f64, String> {
    let wrong = || format!("expected milliseconds above 0, such as 16, found `{text}`");
    text.parse().ok().filter(|ms: &f64| ms.is_finite() && *ms > 0.0).ok_or_else(wrong)
}

/// `town` or `town:16M`: a synthetic scene and its number of points.
pub fn parse_synth(text: &str) -> Result<SynthOptions, String> {
    let (scene, points) = text.split_once(':').unwrap_or((text, "1M"));
    let scene = Scene::from_str(scene, true).map_err(|_| format!("expected town:N or planes:N, found `{text}`"))?;
    Ok(SynthOptions { points: parse_points(points)?.into(), ..SynthOptions::new(scene) })
}

/// Points of an insertion.
pub fn parse_insertion(text: &str) -> Result<u32, String> {
    let points = parse_points(text)?;
    let wrong = || format!("expected at most {MAX_INSERTION_POINTS}, found `{text}`");
    (points <= MAX_INSERTION_POINTS).then_some(points).ok_or_else(wrong)
}

/// Pictures may have no more pixels than this: their arrays alone would take gigabytes.
const MAX_PIXELS: u64 = 1 << 28;

/// `1600x900`: width and height in pixels.
pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let wrong = || format!("expected WIDTHxHEIGHT in pixels, such as 1600x900, found `{text}`");
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or_else(wrong)?;
    let size = [width, height].map(|n| n.trim().parse::<u32>().ok().filter(|&n| n > 0));
    let [Some(width), Some(height)] = size else { return Err(wrong()) };
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(format!("expected at most {MAX_PIXELS} pixels in all, found `{text}`"));
    }
    Ok([width, height])
}

/// `800,450`: column and row of a pixel.
pub fn parse_pixel(text: &str) -> Result<[u32; 2], String> {
    let wrong = || format!("expected COLUMN,ROW of a pixel, such as 800,450, found `{text}`");
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    match [x, y].map(|n| n.trim().parse::<u32>()) {
        [Ok(x), Ok(y)] => Ok([x, y]),
        _ => Err(wrong()),
    }
}

/// `converged`, `frames=N` or `points=N`.
pub fn parse_stop(text: &str) -> Result<Stop, String> {
    let wrong = || format!("expected converged, frames=N or points=N, found `{text}`");
    if text == "converged" {
        return Ok(Stop::Converged);
    }
    let (what, number) = text.split_once('=').ok_or_else(wrong)?;
    let number = parse_count(number)?;
    match (what, number) {
        ("frames" | "points", 0) => Err(format!("expected {what}=1 or more")),
        ("frames", n) => Ok(Stop::Frames(n)),
        ("points", n) => Ok(Stop::Points(n)),
        _ => Err(wrong()),
    }
}

/// `auto`, or a method that can draw a viewer's pictures, with a workgroup size if need be: `early-z:64`.
pub fn parse_method(text: &str) -> Result<RasterChoice, String> {
    if text == "auto" {
        return Ok(RasterChoice::Auto);
    }
    let (name, group) = text.split_once(':').map_or((text, None), |(name, group)| (name, Some(group)));
    let Some(method) = Raster::ON_GPU.into_iter().find(|method| method.name() == name) else {
        let names = Raster::ON_GPU.map(Raster::name).join(", ");
        return Err(match why_not(name) {
            Some(why) => format!("{why}; here choose auto or one of {names} (`firstlight bench` measures all others)"),
            None => format!("expected auto or one of {names}, found `{name}`"),
        });
    };
    let mut candidate = Candidate::new(method);
    if let Some(group) = group {
        let size = group.parse().ok().filter(|size| GROUP_SIZES.contains(size));
        if candidate.group_size.is_none() || size.is_none() {
            return Err(format!("expected :64, :128 or :256 after a method with compute shaders, found `{text}`"));
        }
        candidate.group_size = size;
    }
    Ok(RasterChoice::Fixed(candidate))
}

/// Why a method of the table draws no picture that is built up over many frames: that takes, in each pixel,
/// the point in front and its depth, always.
fn why_not(name: &str) -> Option<String> {
    let method = methods::by_name(name)?;
    Some(match (method.wrong_on_purpose, name) {
        (Some(how), _) => format!("{name} is wrong on purpose ({how})"),
        _ if method.blends => format!("{name} blends points, and the next frame needs one in each pixel"),
        (_, "busy-loop" | "busy-loop-n") => format!("{name} leaves points out where too many wait for a pixel"),
        _ => format!("{name} keeps colours, and the next frame needs to know which points are visible"),
    })
}

/// Strength of eye-dome lighting.
pub fn parse_strength(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(strength) if (0.0..=100.0).contains(&strength) => Ok(strength),
        _ => Err(format!("expected a number from 0 (off) to 100, found `{text}`")),
    }
}

/// A number of threads.
pub fn parse_threads(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(threads @ 1..=1024) => Ok(threads),
        _ => Err(format!("expected 1 to 1024 threads, found `{text}`")),
    }
}

/// `LOW,HIGH`: two numbers, the first the smaller.
pub fn parse_range(text: &str) -> Result<[f64; 2], String> {
    let wrong = || format!("expected two numbers, the smaller first, such as -10,250.5, found `{text}`");
    let (low, high) = text.split_once(',').ok_or_else(wrong)?;
    let [low, high] = [low, high].map(|n| n.trim().parse::<f64>().ok().filter(|n| n.is_finite()));
    match (low, high) {
        (Some(low), Some(high)) if low < high => Ok([low, high]),
        _ => Err(wrong()),
    }
}

/// A number within limits, the upper one included only if `closed`.
fn number_within(text: &str, [low, high]: [f64; 2], closed: bool) -> Result<f64, String> {
    let ok = |n: &f64| *n >= low && (*n < high || closed && *n == high);
    let until = if closed { "to" } else { "to below" };
    text.parse().ok().filter(ok).ok_or_else(|| format!("expected a number from {low} {until} {high}, found `{text}`"))
}

/// Percent that are left out at either end.
pub fn parse_clip(text: &str) -> Result<f64, String> {
    number_within(text, [0.0, 50.0], false)
}

pub fn parse_brightness(text: &str) -> Result<f64, String> {
    number_within(text, [-1.0, 1.0], true)
}

pub fn parse_contrast(text: &str) -> Result<f64, String> {
    number_within(text, [0.0, 10.0], true)
}

pub fn parse_gamma(text: &str) -> Result<f64, String> {
    number_within(text, [0.1, 10.0], true)
}

/// `#ff8000`, or without the sign: red, green, blue.
pub fn parse_color(text: &str) -> Result<[u8; 3], String> {
    let digits = text.strip_prefix('#').unwrap_or(text);
    let is_hex = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
    let number = u32::from_str_radix(digits, 16).ok().filter(|_| is_hex);
    let [_, r, g, b] =
        number.ok_or_else(|| format!("expected a colour such as #ff8000, found `{text}`"))?.to_be_bytes();
    Ok([r, g, b])
}

/// `6=#ff0000`: the number of a class and its colour.
pub fn parse_class_color(text: &str) -> Result<(u8, [u8; 3]), String> {
    parse_color_of(text, "a class, 0 to 255,")
}

pub fn parse_file_color(text: &str) -> Result<(usize, [u8; 3]), String> {
    parse_color_of(text, "a file's number, from 0,")
}

fn parse_color_of<N: FromStr>(text: &str, what: &str) -> Result<(N, [u8; 3]), String> {
    let wrong = || format!("expected {what} and its colour, such as 6=#ff0000, found `{text}`");
    let (number, color) = text.split_once('=').ok_or_else(wrong)?;
    Ok((number.trim().parse().map_err(|_| wrong())?, parse_color(color.trim())?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_suffixes() {
        for (text, count) in [
            ("0", 0),
            ("1500", 1500),
            ("1_500", 1500),
            ("250k", 250_000),
            ("1M", 1_000_000),
            ("1.5M", 1_500_000),
            ("0.25k", 250),
            ("2.0", 2),
            ("1G", 1_000_000_000),
            ("18446744073709551615", u64::MAX),
        ] {
            assert_eq!(parse_count(text), Ok(count), "{text}");
        }
        for text in ["", "k", "-1", "1.5", "1e6", "1.0005k", "ten", "1M2", ".5M", "+3", "18446744073709551616", "٣"] {
            assert!(parse_count(text).is_err(), "{text}");
        }
    }

    #[test]
    fn methods_that_a_viewer_can_use() {
        assert_eq!(parse_method("auto"), Ok(RasterChoice::Auto));
        for method in Raster::ON_GPU {
            assert_eq!(parse_method(method.name()), Ok(method.into()));
        }
        let small = Candidate { method: Raster::EarlyZ, group_size: Some(64) };
        assert_eq!(parse_method("early-z:64"), Ok(RasterChoice::Fixed(small)));
        for (text, why) in [
            ("just-set", "no depth test"),
            ("racy", "wrong on purpose"),
            ("hqs", "blends"),
            ("hqs1r", "blends"),
            ("busy-loop", "leaves points out"),
            ("depth40", "keeps colours"),
            ("paint", "found `paint`"),
            ("cpu", "found `cpu`"),
            ("", "expected auto"),
            ("early-z:63", ":128"),
            ("early-z:", ":128"),
            ("points:64", "compute shaders"),
        ] {
            let message = parse_method(text).unwrap_err();
            assert!(message.contains(why), "{text}: {message}");
        }
    }

    #[test]
    fn sizes_and_stops() {
        assert_eq!(parse_size("1600x900"), Ok([1600, 900]));
        for text in ["", "1600", "0x5", "5x0", "-1x5", "1600x", "99999x99999", "4294967297x1"] {
            assert!(parse_size(text).is_err(), "{text}");
        }
        assert_eq!((parse_color("#ff8000"), parse_color("0102ff")), (Ok([255, 128, 0]), Ok([1, 2, 255])));
        for text in ["", "#", "#fff", "#ff80001", "#+f8000", "red"] {
            assert!(parse_color(text).is_err(), "{text}");
        }
        assert_eq!(parse_pixel("800, 450"), Ok([800, 450]));
        for text in ["", "800", "800x450", "-1,0", "1,2,3", "1.5,2"] {
            assert!(parse_pixel(text).is_err(), "{text}");
        }
        assert_eq!((parse_records("7"), parse_records("7..9")), (Ok(7..=7), Ok(7..=9)));
        for text in ["", "..", "7..", "9..7", "-1", "7..=9", "7-9", "1.5"] {
            assert!(parse_records(text).is_err_and(|why| why.contains("1200..1205")), "{text}");
        }
        assert_eq!(parse_stop("frames=5"), Ok(Stop::Frames(5)));
        assert_eq!(parse_stop("points=1M"), Ok(Stop::Points(1_000_000)));
        for text in ["frames", "frames=0", "points=", "seconds=3", "converge"] {
            assert!(parse_stop(text).is_err(), "{text}");
        }
    }
}
