//! `firstlight` as a user runs it: exit codes, messages, pictures, arrays and reports.

mod bench;
mod command_line;
mod damaged;
mod picture;
mod projection;
