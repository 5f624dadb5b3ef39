//! The long run of random scenes seed after seed, an example of `csg-graph-bounds`.

use std::process::ExitCode;

use crate::example;

/// How many seeds, and where.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// So many seeds of each scene, as 1e6
    #[arg(long, value_name = "N", default_value = "1e6")]
    seeds: String,
    /// Only of the scenes whose path ends so
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
}

/// Builds the comparison and runs it. Its table goes to the standard output.
pub fn run(options: &Options) -> ExitCode {
    let Options { seeds, scene } = options;
    example::run("csg-graph-bounds", "seeds", &[("--seeds", Some(seeds)), ("--scene", scene.as_deref())])
}
