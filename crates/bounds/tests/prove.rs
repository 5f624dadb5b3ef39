//! The short run of the prover in `examples/prove`: no point escapes; and if boxes were too small, it would tell.
#![cfg(feature = "csg-graph")]

#[path = "../examples/prove/prover/mod.rs"]
mod prover;

use csg_graph_bounds::{Aabb, Sphere};
use prover::{Enclosure, Tally, trial};

fn run(graphs: u64, points: u64, altered: fn(Enclosure) -> Enclosure) -> Tally {
    let mut total = Tally::default();
    (0..graphs).for_each(|graph| total.add(trial(1995, graph, points, altered)));
    total
}

#[test]
fn no_point_escapes() {
    let found = run(20, 3_000, std::convert::identity);
    let escapes: Vec<String> = found.escapes.iter().map(ToString::to_string).collect();
    assert!(escapes.is_empty(), "{found}\n{}", escapes.join("\n"));
    assert!(found.checks.iter().all(|checks| *checks > 10_000), "{found}");
}

#[test]
fn volumes_that_are_too_small_are_found_out() {
    let found = run(8, 8_000, |enclosure| smaller(enclosure, 1e-12));
    assert!((0..found.checks.len()).all(|kind| found.escapes_of(kind) > 0), "{found}");
}

/// A volume with a little less on all sides.
fn smaller(enclosure: Enclosure, part: f64) -> Enclosure {
    match enclosure {
        Enclosure::Box(bounds) => {
            let margin = part * bounds.size();
            Enclosure::Box(Aabb { min: bounds.min + margin, max: bounds.max - margin })
        }
        Enclosure::Planes(planes) => {
            let less = |[min, max]: [f64; 2]| [min + part * (max - min), max - part * (max - min)];
            Enclosure::Planes(planes.into_iter().map(|(direction, range)| (direction, less(range))).collect())
        }
        Enclosure::Ball(Sphere { center, radius }) => {
            Enclosure::Ball(Sphere { center, radius: radius * (1.0 - part) })
        }
    }
}
