//! One random scene, many seeds: whether the envelope of every state encloses its exact box, and how tight it is.
//!
//! [`Envelopes`] are made of intervals, without a look at the seed. The exact boxes of a scene of
//! one seed are made of its numbers, by another method, and there is no tolerance between the two but their rounding: so
//! the exact box of each state must lie in the envelope, and so must the supports in the directions of all its planes.
//!
//! - [`subject`]: scenes with chance in them, and with few enough states that all can be listed.
//! - [`enclosure`]: the comparison of one seed.
//! - [`looseness`](fn@looseness): by how much envelopes are too large, and boxes after one [`expansion`].

mod enclosure;
pub(crate) mod expansion;
mod looseness;
mod subject;

use std::ops::Range;
use std::sync::OnceLock;

use csg_graph::Graph;
use csg_graph_bounds::{Envelopes, Limits};
use rayon::prelude::*;

pub(crate) use looseness::looseness;
pub(crate) use subject::{Reduced, Subject};

/// Why nothing can be said.
pub(crate) type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Scenes for this alone: measures that are drawn, parameters that are, and recursion that ends by chance.
pub(crate) const OWN: [(&str, &str); 3] = [
    ("seeds/terrain", include_str!("../scenes/terrain.pcsg")),
    ("seeds/tree", include_str!("../scenes/tree.pcsg")),
    ("seeds/vine", include_str!("../scenes/vine.pcsg")),
];

/// What was found.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) seeds: u64,
    /// All states of all seeds.
    pub(crate) states: u64,
    /// Seeds of which there are no exact boxes, since chance lets the recursion go on for too long.
    pub(crate) unlisted: u64,
    /// States that are not compared. Above ∩ exact boxes are not the least ones, and some solids have no envelope.
    pub(crate) skipped: u64,
    /// States whose envelopes cut something off: all are counted, and some told.
    pub(crate) violations: u64,
    pub(crate) told: Vec<String>,
}

/// Violations that are told.
const TOLD: usize = 5;

impl Tally {
    /// Both, this one first.
    pub(crate) fn and(mut self, other: Self) -> Self {
        self.seeds += other.seeds;
        self.states += other.states;
        self.unlisted += other.unlisted;
        self.skipped += other.skipped;
        self.violations += other.violations;
        self.told.extend(other.told);
        self.told.truncate(TOLD);
        self
    }
}

/// Compares all states of a scene with these seeds. Of a scene that has no seed, once.
///
/// All planes are moved inwards by `shrink`, a share of their distance: 0, but for showing that it would be noticed.
pub(crate) fn check(scene: &Reduced, seeds: Range<u64>, shrink: f64) -> Result<Tally, Failure> {
    each(scene, seeds, |seed, graph, envelopes| enclosure::check(graph, envelopes, seed, shrink))
        .try_reduce(Tally::default, |one, other| Ok(one.and(other)))
}

/// Something for each seed of a scene, of its graph and the envelopes.
///
/// All seeds share the envelopes of the first, unless other initial values depend on the seed.
fn each<T: Send>(
    scene: &Reduced,
    seeds: Range<u64>,
    what: impl Fn(u64, &Graph, &Envelopes) -> Result<T, Failure> + Sync + Send,
) -> impl ParallelIterator<Item = Result<T, Failure>> {
    let shared = OnceLock::new();
    let envelopes = |graph: &Graph| Envelopes::new(graph.clone(), &Limits::default());
    scene.only_seeds(seeds).into_par_iter().map(move |seed| {
        let graph = scene.graph(seed)?;
        let shared = shared.get_or_init(|| envelopes(&graph));
        if scene.differ_by_seed_alone(shared.graph(), &graph) {
            what(seed, &graph, shared)
        } else {
            what(seed, &graph, &envelopes(&graph))
        }
    })
}
