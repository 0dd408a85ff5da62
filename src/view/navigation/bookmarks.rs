//! Cameras that the user keeps.

use serde::{Deserialize, Serialize};

use crate::render::Camera;

/// A camera with a name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bookmark {
    pub name: String,
    pub camera: Camera,
}

/// Bookmarks of one scene; the first nine have keys.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Bookmarks {
    pub entries: Vec<Bookmark>,
}

impl Bookmarks {
    /// Keeps a camera after all others, named by its number, which it returns (from 1).
    pub fn add(&mut self, camera: Camera) -> usize {
        self.entries.push(Bookmark { name: format!("View {}", self.entries.len() + 1), camera });
        self.entries.len()
    }

    /// Keeps a camera as the one with this number (from 1) and leaves its name; as the last one if there are fewer.
    /// Returns its number.
    pub fn set(&mut self, number: usize, camera: Camera) -> usize {
        match number.checked_sub(1).and_then(|at| self.entries.get_mut(at)) {
            Some(bookmark) => {
                bookmark.camera = camera;
                number
            }
            None => self.add(camera),
        }
    }

    /// Takes over those of another scene that has become part of this one.
    pub fn merge(&mut self, others: Bookmarks) {
        let others = others.entries.into_iter().filter(|other| !self.entries.contains(other)).collect::<Vec<_>>();
        self.entries.extend(others);
    }

    /// The one with this number (from 1).
    pub fn get(&self, number: usize) -> Option<&Bookmark> {
        self.entries.get(number.checked_sub(1)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn are_found_by_their_number_and_survive_being_written_down() {
        let camera = |x| Camera {
            eye: [x, 0.1, 4_999_999.123],
            target: [0.0; 3],
            up: [0.0, 0.0, 1.0],
            fov_y_deg: 60.0,
            projection: Default::default(),
        };
        let mut bookmarks = Bookmarks::default();
        assert_eq!(bookmarks.set(4, camera(1.0)), 1, "the first one is number 1 whatever was asked for");
        assert_eq!(bookmarks.add(camera(2.0)), 2);
        bookmarks.entries[0].name = "Church".into();
        assert_eq!(bookmarks.set(1, camera(3.0)), 1);
        assert_eq!(bookmarks.get(1).map(|b| (b.name.as_str(), b.camera)), Some(("Church", camera(3.0))));
        assert_eq!((bookmarks.get(0), bookmarks.get(3)), (None, None));
        let text = serde_json::to_string(&bookmarks).unwrap();
        assert_eq!(serde_json::from_str::<Bookmarks>(&text).unwrap(), bookmarks);
    }
}
