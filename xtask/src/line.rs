//! Command lines that are written down: in cases of golden images, on the page of pictures, and for figures.

use std::path::Path;

use clap::Parser;
use csg_graph_cli::RenderArgs;

/// The arguments of a command without its name.
#[derive(Debug, Parser)]
#[command(no_binary_name = true)]
struct Line<A: clap::Args> {
    #[command(flatten)]
    args: A,
}

/// The arguments of a line. No word of it may hold a space.
pub(crate) fn parse<A: clap::Args>(line: &str) -> Result<A, clap::Error> {
    Line::try_parse_from(line.split_whitespace()).map(|line| line.args)
}

/// The arguments of `pcsg render` on a line, whose scene is found from a folder.
pub(crate) fn render(folder: &Path, line: &str) -> Result<RenderArgs, clap::Error> {
    let mut args: RenderArgs = parse(line)?;
    args.scene.scene = folder.join(&args.scene.scene);
    Ok(args)
}
