//! A picture of the scene in a file, at any size: drawn by the same backend, between two frames of the window.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::mpsc::{Receiver, TryRecvError, channel},
};

use eframe::egui::Context;

use crate::{
    headless::{Destination, write_png},
    render::Picture,
};

/// What is asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShotOptions {
    /// In pixels.
    pub size: [u32; 2],
    /// Not before all is read and the picture is final.
    pub wait: bool,
    pub path: PathBuf,
    /// Otherwise a file of that name stays, and the picture gets a number.
    pub may_replace: bool,
}

/// A picture on its way to a file, on a thread of its own: compressing one of 33 million pixels takes seconds.
pub struct Writing {
    done: Receiver<Result<PathBuf, String>>,
}

impl Writing {
    /// Starts to write.
    pub fn start(ctx: &Context, options: &ShotOptions, picture: Picture) -> Writing {
        let (to, done) = channel();
        let (ctx, options) = (ctx.clone(), options.clone());
        let write = move || {
            // Nobody listens once the window is closed.
            let _ = to.send(write(&options, &picture));
            ctx.request_repaint();
        };
        // Without a thread, the closed channel says so.
        let _ = std::thread::Builder::new().name("picture".into()).spawn(write);
        Writing { done }
    }

    /// Where it is, or why not, once.
    pub fn answer(&self) -> Option<Result<PathBuf, String>> {
        match self.done.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err("The picture was not written: no thread".into())),
        }
    }
}

fn write(options: &ShotOptions, picture: &Picture) -> Result<PathBuf, String> {
    let path = if options.may_replace { options.path.clone() } else { free_name(&options.path) };
    let destination = Destination::check(&path).map_err(|error| error.to_string())?;
    destination.write(|out| write_png(out, picture)).map_err(|error| error.to_string())?;
    Ok(std::path::absolute(&path).unwrap_or(path))
}

/// The name, with `.png` if it has no ending, and with a number if there is such a file.
pub fn free_name(path: &Path) -> PathBuf {
    let path = if path.extension().is_some() { path.to_path_buf() } else { path.with_extension("png") };
    let numbered = |n: u32| {
        let mut name = path.file_stem().unwrap_or_default().to_os_string();
        name.push(format!("-{n}."));
        name.push(path.extension().unwrap_or_default());
        path.with_file_name(name)
    };
    let free = |path: &PathBuf| fs::symlink_metadata(path).is_err();
    std::iter::once(path.clone()).chain((1..10_000).map(numbered)).find(free).unwrap_or(path)
}

/// `scan.png` beside a scan, or a picture of that name in the current folder for several.
pub fn default_path(first: Option<&Path>) -> PathBuf {
    first.map_or_else(|| PathBuf::from("firstlight.png"), |path| path.with_extension("png"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_written_and_replaces_nothing_unless_asked() {
        let folder = tempfile::tempdir().unwrap();
        let picture = Picture {
            width: 2,
            height: 1,
            rgba: vec![[1, 2, 3, 255], [4, 5, 6, 255]],
            records: vec![-1; 2],
            depth: vec![1.0; 2],
        };
        let path = folder.path().join("scan");
        let mut options = ShotOptions { size: [2, 1], wait: false, path, may_replace: false };
        let first = write(&options, &picture).unwrap();
        assert_eq!(first, folder.path().join("scan.png"));
        let mut reader =
            png::Decoder::new(std::io::BufReader::new(fs::File::open(&first).unwrap())).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.width, info.height), (2, 1));
        assert_eq!(write(&options, &picture).unwrap(), folder.path().join("scan-1.png"));
        options.path = first.clone();
        options.may_replace = true;
        assert_eq!(write(&options, &picture).unwrap(), first);
        options.path = folder.path().join("no such folder/x.png");
        let told = write(&options, &picture).unwrap_err();
        assert!(told.contains("no such folder") && !told.contains('\n'), "{told}");
    }
}
