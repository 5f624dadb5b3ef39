//! `pcsg`: recursive solids, from a grammar file to a picture.

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    csg_graph_cli::run(csg_graph_cli::Cli::parse().command)
}
