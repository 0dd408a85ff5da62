//! Store and render: every kernel against its twin, every backend against the picture of all points.

#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a test fails where it stands, and says that it is skipped"
)]

mod aside;
mod backends;
mod choice;
mod cloud;
mod colors;
mod colors_real;
mod convergence;
mod encoding;
mod filter;
mod filter_counts;
mod filter_values;
mod high_quality;
mod looks;
mod pick;
mod projection;
mod shaders;
mod slow;
mod twins;
mod values;
#[path = "../shared/wgsl.rs"]
mod wgsl;
