//! The finished graph: an arena of validated nodes.

use crate::{Env, Node, NodeId, ParamId, liveness::Liveness};

/// A cyclic CSG graph, validated: every handle in it is sound, every cycle passes an S-node, and what the root unfolds
/// into is bounded. Made by a [`GraphBuilder`](crate::GraphBuilder).
#[derive(Clone, Debug)]
pub struct Graph {
    pub(crate) nodes: Vec<Node>,
    pub(crate) params: Vec<String>,
    pub(crate) initial: Env,
    pub(crate) root: NodeId,
    pub(crate) liveness: Liveness,
}

impl Graph {
    /// The node where unfolding starts: the axiom.
    pub fn root(&self) -> NodeId {
        self.root
    }

    /// How many nodes there are; their indices run from 0 to below it.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// All nodes with their handles.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = (NodeId, &Node)> + Clone {
        self.nodes.iter().enumerate().map(|(index, node)| (NodeId::from_index(index), node))
    }

    /// A node.
    ///
    /// # Panics
    /// If the handle is of another, larger graph.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.index()]
    }

    /// All parameters, in the order of their declaration.
    pub fn params(&self) -> impl ExactSizeIterator<Item = ParamId> + Clone {
        (0..self.params.len()).map(ParamId::from_index)
    }

    /// The name of a parameter.
    ///
    /// # Panics
    /// If the handle is of another graph.
    pub fn param_name(&self, param: ParamId) -> &str {
        &self.params[param.index()]
    }

    /// The initial values of the parameters.
    pub fn initial(&self) -> &Env {
        &self.initial
    }

    /// The parameters that a node or something below it can read, among those that some C-node changes.
    pub fn live_params(&self, node: NodeId) -> impl Iterator<Item = ParamId> + '_ {
        self.params().filter(move |param| self.liveness.is_live(node, *param))
    }

    /// What a node is called in messages: a symbol's name, a transformation's, a primitive's, an operator's sign.
    pub fn node_name(&self, id: NodeId) -> String {
        match self.node(id) {
            Node::Symbol(symbol) => symbol.name.clone(),
            Node::Transformation(node) => node.kind.name().to_owned(),
            Node::Primitive(node) => node.kind.name().to_owned(),
            Node::Operator(node) => node.operator.sign().to_owned(),
            Node::Calculation(node) => {
                let names: Vec<_> =
                    node.assignments.iter().map(|(param, _)| self.param_name(*param)).collect();
                names.join(", ")
            }
            Node::Attribute(node) => {
                let names: Vec<_> = node.terms.iter().map(|(term, _)| term.name()).collect();
                names.join(", ")
            }
        }
    }
}
