//! Exit codes and the errors behind them.

use crate::{
    headless::HeadlessError,
    measure::{
        BenchError, ReportDirError, converge::ConvergeError, ingest::IngestError, raster::RasterError,
        stability::StabilityError,
    },
    methods::MethodError,
    render::RenderError,
    synth::SynthError,
    view::ViewError,
};

/// The process's exit code. Listed for users in `HELP`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum ExitStatus {
    Ok = 0,
    /// A defect of the program, or of a driver.
    Internal = 1,
    /// The command line, or the camera file, is wrong.
    Usage = 2,
    /// None of the inputs can be read.
    Input = 3,
    /// The outputs are written, but points are missing.
    Partial = 4,
    /// An output cannot be written.
    Output = 5,
    /// No device does what was asked.
    Device = 6,
}

/// What `--help` says of [`ExitStatus`].
pub const HELP: &str = "\
Exit codes:
  0  done
  1  internal error
  2  the command line or the camera file is wrong
  3  no input can be read: missing, or not LAS/LAZ
  4  partly read: outputs are written, but points are missing (damaged input, or memory ran out)
  5  an output cannot be written
  6  no device does what was asked (--backend, --method, --size)";

/// Why the program ends early.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    #[error("{0}")]
    Usage(String),
    #[error(transparent)]
    Headless(#[from] HeadlessError),
    #[error("{error}; {help}")]
    NoDevice { error: RenderError, help: &'static str },
    #[error(transparent)]
    Synth(#[from] SynthError),
    #[error(transparent)]
    View(#[from] ViewError),
    #[error(transparent)]
    Bench(#[from] BenchError),
    #[error(transparent)]
    Ingest(#[from] IngestError),
    #[error(transparent)]
    Raster(#[from] RasterError),
    #[error(transparent)]
    Converge(#[from] ConvergeError),
    #[error(transparent)]
    Stability(#[from] StabilityError),
    #[error(transparent)]
    ReportDir(#[from] ReportDirError),
}

impl CliError {
    pub fn status(&self) -> ExitStatus {
        match self {
            CliError::Usage(_) => ExitStatus::Usage,
            CliError::Headless(error) => match error {
                HeadlessError::Input(_) => ExitStatus::Input,
                HeadlessError::Output(_) => ExitStatus::Output,
                HeadlessError::Camera(_) | HeadlessError::TooWide(_) => ExitStatus::Usage,
                HeadlessError::Render(RenderError::DeviceLost(_)) | HeadlessError::ReaderEnded => ExitStatus::Internal,
                HeadlessError::Render(_) => ExitStatus::Device,
            },
            CliError::Synth(SynthError::Io { .. } | SynthError::Compress { .. }) => ExitStatus::Output,
            CliError::Synth(_) => ExitStatus::Usage,
            CliError::NoDevice { .. } | CliError::View(_) => ExitStatus::Device,
            CliError::Bench(error) => match error {
                BenchError::Source(_) | BenchError::NoPoints => ExitStatus::Input,
                BenchError::Camera(_) | BenchError::TooWide(_) => ExitStatus::Usage,
                BenchError::Render(_) => ExitStatus::Device,
            },
            CliError::Ingest(error) => match error {
                IngestError::Source(_) | IngestError::ReadAlone { .. } | IngestError::Unsteady { .. } => {
                    ExitStatus::Input
                }
                IngestError::Camera(_) | IngestError::Against { .. } => ExitStatus::Usage,
                IngestError::Render(_) => ExitStatus::Device,
            },
            CliError::Raster(error) => match error {
                RasterError::Source(_) | RasterError::NoPoints => ExitStatus::Input,
                RasterError::Camera(_) | RasterError::Synth(_) => ExitStatus::Usage,
                RasterError::Render(_) | RasterError::Methods(_) => ExitStatus::Device,
                RasterError::ReportDir(_) => ExitStatus::Output,
            },
            CliError::Converge(error) => match error {
                ConvergeError::Source(_) | ConvergeError::NoPoints => ExitStatus::Input,
                ConvergeError::Camera(_)
                | ConvergeError::Synth(_)
                | ConvergeError::TooWide(_)
                | ConvergeError::AutoNeedsTime => ExitStatus::Usage,
                ConvergeError::Render(RenderError::DeviceLost(_)) => ExitStatus::Internal,
                ConvergeError::Render(_) => ExitStatus::Device,
                ConvergeError::ReportDir(_) => ExitStatus::Output,
            },
            CliError::Stability(error) => match error {
                StabilityError::Render(RenderError::DeviceLost(_))
                | StabilityError::Methods(MethodError::Render(RenderError::DeviceLost(_)))
                | StabilityError::Camera(_)
                | StabilityError::NoMethod(_) => ExitStatus::Internal,
                StabilityError::Render(_) | StabilityError::Methods(_) => ExitStatus::Device,
                StabilityError::ReportDir(_) => ExitStatus::Output,
            },
            CliError::ReportDir(_) => ExitStatus::Output,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_status_is_documented() {
        use ExitStatus::*;
        for status in [Ok, Internal, Usage, Input, Partial, Output, Device] {
            assert!(HELP.contains(&format!("\n  {}  ", status as u8)), "{status:?}");
        }
    }
}
