//! From what the user named to a list of files: files stay as they are, folders give their .las and
//! .laz files (also those of their subfolders), sorted by path.

use std::path::{Path, PathBuf};

use super::SourceError;

/// Folders nested deeper than this are not searched.
const MAX_DEPTH: usize = 64;

/// Lists the files to read, in order, and what is wrong with the inputs that gave none.
pub fn list(inputs: &[PathBuf]) -> (Vec<PathBuf>, Vec<(PathBuf, SourceError)>) {
    let mut files = Vec::new();
    let mut errors = Vec::new();
    for input in inputs {
        match std::fs::metadata(input) {
            Ok(meta) if meta.is_dir() => {
                let (before, errors_before) = (files.len(), errors.len());
                search(input, 0, &mut files, &mut errors);
                if files.len() == before && errors.len() == errors_before {
                    errors.push((input.clone(), SourceError::EmptyFolder { path: input.clone() }));
                }
                files[before..].sort();
            }
            // What a file is, and whether it can be read, is for the header reader to find out.
            Ok(_) => files.push(input.clone()),
            Err(error) => errors.push((input.clone(), from_io(input, "look at it", &error))),
        }
    }
    if inputs.is_empty() {
        errors.push((PathBuf::new(), SourceError::NoInput));
    }
    (files, errors)
}

/// Turns an I/O error into one line that names the path.
pub fn from_io(path: &Path, doing: &'static str, error: &std::io::Error) -> SourceError {
    match error.kind() {
        std::io::ErrorKind::NotFound => SourceError::NotFound { path: path.into() },
        _ => SourceError::Io { path: path.into(), doing, reason: error.to_string() },
    }
}

/// A folder that cannot be listed is an error and does not hide the rest.
fn search(folder: &Path, depth: usize, files: &mut Vec<PathBuf>, errors: &mut Vec<(PathBuf, SourceError)>) {
    let mut fail = |error: &std::io::Error| {
        errors.push((folder.into(), from_io(folder, "list the folder", error)));
    };
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) => return fail(&error),
    };
    let mut folders = Vec::new();
    for entry in entries {
        let entry = match entry {
            Ok(entry) => entry,
            Err(error) => {
                fail(&error);
                continue;
            }
        };
        let path = entry.path();
        // `file_type` does not follow links: a linked folder may lead back to where we are.
        let Ok(kind) = entry.file_type() else { continue };
        if kind.is_dir() {
            folders.push(path);
        } else if is_las_name(&path) && (kind.is_file() || path.is_file()) {
            files.push(path);
        }
    }
    for path in folders {
        if depth < MAX_DEPTH {
            search(&path, depth + 1, files, errors);
        } else {
            let reason = format!("folders are searched {MAX_DEPTH} deep");
            errors.push((path.clone(), SourceError::Io { path, doing: "list the folder", reason }));
        }
    }
}

fn is_las_name(path: &Path) -> bool {
    path.extension()
        .and_then(|e| e.to_str())
        .is_some_and(|e| e.eq_ignore_ascii_case("las") || e.eq_ignore_ascii_case("laz"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_searched_and_sorted_and_files_kept_in_the_order_given() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::create_dir(dir.path().join("b")).unwrap();
        for name in ["z.LAZ", "a.las", "b/c.Las", "readme.txt", "z.las.aux"] {
            std::fs::write(dir.path().join(name), b"").unwrap();
        }
        let (files, errors) = list(&[dir.path().join("z.LAZ"), dir.path().to_path_buf()]);
        let names: Vec<_> = files.iter().map(|f| f.strip_prefix(dir.path()).unwrap().to_str().unwrap()).collect();
        assert_eq!(names, ["z.LAZ", "a.las", "b/c.Las", "z.LAZ"]);
        assert!(errors.is_empty());
    }

    #[test]
    fn what_gives_no_file_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let missing = dir.path().join("missing.las");
        let (files, errors) = list(&[missing.clone(), dir.path().to_path_buf()]);
        assert!(files.is_empty());
        assert_eq!(errors[0].1, SourceError::NotFound { path: missing });
        assert_eq!(errors[1].1, SourceError::EmptyFolder { path: dir.path().to_path_buf() });
        assert_eq!(list(&[]).1[0].1, SourceError::NoInput);
    }
}
