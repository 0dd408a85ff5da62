//! Brightness, contrast, gamma: the last step from a value to what is shown.

use serde::{Deserialize, Serialize};

use crate::render::scale::level;

/// How light and dark are spread: `(v − ½) · contrast + ½ + brightness`, cut to 0…1, to the power of `1 / gamma`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Tone {
    /// Added, −1 to 1.
    pub brightness: f64,
    /// Factor around the middle, 0 to 10.
    pub contrast: f64,
    /// 0.1 to 10; above 1 lightens the dark.
    pub gamma: f64,
}

impl Default for Tone {
    fn default() -> Self {
        Tone { brightness: 0.0, contrast: 1.0, gamma: 1.0 }
    }
}

impl Tone {
    /// True if it changes nothing.
    pub fn is_neutral(&self) -> bool {
        *self == Tone::default()
    }

    /// `value` and the result are 0 to 1; never falls where `value` rises.
    pub fn apply(&self, value: f64) -> f64 {
        let Tone { brightness, contrast, gamma } = *self;
        ((value - 0.5) * contrast + 0.5 + brightness).clamp(0.0, 1.0).powf(1.0 / gamma)
    }

    /// For each level in 8 bits the smallest value in 16 bits that is shown by it or a higher one; `u32::MAX` if none
    /// is, and 0 for the first. A neutral tone shows the upper byte.
    pub fn thresholds(&self) -> [u32; 256] {
        let level = |value: u32| (self.apply((f64::from(value) + 0.5) / 65_536.0) * 256.0) as usize;
        std::array::from_fn(|wanted| {
            // It rises, so that halving finds the place.
            let (mut below, mut reaches) = (-1i64, 65_536);
            while reaches - below > 1 {
                let middle = (below + reaches) / 2;
                if level(middle as u32) >= wanted {
                    reaches = middle;
                } else {
                    below = middle;
                }
            }
            if reaches > 65_535 { u32::MAX } else { reaches as u32 }
        })
    }

    /// What each value in 8 bits is shown by.
    pub fn levels(&self) -> [u8; 256] {
        let thresholds = self.thresholds();
        std::array::from_fn(|value| level(&thresholds, value as u32 * 257) as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neutral_changes_nothing() {
        let thresholds = Tone::default().thresholds();
        assert!(thresholds.iter().zip(0..).all(|(&threshold, level)| threshold == 256 * level));
        assert!(Tone::default().levels().iter().zip(0..=255).all(|(&level, value)| level == value));
    }

    #[test]
    fn each_setting_does_what_it_says() {
        let neutral = Tone::default();
        let lighter = Tone { brightness: 0.1, ..neutral }.levels();
        assert_eq!((lighter[0], lighter[128], lighter[255]), (25, 154, 255));
        let harder = Tone { contrast: 2.0, ..neutral }.levels();
        assert_eq!((harder[60], harder[128], harder[200]), (0, 129, 255));
        let gamma = Tone { gamma: 2.0, ..neutral };
        assert_eq!((gamma.levels()[0], gamma.levels()[64]), (0, 128), "the dark is lighter");
        // Dark 16-bit colours keep their steps, which the upper byte alone would not show.
        let thresholds = gamma.thresholds();
        assert_eq!([0, 100, 200, 255].map(|value| level(&thresholds, value)), [0, 10, 14, 15]);
        let flat = Tone { contrast: 0.0, ..neutral };
        assert!(flat.levels().iter().all(|&level| level == 128));
    }

    #[test]
    fn thresholds_are_those_of_the_formula() {
        for tone in [(0.3, 1.7, 0.6), (-0.4, 0.5, 2.2), (0.0, 1.0, 10.0)] {
            let tone = Tone { brightness: tone.0, contrast: tone.1, gamma: tone.2 };
            let thresholds = tone.thresholds();
            assert!(thresholds.is_sorted());
            for value in (0..65_536).step_by(17) {
                let expected = (tone.apply((f64::from(value) + 0.5) / 65_536.0) * 256.0).min(255.0) as usize;
                assert_eq!(level(&thresholds, value), expected, "{tone:?} of {value}");
            }
        }
    }
}
