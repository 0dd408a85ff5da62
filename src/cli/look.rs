//! The options of how a scene is shown, the same for the window and for `render`.

use clap::Args;

use super::values;
use crate::render::{Clause, Clip, ClipBox, Filter, Look, PointSize, Projection, Shading, Slab};

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "How it looks")]
pub struct LookArgs {
    /// Width of a point: pixels, 1 to 8, or a size in the file's unit such as 0.05m, drawn as large as it is from
    /// there (up to 32 pixels); by default 1 in a picture and 2 in the window
    #[arg(long, value_name = "PX|SIZEm")]
    point_size: Option<PointSize>,
    /// Without perspective: everything looks as large as at the camera's target
    #[arg(long)]
    orthographic: bool,
    /// Strength of eye-dome lighting; 0 turns it off
    #[arg(long, value_name = "STRENGTH", default_value_t = Shading::default().edl_strength, value_parser = values::parse_strength, allow_negative_numbers = true)]
    edl: f32,
    /// High-quality shading: each pixel shows the mean colour of all points within 1 % behind its nearest
    #[arg(long)]
    hq: bool,
    /// Show only points whose attribute has one of these values: class=2,6 or class!=7 or elevation=10..55.5 or
    /// file=0; given several times, all must hold
    #[arg(long, value_name = "ATTRIBUTE=VALUES")]
    filter: Vec<Clause>,
    /// Show only what lies in this box, in the file's coordinates; the last number turns it around its middle
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1[,DEGREES]", allow_negative_numbers = true)]
    clip: Option<ClipBox>,
    /// Show only a section: a point of it, the direction across, and how thick it is
    #[arg(long, value_name = "X,Y,Z,NX,NY,NZ,THICKNESS", allow_negative_numbers = true)]
    slab: Option<Slab>,
}

impl LookArgs {
    /// `point_size` is for where none is given.
    pub fn look(&self, point_size: PointSize) -> Look {
        Look {
            point_size: self.point_size.unwrap_or(point_size),
            projection: if self.orthographic { Projection::Orthographic } else { Projection::Perspective },
            shading: Shading { edl_strength: self.edl, high_quality: self.hq, ..Default::default() },
            filter: Filter { clauses: self.filter.clone() },
            clip: Clip { bounds: self.clip, slab: self.slab },
        }
    }
}
