//! The `town` scene: what an airborne scanner sees of a small town.
//!
//! [`plan`] lays the town out once per seed (terrain, river, streets, blocks, buildings, trees) over
//! 2.8 km; [`surface`] answers what one laser beam hits; [`paint`] gives it colour, intensity and class;
//! [`scan`] flies the strips and turns a point's number into its beam. The town is the same for
//! every number of points: a small scan shows its centre, a large one more of it, the largest more densely.

mod paint;
mod plan;
mod scan;
mod surface;

pub(super) use scan::Town;
