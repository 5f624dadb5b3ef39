//! Files that appear whole or not at all.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::Failure;

/// A file that is being written beside its final place and takes the place when it is complete. Dropped before that, it
/// leaves nothing behind and the old file untouched.
#[derive(Debug)]
pub(crate) struct Pending {
    file: NamedTempFile,
    path: PathBuf,
}

impl Pending {
    /// Begins a file. A folder that is missing or read-only shows now, before any long work.
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        if path.is_dir() {
            return Err(Failure::file(path, "write it")(io::Error::other("it is a folder")));
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(".pcsg-").suffix(".part");
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let file = builder.tempfile_in(folder).map_err(Failure::file(path, "write it"))?;
        Ok(Self { file, path: path.to_owned() })
    }

    /// Writes the whole content and puts the file in place.
    pub(crate) fn finish(mut self, content: &[u8]) -> Result<(), Failure> {
        self.file.write_all(content).map_err(Failure::file(&self.path, "write it"))?;
        let placed = self.file.persist(&self.path);
        placed.map(drop).map_err(|error| Failure::file(&self.path, "write it")(error.error))
    }
}
