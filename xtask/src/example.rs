//! The long runs of what tests do in short: examples of the crates, run as programs of their own with the arguments that
//! the chore was given.
//!
//! Each is made of one crate alone and is packaged with it, and the tests include its code.

use std::process::{Command, ExitCode};

use crate::repository;

/// Builds an example and runs it. What it prints is the result.
#[expect(clippy::print_stderr, reason = "the report of a chore")]
pub(crate) fn run(package: &str, example: &str, arguments: &[(&str, Option<&str>)]) -> ExitCode {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(repository());
    command.args(["run", "--quiet", "--release", "--package", package, "--example", example, "--"]);
    for (name, value) in arguments {
        command.args(value.iter().flat_map(|value| [name, value]));
    }
    match command.status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: cargo cannot be run: {error}");
            ExitCode::FAILURE
        }
    }
}
