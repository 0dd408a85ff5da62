//! Settings from one run to the next, in one JSON file in the platform's place for such things.
//!
//! Each field is read on its own: what a newer or older version wrote, or what is damaged, is left at its default, and
//! the rest is kept. The file is replaced as a whole, so that it is never half written.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use serde::{Serialize, de::DeserializeOwned};
use serde_json::{Map, Value};

use super::{
    navigation::Bookmarks,
    settings::{Section, Theme},
};
use crate::{
    render::{Clip, ColorBy, Coloring, Filter, Look},
    scene::Attribute,
};

/// Names another settings file; empty: none is read or written.
pub const SETTINGS_VARIABLE: &str = "FIRSTLIGHT_SETTINGS";

/// So many things that were opened are kept.
const RECENT: usize = 12;

/// Scenes whose bookmarks are kept.
const BOOKMARKED: usize = 50;

/// What is remembered.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Remembered {
    /// Without what belongs to one scan: filter and clipping box would hide another one.
    pub look: Option<Look>,
    pub edl: bool,
    pub bar: bool,
    pub panel: bool,
    /// Width of the side panel, in points.
    pub panel_width: f32,
    /// Sections of the side panel that are open.
    pub sections: Vec<Section>,
    pub theme: Theme,
    /// The camera goes to views on a short way.
    pub smooth: bool,
    /// Width and height of the window, in points.
    pub window: [f32; 2],
    /// Files and folders, the last opened first.
    pub recent: Vec<PathBuf>,
    /// Bookmarks of scenes by their first file, the last seen first.
    pub bookmarks: Vec<(PathBuf, Bookmarks)>,
}

impl Default for Remembered {
    fn default() -> Self {
        Remembered {
            look: None,
            edl: true,
            bar: true,
            panel: true,
            panel_width: 300.0,
            sections: vec![Section::Files, Section::Color, Section::Look],
            theme: Theme::default(),
            smooth: true,
            window: [1280.0, 800.0],
            recent: Vec::new(),
            bookmarks: Vec::new(),
        }
    }
}

impl Remembered {
    /// What can be understood of a text.
    pub fn parse(text: &str) -> Remembered {
        let mut map: Map<String, Value> = serde_json::from_str(text).unwrap_or_default();
        let default = Remembered::default();
        let width: f32 = field(&mut map, "panel_width", default.panel_width);
        Remembered {
            look: field(&mut map, "look", None),
            edl: field(&mut map, "edl", default.edl),
            bar: field(&mut map, "bar", default.bar),
            panel: field(&mut map, "panel", default.panel),
            panel_width: if width.is_finite() { width.clamp(120.0, 2_000.0) } else { default.panel_width },
            sections: field(&mut map, "sections", default.sections),
            theme: field(&mut map, "theme", default.theme),
            smooth: field(&mut map, "smooth", default.smooth),
            window: field(&mut map, "window", default.window).map(|side: f32| side.clamp(160.0, 16_384.0)),
            recent: field(&mut map, "recent", Vec::new()),
            bookmarks: field(&mut map, "bookmarks", Vec::new()),
        }
    }

    /// A look without what belongs to one scan.
    pub fn set_look(&mut self, look: &Look) {
        let mut coloring = Coloring { range: None, files: Default::default(), ..look.coloring.clone() };
        if matches!(coloring.by, ColorBy::Attribute(Attribute::Extra(_))) {
            coloring.by = ColorBy::Auto;
        }
        self.look = Some(Look { coloring, filter: Filter::default(), clip: Clip::default(), ..look.clone() });
    }

    /// Bookmarks of the scene that begins with this file.
    pub fn bookmarks_of(&self, first: &Path) -> Bookmarks {
        let known = self.bookmarks.iter().find(|(file, _)| *file == absolute(first));
        known.map(|(_, bookmarks)| bookmarks.clone()).unwrap_or_default()
    }

    /// Keeps the bookmarks of the scene that begins with this file.
    pub fn set_bookmarks(&mut self, first: &Path, bookmarks: &Bookmarks) {
        let path = absolute(first);
        if self.bookmarks.first().is_some_and(|(file, kept)| *file == path && kept == bookmarks) {
            return;
        }
        self.bookmarks.retain(|(file, _)| *file != path);
        if !bookmarks.entries.is_empty() {
            self.bookmarks.insert(0, (path, bookmarks.clone()));
        }
        self.bookmarks.truncate(BOOKMARKED);
    }

    /// Puts what was opened first.
    pub fn note_opened(&mut self, inputs: &[PathBuf]) {
        for input in inputs.iter().rev() {
            let path = absolute(input);
            self.recent.retain(|known| *known != path);
            self.recent.insert(0, path);
        }
        self.recent.truncate(RECENT);
    }
}

/// A relative path means nothing in another folder.
fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

fn field<T: DeserializeOwned>(map: &mut Map<String, Value>, name: &str, default: T) -> T {
    map.remove(name).and_then(|value| serde_json::from_value(value).ok()).unwrap_or(default)
}

/// Where settings are kept; `None`: nowhere.
pub fn place() -> Option<PathBuf> {
    match std::env::var_os(SETTINGS_VARIABLE) {
        Some(path) if path.is_empty() => None,
        Some(path) => Some(path.into()),
        None => eframe::storage_dir("firstlight").map(|folder| folder.join("settings.json")),
    }
}

/// The settings file, and what it says by now.
#[derive(Debug, Default)]
pub struct Store {
    place: Option<PathBuf>,
    saved: Option<Remembered>,
}

impl Store {
    /// Nothing is read or written without a place.
    pub fn open(place: Option<PathBuf>) -> (Store, Remembered) {
        // Not there yet, or not readable: begin anew.
        let text = place.as_deref().and_then(|path| fs::read_to_string(path).ok());
        let remembered = text.as_deref().map(Remembered::parse).unwrap_or_default();
        let saved = text.is_some().then(|| remembered.clone());
        (Store { place, saved }, remembered)
    }

    /// Writes what has changed. An error is told once, until writing succeeds.
    ///
    /// # Errors
    /// If it cannot be written, in one line.
    pub fn save(&mut self, remembered: &Remembered) -> Result<(), String> {
        let Some(place) = &self.place else { return Ok(()) };
        if self.saved.as_ref() == Some(remembered) {
            return Ok(());
        }
        self.saved = Some(remembered.clone());
        replace(place, remembered).map_err(|error| {
            format!("Settings cannot be kept in {}: {error}; {SETTINGS_VARIABLE} names another file", place.display())
        })
    }
}

fn replace(place: &Path, remembered: &Remembered) -> io::Result<()> {
    if let Some(folder) = place.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        fs::create_dir_all(folder)?;
    }
    let text = serde_json::to_string_pretty(remembered)?;
    // Two windows may write at the same time.
    let aside = place.with_extension(format!("{}.tmp", std::process::id()));
    fs::write(&aside, text)?;
    fs::rename(&aside, place).inspect_err(|_| {
        let _ = fs::remove_file(&aside);
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{Camera, Clause};

    fn camera() -> Camera {
        Camera {
            eye: [0.0; 3],
            target: [0.0, 1.0, 0.0],
            up: [0.0, 0.0, 1.0],
            fov_y_deg: 60.0,
            projection: Default::default(),
        }
    }

    #[test]
    fn settings_come_back_as_they_were() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("new/settings.json");
        let (mut store, mut remembered) = Store::open(Some(place.clone()));
        assert_eq!(remembered, Remembered::default());
        let mut look = Look::default();
        look.shading.high_quality = true;
        look.filter.clauses.push("class=2".parse::<Clause>().unwrap());
        remembered.set_look(&look);
        remembered.theme = Theme::Light;
        remembered.sections = vec![Section::Performance];
        remembered.note_opened(&["/a/b.laz".into(), "/c".into()]);
        remembered.note_opened(&["/c".into()]);
        remembered.smooth = false;
        let mut bookmarks = Bookmarks::default();
        bookmarks.add(Camera { eye: [0.1, 5_000_000.123, 1.0 / 3.0], ..camera() });
        remembered.set_bookmarks(Path::new("/c"), &bookmarks);
        remembered.set_bookmarks(Path::new("/d"), &Bookmarks::default());
        store.save(&remembered).unwrap();
        let (mut store, again) = Store::open(Some(place.clone()));
        assert_eq!(again, remembered);
        assert_eq!(again.recent, [Path::new("/c"), Path::new("/a/b.laz")]);
        assert_eq!(again.bookmarks_of(Path::new("/c")), bookmarks);
        assert_eq!(again.bookmarks.len(), 1, "a scene without bookmarks takes no room");
        let look = again.look.clone().unwrap();
        assert!(look.shading.high_quality && look.filter == Filter::default(), "a filter belongs to one scan");
        // Unchanged: not written again.
        fs::remove_file(&place).unwrap();
        store.save(&again).unwrap();
        assert!(!place.exists());
    }

    #[test]
    fn damaged_and_old_settings_keep_what_can_be_understood() {
        let text = r#"{"look": {"shading": 7}, "edl": false, "panel_width": 1e300, "theme": "purple",
            "sections": ["files", "performance"], "recent": ["/x.las"], "new in the next version": [1]}"#;
        let found = Remembered::parse(text);
        let default = Remembered::default();
        assert!(!found.edl);
        assert_eq!((found.look, found.theme, found.bar), (None, default.theme, default.bar));
        assert_eq!(found.sections, [Section::Files, Section::Performance]);
        assert_eq!(found.recent, [Path::new("/x.las")]);
        assert!(found.panel_width <= 2_000.0);
        for text in ["", "{", "null", "[1, 2]", "\0\u{7f}", &text[..40]] {
            assert_eq!(Remembered::parse(text), default, "{text}");
        }
    }

    #[test]
    fn what_cannot_be_written_is_told_once() {
        let folder = tempfile::tempdir().unwrap();
        let blocked = folder.path().join("file");
        fs::write(&blocked, "").unwrap();
        let (mut store, remembered) = Store::open(Some(blocked.join("settings.json")));
        let told = store.save(&remembered).unwrap_err();
        assert!(told.contains(SETTINGS_VARIABLE) && !told.contains('\n'), "{told}");
        assert_eq!(store.save(&remembered), Ok(()));
    }
}
