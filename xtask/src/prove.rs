//! The long run of the prover: an example of `csg-graph-bounds`, which this runs with the arguments that it was given.
//!
//! As a program of its own, because it is made of that crate alone: it is packaged with it, and a short run of the same
//! code is one of its tests.

use std::process::{Command, ExitCode};

use crate::repository;

/// How long and from where.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// At least so many points, as 1e8
    #[arg(long, value_name = "N", default_value = "1e8")]
    points: String,
    /// Which random graphs
    #[arg(long, value_name = "N", default_value = "0")]
    seed: String,
    /// As many as there are cores, if not given
    #[arg(long, value_name = "N")]
    threads: Option<String>,
    /// Only this graph of the run, as the report of an escape names it
    #[arg(long, value_name = "N")]
    graph: Option<String>,
}

/// Builds the prover and runs it. Its table goes to the standard output.
#[expect(clippy::print_stderr, reason = "the report of a chore")]
pub fn run(options: &Options) -> ExitCode {
    let Options { points, seed, threads, graph } = options;
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(repository());
    command.args([
        "run",
        "--quiet",
        "--release",
        "--package",
        "csg-graph-bounds",
        "--example",
        "prove",
        "--",
    ]);
    command.args(["--points", points, "--seed", seed]);
    for (name, value) in [("--threads", threads), ("--graph", graph)] {
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
