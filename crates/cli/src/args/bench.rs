//! The arguments of `bench`.

use std::path::PathBuf;

use clap::Args;

use super::bounds::{Sweep, svg_path};
use super::values::{whole, zoom_factor};
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
    #[arg(long, value_name = "N", allow_hyphen_values = true, default_value_t = 1, value_parser = whole::<u32>(1..=1024))]
    pub threads: u32,
    /// Repetitions, of which the median counts; one more goes before them to warm up
    #[arg(long, value_name = "N", allow_hyphen_values = true, default_value_t = 5, value_parser = whole::<u32>(1..=10_000))]
    pub reps: u32,
    /// Go so many times closer to the smallest part that is seen from where the scene's camera is, as render does
    #[arg(long, value_name = "FACTOR", allow_hyphen_values = true, value_parser = zoom_factor, conflicts_with = "plot")]
    pub zoom: Option<f64>,
    /// What finds the hits.
    #[command(flatten)]
    pub engine: EngineArgs,
    /// Draw what a ray costs along a sweep, instead of printing it for one value
    ///
    /// Tests are counted. Times are measured: the same command does not draw quite the same twice.
    #[arg(long, value_name = "FILE.svg", value_parser = svg_path, requires = "sweep", conflicts_with = "format")]
    pub plot: Option<PathBuf>,
    /// The parameter along the plot, and its first and last value; at most 16 are tried
    ///
    /// Instead of a parameter, `log2(side)` takes square pictures of 2^A to 2^B pixels along a side, and `log2(budget)`
    /// an engine with so many bytes.
    #[arg(long, value_name = "NAME=A..B", requires = "plot", allow_hyphen_values = true)]
    pub sweep: Option<Sweep>,
    /// How to print the result
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}
