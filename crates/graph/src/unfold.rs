//! Unfolding: the plain CSG tree that a graph stands for, with a matrix at every primitive.
//!
//! This is what the graph saves. It exists for tests, where it is the obvious twin of everything that walks the graph.

use glam::DAffine3;

use crate::{EvalError, Graph, NodeId, Operator, Primitive, State, Step};

/// A plain CSG tree: no symbols, calculations or transformations. Operands come before their operators; the root is the
/// last node.
#[derive(Clone, Debug)]
pub struct UnfoldedTree {
    nodes: Vec<UnfoldedNode>,
}

/// A node of an unfolded tree.
#[derive(Clone, Debug)]
pub enum UnfoldedNode {
    /// A primitive under its whole transform chain.
    Primitive {
        /// The solid in its object frame.
        primitive: Primitive,
        /// The product of the transformations above it.
        world_from_object: DAffine3,
        /// The graph's node that it is an instance of.
        node: NodeId,
    },
    /// An operator on two nodes of the tree, by their indices.
    Operator {
        /// Which operator.
        operator: Operator,
        /// The left and the right operand.
        operands: [usize; 2],
    },
}

/// Why a graph cannot be unfolded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UnfoldError {
    /// An expression has no usable value.
    #[error(transparent)]
    Eval(#[from] EvalError),
    /// The tree is larger than was asked for.
    #[error("the unfolded tree takes more than {limit} steps")]
    TooLarge {
        /// The limit.
        limit: usize,
    },
}

impl UnfoldedTree {
    /// The nodes, operands before operators.
    pub fn nodes(&self) -> &[UnfoldedNode] {
        &self.nodes
    }
}

enum Task {
    Enter(State, DAffine3),
    Combine(Operator),
}

impl Graph {
    /// Unfolds the graph. Takes time and memory in proportion to the unfolded tree, at most `limit` nodes of it.
    ///
    /// # Errors
    /// If an evaluation fails or the tree is larger than `limit`.
    pub fn unfold(&self, limit: usize) -> Result<UnfoldedTree, UnfoldError> {
        let mut nodes = Vec::new();
        let mut operands: Vec<usize> = Vec::new();
        let mut tasks = vec![Task::Enter(self.root_state(), DAffine3::IDENTITY)];
        let mut steps = 0;
        while let Some(task) = tasks.pop() {
            match task {
                Task::Enter(state, world_from_state) => {
                    steps += 1;
                    if steps > limit {
                        return Err(UnfoldError::TooLarge { limit });
                    }
                    match self.step(&state)? {
                        Step::Select(below) | Step::Calculate(below) | Step::Attribute(_, below) => {
                            tasks.push(Task::Enter(below, world_from_state));
                        }
                        Step::Transform(state_from_below, below) => {
                            tasks.push(Task::Enter(below, world_from_state * state_from_below.to_affine()));
                        }
                        Step::Operator(operator, [left, right]) => {
                            tasks.push(Task::Combine(operator));
                            tasks.push(Task::Enter(right, world_from_state));
                            tasks.push(Task::Enter(left, world_from_state));
                        }
                        Step::Primitive(primitive) => {
                            operands.push(nodes.len());
                            let node = state.node();
                            let world_from_object = world_from_state;
                            nodes.push(UnfoldedNode::Primitive { primitive, world_from_object, node });
                        }
                    }
                }
                Task::Combine(operator) => {
                    let right = operands.pop().expect("both operands were entered");
                    let left = operands.pop().expect("both operands were entered");
                    operands.push(nodes.len());
                    nodes.push(UnfoldedNode::Operator { operator, operands: [left, right] });
                }
            }
        }
        Ok(UnfoldedTree { nodes })
    }
}
