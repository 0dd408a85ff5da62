//! How a scene is shown.

use serde::{Deserialize, Serialize};

use super::{
    backend::Shading,
    camera::Projection,
    coloring::Coloring,
    decor::Decor,
    filter::{Clip, Filter},
    point_size::PointSize,
};
use crate::scene::Attribute;

/// How a scene is shown: what the window's controls set, and the options of `render` of the same names. The camera
/// and the size of the picture are not part of it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Look {
    pub point_size: PointSize,
    /// What a camera is made with; one that was given keeps its own if that is orthographic.
    pub projection: Projection,
    pub shading: Shading,
    pub coloring: Coloring,
    /// Which points are shown, by their attributes.
    pub filter: Filter,
    /// Which part of space is shown.
    pub clip: Clip,
    /// What is drawn over the picture.
    pub decor: Decor,
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
