//! Files that appear whole or not at all: PNG, NPY, JSON.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
};

use sha2::{Digest, Sha256};

use crate::render::Picture;

/// What to write, and where to.
#[derive(Debug, Clone, Default)]
pub struct Outputs {
    /// The picture, PNG.
    pub picture: Option<Destination>,
    /// Record numbers, NPY, int64.
    pub ids: Option<Destination>,
    /// Depths, NPY, float32.
    pub depth: Option<Destination>,
    /// The report, JSON.
    pub report: Option<Destination>,
}

/// Why an output cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    #[error("cannot write {path}: there is no folder {folder}")]
    NoFolder { path: PathBuf, folder: PathBuf },
    #[error("cannot write {path}: it is a folder; give a file name")]
    IsFolder { path: PathBuf },
    #[error("cannot write {path}: {source}")]
    Io { path: PathBuf, source: io::Error },
}

/// A place for one output, known to be writable when it was made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Destination {
    /// A file that is written under another name and renamed when it is complete.
    File {
        /// As the user typed it.
        path: PathBuf,
        /// Without links, so that the same place has one name only.
        place: PathBuf,
    },
    /// Something that cannot be replaced, such as `/dev/null` or a pipe.
    Device(PathBuf),
    Stdout,
}

impl Destination {
    /// Checks that `path` (`-`: standard output) can be written, and leaves nothing behind.
    pub fn check(path: &Path) -> Result<Destination, OutputError> {
        if path == Path::new("-") {
            return Ok(Destination::Stdout);
        }
        let io_error = |source| OutputError::Io { path: path.into(), source };
        match fs::metadata(path) {
            Ok(found) if found.is_dir() => return Err(OutputError::IsFolder { path: path.into() }),
            Ok(found) if !found.is_file() => return Ok(Destination::Device(path.into())),
            Ok(_) => {
                // Renaming would replace a file that is protected against writing, and a link.
                OpenOptions::new().append(true).open(path).map_err(io_error)?;
                return Destination::check_folder(path, fs::canonicalize(path).map_err(io_error)?);
            }
            Err(e) if e.kind() == io::ErrorKind::NotFound => {}
            Err(e) => return Err(io_error(e)),
        }
        if path.file_name().is_none() || path.as_os_str().as_encoded_bytes().ends_with(b"/") {
            return Err(OutputError::IsFolder { path: path.into() });
        }
        let folder = folder_of(path);
        match (fs::canonicalize(folder), path.file_name()) {
            (Ok(real), Some(name)) if real.is_dir() => Destination::check_folder(path, real.join(name)),
            _ => Err(OutputError::NoFolder { path: path.into(), folder: folder.into() }),
        }
    }

    fn check_folder(path: &Path, place: PathBuf) -> Result<Destination, OutputError> {
        // No other question to the system gives a reliable answer (access lists, read-only mounts).
        let probe = unfinished_name(&place);
        let probed = OpenOptions::new().write(true).create_new(true).open(&probe).and_then(|_| fs::remove_file(&probe));
        match probed {
            Ok(()) => Ok(Destination::File { path: path.into(), place }),
            Err(source) => Err(OutputError::Io { path: path.into(), source }),
        }
    }

    /// What the user would call this place.
    pub fn path(&self) -> &Path {
        match self {
            Destination::File { path, .. } | Destination::Device(path) => path,
            Destination::Stdout => Path::new("-"),
        }
    }

    /// Writes the whole output with `fill`. Nothing by the final name exists until it is complete,
    /// and what was there before stays if it fails.
    pub fn write(&self, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), OutputError> {
        let written = match self {
            Destination::File { place, .. } => write_and_rename(place, fill),
            Destination::Device(path) => OpenOptions::new().write(true).open(path).and_then(|file| {
                let mut buffered = BufWriter::new(file);
                fill(&mut buffered)?;
                buffered.flush()
            }),
            Destination::Stdout => {
                let mut buffered = BufWriter::new(io::stdout().lock());
                let written = fill(&mut buffered).and_then(|()| buffered.flush());
                match written {
                    // A reader that has seen enough (`| head`) is no failure.
                    Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
                    other => other,
                }
            }
        };
        written.map_err(|source| OutputError::Io { path: self.path().into(), source })
    }
}

fn write_and_rename(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let unfinished = unfinished_name(path);
    let written = File::create(&unfinished).and_then(|file| {
        let mut buffered = BufWriter::new(file);
        fill(&mut buffered)?;
        buffered.flush()?;
        drop(buffered);
        fs::rename(&unfinished, path)
    });
    if written.is_err() {
        // The first error is the one that matters.
        let _ = fs::remove_file(&unfinished);
    }
    written
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// A name in the same folder (a rename across file systems fails), unlikely to be taken.
fn unfinished_name(path: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.unfinished", std::process::id()));
    folder_of(path).join(name)
}

/// SHA-256 of the picture's bytes, in hexadecimal: red, green, blue, alpha per pixel, row by row from
/// the top. It is that of the pixels and not of the PNG, which another compressor may write otherwise.
pub fn picture_sha256(picture: &Picture) -> String {
    let digest = Sha256::digest(picture.rgba.as_flattened());
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Writes the colours as an 8-bit RGB PNG.
pub fn write_png(out: &mut dyn Write, picture: &Picture) -> io::Result<()> {
    let mut encoder = png::Encoder::new(out, picture.width, picture.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.add_text_chunk("Software".into(), concat!("firstlight ", env!("CARGO_PKG_VERSION")).into())?;
    let rgb: Vec<u8> = picture.rgba.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&rgb)?;
    Ok(writer.finish()?)
}

/// Writes a `height` × `width` array of int64 in NumPy's format 1.0.
pub fn write_npy_i64(out: &mut dyn Write, size: [u32; 2], values: &[i64]) -> io::Result<()> {
    write_npy_header(out, "<i8", size)?;
    write_chunks(out, values, i64::to_le_bytes)
}

/// Writes a `height` × `width` array of float32 in NumPy's format 1.0.
pub fn write_npy_f32(out: &mut dyn Write, size: [u32; 2], values: &[f32]) -> io::Result<()> {
    write_npy_header(out, "<f4", size)?;
    write_chunks(out, values, f32::to_le_bytes)
}

fn write_npy_header(out: &mut dyn Write, descr: &str, [width, height]: [u32; 2]) -> io::Result<()> {
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({height}, {width}), }}");
    // Magic (6), version (2), length (2), header and its newline: a multiple of 64.
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&(header.len() as u16).to_le_bytes())?;
    out.write_all(header.as_bytes())
}

fn write_chunks<T: Copy, const N: usize>(
    out: &mut dyn Write,
    values: &[T],
    bytes: impl Fn(T) -> [u8; N],
) -> io::Result<()> {
    for &value in values {
        out.write_all(&bytes(value))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "old").unwrap();
        let destination = Destination::check(&path).unwrap();
        let failed = destination.write(|out| {
            out.write_all(b"half")?;
            Err(io::Error::other("disk full"))
        });
        assert!(failed.unwrap_err().to_string().ends_with("disk full"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        destination.write(|out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left behind");
    }

    #[test]
    fn what_cannot_be_written_is_said_before() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("no/such/a.png");
        assert!(matches!(Destination::check(&missing), Err(OutputError::NoFolder { .. })));
        assert!(matches!(Destination::check(folder.path()), Err(OutputError::IsFolder { .. })));
        let slash = folder.path().join("new/");
        assert!(matches!(Destination::check(&slash), Err(OutputError::IsFolder { .. })));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn npy_is_what_numpy_writes() {
        let mut bytes = Vec::new();
        write_npy_i64(&mut bytes, [3, 2], &[-1, 1, 2, 3, 4, 5]).unwrap();
        // numpy.save(np.arange(...).reshape(2, 3)) of NumPy 1.24 gives this header.
        assert_eq!(&bytes[..10], b"\x93NUMPY\x01\x00\x76\x00");
        assert!(bytes[10..].starts_with(b"{'descr': '<i8', 'fortran_order': False, 'shape': (2, 3), }  "));
        assert_eq!(bytes[127], b'\n');
        assert_eq!(&bytes[128..136], &[0xff; 8]);
        assert_eq!(bytes.len(), 128 + 6 * 8);
    }
}
