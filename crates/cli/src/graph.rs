//! `pcsg graph`: the graph as a drawing.

use crate::args::{GraphArgs, GraphFormat};
use crate::{Failure, load, print};

pub(crate) fn run(args: &GraphArgs) -> Result<(), Failure> {
    let loaded = load::load(&args.scene)?;
    match args.format {
        GraphFormat::Dot => print(loaded.scene.graph.to_dot()),
    }
}
