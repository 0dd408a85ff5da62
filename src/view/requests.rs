//! What the panels ask the window to do: they only show what they are given.

use std::path::PathBuf;

use super::screenshot::ShotOptions;
use crate::scene::Attribute;

#[derive(Debug, Clone, PartialEq)]
pub enum Request {
    /// Files and folders, in the place of what is shown or besides it.
    Open {
        inputs: Vec<PathBuf>,
        add: bool,
    },
    /// With the system's dialog.
    Choose {
        what: Choose,
        add: bool,
    },
    /// Stop reading one file; what is read of it stays.
    StopFile(usize),
    /// Stop reading; what is read stays.
    StopReading,
    /// Take one file away.
    CloseFile(usize),
    /// Reads an attribute of all points.
    Read(Attribute),
    ForgetRecent,
    Screenshot(ShotOptions),
    StopScreenshot,
    /// The command that makes this picture.
    CopyCommand,
    ClearMessages,
}

/// What a dialog is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choose {
    Files,
    Folder,
    /// Where a picture is to be written.
    Picture,
}
