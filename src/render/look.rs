//! How a scene is shown.

use serde::{Deserialize, Serialize};

use super::{
    backend::Shading,
    coloring::Coloring,
    filter::{Clip, Filter},
};
use crate::scene::Attribute;

/// How a scene is shown: what the window's controls set, and the options of `render` of the same names. The camera
/// and the size of the picture are not part of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Look {
    /// Width of a point, pixels, 1 to 8.
    pub point_size: u32,
    pub shading: Shading,
    pub coloring: Coloring,
    /// Which points are shown, by their attributes.
    pub filter: Filter,
    /// Which part of space is shown.
    pub clip: Clip,
}

impl Look {
    /// The attributes that it takes, each once.
    pub fn attributes(&self) -> Vec<Attribute> {
        let mut attributes: Vec<Attribute> = self.coloring.by.attribute().cloned().into_iter().collect();
        for attribute in self.filter.attributes() {
            if !attributes.contains(attribute) {
                attributes.push(attribute.clone());
            }
        }
        attributes
    }

    /// Neither a filter nor a clipping box or slab hides any point.
    pub fn shows_all(&self) -> bool {
        self.filter.clauses.is_empty() && self.clip == Clip::default()
    }
}

impl Default for Look {
    fn default() -> Self {
        Look {
            point_size: 1,
            shading: Shading::default(),
            coloring: Coloring::default(),
            filter: Filter::default(),
            clip: Clip::default(),
        }
    }
}
