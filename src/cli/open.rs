//! `firstlight IN…`: the window, or a picture where there is none.

use std::{
    fs,
    path::{Path, PathBuf},
    time::Instant,
};

use clap::Args;

use super::{
    CliError, ExitStatus,
    look::LookArgs,
    render::{progress_style, tell},
    say, values,
};
use crate::{
    headless::{self, BackendChoice, Destination, HeadlessError, Outputs, Settings, Stop},
    render::{INSERTION_POINTS, PointSize, RasterChoice},
    view::{self, ViewError},
};

#[derive(Debug, Args)]
pub struct OpenArgs {
    /// LAS and LAZ files, and folders of them; without any, the window waits for them to be dropped.
    /// A file called like a command is opened as `./render`
    #[arg(value_name = "IN")]
    inputs: Vec<PathBuf>,
    /// How the GPU turns points into pixels: a method's name, or NAME:64 (:128, :256) with its workgroup
    /// size; auto measures which is the fastest
    #[arg(long, value_name = "auto|NAME", default_value = "auto", value_parser = values::parse_method)]
    method: RasterChoice,
    /// Fixes the order of the points in the store
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Random points that each frame tries (1M, 250k, …); by default as many as a frame's time allows
    #[arg(long, value_name = "N", value_parser = values::parse_points)]
    fill: Option<u32>,
    /// Decoder threads; by default one per core, less one
    #[arg(long, value_name = "N", value_parser = values::parse_threads)]
    threads: Option<usize>,
    /// Ignore what the window remembers from earlier runs (looks, panels, recent files), and remember nothing
    #[arg(long)]
    fresh: bool,
    #[command(flatten)]
    look: LookArgs,
}

/// Width of a point in the window, pixels: at one, near surfaces have holes in motion.
const WINDOW_POINT_SIZE: PointSize = PointSize::Pixels(2);

/// `given`: fields of the look that the command line says, for they win over what is remembered.
pub fn run(args: OpenArgs, given: Vec<&'static str>, started: Instant) -> Result<ExitStatus, CliError> {
    if !view::has_display() {
        return picture_instead(args, started, "no display");
    }
    let options = view::Options {
        inputs: args.inputs.clone(),
        method: args.method,
        look: args.look.look(WINDOW_POINT_SIZE),
        given,
        settings: if args.fresh { None } else { view::settings_place() },
        seed: args.seed,
        fill: args.fill,
        threads: args.threads,
    };
    match view::run(options) {
        Ok(()) => Ok(ExitStatus::Ok),
        Err(error @ (ViewError::NoAdapter(_) | ViewError::NoDisplay(_))) if !args.inputs.is_empty() => {
            picture_instead(args, started, &error.to_string())
        }
        Err(error) => Err(error.into()),
    }
}

/// A picture next to the input, for machines that cannot open a window.
fn picture_instead(args: OpenArgs, started: Instant, why: &str) -> Result<ExitStatus, CliError> {
    let Some(first) = args.inputs.first() else {
        return Err(CliError::Usage(format!(
            "{why}, so no window opens; give a file to get its picture: firstlight scan.laz, \
             or firstlight render scan.laz -o scan.png"
        )));
    };
    let picture = picture_beside(first).map_err(HeadlessError::from)?;
    // Otherwise the next line says that there is nothing to draw.
    if args.inputs.iter().any(|input| input.exists()) {
        say(&format!("firstlight: {why}; writing the picture to {} instead", picture.path().display()));
    }
    let settings = Settings {
        outputs: Outputs { picture: Some(picture), ..Default::default() },
        size: [1600, 900],
        camera: None,
        backend: BackendChoice::Auto,
        method: args.method,
        encoding: None,
        fill: args.fill,
        look: args.look.look(WINDOW_POINT_SIZE),
        seed: args.seed,
        insertion_points: INSERTION_POINTS,
        stop: Stop::Converged,
        brute_force: false,
        threads: args.threads,
        progress: progress_style(false),
        started,
        inputs: args.inputs,
    };
    let report = headless::render(&settings)?;
    Ok(tell(&report, false))
}

/// `scan.png` beside `scan.laz`, in the current folder if that one cannot be written; `scan-1.png`
/// and so on if there is one already: nobody named this file, so none may be lost to it.
fn picture_beside(input: &Path) -> Result<Destination, headless::OutputError> {
    // `.` and `..` have no name of their own.
    let input = fs::canonicalize(input).ok().filter(|_| input.file_name().is_none()).unwrap_or(input.into());
    let stem = input.file_stem().filter(|_| !input.is_dir()).or(input.file_name()).unwrap_or("firstlight".as_ref());
    let free_name = |folder: &Path| {
        let numbered = |n: u32| {
            let mut name = stem.to_os_string();
            name.push(if n == 0 { ".png".into() } else { format!("-{n}.png") });
            folder.join(name)
        };
        (0..1000).map(numbered).find(|path| fs::symlink_metadata(path).is_err()).unwrap_or_else(|| numbered(1000))
    };
    let beside = input.parent().unwrap_or(Path::new(""));
    Destination::check(&free_name(beside)).or_else(|_| Destination::check(&free_name(Path::new(""))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_lies_beside_the_scan_and_replaces_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let scan = folder.path().join("scan.laz");
        fs::write(&scan, "").unwrap();
        let beside = || picture_beside(&scan).unwrap().path().to_path_buf();
        assert_eq!(beside(), folder.path().join("scan.png"));
        fs::write(folder.path().join("scan.png"), "mine").unwrap();
        assert_eq!(beside(), folder.path().join("scan-1.png"));
        let of_folder = picture_beside(&folder.path().join(".")).unwrap();
        assert_eq!(of_folder.path().extension().unwrap(), "png");
    }
}
