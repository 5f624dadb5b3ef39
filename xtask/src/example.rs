//! The long runs of what tests do in short: examples of the crates, run as programs of their own with the arguments that
//! the chore was given.
//!
//! Each is made of one crate alone and is packaged with it, and the tests include its code.

use std::io;
use std::process::{Command, ExitCode, Stdio};

use crate::repository;

/// Builds an example and runs it. What it prints is the result.
#[expect(clippy::print_stderr, reason = "the report of a chore")]
pub(crate) fn run(package: &str, example: &str, arguments: &[(&str, Option<&str>)]) -> ExitCode {
    let mut command = cargo_run(package, example);
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

/// Builds an example and runs it for what it prints.
pub(crate) fn output(package: &str, example: &str) -> io::Result<String> {
    let output = cargo_run(package, example).stderr(Stdio::inherit()).output()?;
    if !output.status.success() {
        return Err(io::Error::other(output.status.to_string()));
    }
    String::from_utf8(output.stdout).map_err(io::Error::other)
}

/// The command, to which arguments may be added.
fn cargo_run(package: &str, example: &str) -> Command {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(repository());
    command.args(["run", "--quiet", "--release", "--package", package, "--example", example, "--"]);
    command
}
