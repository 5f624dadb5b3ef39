//! Scenes with chance in them, made small.
//!
//! A scene is random if an expression of its graph draws, hashes or makes noise. Most are far too large to list their states;
//! their recursion is made less deep by the parameters that count it. A *counter* is a parameter that some C-node lowers
//! by one. The largest counter is lowered by an eighth, again and again, until the states with seed 0 are few enough.

use std::fmt;
use std::ops::Range;

use csg_graph::{Expr, Graph, Limits, Node, ParamId, StatesError};
use csg_graph_grammar::{Override, load};

use super::Failure;

/// Initial values of scenes that begin elsewhere than in their files. In front there is only grass in the forest; here are
/// trees.
const PLACES: [(&str, [&str; 2]); 1] = [("vast/forest", ["x = 22", "y = 33"])];

/// A scene with chance in it.
pub(crate) struct Subject {
    name: String,
    source: String,
    /// By name, with their initial values.
    counters: Vec<(String, f64)>,
    seed: Option<Seed>,
}

/// The parameter that all chance comes from.
#[derive(Clone, Copy)]
struct Seed {
    param: ParamId,
    /// Whether ranges depend on it: it is then a measure as well.
    read: bool,
}

/// A scene with lower counters.
pub(crate) struct Reduced<'a> {
    subject: &'a Subject,
    counters: Vec<(String, f64)>,
}

impl Subject {
    /// A scene by its text. `None` if there is no chance in it.
    pub(crate) fn new(name: &str, source: String) -> Result<Option<Self>, Failure> {
        let graph = read(name, &source, &[])?;
        let mut exprs = graph.nodes().flat_map(|(_, node)| node.exprs());
        if !exprs.any(|expr| expr.is_erratic()) {
            return Ok(None);
        }
        let counters = graph.params().filter_map(|param| {
            let name = graph.param_name(param);
            let lower = format!("{name} - 1");
            let counts = graph.nodes().any(|(_, node)| match node {
                Node::Calculation(node) => node.assignments.iter().any(|(assigned, expr)| {
                    *assigned == param && expr.to_text(|read| graph.param_name(read)) == lower
                }),
                _ => false,
            });
            let value = graph.initial().get(param)?;
            counts.then(|| (name.to_owned(), value))
        });
        let counters = counters.collect();
        let seed = graph.params().find(|param| graph.param_name(*param) == "seed");
        let seed = seed.map(|param| Seed { param, read: is_read(&graph, param) });
        Ok(Some(Self { name: name.to_owned(), source, counters, seed }))
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The scene with at most so many states, with seed 0. `None` if it has more with the least counters, too.
    pub(crate) fn reduced(&self, states: usize) -> Result<Option<Reduced<'_>>, Failure> {
        let mut limits = Limits::default();
        limits.states = states;
        let mut reduced = Reduced { subject: self, counters: self.counters.clone() };
        loop {
            match reduced.graph(0)?.states(&limits) {
                Ok(_) => return Ok(Some(reduced)),
                Err(error @ StatesError::Eval { .. }) => return Err(format!("{}: {error}", self.name).into()),
                Err(_) => {}
            }
            let largest = reduced.counters.iter_mut().max_by(|a, b| a.1.total_cmp(&b.1));
            match largest {
                Some((_, value)) if *value >= 1.0 => *value -= (*value / 8.0).floor().max(1.0),
                _ => return Ok(None),
            }
        }
    }
}

impl Reduced<'_> {
    /// The scene with a seed.
    pub(crate) fn graph(&self, seed: u64) -> Result<Graph, Failure> {
        let Subject { name, source, .. } = self.subject;
        let counters = self.counters.iter().map(|(name, value)| format!("{name} = {value}"));
        let seed = self.subject.seed.map(|_| format!("seed = {seed}"));
        let places =
            PLACES.iter().filter(|(of, _)| of == name).flat_map(|(_, place)| place.map(str::to_owned));
        let set: Result<Vec<_>, _> =
            counters.chain(seed).chain(places).map(|text| Override::parse(&text)).collect();
        let set = set.map_err(|mistakes| format!("{name}: {mistakes:?}"))?;
        read(name, source, &set)
    }

    /// Whether envelopes of one graph of this scene are those of another: no initial value depends on the seed.
    pub(super) fn differ_by_seed_alone(&self, one: &Graph, other: &Graph) -> bool {
        let Some(Seed { param: seed, read: false }) = self.subject.seed else { return false };
        one.params().all(|param| param == seed || one.initial().get(param) == other.initial().get(param))
    }

    /// Of these seeds, those that make a difference: one, if the scene has none.
    pub(super) fn only_seeds(&self, seeds: Range<u64>) -> Range<u64> {
        if self.subject.seed.is_some() { seeds } else { 0..u64::from(seeds.contains(&0)) }
    }
}

/// The counters that are lower than in the file.
impl fmt::Display for Reduced<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lower = self.counters.iter().zip(&self.subject.counters).filter(|(now, first)| now.1 < first.1);
        let told: Vec<String> = lower.map(|((name, value), _)| format!("{name}={value}")).collect();
        if told.is_empty() { f.write_str("as it is") } else { f.write_str(&told.join(" ")) }
    }
}

/// Whether the range of anything but the next seed depends on the seed.
fn is_read(graph: &Graph, seed: ParamId) -> bool {
    let reads = |expr: &Expr| expr.range_params().contains(&seed);
    graph.nodes().any(|(_, node)| match node {
        Node::Calculation(node) => node.assignments.iter().any(|(param, expr)| *param != seed && reads(expr)),
        node => node.exprs().into_iter().any(reads),
    })
}

fn read(name: &str, source: &str, set: &[Override]) -> Result<Graph, Failure> {
    let lowered = load(source, set).map_err(|mistakes| {
        let told: Vec<String> = mistakes.iter().map(|mistake| mistake.render(name, source, false)).collect();
        told.join("\n")
    })?;
    Ok(lowered.scene.graph)
}
