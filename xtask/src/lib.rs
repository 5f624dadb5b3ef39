//! The chores of this repository, for the program and for the tests.

pub mod agree;
mod example;
pub mod figures;
pub mod gallery;
pub mod golden;
mod line;
pub mod peers;
pub mod prove;
pub mod seeds;
pub mod solids;

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The folder of the repository.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the package is in a folder of the repository")
        .to_owned()
}

/// How a chore ends, and what it says if it failed.
#[expect(clippy::print_stderr, reason = "the report of a chore")]
pub fn exit_code(result: Result<(), impl Display>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
