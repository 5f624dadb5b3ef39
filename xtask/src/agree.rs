//! The long run of the comparison of all engines, an example of `csg-graph-trace`.

use std::process::ExitCode;

use crate::example;

/// How many rays, and where.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// At least so many rays in each scene, as 1e6
    #[arg(long, value_name = "N", default_value = "1e6")]
    rays: String,
    /// Only in the scenes whose path ends so
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
}

/// Builds the comparison and runs it. Its table goes to the standard output.
pub fn run(options: &Options) -> ExitCode {
    let Options { rays, scene } = options;
    example::run("csg-graph-trace", "agree", &[("--rays", Some(rays)), ("--scene", scene.as_deref())])
}
