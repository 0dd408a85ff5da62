//! How a scene is shown.

use serde::{Deserialize, Serialize};

use super::{
    backend::Shading,
    camera::Projection,
    coloring::Coloring,
    filter::{Clip, Filter},
    point_size::PointSize,
};

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
}
