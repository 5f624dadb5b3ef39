//! The arguments of `bench`.

use clap::Args;

use super::{EngineArgs, Format, SceneArgs, Size};

/// Arguments of `bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// What to trace.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Width and height in pixels; each pixel has one ray
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, default_value = "512x512")]
    pub size: Size,
    /// Threads
    #[arg(long, value_name = "N", allow_hyphen_values = true, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub threads: u32,
    /// Repetitions, of which the median counts; one more goes before them to warm up
    #[arg(long, value_name = "N", allow_hyphen_values = true, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub reps: u32,
    /// What finds the hits.
    #[command(flatten)]
    pub engine: EngineArgs,
    /// How to print the result
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}
