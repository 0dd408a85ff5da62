//! Every method against its twin, on the GPU at hand.

#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a test fails where it stands, and says that it is skipped"
)]

mod clouds;
mod failures;
mod pictures;
mod shaders;
mod times;
#[path = "../shared/wgsl.rs"]
mod wgsl;
