//! Files that appear whole or not at all.
//!
//! A file is written beside its place and then takes the place, so that a failure leaves the old file untouched and nothing
//! half-written. It is written at once when its content is complete: a program that is interrupted during the long work
//! before has nothing to clean up.

use std::io::{self, Write};
use std::path::Path;

use tempfile::NamedTempFile;

use crate::Failure;

/// Fails if the file could not be written: long work should not be for nothing.
pub(crate) fn check_writable(path: &Path) -> Result<(), Failure> {
    beside(path).map(drop)
}

/// Writes the file.
pub(crate) fn write(path: &Path, content: &[u8]) -> Result<(), Failure> {
    let mut file = beside(path)?;
    file.write_all(content).map_err(Failure::file(path, "write it"))?;
    let placed = file.persist(path);
    placed.map(drop).map_err(|error| Failure::file(path, "write it")(error.error))
}

/// A temporary file in the same folder, which is removed when it is dropped.
fn beside(path: &Path) -> Result<NamedTempFile, Failure> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if path.is_dir() {
        return Err(Failure::file(path, "write it")(io::Error::other("it is a folder")));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pcsg-").suffix(".part");
    // The usual permissions of a new file, of which the system takes what the user wants to be taken.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder).map_err(Failure::file(path, "write it"))
}
