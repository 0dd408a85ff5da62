//! What the panels ask the window to do: they only show what they are given.

use std::path::PathBuf;

use super::screenshot::ShotOptions;

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
    ForgetRecent,
    Screenshot(ShotOptions),
    StopScreenshot,
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
