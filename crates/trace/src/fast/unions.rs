//! How many parts unions have, before anything is known of their states: it is written in the rules.

use csg_graph::{Graph, Node, NodeId, Operator};

/// The number of parts of the union at each node of a graph, those of unions in unions of one rule among them; 1 where there
/// is no union.
#[derive(Debug)]
pub(super) struct Unions {
    /// By node. More than any integer holds where definitions are used over and over.
    parts: Vec<f64>,
}

impl Unions {
    pub(super) fn new(graph: &Graph) -> Self {
        let mut parts = vec![0.0; graph.node_count()];
        // A node waits below its children; a symbol is where a rule ends.
        let mut open: Vec<NodeId> = graph.nodes().map(|(id, _)| id).collect();
        while let Some(id) = open.last() {
            let children = match graph.node(*id) {
                Node::Symbol(_) | Node::Primitive(_) => &[],
                Node::Operator(node) if node.operator != Operator::Union => &[],
                node => node.children(),
            };
            let waiting = open.len();
            let count = children.iter().map(|child| parts[child.index()]).sum::<f64>();
            if parts[id.index()] == 0.0 {
                open.extend(children.iter().filter(|child| parts[child.index()] == 0.0));
            }
            if open.len() == waiting
                && let Some(id) = open.pop()
            {
                parts[id.index()] = count.max(1.0);
            }
        }
        Self { parts }
    }

    pub(super) fn parts(&self, node: NodeId) -> f64 {
        self.parts[node.index()]
    }
}
