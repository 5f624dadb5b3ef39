//! The long run of the prover, an example of `csg-graph-bounds`.

use std::process::ExitCode;

use crate::example;

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
pub fn run(options: &Options) -> ExitCode {
    let Options { points, seed, threads, graph } = options;
    let arguments = [
        ("--points", Some(points.as_str())),
        ("--seed", Some(seed)),
        ("--threads", threads.as_deref()),
        ("--graph", graph.as_deref()),
    ];
    example::run("csg-graph-bounds", "prove", &arguments)
}
