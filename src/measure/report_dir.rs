//! A folder for a report: new, empty, or one of the same kind that is written over.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use crate::headless::{Destination, OutputError};

/// Why a folder cannot take a report.
#[derive(Debug, thiserror::Error)]
pub enum ReportDirError {
    #[error("cannot write the report to {}: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("{} is not a folder; name a new one for the report", path.display())]
    NotAFolder { path: PathBuf },
    #[error("{} holds other files and no {kind} report; name a new folder, or an empty one", path.display())]
    Occupied { path: PathBuf, kind: &'static str },
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// A folder that is there and can be written.
#[derive(Debug)]
pub struct ReportDir {
    path: PathBuf,
}

impl ReportDir {
    /// Makes the folder, or checks that it is empty or holds a report of this kind: a JSON file `json`
    /// that says so in its field `report`. Files are only written by [`ReportDir::write`]: what stops the
    /// program before that leaves an older report as it was.
    ///
    /// # Errors
    /// If the folder cannot be made or written, or holds something else.
    pub fn prepare(path: &Path, json: &str, kind: &'static str) -> Result<ReportDir, ReportDirError> {
        let io = |source| ReportDirError::Io { path: path.into(), source };
        match fs::metadata(path) {
            Ok(found) if !found.is_dir() => return Err(ReportDirError::NotAFolder { path: path.into() }),
            Ok(_) => {
                let is_empty = fs::read_dir(path).map_err(io)?.next().is_none();
                if !is_empty && !is_report(&path.join(json), kind) {
                    return Err(ReportDirError::Occupied { path: path.into(), kind });
                }
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => fs::create_dir_all(path).map_err(io)?,
            Err(error) => return Err(io(error)),
        }
        let dir = ReportDir { path: path.into() };
        // Before hours of work, not after.
        Destination::check(&dir.path.join(json))?;
        Ok(dir)
    }

    /// Writes one file of the report; by its name there is the old one, or the whole new one.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(
        &self,
        name: &str,
        fill: impl FnOnce(&mut dyn io::Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        Destination::check(&self.path.join(name))?.write(fill)
    }

    pub fn path(&self) -> &Path {
        &self.path
    }
}

fn is_report(path: &Path, kind: &str) -> bool {
    let parsed = fs::read(path).ok().and_then(|bytes| serde_json::from_slice::<serde_json::Value>(&bytes).ok());
    parsed.is_some_and(|json| json["report"] == kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_report_is_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let prepare = |name: &str| ReportDir::prepare(&folder.path().join(name), "a.json", "kind a");
        let dir = prepare("new/deeper").unwrap();
        dir.write("a.json", |out| write!(out, r#"{{"report":"kind a"}}"#)).unwrap();
        prepare("new/deeper").unwrap();
        assert!(matches!(prepare("new"), Err(ReportDirError::Occupied { .. })), "it holds a folder");
        for other in [r#"{"report":"kind b"}"#, "{}", "no json"] {
            dir.write("a.json", |out| out.write_all(other.as_bytes())).unwrap();
            assert!(matches!(prepare("new/deeper"), Err(ReportDirError::Occupied { .. })), "{other}");
        }
        assert!(matches!(prepare("new/deeper/a.json"), Err(ReportDirError::NotAFolder { .. })));
        assert!(matches!(prepare("new/deeper/a.json/b"), Err(ReportDirError::Io { .. })));
    }
}
