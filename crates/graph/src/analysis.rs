//! What a graph unfolds into, counted exactly from its states, without unfolding it.
//!
//! Every count of a state is a sum over the states directly below it, so one pass from the leaves up is enough. Counts of
//! unfolded things grow with the power of the depth and are big integers; each is dropped when the last state above it
//! has used it, so that a deep recursion does not keep them all.

use num_bigint::BigUint;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::{EvalError, Graph, Limits, Node, Operator, State, StateGraph, StatesError, Step};

/// The static analysis of a graph. It exists only for a graph whose recursion ends and whose every reachable expression
/// has a value.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Analysis {
    /// Nodes of the graph.
    pub nodes: usize,
    /// States of symbols: S-nodes with the values of the parameters that are live there.
    pub states: usize,
    /// How many of them remain if states whose rules unfold into the same tree are counted once.
    pub distinct_states: usize,
    /// States of all nodes.
    pub node_states: usize,
    /// Nodes of the unfolded tree. Attributes are not nodes of it: they ride along.
    pub instances: BigUint,
    /// Primitives of the unfolded tree.
    pub primitives: BigUint,
    /// Boxes that the chain algorithm computes: for each primitive of the unfolded tree one in its own frame and one a
    /// transformation above it.
    pub chain_boxes: BigUint,
    /// Recursion depth: the most S-nodes on a path of the unfolded tree.
    pub depth: u64,
}

/// The counts of what is below one state, itself included.
#[derive(Clone, Default)]
struct Counts {
    instances: BigUint,
    primitives: BigUint,
    chain_boxes: BigUint,
    depth: u64,
}

impl Graph {
    /// Analyses the graph: lists its states and counts what they unfold into.
    ///
    /// Takes time and memory in proportion to the states, times the length of the numbers.
    ///
    /// # Errors
    /// As [`states`](Self::states).
    pub fn analyse(&self, limits: &Limits) -> Result<Analysis, StatesError> {
        let states = self.states(limits)?;
        let counts = self.count(&states);
        Ok(Analysis {
            nodes: self.node_count(),
            states: states.states().iter().filter(|state| self.symbol(state)).count(),
            distinct_states: self.distinct(&states)?,
            node_states: states.len(),
            instances: counts.instances,
            primitives: counts.primitives,
            chain_boxes: counts.chain_boxes,
            depth: counts.depth,
        })
    }

    fn symbol(&self, state: &State) -> bool {
        matches!(self.node(state.node()), Node::Symbol(_))
    }

    fn count(&self, states: &StateGraph) -> Counts {
        let mut uses = vec![0_u32; states.len()];
        for child in (0..states.len()).flat_map(|index| states.children(index)) {
            uses[child] += 1;
        }
        let mut known: Vec<Option<Counts>> = vec![None; states.len()];
        for (index, state) in states.states().iter().enumerate() {
            let mut sum = Counts::default();
            for child in states.children(index) {
                uses[child] -= 1;
                let counts = if uses[child] == 0 { known[child].take() } else { known[child].clone() };
                let counts = counts.expect("children come before their parents");
                sum.instances += counts.instances;
                sum.primitives += counts.primitives;
                sum.chain_boxes += counts.chain_boxes;
                sum.depth = sum.depth.max(counts.depth);
            }
            match self.node(state.node()) {
                Node::Attribute(_) => {}
                node => {
                    sum.instances += 1_u32;
                    match node {
                        Node::Symbol(_) => sum.depth += 1,
                        Node::Transformation(_) => sum.chain_boxes += &sum.primitives,
                        Node::Primitive(_) => {
                            sum.primitives += 1_u32;
                            sum.chain_boxes += 1_u32;
                        }
                        _ => {}
                    }
                }
            }
            known[index] = Some(sum);
        }
        known.pop().flatten().unwrap_or_default()
    }

    /// Counts the states of symbols up to equality of what they unfold into: two states are in one class if their nodes
    /// do the same and the states below them are in the same classes.
    fn distinct(&self, states: &StateGraph) -> Result<usize, EvalError> {
        let mut table: FxHashMap<Vec<u64>, u64> = FxHashMap::default();
        let mut class: Vec<u64> = Vec::with_capacity(states.len());
        let mut symbols = FxHashSet::default();
        for (index, state) in states.states().iter().enumerate() {
            let below: Vec<u64> = states.children(index).map(|child| class[child]).collect();
            let own = match self.step(state)? {
                Step::Calculate(_) => below[0],
                step => {
                    let mut key = fingerprint(&step);
                    key.extend(below);
                    let fresh = table.len() as u64;
                    *table.entry(key).or_insert(fresh)
                }
            };
            if self.symbol(state) {
                symbols.insert(own);
            }
            class.push(own);
        }
        Ok(symbols.len())
    }
}

/// What the node of a step does, without what is below it, as words that are equal when the node does the same.
fn fingerprint(step: &Step) -> Vec<u64> {
    let (kind, numbers): (u64, Vec<f64>) = match step {
        Step::Select(_) => (0, vec![]),
        Step::Calculate(_) => (1, vec![]),
        Step::Transform(transform, _) => (2, transform.to_affine().to_cols_array().to_vec()),
        Step::Attribute(terms, _) => {
            (3, terms.iter().flat_map(|(term, value)| [f64::from(*term as u8), *value]).collect())
        }
        Step::Operator(Operator::Union, _) => (4, vec![]),
        Step::Operator(Operator::Intersection, _) => (5, vec![]),
        Step::Operator(Operator::Difference, _) => (6, vec![]),
        Step::Primitive(primitive) => (7, primitive.words()),
    };
    std::iter::once(kind).chain(numbers.into_iter().map(f64::to_bits)).collect()
}
