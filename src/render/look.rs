//! How a scene is shown.

use serde::{Deserialize, Serialize};

use super::{
    backend::Shading,
    coloring::Coloring,
    filter::{Clip, Filter},
};

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
