//! The long runs of what tests do in short: examples of the crates, run as programs of their own with the arguments that
//! the chore was given.
//!
//! Each is made of one crate alone and is packaged with it, and the tests include its code.

use std::io;
use std::process::{Command, ExitCode, Stdio};

use crate::{exit_code, repository};

/// Builds an example and runs it. What it prints is the result.
pub(crate) fn run(package: &str, example: &str, arguments: &[(&str, Option<&str>)]) -> ExitCode {
    let mut command = cargo_run(package, ["--example", example]);
    for (name, value) in arguments {
        command.args(value.iter().flat_map(|value| [name, value]));
    }
    match command.status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => exit_code(Err(format!("cargo cannot be run: {error}"))),
    }
}

/// Runs a command for what it prints.
pub(crate) fn printed(command: &mut Command) -> io::Result<String> {
    let output = command.stderr(Stdio::inherit()).output()?;
    if !output.status.success() {
        return Err(io::Error::other(output.status.to_string()));
    }
    String::from_utf8(output.stdout).map_err(io::Error::other)
}

/// The command that builds a program of a package for release and runs it, to which arguments may be added.
pub(crate) fn cargo_run(package: &str, [kind, name]: [&str; 2]) -> Command {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(repository());
    command.args(["run", "--quiet", "--release", "--package", package, kind, name, "--"]);
    command
}
