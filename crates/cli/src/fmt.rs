//! `pcsg fmt`: a scene in the standard layout.

use crate::args::FmtArgs;
use crate::{Failure, load, output, print};

pub(crate) fn run(args: &FmtArgs) -> Result<(), Failure> {
    let source = load::read(&args.scene)?;
    let name = args.scene.display().to_string();
    let parsed = csg_graph_grammar::parse(&source);
    load::report(&name, &source, &parsed.diagnostics);
    if parsed.has_errors() {
        return Err(load::mistakes(&args.scene, &parsed.diagnostics));
    }
    let printed = csg_graph_grammar::print(&parsed.tree);
    match (args.check, args.write) {
        (true, _) if printed != source => Err(Failure::Layout { scene: args.scene.clone() }),
        (true, _) => Ok(()),
        (_, true) if printed == source => Ok(()),
        (_, true) => output::write(&args.scene, printed.as_bytes()),
        _ => print(printed),
    }
}
