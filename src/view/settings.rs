//! What the user sets, with a control or a key.

use super::{Options, keys::Command, overlay::POINT_SIZES};
use crate::render::{Look, Shading};

#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    pub look: Look,
    /// Off: the strength of `look` waits.
    pub edl: bool,
    /// The lines at the lower edge.
    pub bar: bool,
    pub help: bool,
    /// The camera goes to a view that is asked for on a short way, instead of jumping there.
    pub smooth: bool,
}

impl Settings {
    pub fn new(options: &Options) -> Settings {
        let mut look = options.look.clone();
        // Switched off, it comes back with the usual strength.
        let edl = look.shading.edl_strength > 0.0;
        if !edl {
            look.shading.edl_strength = Shading::default().edl_strength;
        }
        Settings { look, edl, bar: true, help: false, smooth: true }
    }

    /// What is drawn with.
    pub fn shading(&self) -> Shading {
        let edl_strength = if self.edl { self.look.shading.edl_strength } else { 0.0 };
        Shading { edl_strength, ..self.look.shading }
    }

    /// What a key asks for, if it is of these settings.
    pub fn obey(&mut self, command: Command) {
        match command {
            Command::SmallerPoints => self.change_point_size(-1),
            Command::LargerPoints => self.change_point_size(1),
            Command::ToggleLighting => self.edl ^= true,
            Command::ToggleQuality => self.look.shading.high_quality ^= true,
            Command::ToggleBar => self.bar ^= true,
            Command::ToggleHelp => self.help ^= true,
            Command::Close => self.help = false,
            _ => {}
        }
    }

    /// Larger or smaller points.
    pub fn change_point_size(&mut self, by: i32) {
        let size = self.look.point_size.saturating_add_signed(by);
        self.look.point_size = size.clamp(*POINT_SIZES.start(), *POINT_SIZES.end());
    }
}
