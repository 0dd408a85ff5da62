//! Store and render: every kernel against its twin, every backend against the picture of all points.

mod backends;
mod cloud;
mod convergence;
mod projection;
mod shaders;
mod twins;
