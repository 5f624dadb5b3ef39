//! The program as a stranger meets it: what it prints, where, and with which exit code.

mod bench;
mod bounds;
mod bounds_document;
mod check;
mod files;
mod fmt;
mod graph;
mod layers;
mod regimes;
mod render;
#[cfg(unix)]
mod resume;
mod usage;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// A file of the repository.
fn repository(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

/// A scene of the corpus.
fn scene(name: &str) -> PathBuf {
    repository("scenes").join(name)
}

/// A path as an argument.
fn path(path: &Path) -> &str {
    path.to_str().expect("the repository is in a folder with a plain name")
}

/// The program with arguments, to be run in a folder.
fn pcsg(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pcsg"));
    command.current_dir(folder).args(args);
    command
}

/// Runs the program in an empty folder; gives the exit code, both outputs, and the names of the files that it left.
fn run(args: &[&str]) -> (i32, String, String, Vec<String>) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    run_in(folder.path(), args)
}

/// The same in a folder that may have files.
fn run_in(folder: &Path, args: &[&str]) -> (i32, String, String, Vec<String>) {
    let output = pcsg(folder, args).output().expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("the program speaks UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr), files(folder))
}

/// The names of the files in a folder, in order.
fn files(folder: &Path) -> Vec<String> {
    let mut files: Vec<_> = fs::read_dir(folder)
        .expect("the folder is there")
        .map(|entry| entry.expect("it can be read").file_name().to_string_lossy().into_owned())
        .collect();
    files.sort();
    files
}

/// A file of JSON.
fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("the file is there")).expect("it is JSON")
}
