//! Colour maps: from 0 to 255, low to high.

use std::{
    fmt::{self, Display, Formatter},
    str::FromStr,
};

use colorgrad::{Gradient, preset};
use serde::{Deserialize, Serialize};

/// A colour map. All but turbo and spectral are even in lightness, and readable by the colour-blind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColorMap {
    #[default]
    Viridis,
    Plasma,
    Inferno,
    Magma,
    Cividis,
    Turbo,
    Spectral,
    Grey,
}

impl ColorMap {
    pub const ALL: [ColorMap; 8] = [
        ColorMap::Viridis,
        ColorMap::Plasma,
        ColorMap::Inferno,
        ColorMap::Magma,
        ColorMap::Cividis,
        ColorMap::Turbo,
        ColorMap::Spectral,
        ColorMap::Grey,
    ];

    /// What [`ColorMap::from_str`] takes.
    pub fn names() -> Vec<&'static str> {
        ColorMap::ALL.map(ColorMap::name).to_vec()
    }

    pub fn name(self) -> &'static str {
        match self {
            ColorMap::Viridis => "viridis",
            ColorMap::Plasma => "plasma",
            ColorMap::Inferno => "inferno",
            ColorMap::Magma => "magma",
            ColorMap::Cividis => "cividis",
            ColorMap::Turbo => "turbo",
            ColorMap::Spectral => "spectral",
            ColorMap::Grey => "grey",
        }
    }

    /// The colours, low to high: red, green, blue, 255.
    pub fn colors(self) -> [[u8; 4]; 256] {
        let of = |gradient: &dyn Gradient| {
            std::array::from_fn(|i| {
                let [r, g, b, _] = gradient.at(i as f32 / 255.0).to_rgba8();
                [r, g, b, 255]
            })
        };
        match self {
            ColorMap::Viridis => of(&preset::viridis()),
            ColorMap::Plasma => of(&preset::plasma()),
            ColorMap::Inferno => of(&preset::inferno()),
            ColorMap::Magma => of(&preset::magma()),
            ColorMap::Cividis => of(&preset::cividis()),
            ColorMap::Turbo => of(&preset::turbo()),
            // Low is blue, as in all others that have any.
            ColorMap::Spectral => {
                let mut colors = of(&preset::spectral());
                colors.reverse();
                colors
            }
            // The darkest are still lighter than the background.
            ColorMap::Grey => std::array::from_fn(|i| {
                let grey = (32 + i * 223 / 255) as u8;
                [grey, grey, grey, 255]
            }),
        }
    }
}

impl Display for ColorMap {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// There is no colour map of this name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected one of {names}, found `{0}`", names = ColorMap::names().join(", "))]
pub struct UnknownMap(String);

impl FromStr for ColorMap {
    type Err = UnknownMap;

    fn from_str(text: &str) -> Result<ColorMap, UnknownMap> {
        ColorMap::ALL.into_iter().find(|map| map.name() == text).ok_or_else(|| UnknownMap(text.to_owned()))
    }
}

/// A colour for the `n`-th of things that are only to be told apart: neighbours differ most. Hues go on by the golden
/// angle, which never comes back to the same; lightness takes turns, so that close hues differ too.
pub fn palette(n: usize) -> [u8; 3] {
    const GOLDEN: f32 = 0.618_034;
    let hue = (0.05 + n as f32 * GOLDEN).fract() * 6.0;
    let (lightness, saturation) = [(0.58, 0.75), (0.42, 0.7), (0.74, 0.8)][n % 3];
    // Blue is the darkest of all hues; on the usual background a dark one is not seen.
    let lightness: f32 = if (3.5..5.0).contains(&hue) { f32::max(lightness, 0.64) } else { lightness };
    let chroma = saturation * (1.0 - (2.0 * lightness - 1.0f32).abs());
    let second = chroma * (1.0 - (hue % 2.0 - 1.0).abs());
    let rgb = match hue as u32 {
        0 => [chroma, second, 0.0],
        1 => [second, chroma, 0.0],
        2 => [0.0, chroma, second],
        3 => [0.0, second, chroma],
        4 => [second, 0.0, chroma],
        _ => [chroma, 0.0, second],
    };
    rgb.map(|c| ((c + lightness - chroma / 2.0) * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_what_their_names_say() {
        for map in ColorMap::ALL {
            assert_eq!(map.to_string().parse(), Ok(map));
            let colors = map.colors();
            assert_ne!(colors[0], colors[255], "{map}");
            // Rec. 709 weights, near enough for telling dark from light.
            let luma = |c: [u8; 4]| 0.2126 * f32::from(c[0]) + 0.7152 * f32::from(c[1]) + 0.0722 * f32::from(c[2]);
            if !matches!(map, ColorMap::Turbo | ColorMap::Spectral) {
                assert!(colors.windows(16).all(|w| luma(w[15]) > luma(w[0])), "{map} gets lighter all the way");
            }
        }
        // matplotlib's own ends, give or take the spline.
        let near = |a: [u8; 4], b: [u8; 3]| (0..3).all(|c| a[c].abs_diff(b[c]) <= 3);
        let viridis = ColorMap::Viridis.colors();
        assert!(
            near(viridis[0], [68, 1, 84]) && near(viridis[255], [253, 231, 37]),
            "{:?} {:?}",
            viridis[0],
            viridis[255]
        );
        let turbo = ColorMap::Turbo.colors();
        assert!(turbo[128][1] > 200 && turbo[255][0] > 100 && turbo[0][2] > turbo[0][1], "blue, green, red");
        let message = "jet".parse::<ColorMap>().unwrap_err().to_string();
        assert!(message.starts_with("expected one of viridis, plasma"), "{message}");
    }

    #[test]
    fn neighbours_of_the_palette_differ() {
        let apart = |a: [u8; 3], b: [u8; 3]| (0..3).map(|c| u32::from(a[c].abs_diff(b[c]))).sum::<u32>();
        for n in 0..256 {
            for k in 1..4 {
                assert!(apart(palette(n), palette(n + k)) > 60, "{n} and {}", n + k);
            }
        }
    }
}
