//! The state graph: all states that the root unfolds into, each once.
//!
//! A depth-first search with an explicit path. A state met again while it is still on the path is a recursion that
//! never ends, since equal states unfold alike; the path from its first occurrence is the counterexample. A recursion
//! whose parameters never repeat has no such witness, and runs into the [limit](Limits::states) instead.

use std::fmt;

use rustc_hash::FxHashMap;

use crate::eval::ParamValues;
use crate::{EvalError, Graph, Node, NodeId, State};

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
    /// An expression has no usable value at a state that the root reaches.
    #[error(transparent)]
    Eval(#[from] EvalError),
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
    /// The next state below has that index.
    fn found(&mut self, index: u32) {
        self.children[self.next] = Some(index);
        self.next += 1;
    }
}

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
    /// If an evaluation fails, the recursion never ends, or there are too many states.
    pub fn states(&self, limits: &Limits) -> Result<StateGraph, StatesError> {
        let most = limits.states.min(limits.values / self.params().len().max(1));
        let mut found = StateGraph { states: Vec::new(), children: Vec::new() };
        let mut marks: FxHashMap<State, Mark> = FxHashMap::default();
        let root = self.root_state();
        marks.insert(root.clone(), Mark::OnPath);
        let mut path = vec![self.open(root)?];
        while let Some(frame) = path.last_mut() {
            if let Some(next) = frame.pending.get_mut(frame.next).and_then(Option::take) {
                match marks.get(&next) {
                    Some(Mark::Done(index)) => frame.found(*index),
                    Some(Mark::OnPath) => return Err(self.endless(&path, &next)),
                    None if marks.len() >= most => return Err(self.too_many(&path, most)),
                    None => {
                        marks.insert(next.clone(), Mark::OnPath);
                        path.push(self.open(next)?);
                    }
                }
            } else if let Some(Frame { state, children, .. }) = path.pop() {
                let index = u32::try_from(found.states.len()).expect("2^32 states outgrow the memory before");
                found.states.push(state.clone());
                found.children.push(children);
                marks.insert(state, Mark::Done(index));
                if let Some(parent) = path.last_mut() {
                    parent.found(index);
                }
            }
        }
        Ok(found)
    }

    fn open(&self, state: State) -> Result<Frame, EvalError> {
        let pending = self.step(&state)?.into_states();
        Ok(Frame { state, pending, children: [None; 2], next: 0 })
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
