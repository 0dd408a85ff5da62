//! What the user sets, with a control or a key.

use std::collections::BTreeSet;

use eframe::egui::ThemePreference;
use serde::{Deserialize, Serialize};

use super::{Options, keys::Command, remembered::Remembered};
use crate::render::{Clip, Filter, Look, Shading};

#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    pub look: Look,
    /// Off: the strength of `look` waits.
    pub edl: bool,
    /// The lines at the lower edge.
    pub bar: bool,
    /// The panel at the right.
    pub panel: bool,
    /// In points.
    pub panel_width: f32,
    /// Sections of the panel that are open.
    pub sections: BTreeSet<Section>,
    pub theme: Theme,
    /// The camera goes to a view that is asked for on a short way, instead of jumping there.
    pub smooth: bool,
    pub help: bool,
}

/// The parts of the side panel, from above.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Section {
    Files,
    Color,
    Filter,
    Look,
    Share,
    Performance,
    Messages,
}

/// Dark or light controls. The picture's background is set by the look.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Theme {
    /// As the system has it.
    System,
    #[default]
    Dark,
    Light,
}

impl Theme {
    pub const ALL: [(Theme, &'static str); 3] =
        [(Theme::System, "As the system"), (Theme::Dark, "Dark"), (Theme::Light, "Light")];

    pub fn preference(self) -> ThemePreference {
        match self {
            Theme::System => ThemePreference::System,
            Theme::Dark => ThemePreference::Dark,
            Theme::Light => ThemePreference::Light,
        }
    }
}

impl Settings {
    /// What was remembered, with what the command line says in its place.
    pub fn new(options: &Options, remembered: &Remembered) -> Settings {
        let mut look = match &remembered.look {
            Some(look) => with_given(look, &options.look, &options.given),
            None => {
                let mut look = options.look.clone();
                look.decor.legend |= !options.given.contains(&"/decor");
                look
            }
        };
        // Switched off, it comes back with the usual strength.
        let edl = look.shading.edl_strength > 0.0;
        if !edl {
            look.shading.edl_strength = Shading::default().edl_strength;
        }
        Settings {
            look,
            edl: edl && (remembered.edl || options.given.contains(&"/shading/edl_strength")),
            bar: remembered.bar,
            panel: remembered.panel,
            panel_width: remembered.panel_width,
            sections: remembered.sections.iter().copied().collect(),
            theme: remembered.theme,
            smooth: remembered.smooth,
            help: false,
        }
    }

    /// To be remembered; recent files and bookmarks stay as they are.
    pub fn note(&self, remembered: &mut Remembered) {
        remembered.set_look(&self.look);
        remembered.edl = self.edl;
        remembered.bar = self.bar;
        remembered.panel = self.panel;
        remembered.panel_width = self.panel_width;
        remembered.sections = self.sections.iter().copied().collect();
        remembered.theme = self.theme;
        remembered.smooth = self.smooth;
    }

    /// What belongs to one scan must not hide another one.
    pub fn forget_scene(&mut self) {
        self.show_all();
        self.look.coloring.range = None;
        self.look.coloring.files.clear();
    }

    /// No filter, no clipping.
    pub fn show_all(&mut self) {
        self.look.filter = Filter::default();
        self.look.clip = Clip::default();
    }

    /// The panel shows this section.
    pub fn shows(&self, section: Section) -> bool {
        self.panel && self.sections.contains(&section)
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
            _ => {}
        }
    }

    /// Larger or smaller points.
    pub fn change_point_size(&mut self, by: i32) {
        self.look.point_size = self.look.point_size.stepped(by);
    }
}

/// A remembered look with the fields in place that the command line gave, named as JSON pointers.
fn with_given(remembered: &Look, given: &Look, fields: &[&str]) -> Look {
    let (Ok(mut merged), Ok(given_json)) = (serde_json::to_value(remembered), serde_json::to_value(given)) else {
        return given.clone();
    };
    for field in fields {
        if let (Some(to), Some(from)) = (merged.pointer_mut(field), given_json.pointer(field)) {
            *to = from.clone();
        }
    }
    serde_json::from_value(merged).unwrap_or_else(|_| given.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn remembered() -> Remembered {
        let mut look = Look { point_size: 5.into(), ..Default::default() };
        look.shading.high_quality = true;
        let mut remembered = Remembered { edl: false, ..Default::default() };
        remembered.set_look(&look);
        remembered
    }

    #[test]
    fn the_command_line_wins_over_what_is_remembered() {
        let nothing_given = Settings::new(&Options::default(), &remembered());
        assert_eq!((nothing_given.look.point_size, nothing_given.edl), (5.into(), false));
        assert!(nothing_given.look.shading.high_quality);
        let look = Look { point_size: 2.into(), ..Default::default() };
        let options = Options { look, given: vec!["/point_size", "/shading/edl_strength"], ..Default::default() };
        let given = Settings::new(&options, &remembered());
        assert_eq!((given.look.point_size, given.edl), (2.into(), true));
        assert!(given.look.shading.high_quality, "what was not given is as it was");
    }

    #[test]
    fn a_first_window_has_a_legend_unless_other_decor_is_given() {
        let of = |given| {
            let look = Look { decor: "box".parse().unwrap(), ..Default::default() };
            Settings::new(&Options { look, given, ..Default::default() }, &Remembered::default()).look.decor.to_string()
        };
        assert_eq!(of(vec![]), "box,legend");
        assert_eq!(of(vec!["/decor"]), "box");
    }

    #[test]
    fn what_is_set_is_what_is_remembered() {
        let mut settings = Settings::new(&Options::default(), &Remembered::default());
        settings.look.point_size = 4.into();
        settings.panel = false;
        settings.sections = [Section::Messages].into();
        settings.theme = Theme::Light;
        let mut remembered = Remembered::default();
        settings.note(&mut remembered);
        assert_eq!(Settings::new(&Options::default(), &remembered), settings);
    }
}
