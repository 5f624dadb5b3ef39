//! How many parts unions have, before anything is known of their states: it is written in the rules.
//!
//! A definition that is used twice by one that is used twice, and so on, makes more parts than anybody wrote. So a union is
//! written out only while it has no more parts than the graph has nodes; in others it is one part.

use csg_graph::{Graph, Node, NodeId, Operator};

/// The number of parts of the union at each node of a graph, those of unions in it that are in the same rule and written out
/// among them; 1 where there is no union.
#[derive(Debug)]
pub(crate) struct Unions {
    /// By node.
    parts: Vec<usize>,
    /// The most parts of a union that is written out in others.
    most: usize,
}

impl Unions {
    /// So many parts are written out in the smallest of graphs.
    const FEW: usize = 1024;

    pub(crate) fn new(graph: &Graph) -> Self {
        let most = graph.node_count().max(Self::FEW);
        let mut parts = vec![0; graph.node_count()];
        // A node waits below its children; a symbol is where a rule ends.
        let mut open: Vec<NodeId> = graph.nodes().map(|(id, _)| id).collect();
        while let Some(id) = open.last() {
            let children = match graph.node(*id) {
                Node::Symbol(_) | Node::Primitive(_) => &[],
                Node::Operator(node) if node.operator != Operator::Union => &[],
                node => node.children(),
            };
            let waiting = open.len();
            if parts[id.index()] == 0 {
                open.extend(children.iter().filter(|child| parts[child.index()] == 0));
            }
            if open.len() == waiting
                && let Some(id) = open.pop()
            {
                let written_out = children.iter().map(|child| parts[child.index()]);
                let count: usize = written_out.map(|count| if count > most { 1 } else { count }).sum();
                parts[id.index()] = count.max(1);
            }
        }
        Self { parts, most }
    }

    pub(super) fn parts(&self, node: NodeId) -> usize {
        self.parts[node.index()]
    }

    /// Whether a union in another one of the same rule is no part of that, but its parts are.
    pub(super) fn is_written_out(&self, node: NodeId) -> bool {
        self.parts(node) <= self.most
    }
}
