//! `pcsg bounds`: volumes of the whole, of all nodes and of all states, listed, compared, or drawn as they grow.

mod compare;
mod costs;
mod growth;
mod instances;
mod list;
mod methods;
mod plot;
mod sweep;
mod volume;

use crate::Failure;
use crate::args::BoundsArgs;
use crate::load::load;

pub use costs::{Cost, costs_drawing};
pub(crate) use methods::{endless_boxes, exact_boxes, failure, hyper_boxes, refuse_more_than};
pub(crate) use volume::{line, point};

/// The drawing that `bounds --plot` would write, as an SVG file.
///
/// # Errors
/// If the scene has mistakes, which are reported, or asks for what cannot be done.
pub fn drawing(args: &BoundsArgs) -> Result<String, Failure> {
    growth::grow(args, &load(&args.scene)?).map(|(drawing, _)| drawing)
}

pub(crate) fn run(args: &BoundsArgs) -> Result<(), Failure> {
    let loaded = load(&args.scene)?;
    match &args.plot {
        _ if args.compare => compare::run(args, &loaded),
        Some(path) => growth::run(args, &loaded, path),
        None => list::run(args, &loaded),
    }
}
