//! Files that appear whole or not at all.
//!
//! A file is written beside its place and then takes the place, so that a failure leaves the old file untouched and nothing
//! half-written. It is written at once when its content is complete: a program that is interrupted during the long work
//! before has nothing to clean up.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::Failure;

/// Fails if the file could not be written: long work should not be for nothing.
pub(crate) fn check_writable(path: &Path) -> Result<(), Failure> {
    match Place::of(path).map_err(Failure::file(path, "write it"))? {
        Place::File(place) => beside(&place).map(drop),
        Place::Device => OpenOptions::new().write(true).open(path).map(drop),
    }
    .map_err(Failure::file(path, "write it"))
}

/// Writes the file.
pub(crate) fn write(path: &Path, content: &[u8]) -> Result<(), Failure> {
    write_with(path, |file| file.write_all(content))
}

/// Writes the file piece by piece.
pub(crate) fn write_with(
    path: &Path,
    content: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<(), Failure> {
    let write = || match Place::of(path)? {
        Place::File(place) => {
            let mut file = beside(&place)?;
            content(file.as_file_mut())?;
            if let Ok(old) = fs::metadata(&place) {
                file.as_file().set_permissions(old.permissions())?;
            }
            file.persist(&place).map(drop).map_err(|error| error.error)
        }
        Place::Device => content(&mut OpenOptions::new().write(true).open(path)?),
    };
    write().map_err(Failure::file(path, "write it"))
}

/// What a path leads to.
enum Place {
    /// A file, or where one will be. Links are followed: what they point to is replaced, not they.
    File(PathBuf),
    /// Something that takes bytes and cannot be replaced, such as `/dev/stdout`.
    Device,
}

impl Place {
    fn of(path: &Path) -> io::Result<Self> {
        match fs::metadata(path) {
            Ok(found) if found.is_dir() => Err(io::Error::other("it is a folder")),
            Ok(found) if found.is_file() && found.permissions().readonly() => {
                Err(io::Error::other("it is write-protected"))
            }
            Ok(found) if found.is_file() => Ok(Self::File(fs::canonicalize(path)?)),
            Ok(_) => Ok(Self::Device),
            Err(_) => end_of_links(path).map(Self::File),
        }
    }
}

/// Where a file will be that is not there yet: where links lead that lead to nothing.
fn end_of_links(path: &Path) -> io::Result<PathBuf> {
    /// As many as Linux follows.
    const MOST: usize = 40;
    let mut place = path.to_owned();
    for _ in 0..MOST {
        match fs::read_link(&place) {
            // What is relative is so to the folder of the link.
            Ok(target) => place = place.parent().unwrap_or(Path::new("")).join(target),
            Err(_) => return Ok(place),
        }
    }
    Err(io::Error::other("it is a link that leads back to itself"))
}

/// Whether two paths lead to the same file, or will.
pub(crate) fn is_same(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        fs::canonicalize(path).or_else(|_| {
            let place = end_of_links(path)?;
            Ok::<_, io::Error>(fs::canonicalize(folder(&place))?.join(place.file_name().unwrap_or_default()))
        })
    };
    a == b || matches!((place(a), place(b)), (Ok(a), Ok(b)) if a == b)
}

/// The folder that a file is in.
fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// A temporary file in the same folder, which is removed when it is dropped.
fn beside(path: &Path) -> io::Result<NamedTempFile> {
    let folder = folder(path);
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pcsg-").suffix(".part");
    // The usual permissions of a new file, of which the system takes what the user wants to be taken.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder).map_err(|error| {
        if folder.is_dir() {
            // Without the name of the temporary file, of which nobody has heard.
            error.kind().into()
        } else {
            io::Error::other(format!("there is no folder {}", folder.display()))
        }
    })
}
