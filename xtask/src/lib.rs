//! The chores of this repository, for the program and for the tests.

pub mod agree;
mod example;
pub mod figures;
pub mod gallery;
pub mod golden;
pub mod peers;
pub mod prove;
pub mod seeds;
pub mod solids;

use std::path::{Path, PathBuf};

/// The folder of the repository.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the package is in a folder of the repository")
        .to_owned()
}
