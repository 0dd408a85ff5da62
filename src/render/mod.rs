//! From points in random slots to a picture: reproject, fresh, fill, index build, resolve.
//!
//! [`Progressive`] decides what each frame draws; a [`Backend`] draws it. Every pixel is one 64-bit
//! word, depth (the bits of a positive f32) in the upper half and slot in the lower; the smallest word
//! wins, so the order in which points arrive cannot change a picture.
//!
//! High-quality shading ([`Shading::high_quality`]) adds a second pass. While depths are being found, it
//! averages the points that the frame draws anyway; once they are final it goes over all points, each once,
//! and the depths stay as they are. Its sums are integers, so that the result is again that of all points
//! at once, bit for bit.

mod averages;
mod backend;
mod budget;
mod camera;
mod choice;
mod clipped;
mod color;
mod coloring;
mod column;
mod cpu;
mod decor;
mod filter;
mod frame;
mod gpu;
mod histogram;
mod holes;
mod in_motion;
mod keys;
mod legend;
mod legend_layout;
mod lens;
mod look;
mod paint;
mod pick;
mod point_size;
mod progressive;
mod progressive_values;
mod scale;
mod selection;
mod shading;
mod values;
mod view;
mod wide;

pub use crate::device::{PassTimes, Passes, Raster, RenderError};
pub use backend::{Averaging, Backend, BackendInfo, FramePlan, Picture, Shading, Sums};
pub use budget::{BudgetController, FillBudget};
pub use camera::{Camera, CameraError, Projection, SOUTH_AND_ABOVE};
pub use choice::{
    Candidate, Choice, Clock, GROUP_SIZES, MARGIN, Measured, Measurement, RasterChoice, Speed, Why, best,
};
pub use clipped::clipped;
pub use color::{FileColor, NO_DATA, PointColors, elevation_ramp};
pub use coloring::{
    CLIP_PERCENT, Class, ClassTable, ColorBy, ColorMap, Coloring, Tone, UnknownColor, UnknownMap, palette,
};
pub use column::{ColumnColors, ColumnId, Keys, Lookup, table_index};
pub use cpu::{CpuBackend, list_visible};
pub use decor::{Align, Decor, Label, Line, Overlay, Plate, Sheet, overlay};
pub use filter::{
    Border, Clause, ClauseError, Clip, ClipBox, ClipError, Filter, Key, MaskRules, Place, Ranges, RangesError, Slab,
    Test,
};
pub use frame::{FrameReport, FrameRequest, INSERTION_POINTS, Reprojection, StoreOptions};
pub use gpu::{ColorTablesUniform, ColumnScaleUniform, GpuBackend, PickWords, ShadingUniform};
pub use histogram::{AttributeStats, Histogram, SampledIntensities};
pub use holes::{MASK as HOLE_MASK, REACH as HOLE_REACH, source as hole_source};
pub use legend::{Legend, LegendClass, LegendKey, Tick};
pub use lens::Lens;
pub use look::Look;
pub use pick::{MAX_REACH, Pick, PickAt, PickTicket};
pub use point_size::{MAX_PX, MAX_WORLD_PX, PointSize, PointWidth};
pub use progressive::Progressive;
pub use scale::{Scale, Transfer, key_of, value_of};
pub use shading::{AVERAGED_DEPTH, EDL_GAIN, MOST_FRAGMENTS};
pub use view::{Projected, View};
