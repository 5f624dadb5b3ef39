//! The one validation of a graph. What passes it needs no check later.

use crate::{EvalError, Graph, Node, NodeId, Operator, PrimitiveKind};

/// Why a graph is not sound.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GraphError {
    /// A node names a node or a parameter that does not exist.
    #[error("node {node:?} refers to a node or parameter of another graph")]
    Dangling {
        /// The node with the bad handle, or the handle of the root.
        node: NodeId,
    },
    /// A symbol was declared and never given rules.
    #[error("symbol `{name}` has no rules")]
    NoRules {
        /// The S-node.
        node: NodeId,
        /// The symbol.
        name: String,
    },
    /// A cycle passes no S-node, so that nothing could ever end it.
    #[error("a cycle passes no symbol: {}", path.join(" → "))]
    Cycle {
        /// A node on the cycle.
        node: NodeId,
        /// What the nodes of the cycle are called, from one to itself.
        path: Vec<String>,
    },
    /// Transformations are singular or primitives without extent, whatever the parameters.
    #[error("{}", errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Constants {
        /// All of them, in the order of their nodes.
        errors: Vec<EvalError>,
    },
    /// A half-space reaches the root without an intersection or a subtraction that bounds it.
    #[error(
        "the half-space is not bounded: intersect it with a bounded solid, or subtract it from one, \
         on every way from the root"
    )]
    Unbounded {
        /// The half-space.
        node: NodeId,
    },
}

/// Every handle is in range and every symbol has rules.
pub(crate) fn handles(nodes: &[Node], params: usize, root: NodeId) -> Result<(), GraphError> {
    for (index, node) in nodes.iter().enumerate() {
        let id = NodeId::from_index(index);
        let mut assigned = match node {
            Node::Calculation(node) => node.assignments.iter().map(|(param, _)| *param).collect(),
            _ => Vec::new(),
        };
        assigned.extend(node.exprs().into_iter().flat_map(|expr| expr.params()));
        let dangling = node.children().iter().any(|child| child.index() >= nodes.len())
            || assigned.iter().any(|param| param.index() >= params);
        if dangling {
            return Err(GraphError::Dangling { node: id });
        }
        if let Node::Symbol(symbol) = node
            && symbol.rules.is_empty()
        {
            return Err(GraphError::NoRules { node: id, name: symbol.name.clone() });
        }
    }
    if root.index() >= nodes.len() { Err(GraphError::Dangling { node: root }) } else { Ok(()) }
}

/// Every cycle passes an S-node: without the S-nodes, a depth-first search meets no node that it is still inside of.
pub(crate) fn cycles(graph: &Graph) -> Result<(), GraphError> {
    #[derive(Clone, Copy, PartialEq)]
    enum Mark {
        New,
        Inside,
        Done,
    }
    let is_symbol = |id: NodeId| matches!(graph.node(id), Node::Symbol(_));
    let mut marks = vec![Mark::New; graph.node_count()];
    for (start, _) in graph.nodes() {
        if marks[start.index()] != Mark::New || is_symbol(start) {
            continue;
        }
        marks[start.index()] = Mark::Inside;
        let mut path = vec![(start, 0)];
        while let Some((node, next)) = path.last_mut() {
            let Some(&child) = graph.node(*node).children().get(*next) else {
                marks[node.index()] = Mark::Done;
                path.pop();
                continue;
            };
            *next += 1;
            match marks[child.index()] {
                _ if is_symbol(child) => {}
                Mark::New => {
                    marks[child.index()] = Mark::Inside;
                    path.push((child, 0));
                }
                Mark::Inside => {
                    let from = path.iter().position(|(node, _)| *node == child).unwrap_or(0);
                    let ids = path[from..].iter().map(|(node, _)| *node).chain([child]);
                    return Err(GraphError::Cycle {
                        node: child,
                        path: ids.map(|id| graph.node_name(id)).collect(),
                    });
                }
                Mark::Done => {}
            }
        }
    }
    Ok(())
}

/// No half-space reaches the root unbounded.
///
/// A node is unbounded if a half-space below it is: ∪ is where an operand is, ∩ where both are, \ where the left is. A
/// symbol is where a rule is. On a cyclic graph this is a least fixed point. It is decided per node and not per state,
/// and an intersection of half-spaces counts as unbounded even where they happen to close; both are on the safe side.
pub(crate) fn extents(graph: &Graph) -> Result<(), GraphError> {
    // For each unbounded node, the half-space that makes it so.
    let mut culprit: Vec<Option<NodeId>> = vec![None; graph.node_count()];
    let mut changed = true;
    while changed {
        changed = false;
        for (id, node) in graph.nodes() {
            if culprit[id.index()].is_some() {
                continue;
            }
            let of = |child: &NodeId| culprit[child.index()];
            let found = match node {
                Node::Primitive(primitive) if primitive.kind == PrimitiveKind::HalfSpace => Some(id),
                Node::Operator(node) => {
                    let [left, right] = &node.operands;
                    match node.operator {
                        Operator::Union => of(left).or(of(right)),
                        Operator::Intersection => of(left).and(of(right)),
                        Operator::Difference => of(left),
                    }
                }
                _ => node.children().iter().find_map(of),
            };
            changed |= found.is_some();
            culprit[id.index()] = found;
        }
    }
    culprit[graph.root().index()].map_or(Ok(()), |node| Err(GraphError::Unbounded { node }))
}
