//! The `pcsg` program as a library: its arguments, and a function that runs them.
//!
//! This is the only crate of the system that touches files and terminals. Each command is a module; [`run`] is all that
//! a program around it needs; [`render::picture`] and [`bounds::drawing`] serve those who want a picture and not the file.

mod args;
pub mod bench;
pub mod bounds;
mod check;
mod engine;
mod extent;
mod failure;
mod fmt;
mod graph;
mod interrupt;
mod load;
mod output;
mod plot;
mod process;
mod progress;
mod regime;
pub mod render;
mod stage;
mod text;

use std::io::Write;
use std::process::ExitCode;

use clap::CommandFactory;

pub use args::{
    BenchArgs, BooleansArg, BoundsArgs, BoxesArg, CheckArgs, Cli, Command, EngineArg, EngineArgs, FmtArgs,
    Format, GraphArgs, GraphFormat, IntegratorArg, MethodArg, RenderArgs, SceneArgs, Size, StepsArg, Sweep,
    ViewArg, VolumeArg,
};
pub use failure::Failure;

/// Runs a command and reports why it failed, if it does.
///
/// Results go to standard output, everything else to standard error. The exit code is 0, 1 for a mistake in the input, or
/// 2 for arguments that do not fit together; what parsing alone can tell never comes this far. A render that was interrupted
/// gives 130.
pub fn run(command: Command) -> ExitCode {
    let result = match command {
        Command::Render(args) => render::run(&args),
        Command::Bounds(args) => bounds::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Graph(args) => graph::run(&args),
        Command::Fmt(args) => fmt::run(&args),
        Command::Completions { shell } => completions(shell),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) if failure.is_closed_pipe() => ExitCode::SUCCESS,
        Err(failure @ Failure::Interrupted { .. }) => {
            say(&failure);
            failure.exit_code()
        }
        Err(failure) => {
            say(format_args!("\x1b[1;91merror\x1b[0m: {failure}"));
            failure.exit_code()
        }
    }
}

fn completions(shell: clap_complete::Shell) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "pcsg", &mut script);
    print(&script)
}

/// Writes a line to standard error, where colours are left out if it is no terminal. Whoever closed it does not want to
/// know.
fn say(line: impl std::fmt::Display) {
    let _ = writeln!(anstream::stderr(), "{line}");
}

/// Writes a result to standard output.
fn print(text: impl AsRef<[u8]>) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_ref())?;
    out.flush()?;
    Ok(())
}
