//! The state graph: all states that the root unfolds into, each once.
//!
//! A depth-first search with an explicit path. A state met again while it is still on the path is a recursion that
//! never ends, since equal states unfold alike; the path from its first occurrence is the counterexample. A recursion
//! whose parameters never repeat has no such witness, and runs into the [limit](Limits::states) instead.
//!
//! Where an evaluation fails, the search goes on with all other states, so that one run finds every place that fails.

use std::collections::BTreeMap;
use std::fmt;

use rustc_hash::FxHashMap;

use crate::eval::ParamValues;
use crate::node::{AttributeNode, Transformation};
use crate::{EvalError, Graph, Node, NodeId, State, Step};

/// What an analysis may use before it gives up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// The most states, of all nodes together. The default, 2 million, is a few hundred megabytes and a second or two:
    /// enough for a recursion of 300,000 levels, and soon over where one never ends.
    pub states: usize,
    /// The most values of parameters that all states together hold: each change of one copies all. The default, 100
    /// million, is 800 megabytes and matters only to graphs with more than fifty parameters.
    pub values: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { states: 2_000_000, values: 100_000_000 }
    }
}

/// All states below the root, children before their parents, so that the root's is the last.
#[derive(Clone, Debug)]
pub struct StateGraph {
    states: Vec<State>,
    children: Vec<[Option<u32>; 2]>,
}

impl StateGraph {
    /// How many states there are.
    #[expect(clippy::len_without_is_empty, reason = "there is always the root's")]
    pub fn len(&self) -> usize {
        self.states.len()
    }

    /// The states. Each has a smaller index than the states above it.
    pub fn states(&self) -> &[State] {
        &self.states
    }

    /// The indices of the states directly below the state of that index, in order.
    ///
    /// # Panics
    /// If there is no such state.
    pub fn children(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        self.children[index].iter().flatten().map(|child| *child as usize)
    }
}

/// Why the states cannot be listed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StatesError {
    /// Expressions have no usable values at states that the root reaches.
    #[error("{}", errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Eval {
        /// One for each place, with the values of the first state that was found to fail there; in the order of their nodes.
        errors: Vec<EvalError>,
    },
    /// The recursion never ends: a state comes back to itself.
    #[error("the recursion never ends: {}", Path(.path))]
    Endless {
        /// The S-nodes on the way from the state to itself; the first and the last are the same.
        path: Vec<SymbolState>,
    },
    /// There are more states than the limit allows, or infinitely many.
    #[error("more than {limit} states: does the recursion end? … → {}", Path(&.path[.path.len().saturating_sub(3)..]))]
    TooMany {
        /// The limit.
        limit: usize,
        /// The S-nodes on the way from the root to the last state, first and last few.
        path: Vec<SymbolState>,
    },
}

impl From<EvalError> for StatesError {
    fn from(error: EvalError) -> Self {
        Self::Eval { errors: vec![error] }
    }
}

/// A symbol with the values of its live parameters, for messages.
#[derive(Clone, Debug, PartialEq)]
pub struct SymbolState {
    /// The S-node.
    pub node: NodeId,
    /// The symbol.
    pub name: String,
    /// The live parameters that have values, in the order of their declaration.
    pub values: Vec<(String, f64)>,
}

impl fmt::Display for SymbolState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.name, ParamValues(&self.values))
    }
}

/// `A where n = 1 → B where n = 0`
struct Path<'a>(&'a [SymbolState]);

impl fmt::Display for Path<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, state) in self.0.iter().enumerate() {
            write!(f, "{}{state}", if index == 0 { "" } else { " → " })?;
        }
        Ok(())
    }
}

/// A state on the path of the search.
struct Frame {
    state: State,
    /// The states below it that are yet to be searched.
    pending: [Option<State>; 2],
    /// The indices of those that were.
    children: [Option<u32>; 2],
    /// Which of both is next.
    next: usize,
}

impl Frame {
    /// The next state below has that index, or none if it is above as well.
    fn found(&mut self, index: Option<u32>) {
        self.children[self.next] = index;
        self.next += 1;
    }
}

/// What fails, by its place.
type Faults = BTreeMap<(NodeId, Option<usize>), EvalError>;

enum Mark {
    OnPath,
    Done(u32),
}

impl Graph {
    /// Lists all states below the root.
    ///
    /// Takes time and memory in proportion to their number, not to the unfolded tree.
    ///
    /// # Errors
    /// If evaluations fail, the recursion never ends, or there are too many states; the first of these where there are more.
    pub fn states(&self, limits: &Limits) -> Result<StateGraph, StatesError> {
        let most = limits.states.min(limits.values / self.params().len().max(1));
        let mut found = StateGraph { states: Vec::new(), children: Vec::new() };
        let mut marks: FxHashMap<State, Mark> = FxHashMap::default();
        let mut faults = Faults::new();
        let mut unlisted = None;
        let root = self.root_state();
        marks.insert(root.clone(), Mark::OnPath);
        let mut path = vec![self.open(root, &mut faults)];
        while let Some(frame) = path.last_mut() {
            if let Some(next) = frame.pending.get_mut(frame.next).and_then(Option::take) {
                match marks.get(&next) {
                    Some(Mark::Done(index)) => frame.found(Some(*index)),
                    Some(Mark::OnPath) => {
                        frame.found(None);
                        unlisted.get_or_insert_with(|| self.endless(&path, &next));
                    }
                    None if marks.len() >= most => {
                        unlisted.get_or_insert_with(|| self.too_many(&path, most));
                        break;
                    }
                    None => {
                        marks.insert(next.clone(), Mark::OnPath);
                        path.push(self.open(next, &mut faults));
                    }
                }
            } else if let Some(Frame { state, children, .. }) = path.pop() {
                let index = u32::try_from(found.states.len()).expect("2^32 states outgrow the memory before");
                found.states.push(state.clone());
                found.children.push(children);
                marks.insert(state, Mark::Done(index));
                if let Some(parent) = path.last_mut() {
                    parent.found(Some(index));
                }
            }
        }
        if !faults.is_empty() {
            return Err(StatesError::Eval { errors: faults.into_values().collect() });
        }
        unlisted.map_or(Ok(found), Err)
    }

    fn open(&self, state: State, faults: &mut Faults) -> Frame {
        let pending = self.step(&state).map(Step::into_states).unwrap_or_else(|error| {
            faults.entry((error.at.node, error.at.expr)).or_insert(error);
            [self.below_fault(&state), None]
        });
        Frame { state, pending, children: [None; 2], next: 0 }
    }

    /// What is below a state that fails, if that is known all the same: a rule or a value is not, but what was to be
    /// transformed or painted is.
    fn below_fault(&self, state: &State) -> Option<State> {
        match self.node(state.node()) {
            Node::Transformation(Transformation { body, .. })
            | Node::Attribute(AttributeNode { body, .. }) => Some(self.state(*body, state.env().clone())),
            _ => None,
        }
    }

    fn endless(&self, path: &[Frame], again: &State) -> StatesError {
        let from = path.iter().position(|frame| frame.state == *again).unwrap_or(0);
        let mut cycle = self.symbols(path[from..].iter().map(|frame| &frame.state));
        cycle.extend(cycle.first().cloned());
        StatesError::Endless { path: cycle }
    }

    fn too_many(&self, path: &[Frame], limit: usize) -> StatesError {
        const SHOWN: usize = 3;
        let on_path: Vec<_> =
            path.iter().map(|frame| &frame.state).filter(|state| self.is_symbol(state)).collect();
        let last = on_path.len().saturating_sub(SHOWN).max(SHOWN.min(on_path.len()));
        let shown = on_path.iter().take(SHOWN).chain(&on_path[last..]);
        StatesError::TooMany { limit, path: self.symbols(shown.copied()) }
    }

    fn is_symbol(&self, state: &State) -> bool {
        matches!(self.node(state.node()), Node::Symbol(_))
    }

    fn symbols<'a>(&self, states: impl Iterator<Item = &'a State>) -> Vec<SymbolState> {
        let symbols = states.filter(|state| self.is_symbol(state));
        symbols
            .map(|state| SymbolState {
                node: state.node(),
                name: self.node_name(state.node()),
                values: self.live_values(state),
            })
            .collect()
    }
}
