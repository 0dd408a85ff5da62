//! `firstlight` as a user runs it: exit codes, messages, pictures, arrays and reports.

#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a test fails where it stands, and says that it is skipped"
)]

mod bench;
mod command_line;
mod compare;
mod damaged;
mod ingest;
mod manual;
mod measure;
mod pick;
mod picture;
mod projection;
mod raster;
mod stability;
