//! How a scene is shown.

use serde::{Deserialize, Serialize};

use super::{backend::Shading, camera::Projection, point_size::PointSize};

/// How a scene is shown: what the window's controls set, and the options of `render` of the same names. The camera
/// and the size of the picture are not part of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Look {
    pub point_size: PointSize,
    /// What a camera is made with; one that was given keeps its own if that is orthographic.
    pub projection: Projection,
    pub shading: Shading,
}

impl Default for Look {
    fn default() -> Self {
        Look { point_size: PointSize::default(), projection: Projection::default(), shading: Shading::default() }
    }
}
