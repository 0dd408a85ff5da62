//! The system's dialogs, each on a thread of its own: the picture goes on meanwhile.

use std::{
    path::PathBuf,
    sync::mpsc::{Receiver, TryRecvError, channel},
    time::{Duration, Instant},
};

use eframe::egui::Context;

use super::requests::Choose;

/// Nobody dismisses a dialog faster: then none appeared.
const TOO_FAST: Duration = Duration::from_millis(300);

/// One dialog at a time.
#[derive(Default)]
pub struct Dialogs {
    open: Option<Open>,
}

struct Open {
    what: Choose,
    add: bool,
    since: Instant,
    chosen: Receiver<Option<Vec<PathBuf>>>,
}

/// What came of a dialog.
#[derive(Debug, PartialEq, Eq)]
pub enum Chosen {
    Files {
        inputs: Vec<PathBuf>,
        add: bool,
    },
    Picture(PathBuf),
    /// There was none to be seen, and what to do instead.
    NoDialog(&'static str),
}

impl Dialogs {
    /// Shows a dialog, unless one is open. It begins in `folder`, for a picture with the file's name.
    pub fn show(&mut self, ctx: &Context, what: Choose, add: bool, at: Option<PathBuf>) {
        if self.open.is_some() {
            return;
        }
        let (to, chosen) = channel();
        let ctx = ctx.clone();
        let ask = move || {
            // Nobody listens once the window is closed.
            let _ = to.send(ask(what, at));
            ctx.request_repaint();
        };
        // Without a thread there is no dialog, and the closed channel says so.
        let _ = std::thread::Builder::new().name("dialog".into()).spawn(ask);
        self.open = Some(Open { what, add, since: Instant::now(), chosen });
    }

    /// What was chosen, once.
    pub fn answer(&mut self) -> Option<Chosen> {
        let open = self.open.as_ref()?;
        let chosen = match open.chosen.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Ok(chosen) => chosen,
            Err(TryRecvError::Disconnected) => None,
        };
        let Open { what, add, since, .. } = self.open.take()?;
        match (chosen, what) {
            (None, _) if since.elapsed() > TOO_FAST => None,
            (None, Choose::Picture) => {
                Some(Chosen::NoDialog("No save dialog (no desktop portal answers): type the picture's path instead"))
            }
            (None, _) => Some(Chosen::NoDialog(
                "No open dialog (no desktop portal answers): type a path under Files, or drop files on the window",
            )),
            (Some(paths), Choose::Picture) => paths.into_iter().next().map(Chosen::Picture),
            (Some(inputs), _) => Some(Chosen::Files { inputs, add }),
        }
    }
}

fn ask(what: Choose, at: Option<PathBuf>) -> Option<Vec<PathBuf>> {
    let mut dialog = rfd::FileDialog::new();
    if let Some(at) = at {
        let folder = if at.is_dir() { Some(at.as_path()) } else { at.parent() };
        if let Some(folder) = folder.filter(|folder| folder.is_dir()) {
            dialog = dialog.set_directory(folder);
        }
        if let (Choose::Picture, Some(name)) = (what, at.file_name()) {
            dialog = dialog.set_file_name(name.to_string_lossy());
        }
    }
    match what {
        Choose::Files => dialog
            .set_title("Open scans")
            .add_filter("LAS and LAZ", &["las", "laz", "LAS", "LAZ"])
            .add_filter("All files", &["*"])
            .pick_files(),
        Choose::Folder => dialog.set_title("Open folders of scans").pick_folders(),
        Choose::Picture => {
            dialog.set_title("Save the picture").add_filter("PNG", &["png"]).save_file().map(|path| vec![path])
        }
    }
}
