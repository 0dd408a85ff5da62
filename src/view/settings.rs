//! What the user sets, with a control or a key.

use super::Options;
use crate::render::{Look, Shading};

#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    pub look: Look,
    /// Off: the strength of `look` waits.
    pub edl: bool,
    /// The lines at the lower edge.
    pub bar: bool,
    pub help: bool,
}

/// What the user asks for with a button or a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ask {
    Home,
    Top,
    Front,
    Side,
}

impl Settings {
    pub fn new(options: &Options) -> Settings {
        let mut look = options.look.clone();
        // Switched off, it comes back with the usual strength.
        let edl = look.shading.edl_strength > 0.0;
        if !edl {
            look.shading.edl_strength = Shading::default().edl_strength;
        }
        Settings { look, edl, bar: true, help: false }
    }

    /// What is drawn with.
    pub fn shading(&self) -> Shading {
        let edl_strength = if self.edl { self.look.shading.edl_strength } else { 0.0 };
        Shading { edl_strength, ..self.look.shading }
    }

    /// Larger or smaller points.
    pub fn change_point_size(&mut self, by: i32) {
        self.look.point_size = self.look.point_size.stepped(by);
    }
}
